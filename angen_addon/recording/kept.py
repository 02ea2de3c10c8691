# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording that is kept, and whether the scene is still the one that it was made of."""

from __future__ import annotations

import secrets
from collections.abc import Iterable, Sequence
from typing import Any

import bpy

from ...sensor_logic.kind import LIGHT, REFLECTANCE
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.recording.tracks import Recording
from ...sensor_logic.wording import listed
from ..scene.sensors import Sensor, all_sensors
from .fingerprint import (
    SCENE,
    SHOWN,
    Fingerprint,
    digest_of,
    is_looked_at,
    key_of,
    own_settings,
    take,
    warmth_of,
    what_is_shown,
)
from .portable import portable

HERE = tuple(bpy.app.version[:2])


class StoredRecording:
    """`unsure` after undo or load, until `verify`; `stored` is how a file holds it, once made;
    `blender` the version whose properties the fingerprint is of; `mark` tells it from all others,
    also of other sessions; `made_in` the version that it was made in, and `stale_then` why it was
    stale when its file was saved."""

    def __init__(
        self, recording: Recording, fingerprint: Fingerprint, blender: tuple[int, ...] = ()
    ) -> None:
        self.recording = recording
        self.fingerprint = fingerprint
        self.blender = self.made_in = blender or HERE
        self.stale_then = ""
        self.mark = 1 + secrets.randbelow(2**31 - 1)
        self.unsure = False
        self.stored = ""
        # What differs from the fingerprint, in words, by its key there.
        self._changed: dict[str, str] = {}
        # Animated things that the user moved: they are back in place at the next frame.
        self._touched: dict[str, str] = {}
        # How many the file had when that was looked at last.
        self._objects = len(bpy.data.objects)
        self._elsewhere = False
        self._renamed: dict[str, str] = {}
        # The list of sensors that names and what is shown were looked at with last.
        self._sensors: Sequence[Sensor] | None = None

    @property
    def stale(self) -> str:
        """What makes the recording stale, in a few words; empty while it is fresh."""
        if self.blender != HERE:
            return f"it was made in Blender {version_text(self.blender)}"
        if self._elsewhere:
            return f"it is of the view layer '{self.fingerprint.view_layer}'"
        if self.unsure:
            return "it is not known whether the scene is still the same"
        # A sensor's name is in the log, and decides its noise.
        names = [f"'{then}' is called '{now}'" for now, then in self._renamed.items()]
        changed = self._changed | self._touched
        if any(text.endswith(("(new)", "(gone)")) for text in changed.values()):
            # That tells what else is shown.
            changed.pop(SHOWN, None)
        # Objects, which users know by name, before their meshes.
        keys = sorted(changed, key=lambda key: not key.startswith("Object "))
        names += dict.fromkeys(changed[key] for key in keys)
        if not names:
            return ""
        return f"changed since: {listed(names, 3)}"

    def verify(self, scene: Any, depsgraph: Any) -> None:
        """Looks at everything; to be called after undo and load, and before results leave."""
        if self._is_elsewhere(depsgraph):
            return
        if self.blender != HERE:
            self._carry_over(scene, depsgraph)
        self._note_names(all_sensors(scene.view_layers[depsgraph.view_layer.name]))
        now = take(scene, depsgraph, self.fingerprint.light, self._renamed)
        self._changed = self.fingerprint.differences(now)
        self._touched.clear()
        self.unsure = False

    def _carry_over(self, scene: Any, depsgraph: Any) -> None:
        """Takes a scene that another version saved for the one of the recording, if all that both
        versions tell alike is the same, and the recording was fresh then."""
        made = self.fingerprint
        if made.portable and not self.stale_then and made.portable == portable(scene, depsgraph):
            self.fingerprint = take(scene, depsgraph, made.light)
            self.fingerprint.portable = made.portable
            self.blender, self.stored = HERE, ""

    def note_edit(
        self, scene: Any, depsgraph: Any, sensors: Sequence[Sensor], playing: bool
    ) -> None:
        """Looks at what was just evaluated for another reason than a change of frame."""
        if self._is_elsewhere(depsgraph):
            return
        if self.unsure:
            self.verify(scene, depsgraph)
            return
        before = self._renamed
        self._note_surroundings(scene, depsgraph, sensors)
        # Blender then evaluates anew all that refers to what was renamed: nobody moved it.
        follows = playing or before != self._renamed
        updates = list(depsgraph.updates)
        originals = {update.id.original: update for update in updates}
        if any(isinstance(o, bpy.types.Action) or o.is_embedded_data for o in originals):
            # Keys and nodes count as part of what they belong to, which may not be told of.
            originals.update(dict.fromkeys(_owners(depsgraph, originals)))
        for original, update in originals.items():
            self.check(original)
            if follows or not isinstance(original, bpy.types.Object) or update is None:
                continue
            moved = update.is_updated_transform or update.is_updated_geometry
            if moved and original.animation_data is not None:
                self._touched[key_of(original)] = f"'{original.name}'"

    def note_elsewhere(self, depsgraph: Any) -> None:
        """Another scene was evaluated anew, in part perhaps what this one has too."""
        for original in (update.id.original for update in depsgraph.updates):
            # Keys and nodes belong to something that may not be told of.
            hidden = isinstance(original, bpy.types.Action) or original.is_embedded_data
            if not isinstance(original, bpy.types.Scene):
                self.unsure |= hidden or key_of(original) in self.fingerprint.digests

    def note_frame(self, scene: Any, depsgraph: Any, sensors: Sequence[Sensor]) -> None:
        """The playhead moved: what is animated is where its keys say. `sensors`: the same list as
        long as nothing else was changed."""
        self._touched.clear()
        if self._is_elsewhere(depsgraph):
            return
        if self.unsure:
            self.verify(scene, depsgraph)
        elif sensors is self._sensors:
            # Of the user's own properties and of texts Blender tells no change.
            now = own_settings(scene, sensors, self.fingerprint.light, self._renamed)
            self._compare({SCENE: now})
        else:
            self._note_surroundings(scene, depsgraph, sensors)

    def check(self, original: Any) -> None:
        """Looks at one datablock."""
        if isinstance(original, bpy.types.Scene):
            layer = original.view_layers.get(self.fingerprint.view_layer)
            if layer is not None:
                self._compare(self._around(original, layer, all_sensors(layer)))
            return
        known = self.fingerprint.digests
        key = key_of(original, self._renamed)
        if is_looked_at(original) and key in known:
            self._compare({key: digest_of(original, self._renamed)})
        self._compare({k: d for k, d in warmth_of(original).items() if k in known})

    def _around(self, scene: Any, layer: Any, sensors: Sequence[Sensor]) -> dict[str, str]:
        light, renamed = self.fingerprint.light, self._renamed
        return {
            SCENE: own_settings(scene, sensors, light, renamed),
            SHOWN: what_is_shown(layer, renamed),
        }

    def _note_surroundings(self, scene: Any, depsgraph: Any, sensors: Sequence[Sensor]) -> None:
        self._sensors = sensors
        self._note_names(sensors)
        around = self._around(scene, scene.view_layers[depsgraph.view_layer.name], sensors)
        before, self._objects = self._objects, len(bpy.data.objects)
        if before != self._objects and self.fingerprint.difference(SHOWN, around[SHOWN]):
            # An object came or went: only a look at everything tells which.
            now = take(scene, depsgraph, self.fingerprint.light, self._renamed)
            self._changed = self.fingerprint.differences(now)
        self._compare(around)

    def _note_names(self, sensors: Iterable[Sensor]) -> None:
        """Which of the recorded sensors have another name now."""
        recorded = {track.uid: name for name, track in self.recording.tracks.items()}
        self._renamed = {}
        for sensor in sensors:
            self._renamed |= _renamed(sensor, recorded.get(sensor.uid, sensor.name))

    def was_called(self, sensor: Sensor, name: str) -> bool:
        """Whether a sensor had this name at the run, and is the same but for that."""
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

    def _is_elsewhere(self, depsgraph: Any) -> bool:
        """Whether another view layer is looked at; what happens there is not followed."""
        self._elsewhere = depsgraph.view_layer.name != self.fingerprint.view_layer
        self.unsure |= self._elsewhere
        return self._elsewhere


def keep(recording: Recording, scene: Any, depsgraph: Any) -> StoredRecording:
    """The recording of a run that has just ended, with the scene as it is."""
    kinds = [KINDS[track.kind_name] for track in recording.tracks.values()]
    light = any(kind.requires(LIGHT) or kind.requires(REFLECTANCE) for kind in kinds)
    made = take(scene, depsgraph, light)
    made.portable = portable(scene, depsgraph)
    return StoredRecording(recording, made)


def version_text(version: tuple[int, ...]) -> str:
    return ".".join(map(str, version))


def _renamed(sensor: Sensor, then: str) -> dict[str, str]:
    """By their names now, what the sensor's object, and those that instance it, were called when
    the sensor was called `then`."""
    parts = (*sensor.holders, sensor.object)
    names = then.split("/") if sensor.holders else [then]
    if len(names) != len(parts):
        return {}
    return {p.name: name for p, name in zip(parts, names, strict=True) if p.name != name}


def _owners(depsgraph: Any, changed: Any) -> list[Any]:
    """What is animated by actions, or holds node trees, that changed."""
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
