# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of the present scene with the scene for which a result was computed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import bpy

from ...sensor_logic.logs.wording import listed
from ..scene.animation import is_off_keys
from ..scene.facts import FACTS_VERSION
from ..scene.sensors import Sensor, all_sensors
from .fingerprint import (
    SCENE,
    SHOWN,
    Fingerprint,
    digest_of,
    fingerprint_of,
    is_looked_at,
    key_of,
    own_settings,
    warmth_of,
    what_is_shown,
)

THIS_BLENDER = tuple(bpy.app.version[:2])


class FollowedScene:
    """The fingerprint that a scene had when a result, such as a recording, was computed from it.

    Call the methods `note_…` after edits and changes of frame. They compare the datablocks that
    Blender reports as updated with the fingerprint.

    Attributes
    ----------
    fingerprint
        The fingerprint of the scene at the time of the result.
    unsure
        Whether the scene must be compared by `verify`, after undo or loading.
    stored
        The result as a text for the file; empty until it is encoded.
    blender
        The version of Blender that computed the fingerprint.
    facts
        The FACTS_VERSION with which the fingerprint was computed.
    """

    def __init__(self, fingerprint: Fingerprint, blender: tuple[int, ...] = ()) -> None:
        self.fingerprint = fingerprint
        self.blender = blender or THIS_BLENDER
        self.facts = FACTS_VERSION
        self.unsure = False
        self.stored = ""
        # Texts for the user on each difference from the fingerprint, by the fingerprint's key.
        self._changed: dict[str, str] = {}
        # Likewise for animated objects that the user moved. The next change of frame moves them
        # back to where their keyframes say.
        self._moved: dict[str, str] = {}
        # How many objects the file had when an object was last found to be new or gone. None after
        # `verify`: undo adds and removes objects without a count.
        self._objects: int | None = len(bpy.data.objects)
        self._other_view_layer = False
        # The former names of objects that were renamed since, by present name.
        self._renamed: dict[str, str] = {}
        # The revision of the scene at the last comparison of names and visibility.
        self._revision = -1

    @property
    def stale(self) -> str:
        """A short text on why the result is stale; empty while it is fresh."""
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
        objects = {key: text for key, text in changed.items() if key.startswith("Object ")}
        others = {key: text for key, text in changed.items() if key not in objects}
        if _names_new_or_gone(objects):
            # Their meshes and materials came or went with them.
            others = {key: text for key, text in others.items() if not _is_new_or_gone(text)}
        # Objects come first, since users know the names of objects better than the names of meshes.
        keys = [*objects, *others]
        names = {f"'{then}'": f"'{now}'" for now, then in self._renamed.items()}
        texts = dict.fromkeys(names.get(changed[key], changed[key]) for key in keys)
        return f"changed since: {listed(list(texts), 3)}" if texts else ""

    def verify(self, scene: Any, depsgraph: Any) -> None:
        """Compare the whole present scene with the scene then, part by part.

        Call this method after undo, after loading, and before an export.
        """
        if self._is_other_view_layer(depsgraph):
            return
        self._note_names(all_sensors(scene.view_layers[depsgraph.view_layer.name]))
        self._changed = self.fingerprint.differences(self._fingerprint_now(scene, depsgraph))
        self._moved.clear()
        self._objects, self.unsure = None, False

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
        """Check updates in another scene, which may share datablocks with this scene.

        If a datablock may be shared, the result is unsure until `verify`.
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
        self._note_names(sensors)
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

    def _note_names(self, sensors: Iterable[Sensor]) -> None:
        """Find the sensors that were renamed since. Without names, they count as changed."""

    def _compare(self, now: dict[str, str]) -> None:
        for key, digest in now.items():
            text = self.fingerprint.difference(key, digest)
            if text:
                self._changed[key] = text
            else:
                self._changed.pop(key, None)

    def _is_other_view_layer(self, depsgraph: Any) -> bool:
        """Return whether the depsgraph belongs to another view layer than the result."""
        self._other_view_layer = depsgraph.view_layer.name != self.fingerprint.view_layer
        # Updates of another view layer do not show whether the result is stale.
        self.unsure |= self._other_view_layer
        return self._other_view_layer


def version_text(version: tuple[int, ...]) -> str:
    """Return a version of Blender as a text."""
    return ".".join(map(str, version))


def _names_new_or_gone(changed: dict[str, str]) -> bool:
    return any(map(_is_new_or_gone, changed.values()))


def _is_new_or_gone(text: str) -> bool:
    return text.endswith(("(new)", "(gone)"))


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
