# SPDX-License-Identifier: GPL-3.0-or-later
"""Rooms that meshes mark, and the room at a point of a home.

A mesh marks a room if it is *Ignored by sensors* and has its Room set, or is displayed as wire or
bounds.
"""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from ....sensor_logic.model import Array
from ..marks import COVERAGE_MARK
from ..rays.geometry import faces_along
from ..sensors import (
    NotPlaced,
    is_placed,
    noted_room,
    placed_matrix,
    room_of,
    room_of_collections,
    unit_scale,
)
from .first_surface import belongs_to, first_surface

Mask = NDArray[np.bool_]

# A ray in this direction runs along no edge of a rectangular building.
ASKEW = np.array([0.1234, 0.2345, 0.9642]) / np.linalg.norm([0.1234, 0.2345, 0.9642])


class Volume:
    """An object whose mesh encloses a room. The user adds it to mark the room."""

    def __init__(self, depsgraph: Any, obj: Any) -> None:
        self.name = room_of(obj) or obj.name
        matrix, metres = placed_matrix(obj, depsgraph), unit_scale(depsgraph.scene)
        points = [matrix @ v.co * metres for v in obj.data.vertices]
        self.lo = np.min(np.array(points), axis=0)
        self.hi = np.max(np.array(points), axis=0)
        self._tree = BVHTree.FromPolygons(points, [tuple(p.vertices) for p in obj.data.polygons])

    def holds(self, points: Array) -> Mask:
        """Return a mask (n,) of the points (n, 3) that are inside the mesh.

        A ray from a point inside leaves the mesh through an odd number of faces.
        """
        inside = ((points >= self.lo) & (points <= self.hi)).all(axis=1)
        for i in np.flatnonzero(inside).tolist():
            inside[i] = faces_along(self._tree, points[i], ASKEW, 1e-4) % 2 == 1
        return inside


def volumes(depsgraph: Any) -> list[Volume]:
    """Return the meshes that mark rooms and that Blender evaluates, sorted by name."""
    marks = [
        obj
        for obj in depsgraph.view_layer.objects
        if obj.type == "MESH"
        and obj.angen_ignored
        and COVERAGE_MARK not in obj
        and len(obj.data.polygons) > 3
        and (room_of(obj) or obj.display_type in {"WIRE", "BOUNDS"})
    ]
    found = []
    for obj in sorted(marks, key=lambda obj: obj.name):
        with suppress(NotPlaced):
            found.append(Volume(depsgraph, obj))
    return found


# m. A room reaches at most this far. A storey has at least this height.
WIDEST_M, STOREY_M = 10.0, 2.2
# m. A search goes on this far below a surface.
STEP_M = 1e-3
PASSED = 64


def fill_room(depsgraph: Any, sensor: Any, point: Vector | None = None) -> None:
    """Set the Room of a new sensor to that at a point, unless it has one.

    The point, in Blender units, is where the sensor is, by default. A sensor that Blender does not
    place, such as one in a collection that others instance, gets no room.
    """
    if not noted_room(sensor) and (point is not None or is_placed(sensor, depsgraph)):
        here = sensor.matrix_world.translation if point is None else point
        sensor.angen_sensor.room = room_at(depsgraph, here, sensor)


def room_at(depsgraph: Any, point: Vector, own: Any = None) -> str:
    """Return the name of the room at a point, in Blender units; empty if nothing tells it.

    The room is that of a mesh around the point, or else the room after which the floor below is
    named. Otherwise it is the room of the nearest sensor or place in sight. `own` is an object that
    is passed over, such as the sensor at the point.
    """
    here = np.array([point]) * unit_scale(depsgraph.scene)
    for volume in volumes(depsgraph):
        if volume.holds(here)[0]:
            return volume.name
    noted = [(obj, noted_room(obj)) for obj in depsgraph.view_layer.objects if obj != own]
    rooms = [(obj, room) for obj, room in noted if room]
    if not rooms:
        return ""
    known = {room for _, room in rooms}
    return _room_of_floor(depsgraph, point, own, known) or _room_in_sight(
        depsgraph, point, own, rooms
    )


def _room_of_floor(depsgraph: Any, point: Vector, own: Any, known: set[str]) -> str:
    """Return the known room after which a surface below, or a collection of it, is named."""
    metres, down = unit_scale(depsgraph.scene), Vector((0.0, 0.0, -1.0))
    start, length, passes = point, WIDEST_M / metres, partial(_is_part, (own,))
    for _ in range(PASSED):
        hit = first_surface(depsgraph.scene, depsgraph, start, down, length, passes)
        if hit is None:
            break
        words = f" {hit.object.name.partition('.')[0].replace('_', ' ').lower()} "
        named = [room for room in known if f" {room.lower()} " in words]
        found = max(named, key=len, default="") or room_of_collections(hit.object, known)
        if found:
            return found
        # Below a floor the next storey begins.
        start, length = hit.point + down * (STEP_M / metres), STOREY_M / metres
    return ""


def _room_in_sight(depsgraph: Any, point: Vector, own: Any, rooms: list[tuple[Any, str]]) -> str:
    """Return the room of the nearest object in sight of all that have one."""
    most, found = WIDEST_M / unit_scale(depsgraph.scene), []
    for obj, room in rooms:
        away = (obj.matrix_world.translation - point).length
        if away <= most and is_placed(obj, depsgraph):
            found.append((away, obj.name, obj, room))
    for away, _, obj, room in sorted(found, key=lambda one: one[:2]):
        passes = partial(_is_part, (own, obj))
        way = obj.matrix_world.translation - point
        if first_surface(depsgraph.scene, depsgraph, point, way, away, passes) is None:
            return room
    return ""


def _is_part(owners: tuple[Any, ...], obj: Any) -> bool:
    """Return whether an object is one of `owners`, or a descendant of one."""
    return any(belongs_to(obj, owner) for owner in owners)
