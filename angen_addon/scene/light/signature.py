# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether anything that light depends on has changed since the last look.

Blender's list of updates names everything that may have changed, and every animated datablock at
every frame. So it says where to look, and values decide. What cannot be compared (nodes that make
geometry, images, volumes) counts as changed.
"""

from __future__ import annotations

import hashlib
from enum import Flag, auto
from typing import Any

import bpy
import numpy as np

from ..animation import only_moves
from ..timed import films
from .scene import shown_objects
from .values import (
    LIGHTLESS,
    TOLD_ELSEWHERE,
    lamp_values,
    looked_up,
    looks_at_places,
    names_looked_up,
    object_values,
    own_properties,
    powers,
    shape_values,
    tree_values,
    values,
)


class LightChange(Flag):
    """What of a scene differs from the last look; false where nothing does. `MOTION`: place and
    shape of its objects, and which picture of a film they show."""

    NONE = 0
    POWER = auto()
    MOTION = auto()
    VALUES = auto()


class LightSignature:
    """Remembers the state of a scene as digests. To be told of updates as they come."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """The next look finds everything changed: after undo, or when a file was opened."""
        # Changes of values and of shapes.
        self._count = self._reshaped = 0
        self._known: dict[int, bytes] = {}
        self._digests: dict[LightChange, bytes | None] = dict.fromkeys(LightChange)
        self._empties_matter = False
        # Pictures that change by themselves: Blender's list of updates does not tell of them.
        self._has_films = False
        # By object, whether frames can change where it is, and no other value of its own.
        self._only_moves: dict[int, bool] = {}
        # What nodes look up in the view layer, the scene and the world.
        self._names: set[str] = set()
        # Whether anybody asks about the frames that come: each names all that frames can change.
        self.is_asked = True

    def note(self, depsgraph: Any, edited: bool = False, by_frame: bool = False) -> None:
        """Takes down what was evaluated anew; to be called in the handlers of each evaluation:
        later the list is empty. `edited`: by more than a change of frame."""
        if not self._known or (by_frame and not edited and not self.is_asked):
            return
        if edited:
            self._only_moves.clear()
        for update in depsgraph.updates:
            changed = update.id
            if isinstance(changed, TOLD_ELSEWHERE):
                continue
            if isinstance(changed, bpy.types.Object):
                if edited or self._may_change(changed.original):
                    self._compare(changed.original, object_values(changed))
                if update.is_updated_geometry and changed.type not in LIGHTLESS | {"LIGHT"}:
                    self._compare_shape(changed)
            elif isinstance(changed, bpy.types.Mesh) and not edited:
                # Its object tells of the shape.
                self._compare(changed.original, own_properties(changed))
            else:
                self._compare(changed.original, self._values_of(changed))

    def changed(self, view_layer: Any, depsgraph: Any, asked: Any = None) -> LightChange:
        """What of the scene, or of what is `asked` of it, differs from when this was last asked."""
        if not self._known:
            self._know_all(depsgraph)
        scene = view_layer.id_data
        world = scene.world.session_uid if scene.world else 0
        names = [(name, looked_up(name, view_layer)) for name in sorted(self._names)]
        shown = list(shown_objects(view_layer))
        apart, other = powers(shown)
        uids = [obj.session_uid for obj in shown]
        found = {
            LightChange.POWER: _digest(apart),
            LightChange.MOTION: self._motion(view_layer, depsgraph),
            LightChange.VALUES: _digest([self._count, world, asked, names, other, uids]),
        }
        before, self._digests = self._digests, found
        return LightChange(sum(c.value for c in found if found[c] != before[c]))

    def _may_change(self, original: Any) -> bool:
        """Whether a frame can change more of an object than where it is, and its shape."""
        uid = original.session_uid
        if uid not in self._only_moves:
            self._only_moves[uid] = only_moves(original)
        return not self._only_moves[uid]

    def _compare(self, original: Any, found: Any) -> None:
        key, digest = original.as_pointer(), _digest(found)
        if digest is None or self._known.get(key) != digest:
            self._count += 1
            self._known[key] = digest or b""

    def _compare_shape(self, evaluated: Any) -> None:
        original = evaluated.original
        # Beside the object's own entry.
        key, digest = -original.as_pointer(), _digest(shape_values(evaluated))
        if digest is None or self._known.get(key) != digest:
            self._reshaped += 1
            self._known[key] = digest or b""

    def _know_all(self, depsgraph: Any) -> None:
        """The state against which updates are compared from now on."""
        self._known[0] = b""
        for obj in depsgraph.objects:
            self._known[obj.original.as_pointer()] = _digest(object_values(obj)) or b""
            if obj.type == "MESH" and (obj.original.modifiers or obj.original.data.shape_keys):
                self._compare_shape(obj)
        data = bpy.data
        for mesh in data.meshes:
            self._known[mesh.as_pointer()] = _digest(own_properties(mesh)) or b""
        for group in (data.worlds, data.materials, data.lights, data.node_groups):
            for original in group:
                evaluated = original.evaluated_get(depsgraph)
                self._known[original.as_pointer()] = _digest(self._values_of(evaluated)) or b""
                tree = getattr(original, "node_tree", None)
                if tree is not None and group is not data.node_groups:
                    found = self._values_of(evaluated.node_tree)
                    self._known[tree.as_pointer()] = _digest(found) or b""

    def _values_of(self, datablock: Any) -> Any:
        """The values of a datablock that light may depend on; None where they cannot be told."""
        if isinstance(datablock, bpy.types.NodeTree):
            self._empties_matter |= looks_at_places(datablock)
            self._has_films |= bool(films(datablock))
            self._names |= names_looked_up(datablock)
            return tree_values(datablock)
        if isinstance(datablock, bpy.types.Light):
            # Their power is looked at at each update. An embedded tree is told of by itself too.
            return lamp_values(datablock, power=False)
        if isinstance(datablock, (bpy.types.Material, bpy.types.World)):
            tree = datablock.node_tree
            return values(datablock), self._values_of(tree) if tree else ()
        return None

    def _motion(self, view_layer: Any, depsgraph: Any) -> bytes:
        """A digest of where everything is, of changes of shapes, and of the pictures of films."""
        digest, objects = hashlib.blake2b(digest_size=16), depsgraph.objects
        matrices = np.empty(len(objects) * 16, np.float32)
        objects.foreach_get("matrix_world", matrices)
        if not self._empties_matter:
            matter = np.fromiter((o.type not in LIGHTLESS for o in objects), bool, len(objects))
            matrices = matrices.reshape(-1, 16)[matter]
        digest.update(matrices.tobytes())
        film = view_layer.id_data.frame_float if self._has_films else None
        digest.update(repr((self._reshaped, film)).encode())
        if any(obj.is_instancer for obj in view_layer.objects):
            for instance in depsgraph.object_instances:
                if instance.is_instance:
                    seen = instance.object.session_uid, instance.show_self
                    digest.update(repr(seen).encode())
                    digest.update(np.array(instance.matrix_world, np.float32).tobytes())
        return digest.digest()


def _digest(found: Any) -> bytes | None:
    if found is None:
        return None
    return hashlib.blake2b(repr(found).encode(), digest_size=16).digest()
