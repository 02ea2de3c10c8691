# SPDX-License-Identifier: GPL-3.0-or-later
"""Doors, drawers and curtains as the marks on their leaves tell them."""

from __future__ import annotations

from typing import Any

import numpy as np
from mathutils import Vector

from ....sensor_logic.error import AngenError
from ....sensor_logic.model import Array
from ....sensor_logic.residents.places import CURTAIN, DRAWER, Door
from ...scene.door_motion import Leaf, leaves_of, shutting_of
from ...scene.home import EvaluatedHome
from .looks import look_of
from .marked_object import MarkedObject

UP = np.array([0.0, 0.0, 1.0])
# m: a handle above the floor, and from the free edge at most; of what is narrow a share of it.
HANDLE_M, INSET_M, INSET = 1.05, 0.11, 0.15
# Of its width, or depth, that slides away where the mark does not tell.
SLIDES = 0.9


def leaf_of(obj: Any) -> tuple[Leaf, Any]:
    """The likeliest leaf of a marked door or curtain, shut, and what takes it there from where it
    stands. Raises AngenError."""
    mark = obj.angen_place
    motion = "SLIDING" if mark.use == CURTAIN else mark.motion
    shutting = shutting_of(obj)
    leaf = leaves_of(obj, motion, shutting)[0][0]
    if mark.other_side:
        turned = leaf.turned_round()
        if leaf.slides:
            # It slides to the other end.
            corner = leaf.corner - leaf.edge * leaf.width
            turned = Leaf(corner, -leaf.edge, leaf.out, leaf.up, leaf.width, leaf.thickness, True)
        leaf = turned
    return leaf, shutting


def turns_by(leaf: Leaf, angle: float) -> float:
    """How far (rad) the leaf opens about Z, with its sign: towards its `out`."""
    return angle if leaf.up.cross(leaf.edge).dot(leaf.out) > 0.0 else -angle


def door_of(home: EvaluatedHome, obj: Any, floor: float, room: str, number: int) -> Door:
    """The door of a marked leaf on a storey whose floor is at a height in m. Raises AngenError."""
    if obj.angen_place.use == DRAWER:
        return _drawer(home, obj, room, number)
    leaf, shutting = leaf_of(obj)
    mark, metres = obj.angen_place, home.metres
    edge, out, up = (np.array(v) for v in (leaf.edge, leaf.out, leaf.up))
    corner = np.array(leaf.corner) * metres
    width, thick = leaf.width * metres, leaf.thickness * metres
    low_z = float(MarkedObject(home, obj).points[:, 2].min(initial=corner[2]))
    hinge = corner - edge * width
    if leaf.pivot is not None and not leaf.slides:
        hinge = np.array(leaf.pivot) * metres
    hinge = np.array([hinge[0], hinge[1], low_z])
    frame = np.column_stack([edge, np.cross(up, edge), up])
    # The leaf's box in that frame, from its free upper corner.
    free = (corner - hinge) @ frame
    side = float(out @ frame[:, 1])
    faces = sorted((free[1], free[1] - side * thick))
    low = np.array([free[0] - width, faces[0], 0.0])
    high = np.array([free[0], faces[1], float(corner[2] - low_z)])
    handle = _handle(low, high, floor - low_z)
    if leaf.slides:
        way = -edge
        slide = mark.slide or SLIDES * width
        shut = float(np.array(shutting.translation) * metres @ way) if _moved(shutting) else 0.0
        return Door(
            obj.name, mark.use, hinge - way * shut, way, shut, shut + slide, frame, low, high,
            handle, True, mark.entrance, room, number,
        )  # fmt: skip
    about, turned = shutting.to_quaternion().to_axis_angle()
    shut = turned if about.z >= 0.0 else -turned
    back = np.array(shutting.to_3x3().normalized().inverted())
    opened = shut + turns_by(leaf, mark.angle)
    return Door(
        obj.name, mark.use, hinge, UP, shut, opened, back @ frame, low, high, handle, False,
        mark.entrance, room, number,
    )  # fmt: skip


def _moved(shutting: Any) -> bool:
    return bool(shutting.translation.length > 0.0)


def _handle(low: Array, high: Array, floor: float) -> Array:
    """(3,) in the leaf's frame, in which the floor is at a height."""
    width, height = float(high[0] - low[0]), float(high[2])
    at = floor + HANDLE_M
    if not 0.1 * height <= at <= 0.95 * height:
        at = height / 2.0
    inset = min(INSET_M, INSET * width)
    return np.array([high[0] - inset, (low[1] + high[1]) / 2.0, at])


def _drawer(home: EvaluatedHome, obj: Any, room: str, number: int) -> Door:
    """It comes out towards who looks at it."""
    marked = MarkedObject(home, obj)
    if not marked.solid:
        raise AngenError("it has no surface: a drawer is a mesh, pulled out against where it faces")
    look = look_of(obj, marked.matrix)
    middle, deep, wide = marked.box(look)
    low_z, high_z = float(marked.points[:, 2].min()), float(marked.points[:, 2].max())
    way = np.array([*-look, 0.0])
    across = np.cross(UP, way)
    hinge = np.array([*(middle - look * deep), low_z]) - across * wide
    frame = np.column_stack([across, -way, UP])
    high = np.array([2 * wide, 2 * deep, high_z - low_z])
    handle = np.array([wide, 0.0, high[2] / 2.0])
    slide = obj.angen_place.slide or SLIDES * 2 * deep
    return Door(
        obj.name, DRAWER, hinge, way, 0.0, slide, frame, np.zeros(3), high, handle, True, False,
        room, number,
    )  # fmt: skip


def as_door(obj: Any) -> tuple[str, bool]:
    """A text for a panel on how a marked leaf moves, and whether it slides."""
    try:
        leaf, _ = leaf_of(obj)
    except AngenError as error:
        return str(error), False
    if leaf.slides:
        return "Slides along its width", True
    hinge = "at its origin" if leaf.pivot is not None else "at the edge of its box"
    guessed = ", a guess: choose the Motion" if leaf.guessed else ""
    return f"Hinge {hinge}{guessed}", False


def keyed_angle(leaf: Leaf) -> float:
    """rad that the keys open it by; 0 without."""
    return abs(leaf.opening.turn) if leaf.opening is not None and leaf.opening.pivot else 0.0


def keyed_slide(leaf: Leaf) -> float:
    """Units of the scene that the keys slide it by; 0 without."""
    way = leaf.opening.way if leaf.opening is not None else Vector()
    return way.length if leaf.slides else 0.0
