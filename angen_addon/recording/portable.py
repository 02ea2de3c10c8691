# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of a scene that all versions of Blender compute alike, although their properties differ:
of poses and animation, meshes, bones, lamps and sensors, and of the names of materials."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from .digests import Facts, animation_facts, part_facts, setting_facts
from .fingerprint import (
    SCENE,
    SHOWN,
    digest,
    harmless_cameras,
    is_looked_at,
    key_of,
    scene_facts,
    what_is_shown,
)
from .mesh_digests import corners_and_faces, weights_of

OF_OBJECT = (
    "location", "rotation_mode", "rotation_euler", "rotation_quaternion", "rotation_axis_angle",
    "scale", "delta_location", "delta_rotation_euler", "delta_scale", "hide_viewport",
    "display_type", "instance_type", "angen_ignored",
)  # fmt: skip
OF_BODY = ("type", "enabled", "kinematic", "mass", "collision_shape", "friction", "restitution")
OF_LIGHT = ("type", "energy", "color", "shadow_soft_size", "shape", "size", "size_y", "spot_size",
            "angle")  # fmt: skip
SHAPED = {"CURVE", "CURVES", "FONT", "META", "SURFACE"}


def portable(scene: Any, depsgraph: Any) -> dict[str, str]:
    """Digests by the keys of a fingerprint, to compare scenes between versions of Blender."""
    layer = scene.view_layers[depsgraph.view_layer.name]
    found = {
        SCENE: digest([scene_facts(scene), animation_facts(scene)]),
        SHOWN: what_is_shown(layer),
    }
    originals = [evaluated.original for evaluated in depsgraph.ids]
    harmless = set(harmless_cameras(originals))
    for original in originals:
        if original not in harmless and is_looked_at(original):
            found[key_of(original)] = digest(list(_facts(original)))
    return found


def _facts(original: Any) -> Iterator[Any]:
    yield animation_facts(original)
    if isinstance(original, bpy.types.Object):
        yield from _object(original)
    elif isinstance(original, bpy.types.Mesh):
        yield from _mesh(original)
    elif isinstance(original, bpy.types.Armature):
        yield [
            (bone.name, bone.parent.name if bone.parent else "", *bone.head_local, *bone.tail_local)
            for bone in original.bones
        ]
    elif isinstance(original, bpy.types.Light):
        yield setting_facts(original, original, [n for n in OF_LIGHT if hasattr(original, n)])


def _object(obj: Any) -> Iterator[Facts]:
    yield [obj.type, *(getattr(other, "name_full", "") for other in (obj.data, obj.parent))]
    yield [getattr(slot.material, "name_full", "") for slot in obj.material_slots]
    yield setting_facts(obj, obj, OF_OBJECT)
    yield [tuple(row) for row in obj.matrix_parent_inverse]
    yield [(modifier.name, modifier.type, modifier.show_viewport) for modifier in obj.modifiers]
    yield [(constraint.name, constraint.type, constraint.mute) for constraint in obj.constraints]
    yield [part_facts(obj, obj.angen_sensor), part_facts(obj, obj.angen_load)]
    if obj.rigid_body is not None:
        yield setting_facts(obj, obj.rigid_body, OF_BODY)
    if obj.type == "MESH" and obj.vertex_groups:
        yield weights_of(obj.data)
    if obj.type in SHAPED:
        # Each version stores their points in another way.
        yield [tuple(round(c, 4) for c in corner) for corner in obj.bound_box]


def _mesh(mesh: Any) -> Iterator[Any]:
    if mesh.is_editmode:
        yield "is edited"
        return
    yield from corners_and_faces(mesh)
