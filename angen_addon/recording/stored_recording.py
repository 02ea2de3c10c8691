# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished recording, which follows the changes of its scene."""

from __future__ import annotations

import secrets
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

from ...sensor_logic.kind import LIGHT, Kind
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.recording.tracks import Recording
from ..scene.instances import Uid
from ..scene.sensors import Sensor, all_sensors
from ..scene.surfaces import SURFACES
from .fingerprint import SCENE, Fingerprint, digest_of, fingerprint_of, key_of, own_settings
from .followed_scene import THIS_BLENDER, FollowedScene


class StoredRecording(FollowedScene):
    """A recording, with the fingerprint that its scene had at the run.

    Attributes
    ----------
    recording
        The readings of the run.
    made_in
        The version of Blender that ran the simulation.
    stale_then
        Why the recording was stale when the file was saved; empty if it was fresh.
    mark
        A random number that identifies this recording; its scene stores it too.
    names
        The names that the scene's sensors had at the run, by their uid.
    """

    def __init__(
        self, recording: Recording, fingerprint: Fingerprint, blender: tuple[int, ...] = ()
    ) -> None:
        super().__init__(fingerprint, blender)
        self.recording = recording
        self.made_in = self.blender
        self.stale_then = ""
        self.mark = 1 + secrets.randbelow(2**31 - 1)
        self.names: dict[Uid, str] = {}

    def verify(self, scene: Any, depsgraph: Any) -> None:
        if self.blender != THIS_BLENDER and not self._is_other_view_layer(depsgraph):
            self._accept_from_other_version(scene, depsgraph)
        super().verify(scene, depsgraph)

    def _accept_from_other_version(self, scene: Any, depsgraph: Any) -> None:
        """Compute the fingerprint anew if another version of Blender made the recording.

        Fingerprints of two versions cannot be compared. So the recording must have been fresh when
        the file was saved, and the panel says that another version made it.
        """
        if not self.stale_then:
            self.fingerprint = fingerprint_of(scene, depsgraph, self.fingerprint.light)
            self.names = _names_of(scene.view_layers[depsgraph.view_layer.name])
            self.blender, self.stored = THIS_BLENDER, ""

    def note_begin(self, settings: dict[str, str]) -> None:
        """Mark the recording as stale if other code has changed settings during the run.

        `settings` are the digests that `settings_of` returned when the run began. The fingerprint
        is from the end of the run.
        """
        known = self.fingerprint.digests
        for key, digest in settings.items():
            if known.get(key, digest) != digest:
                known[key], now = digest, known[key]
                self._compare({key: now})

    def _note_names(self, sensors: Iterable[Sensor]) -> None:
        """Find the sensors that were renamed since the run, and give their tracks the new names."""
        self._renamed, names = {}, {}
        for sensor in sensors:
            self._renamed |= _renamed(sensor, self.names.get(sensor.uid, sensor.name))
            names[sensor.uid] = sensor.name
        tracks = list(self.recording.tracks.values())
        wanted = [names.get(track.uid, track.sensor) for track in tracks]
        is_same = wanted == [track.sensor for track in tracks]
        # A name can still belong to the track of a sensor that was deleted.
        if is_same or len(set(wanted)) < len(wanted):
            return
        renamed = {n: t.renamed(n) for n, t in zip(wanted, tracks, strict=True)}
        self.recording = replace(self.recording, tracks=renamed)
        self.stored = ""

    def was_called(self, sensor: Sensor, name: str) -> bool:
        """Return whether a sensor had the name `name` at the run, and has not changed otherwise."""
        renamed = _renamed(sensor, name)
        known = self.fingerprint.digests
        parts = (*sensor.holders, sensor.object)
        return bool(renamed) and all(
            known.get(key_of(part, renamed)) == digest_of(part, renamed) for part in parts
        )


def settings_of(
    scene: Any, sensors: Sequence[Sensor], recorded: Iterable[Sensor]
) -> dict[str, str]:
    """Return digests of the scene's settings and sensors, none of which may change during a run.

    The keys are as in `Fingerprint.digests`. `sensors` are all sensors of the scene, and `recorded`
    the sensors that the run records.
    """
    light = _depend_on_light(sensor.kind for sensor in recorded)
    objects = {part for sensor in sensors for part in (sensor.object, *sensor.holders)}
    found = {key_of(obj): digest_of(obj) for obj in objects}
    return found | {SCENE: own_settings(scene, sensors, light)}


def _depend_on_light(kinds: Iterable[Kind]) -> bool:
    shading = [LIGHT, *(need for need, probe in SURFACES.items() if probe.reads_shading)]
    return any(kind.requires(need) for kind in kinds for need in shading)


def stored_run(recording: Recording, scene: Any, depsgraph: Any) -> StoredRecording:
    """Return a recording with the fingerprint of the present scene.

    Call this function when the run of the recording has ended.
    """
    light = _depend_on_light(KINDS[track.kind_name] for track in recording.tracks.values())
    stored = StoredRecording(recording, fingerprint_of(scene, depsgraph, light))
    stored.names = _names_of(scene.view_layers[depsgraph.view_layer.name])
    return stored


def _names_of(view_layer: Any) -> dict[Uid, str]:
    return {sensor.uid: sensor.name for sensor in all_sensors(view_layer)}


def _renamed(sensor: Sensor, former_name: str) -> dict[str, str]:
    """Return the former names of a sensor's object and of its instancers, by present name.

    Names that have not changed are left out. The `former_name` of a sensor in a collection instance
    has the names of the instancers and of the object, with slashes between them.
    """
    parts = (*sensor.holders, sensor.object)
    names = former_name.split("/") if sensor.holders else [former_name]
    if len(names) != len(parts):
        return {}
    return {p.name: name for p, name in zip(parts, names, strict=True) if p.name != name}
