# SPDX-License-Identifier: GPL-3.0-or-later
"""Find visible objects that look solid but have no faces: scans, lines, hair and volumes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import bpy
import numpy as np

from ...sensor_logic.model import Array
from ..scene.rays.solids import is_transient
from ..scene.timed import INSTANCING_MODIFIERS

# By Blender's type of an evaluated object: what it is, unless it has a mesh too.
KINDS = {
    "POINTCLOUD": "POINTS", "VOLUME": "VOLUME", "CURVES": "HAIR", "CURVE": "CURVES",
    "SURFACE": "CURVES", "FONT": "CURVES", "GPENCIL": "DRAWING", "GREASEPENCIL": "DRAWING",
}  # fmt: skip
# m. Smaller hair, drawings, curves and loose points hide nothing, such as the hair of a rug.
LEAST = 0.5
SMALL_ONES = ("HAIR", "DRAWING", "CURVES", "POINTS")


class Bare(NamedTuple):
    """A visible object without faces.

    Attributes
    ----------
    name
        The name of the object.
    kind
        EDGES, POINTS, CURVES, HAIR, VOLUME or DRAWING.
    bounds
        The least and greatest coordinates (2, 3) in the world, in m; none if they are unknown.
    """

    name: str
    kind: str
    bounds: list[Array]


def bare_objects(depsgraph: Any, view_layer: Any, metres: float) -> Iterator[Bare]:
    """Yield the visible objects without faces that sensors do not ignore.

    Curves that something else uses, such as a path that an object follows, are left out.
    """
    found: list[tuple[Any, str, list[Array]]] = []
    has_mesh = set()
    for instance in depsgraph.object_instances:
        seen, original = instance.object, instance.object.original
        owner = instance.parent.original if instance.is_instance else original
        ignored = original.angen_ignored or owner.angen_ignored
        if ignored or not instance.show_self or not owner.visible_get(view_layer=view_layer):
            continue
        is_mesh = instance.is_instance and seen.type == "MESH" and original.type in KINDS
        if is_mesh and len(seen.data.polygons):
            has_mesh.add(original)
        found += (
            (original, kind, _bounds(seen, instance.matrix_world, metres))
            for kind in _kinds(seen, original, depsgraph, metres)
        )
    curves = {obj for obj, kind, _ in found if kind == "CURVES" and obj.type in KINDS}
    users = bpy.data.user_map(subset=curves) if curves else {}
    for obj, kind, bounds in found:
        if kind == "CURVES" and (obj in has_mesh or _is_used(obj, users)):
            continue
        size = max((float((box[1] - box[0]).max()) for box in bounds), default=np.inf)
        if size >= LEAST or kind not in SMALL_ONES:
            yield Bare(obj.name, kind, bounds)


def _kinds(seen: Any, original: Any, depsgraph: Any, metres: float) -> Iterator[str]:
    """Yield what an evaluated object without faces is; nothing if it has faces."""
    if seen.type in KINDS:
        yield KINDS[seen.type]
    elif seen.type == "MESH" and not is_transient(depsgraph, seen, original):
        mesh = seen.data
        makes_more = any(m.type in INSTANCING_MODIFIERS for m in original.modifiers)
        if len(mesh.vertices) and not (len(mesh.polygons) or makes_more or original.is_instancer):
            yield "EDGES" if len(mesh.edges) else "POINTS"
        if any(_is_long_hair(system.settings, metres) for system in original.particle_systems):
            yield "HAIR"


def _is_long_hair(particles: Any, metres: float) -> bool:
    is_hair = particles.type == "HAIR" and particles.render_type == "PATH"
    return bool(is_hair and particles.hair_length * metres >= LEAST)


def _bounds(seen: Any, matrix: Any, metres: float) -> list[Array]:
    """Return the bounds (2, 3) of an evaluated object in m, in a list that is empty without any."""
    corners = np.array(seen.bound_box, np.float64)
    placed = np.array(matrix, np.float64)
    corners = (corners @ placed[:3, :3].T + placed[:3, 3]) * metres
    bounds = np.stack([corners.min(axis=0), corners.max(axis=0)])
    # Blender knows no bounds of curves that geometry nodes made.
    is_known = seen.type == seen.original.type or (bounds[0] < bounds[1]).any()
    return [bounds] if is_known and np.isfinite(bounds).all() else []


def _is_used(curve: Any, users: Any) -> bool:
    """Return whether another datablock than a collection or scene uses a curve."""
    lists = (bpy.types.Collection, bpy.types.Scene, bpy.types.WindowManager, bpy.types.Screen)
    return any(not isinstance(user, lists) for user in users.get(curve, ()))
