# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished recording, and the comparison of its scene with the present scene.

The comparison is by fingerprints. A fingerprint is a dictionary from the name of each part of the
scene that sensors read to a digest of this part.
"""

from __future__ import annotations

import secrets
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import bpy

from ...sensor_logic.kind import LIGHT, Kind
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.recording.tracks import Recording
from ...sensor_logic.wording import listed
from ..scene.animation import is_off_keys
from ..scene.changes import (
    SCENE,
    SHOWN,
    Fingerprint,
    digest_of,
    fingerprint_of,
    is_looked_at,
    key_of,
    own_settings,
    portable,
    warmth_of,
    what_is_shown,
)
from ..scene.facts import FACTS_VERSION
from ..scene.instances import Uid
from ..scene.sensors import Sensor, all_sensors
from ..scene.surfaces import SURFACES

THIS_BLENDER = tuple(bpy.app.version[:2])


class StoredRecording:
    """A recording, with the fingerprint that its scene had at the run.

    Attributes
    ----------
    recording
        The readings of the run.
    fingerprint
        The fingerprint of the scene at the run.
    unsure
        Whether the recording must be compared with the scene by `verify`, after undo or loading.
    stored
        The recording as a text for the file; empty until it is encoded.
    blender
        The version of Blender that computed the fingerprint.
    made_in
        The version of Blender that ran the simulation.
    stale_then
        Why the recording was stale when the file was saved; empty if it was fresh.
    facts
        The FACTS_VERSION with which the fingerprint was computed.
    mark
        A random number that identifies this recording; its scene stores it too.
    names
        The names that the scene's sensors had at the run, by their uid.
    """

    def __init__(
        self, recording: Recording, fingerprint: Fingerprint, blender: tuple[int, ...] = ()
    ) -> None:
        self.recording = recording
        self.fingerprint = fingerprint
        self.blender = self.made_in = blender or THIS_BLENDER
        self.stale_then = ""
        self.facts = FACTS_VERSION
        self.mark = 1 + secrets.randbelow(2**31 - 1)
        self.names: dict[Uid, str] = {}
        self.unsure = False
        self.stored = ""
        # Texts for the user on each difference from the fingerprint, by the fingerprint's key.
        self._changed: dict[str, str] = {}
        # Likewise for animated objects that the user moved. The next change of frame moves them
        # back to where their keyframes say.
        self._moved: dict[str, str] = {}
        # How many objects the file had at the last comparison.
        self._objects = len(bpy.data.objects)
        self._other_view_layer = False
        self._renamed: dict[str, str] = {}
        # The revision of the scene at the last comparison of names and visibility.
        self._revision = -1

    @property
    def stale(self) -> str:
        """A short text on why the recording is stale; empty while it is fresh."""
        if self.facts != FACTS_VERSION:
            return "it was made by an earlier version of Ängen Sensors"
        if self.blender != THIS_BLENDER:
            return f"it was made in Blender {version_text(self.blender)}"
        if self._other_view_layer:
            return f"it was made in the view layer '{self.fingerprint.view_layer}'"
        if self.unsure:
            return "it is not known whether the scene is still the same"
        changed = self._changed | self._moved
        if _names_new_or_gone(changed):
            # Objects that came or went change the visibility too: one text is enough.
            changed.pop(SHOWN, None)
        # Objects come first, since users know the names of objects better than the names of meshes.
        keys = sorted(changed, key=lambda key: not key.startswith("Object "))
        names = {f"'{then}'": f"'{now}'" for now, then in self._renamed.items()}
        texts = dict.fromkeys(names.get(changed[key], changed[key]) for key in keys)
        return f"changed since: {listed(list(texts), 3)}" if texts else ""

    def verify(self, scene: Any, depsgraph: Any) -> None:
        """Compare the whole present scene with the scene at the run, part by part.

        Call this method after undo, after loading, and before an export.
        """
        if self._is_other_view_layer(depsgraph):
            return
        if self.blender != THIS_BLENDER:
            self._accept_from_other_version(scene, depsgraph)
        self._find_renamed(all_sensors(scene.view_layers[depsgraph.view_layer.name]))
        self._changed = self.fingerprint.differences(self._fingerprint_now(scene, depsgraph))
        self._moved.clear()
        self.unsure = False

    def _accept_from_other_version(self, scene: Any, depsgraph: Any) -> None:
        """Compute the fingerprint anew if another version of Blender made the recording.

        The recording must have been fresh when the file was saved. In addition, the digests that
        all versions of Blender compute alike must show no change of the scene.
        """
        made = self.fingerprint
        if made.portable and not self.stale_then and made.portable == portable(scene, depsgraph):
            self.fingerprint = fingerprint_of(scene, depsgraph, made.light)
            self.fingerprint.portable = made.portable
            self.names = _names_of(scene.view_layers[depsgraph.view_layer.name])
            self.blender, self.stored = THIS_BLENDER, ""

    def add_portable(self, scene: Any) -> None:
        """Add digests to the fingerprint that all versions of Blender compute alike.

        Call this method before the file is saved. Add nothing while the recording is stale, because
        the scene then differs from the scene of the run.
        """
        layer = scene.view_layers.get(self.fingerprint.view_layer)
        depsgraph = None if self.fingerprint.portable or self.stale else layer.depsgraph
        if depsgraph is not None:
            self.fingerprint.portable, self.stored = portable(scene, depsgraph), ""

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

    def note_edit(
        self, scene: Any, depsgraph: Any, sensors: Sequence[Sensor], revision: int, playing: bool
    ) -> None:
        """Compare the datablocks that Blender reports as updated after an edit.

        Parameters
        ----------
        scene, depsgraph
            The scene and its depsgraph, which has the updates.
        sensors, revision
            All sensors of the scene, and the revision of the scene at which they were listed.
        playing
            Whether the animation plays.
        """
        if self._is_other_view_layer(depsgraph):
            return
        if self.unsure:
            self.verify(scene, depsgraph)
            return
        before = self._renamed
        self._compare_scene(scene, depsgraph, sensors, revision)
        # When an object is renamed, Blender also reports datablocks that refer to it as updated.
        follows = playing or before != self._renamed
        updates = list(depsgraph.updates)
        originals = {update.id.original: update for update in updates}
        if any(isinstance(o, bpy.types.Action) or o.is_embedded_data for o in originals):
            # Keyframes and nodes count as part of the datablock that owns them. Blender may report
            # no update of the owner.
            originals.update(dict.fromkeys(_owners(depsgraph, originals)))
        for original, update in originals.items():
            self.check(original)
            if follows or not isinstance(original, bpy.types.Object) or update is None:
                continue
            moved = update.is_updated_transform or update.is_updated_geometry
            off = is_off_keys(original, scene) if moved else False
            # When collections are shown or hidden, Blender reports all that is animated.
            if off is None:
                off = not depsgraph.id_type_updated("COLLECTION")
            if off:
                self._moved[key_of(original)] = f"'{original.name}'"
            elif moved:
                self._moved.pop(key_of(original), None)

    def note_other_scene(self, depsgraph: Any) -> None:
        """Check updates in another scene, which may share datablocks with the recording's scene.

        If a datablock may be shared, the recording is unsure until `verify`.
        """
        for original in (update.id.original for update in depsgraph.updates):
            # Blender may report no update of the datablocks that own keyframes and nodes.
            hidden = isinstance(original, bpy.types.Action) or original.is_embedded_data
            if not isinstance(original, bpy.types.Scene):
                self.unsure |= hidden or key_of(original) in self.fingerprint.digests

    def note_frame(
        self, scene: Any, depsgraph: Any, sensors: Sequence[Sensor], revision: int
    ) -> None:
        """Compare the scene after a change of frame.

        The change of frame puts animated objects that an edit had moved back to their keyframes.
        `sensors` are all sensors, listed at this `revision` of the scene. If the revision has not
        changed since the last comparison, only the scene's settings are compared.
        """
        self._moved.clear()
        if self._is_other_view_layer(depsgraph):
            return
        if self.unsure:
            self.verify(scene, depsgraph)
        elif revision == self._revision:
            # Blender reports no edits of custom properties and texts, so these are compared always.
            self._compare({SCENE: self._settings(scene, sensors)})
        else:
            self._compare_scene(scene, depsgraph, sensors, revision)

    def check(self, original: Any) -> None:
        """Compare one original datablock (not an evaluated copy) with the fingerprint."""
        if isinstance(original, bpy.types.Scene):
            layer = original.view_layers.get(self.fingerprint.view_layer)
            if layer is not None:
                self._compare(self._scene_digests(original, layer, all_sensors(layer)))
            return
        known = self.fingerprint.digests
        key = key_of(original, self._renamed)
        if is_looked_at(original) and key in known:
            self._compare({key: digest_of(original, self._renamed)})
        self._compare({k: d for k, d in warmth_of(original).items() if k in known})

    def _fingerprint_now(self, scene: Any, depsgraph: Any) -> Fingerprint:
        return fingerprint_of(scene, depsgraph, self.fingerprint.light, self._renamed)

    def _settings(self, scene: Any, sensors: Sequence[Sensor]) -> str:
        return own_settings(scene, sensors, self.fingerprint.light, self._renamed)

    def _scene_digests(self, scene: Any, layer: Any, sensors: Sequence[Sensor]) -> dict[str, str]:
        return {
            SCENE: self._settings(scene, sensors),
            SHOWN: what_is_shown(layer, self._renamed),
        }

    def _compare_scene(
        self, scene: Any, depsgraph: Any, sensors: Sequence[Sensor], revision: int
    ) -> None:
        self._revision = revision
        self._find_renamed(sensors)
        around = self._scene_digests(scene, scene.view_layers[depsgraph.view_layer.name], sensors)
        differs = self.fingerprint.difference(SHOWN, around[SHOWN])
        count = len(bpy.data.objects)
        if count != self._objects and (differs or _names_new_or_gone(self._changed)):
            # An object was added or removed, perhaps one that was added since the run. Only a
            # comparison of the whole scene shows which. An asset is imported at one update and
            # joins the scene at a later one: until then `_objects` keeps the earlier count.
            self._objects = count
            self._changed = self.fingerprint.differences(self._fingerprint_now(scene, depsgraph))
        self._compare(around)

    def _find_renamed(self, sensors: Iterable[Sensor]) -> None:
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
        self.stored, self.fingerprint.portable = "", {}

    def was_called(self, sensor: Sensor, name: str) -> bool:
        """Return whether a sensor had the name `name` at the run, and has not changed otherwise."""
        renamed = _renamed(sensor, name)
        known = self.fingerprint.digests
        parts = (*sensor.holders, sensor.object)
        return bool(renamed) and all(
            known.get(key_of(part, renamed)) == digest_of(part, renamed) for part in parts
        )

    def _compare(self, now: dict[str, str]) -> None:
        for key, digest in now.items():
            text = self.fingerprint.difference(key, digest)
            if text:
                self._changed[key] = text
            else:
                self._changed.pop(key, None)

    def _is_other_view_layer(self, depsgraph: Any) -> bool:
        """Return whether the depsgraph belongs to another view layer than the recording."""
        self._other_view_layer = depsgraph.view_layer.name != self.fingerprint.view_layer
        # Updates of another view layer do not show whether the recording is stale.
        self.unsure |= self._other_view_layer
        return self._other_view_layer


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


def version_text(version: tuple[int, ...]) -> str:
    """Return a version of Blender as a text."""
    return ".".join(map(str, version))


def _names_new_or_gone(changed: dict[str, str]) -> bool:
    return any(text.endswith(("(new)", "(gone)")) for text in changed.values())


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


def _owners(depsgraph: Any, changed: Any) -> list[Any]:
    """Return the datablocks that may own a changed action or a changed node tree.

    Blender does not report the owners. So return all datablocks with animation if an action is in
    `changed`, and all with nodes if a node tree is.
    """
    actions = {o for o in changed if isinstance(o, bpy.types.Action)}
    embedded = any(o.is_embedded_data for o in changed)
    found = []
    for evaluated in depsgraph.ids:
        original = evaluated.original
        animation = getattr(original, "animation_data", None)
        holds_nodes = isinstance(original, (bpy.types.Light, bpy.types.Material, bpy.types.World))
        if (actions and animation is not None) or (embedded and holds_nodes):
            found.append(original)
    return found
