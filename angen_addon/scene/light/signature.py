# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether anything that light depends on has changed since the last look.

Blender's list of updates names everything that may have changed, and every animated datablock at
every frame. So it says where to look, and values decide. What cannot be compared (nodes that make
geometry, images, volumes) counts as changed.
"""

from __future__ import annotations

import hashlib
from typing import Any

import bpy
import numpy as np

from .lamps import tint_of
from .scene import MARK, shown_objects
from .values import (
    lamp_values,
    looked_up,
    names_looked_up,
    object_values,
    own_properties,
    tree_values,
    values,
)

# Modifiers that move vertices and touch nothing else that a material can look at.
DEFORMING = {"ARMATURE", "CAST", "CURVE", "HOOK", "LATTICE", "MESH_DEFORM", "SHRINKWRAP"}
DEFORMING |= {"SIMPLE_DEFORM", "SMOOTH", "CORRECTIVE_SMOOTH", "SUBSURF", "SURFACE_DEFORM", "WARP"}
# Objects whose place alone matters to no light.
LIGHTLESS = {"EMPTY", "CAMERA", "ARMATURE", "SPEAKER", "LATTICE"}
# Datablocks that are told of by the objects, or that light does not depend on.
TOLD_ELSEWHERE = (
    bpy.types.Action,
    bpy.types.Armature,
    bpy.types.Camera,
    bpy.types.Collection,
    bpy.types.Key,
    bpy.types.Scene,
    bpy.types.Speaker,
)


class LightSignature:
    """Remembers the state of a scene as digests. To be told of updates as they come."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """The next look finds everything changed: after undo, or when a file was opened."""
        self._count = 0
        self._known: dict[int, bytes] = {}
        self._digest = b""
        self._powers = b""
        # Whether all but the power of lamps was as before when this was last asked.
        self.only_power_changed = False
        self._empties_matter = False
        # What nodes look up in the view layer, the scene and the world.
        self._names: set[str] = set()

    def note(self, depsgraph: Any, edited: bool = False, by_frame: bool = False) -> None:
        """Takes down what was evaluated anew; to be called in the handlers of each evaluation:
        later the list is empty. `edited`: by more than a change of frame."""
        if not self._known:
            return
        for update in depsgraph.updates:
            changed = update.id
            if isinstance(changed, TOLD_ELSEWHERE):
                continue
            if isinstance(changed, bpy.types.Object):
                self._compare(changed.original, object_values(changed))
                if update.is_updated_geometry and changed.type not in LIGHTLESS | {"LIGHT"}:
                    self._compare_shape(changed)
            elif isinstance(changed, bpy.types.Mesh) and not edited:
                # Its object tells of the shape.
                self._compare(changed.original, own_properties(changed))
            else:
                self._compare(changed.original, self._values_of(changed))

    def changed(self, view_layer: Any, depsgraph: Any, asked: Any = None) -> bool:
        """Whether the scene, or what is `asked` of it, differs from when this was last asked."""
        if not self._known:
            self._know_all(depsgraph)
        digest = hashlib.blake2b(digest_size=16)
        scene = view_layer.id_data
        world = scene.world.session_uid if scene.world else 0
        names = [(name, looked_up(name, view_layer)) for name in sorted(self._names)]
        apart, other = _powers(view_layer)
        digest.update(repr((self._count, world, asked, names, other)).encode())
        self._objects(digest, view_layer, depsgraph)
        before = self._digest, self._powers
        self._digest, self._powers = digest.digest(), repr(apart).encode()
        self.only_power_changed = self._digest == before[0]
        return (self._digest, self._powers) != before

    def _compare(self, original: Any, found: Any) -> None:
        key, digest = original.as_pointer(), _digest(found)
        if digest is None or self._known.get(key) != digest:
            self._count += 1
            self._known[key] = digest or b""

    def _compare_shape(self, evaluated: Any) -> None:
        original = evaluated.original
        comparable = original.type == "MESH" and all(
            m.type in DEFORMING for m in original.modifiers
        )
        mesh = evaluated.data if comparable else None
        if mesh is None or mesh.is_editmode:
            self._count += 1
            return
        # Beside the object's own entry.
        key, digest = -original.as_pointer(), _shape(mesh)
        if self._known.get(key) != digest:
            self._count += 1
            self._known[key] = digest

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
            found, looks_at_objects = tree_values(datablock)
            self._empties_matter |= looks_at_objects
            self._names |= names_looked_up(datablock)
            return found
        if isinstance(datablock, bpy.types.Light):
            # Their power is looked at at each update. An embedded tree is told of by itself too.
            return lamp_values(datablock, power=False)
        if isinstance(datablock, (bpy.types.Material, bpy.types.World)):
            tree = datablock.node_tree
            return values(datablock), self._values_of(tree) if tree else ()
        return None

    def _objects(self, digest: Any, view_layer: Any, depsgraph: Any) -> None:
        """What is shown, and where."""
        objects = depsgraph.objects
        matrices = np.empty(len(objects) * 16, np.float32)
        objects.foreach_get("matrix_world", matrices)
        if not self._empties_matter:
            matter = np.fromiter((o.type not in LIGHTLESS for o in objects), bool, len(objects))
            matrices = matrices.reshape(-1, 16)[matter]
        digest.update(matrices.tobytes())
        shown = [
            obj.session_uid for obj in view_layer.objects if obj.visible_get(view_layer=view_layer)
        ]
        digest.update(np.array(shown, np.uint64).tobytes())
        if any(obj.is_instancer for obj in view_layer.objects):
            for instance in depsgraph.object_instances:
                if instance.is_instance:
                    seen = instance.object.session_uid, instance.show_self
                    digest.update(repr(seen).encode())
                    digest.update(np.array(instance.matrix_world, np.float32).tobytes())


def _powers(view_layer: Any) -> tuple[list[Any], list[Any]]:
    """Power of the lamps that are shown, and of those that others too, such as instances, have."""
    shown: dict[Any, int] = {}
    for obj in shown_objects(view_layer):
        if obj.type == "LIGHT":
            shown[obj.data] = shown.get(obj.data, 0) + 1
    apart: list[Any] = []
    other: list[Any] = []
    for data in bpy.data.lights:
        if MARK in data:
            continue
        power = data.session_uid, data.energy, *tint_of(data)
        is_apart = data.users - data.use_fake_user == shown.get(data)
        (apart if is_apart else other).append(power)
    return apart, other


def _digest(found: Any) -> bytes | None:
    if found is None:
        return None
    return hashlib.blake2b(repr(found).encode(), digest_size=16).digest()


def _shape(mesh: Any) -> bytes:
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.attributes["position"].data.foreach_get("vector", points)
    digest = hashlib.blake2b(points.tobytes(), digest_size=16)
    digest.update(repr((len(mesh.loops), len(mesh.polygons))).encode())
    return digest.digest()
