# SPDX-License-Identifier: GPL-3.0-or-later
"""Turn sensors that were dragged from the Asset Browser, so that they look out of their surface.

Blender lays the underside of a dropped object's bounding box on the surface, with +Z outwards. A
sensor would look into its wall then, at the end of the lines that show where it looks.
"""

from __future__ import annotations

import sys
from typing import Any

import bpy
from mathutils import Matrix, Vector

from ...sensor_logic.kinds import KINDS, NO_KIND
from ..appearance.housing import Housing, housing_mesh
from ..runtime import handlers
from ..scene.home.first_surface import belongs_to, first_surface
from ..scene.home.rooms import fill_room
from ..scene.marks import HOUSING_MARK
from ..scene.sensors import unit_scale
from .of_kind import housing_of, place_on

# Blender's operators at the end of a drag, for assets of other files and of this file.
DROPS = {"OBJECT_OT_transform_to_mouse", "OBJECT_OT_add_named"}
# Relative tolerance of matrices in single precision.
SAME = 1e-5
# m. The surface is searched this far around the point where the sensor was dropped.
NEAR_M = 0.01

# The matrix with which Blender dropped a sensor, by its session uid. Undo and redo bring it back,
# and empty Blender's list of operators.
_drops: dict[int, Matrix] = {}
# Session uids of the sensors whose place, with its room, is that of the drop: such as a pad's.
_done: set[int] = set()


def wants_rays(scene: Any) -> bool:
    """Return False, because nothing is drawn here."""
    return False


def follow(scene: Any, view_layer: Any, depsgraph: Any) -> None:
    """Do nothing at a frame change, because only an edit drops a sensor."""


def note_edit(scene: Any) -> None:
    """Place the sensors that were dropped on surfaces, and fill in their rooms."""
    if scene != bpy.context.scene:
        return
    _note_drops(scene)
    if not _operators():
        # After undo or redo.
        _done.clear()
    for obj in scene.objects if _drops else ():
        matrix = _drops.get(obj.session_uid)
        if matrix is None or obj.session_uid in _done or obj.angen_sensor.kind == NO_KIND:
            continue
        if _is_same(obj.matrix_basis, matrix):
            _place(scene, obj, matrix)
            if _is_same(obj.matrix_basis, matrix):
                _done.add(obj.session_uid)


def _operators() -> Any:
    """Return Blender's list of the operators that ran, which undo empties."""
    return bpy.context.window_manager.operators


def _note_drops(scene: Any) -> None:
    """Store which sensors were dropped with which matrix.

    Blender's list of operators tells it, since no handler is called for a drop.
    """
    for operator in _operators():
        if operator.bl_idname not in DROPS or not operator.properties.is_property_set("matrix"):
            continue
        # Blender copies an asset of the present file: the copy is known by its matrix.
        is_copy = operator.bl_idname == "OBJECT_OT_add_named"
        matrix = Matrix(operator.properties.matrix)
        uid = operator.properties.session_uid
        for obj in scene.objects:
            if (not is_copy and obj.session_uid != uid) or obj.angen_sensor.kind == NO_KIND:
                continue
            is_free = obj.parent is None and obj.library is None
            if is_free and _is_same(obj.matrix_basis, matrix):
                _drops[obj.session_uid] = matrix


def _is_same(one: Matrix, other: Matrix) -> bool:
    size = 1.0 + other.translation.length
    return all(
        abs(a - b) <= SAME * size for i in range(4) for a, b in zip(one[i], other[i], strict=True)
    )


def _place(scene: Any, sensor: Any, dropped: Matrix) -> None:
    """Place a dropped sensor with its back on the surface, and fill in its room."""
    low, high = (Vector(map(of, zip(*sensor.bound_box, strict=True))) for of in (min, max))
    point = dropped @ Vector(((low.x + high.x) / 2, (low.y + high.y) / 2, low.z))
    normal = dropped.col[2].xyz.normalized()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    near = normal * (NEAR_M / unit_scale(scene))
    surface = first_surface(
        scene, depsgraph, point + near, -near, 2 * near.length, lambda o: belongs_to(o, sensor)
    )
    settings = sensor.angen_sensor
    _fit_unit(scene, sensor)
    size = sensor.matrix_basis.to_scale()
    along = surface.axes if surface is not None and surface.whole else []
    matrix = place_on(settings.kind, _housing(sensor, size), point, normal, along=along)
    matrix = matrix @ Matrix.Diagonal((*size, 1.0))
    sensor.matrix_basis = matrix
    fill_room(depsgraph, sensor, matrix.translation + near)


def _fit_unit(scene: Any, sensor: Any) -> None:
    """Give a sensor its housing in real size, if that was made for scenes in metres.

    Blender keeps the numbers of an asset's mesh, also where a unit is not a metre.
    """
    settings, scale = sensor.angen_sensor, unit_scale(scene)
    if scale == 1.0 or sensor.type != "MESH" or HOUSING_MARK not in sensor.data:
        return
    housing = housing_of(settings.kind, settings.preset)
    points = [vertex.co for vertex in sensor.data.vertices]
    if len(points) == len(housing.points) and all(
        (one - Vector(other)).length < SAME
        for one, other in zip(points, housing.points, strict=True)
    ):
        sensor.data = housing_mesh(housing, KINDS[settings.kind].label, scale)


def _housing(sensor: Any, size: Vector) -> Housing:
    """Return the mesh of a sensor, scaled, in Blender units; without a mesh a point."""
    if sensor.type != "MESH":
        return Housing()
    points = [tuple(vertex.co * size) for vertex in sensor.data.vertices]
    return Housing(points, [tuple(face.vertices) for face in sensor.data.polygons])  # type: ignore[misc]


def register() -> None:
    handlers.add_view(sys.modules[__name__])  # type: ignore[arg-type]


def unregister() -> None:
    handlers.remove_view(sys.modules[__name__])  # type: ignore[arg-type]
    _done.clear()
    _drops.clear()
