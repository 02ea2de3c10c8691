# SPDX-License-Identifier: GPL-3.0-or-later
"""How a door's leaf moves, from its keys or its shape, and where its free upper corner is."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from mathutils import Euler, Matrix, Quaternion, Vector

from ...sensor_logic.error import AngenError
from .animation import curves

# A leaf stands if its height is this near to upright, as a cosine.
UPRIGHT = 0.95
# A hinge is this far from the leaf's middle, as shares of its width.
HINGE_AT = (0.25, 0.75)
# What turns less (rad) does not turn; what moves less (of the width) does not move.
TURNED, MOVED = math.radians(2), 0.02
# How a leaf may move, as users choose it.
MOTIONS = [
    (
        "AUTO", "Automatic", "As it is keyed; without keys, about its origin where that is at an "
        "edge, else with the hinge at the left", 0,
    ),
    ("LEFT", "Hinge left", "It turns about its left edge, seen from the side that it opens to", 3),
    ("RIGHT", "Hinge right", "It turns about its right edge, seen from where it opens to", 4),
    ("SLIDING", "Sliding", "It slides along its width", 2),
]  # fmt: skip
ROTATIONS = ("rotation_euler", "rotation_quaternion")


@dataclass(frozen=True)
class Opening:
    """A leaf's way from closed to open: where its middle goes, the pivot that it turns about (None:
    it slides) and by how much (rad, about Z). In units of the scene."""

    way: Vector
    pivot: Vector | None
    turn: float = 0.0


@dataclass(frozen=True)
class Leaf:
    """A closed leaf. `corner` is its free upper corner, on the face that looks `out`; `edge` runs
    level from the hinge to the free edge. Unit vectors; sizes in units of the scene. `hand`: LEFT
    or RIGHT where the hinge is to be on that side, seen from where the leaf opens to; `guessed`:
    nothing tells the hand. `pivot` lies on the hinge's line; None: it slides, or nothing tells it.
    `opening` as it is keyed, if it is."""

    corner: Vector
    edge: Vector
    out: Vector
    up: Vector
    width: float
    thickness: float
    slides: bool = False
    hand: str = ""
    guessed: bool = False
    pivot: Vector | None = None
    opening: Opening | None = None

    def turned_round(self) -> Leaf:
        """The same leaf, looked at from the other side."""
        corner, edge = self.corner - self.out * self.thickness, self.edge
        if self.hand:
            corner, edge = corner - edge * self.width, -edge
        return replace(self, corner=corner, edge=edge, out=-self.out)


def leaves_of(obj: Any, motion: str, shutting: Matrix | None = None) -> list[list[Leaf]]:
    """What the leaf may be: the likelier first; those in one list, the same leaf from both sides,
    are equally likely. It is closed where `shutting` takes it from where it stands now, else as it
    stands.

    `motion`: AUTO asks its keys and its origin, and guesses the hinge where they do not tell it;
    LEFT, RIGHT: the edge that it turns about, seen from the side that it opens to; SLIDING. Raises
    AngenError.
    """
    shutting = shutting or Matrix()
    middle, width, thickness, height = _box(obj, shutting)
    if abs(height.normalized().z) < UPRIGHT or height.length < thickness.length:
        raise AngenError("it does not stand upright: its height must be along Z")
    up = height.normalized() * math.copysign(1.0, height.z)
    edge, out = width.normalized(), thickness.normalized()

    def both(edge: Vector, **more: Any) -> list[Leaf]:
        corner = middle + (edge * width.length + out * thickness.length + up * height.length) / 2
        more |= {"pivot": pivot, "opening": opening}
        leaf = Leaf(corner, edge, out, up, width.length, thickness.length, **more)
        return [leaf, leaf.turned_round()]

    def handed(hand: str, guessed: bool = False) -> list[Leaf]:
        right = up.cross(out)
        return both(right if hand == "LEFT" else -right, hand=hand, guessed=guessed)

    pivot, opening = None, _opening(obj, shutting, middle, width.length)
    if motion == "SLIDING" or (motion == "AUTO" and opening and opening.pivot is None):
        # What it leaves is where it closes against; unkeyed, either end does.
        if opening is not None and opening.pivot is None and opening.way.dot(edge) > 0.0:
            edge = -edge
        return [both(edge, slides=True)]
    if opening is not None and opening.pivot is None:
        opening = None
    pivot = opening.pivot if opening else _hinge(obj, shutting, middle, edge, width.length)
    if motion != "AUTO":
        pivot = None
        sides = handed(motion)
    elif pivot is None:
        return [handed("LEFT", guessed=True), handed("RIGHT", guessed=True)]
    else:
        sides = both(edge if (middle - pivot).dot(edge) > 0.0 else -edge)
    # Without keys: a hinge is on the face that the leaf opens to.
    side = opening.way.dot(out) if opening else (pivot - middle).dot(out) if pivot else 0.0
    if abs(side) <= 0.1 * thickness.length:
        return [sides]
    return [sides[:1], sides[1:]] if side > 0.0 else [sides[1:], sides[:1]]


def shutting_of(obj: Any) -> Matrix:
    """The matrix that takes a leaf from where it stands now to its first key, which counts as
    closed; the unit matrix without keys."""
    for owner in _chain(obj):
        bases = _keyed_bases(owner)
        if bases and abs(owner.matrix_basis.determinant()) > 1e-12:
            now = owner.matrix_world
            return now @ owner.matrix_basis.inverted() @ bases[0] @ now.inverted_safe()
    return Matrix()


def _box(obj: Any, shutting: Matrix) -> tuple[Vector, Vector, Vector, Vector]:
    """The middle of the leaf's box and its width, thickness and height as vectors."""
    corners = [Vector(c) for c in obj.bound_box]
    low = Vector([min(c[i] for c in corners) for i in range(3)])
    high = Vector([max(c[i] for c in corners) for i in range(3)])
    matrix = shutting @ obj.matrix_world
    sides = [matrix.col[i].xyz * (high[i] - low[i]) for i in range(3)]
    if min(side.length for side in sides) == 0.0:
        raise AngenError("it has no thickness, width or height: give its mesh a size")
    upright = max(sides, key=lambda side: abs(side.normalized().z))
    flat, wide = sorted((s for s in sides if s is not upright), key=lambda side: side.length)
    return matrix @ ((low + high) / 2), wide, flat, upright


def _chain(obj: Any) -> list[Any]:
    found = []
    while obj is not None:
        found.append(obj)
        obj = obj.parent
    return found


def _hinge(obj: Any, shutting: Matrix, middle: Vector, edge: Vector, width: float) -> Vector | None:
    """The origin, of the leaf or of what it hangs on, that lies at an edge of it; None where none
    does, as with a box that was made a door."""
    for owner in _chain(obj):
        origin = shutting @ owner.matrix_world.translation
        away = abs((middle - origin).dot(edge)) / width
        if HINGE_AT[0] <= away <= HINGE_AT[1]:
            return origin.copy()
    return None


def _opening(obj: Any, shutting: Matrix, middle: Vector, width: float) -> Opening | None:
    """The keyed pose that is farthest from the closed one, of the leaf or what it hangs on."""
    best: Opening | None = None
    back = shutting.inverted()
    for owner in _chain(obj):
        now, origin = owner.matrix_world, shutting @ owner.matrix_world.translation
        # Without its keys; what the parent and its inverse add stays as it is now.
        if abs(owner.matrix_basis.determinant()) < 1e-12:
            continue
        above = now @ owner.matrix_basis.inverted()
        for basis in _keyed_bases(owner):
            moved = above @ basis @ now.inverted_safe() @ back
            way = moved @ middle - middle
            if way.length < MOVED * width or (best and way.length <= best.way.length):
                continue
            about, turned = moved.to_quaternion().to_axis_angle()
            turn = math.copysign(turned, about.z)
            best = Opening(way, origin.copy() if turned > TURNED else None, turn)
    return best


def _keyed_bases(obj: Any) -> list[Matrix]:
    """The object's own matrices at its keys."""
    paths = {"location", *ROTATIONS}
    found = curves(obj, paths)
    frames = sorted({point.co.x for curve in found for point in curve.keyframe_points})
    return [_basis_at(obj, found, frame) for frame in frames]


def _basis_at(obj: Any, found: list[Any], frame: float) -> Matrix:
    place, turn = obj.location.copy(), obj.rotation_euler.copy()
    quaternion = obj.rotation_quaternion.copy()
    owners = {"location": place, ROTATIONS[0]: turn, ROTATIONS[1]: quaternion}
    for curve in found:
        owners[curve.data_path][curve.array_index] = curve.evaluate(frame)
    if obj.rotation_mode == "QUATERNION":
        rotation: Quaternion | Euler = quaternion
    elif obj.rotation_mode == "AXIS_ANGLE":
        rotation = obj.matrix_basis.to_quaternion()
    else:
        rotation = Euler(turn, obj.rotation_mode)
    return Matrix.LocRotScale(place, rotation, obj.scale)
