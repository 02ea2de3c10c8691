# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the motion of a door leaf, and its free upper corner, by its keyframes or its shape.

A *leaf* is the part of a door that moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

from mathutils import Euler, Matrix, Quaternion, Vector

from ...sensor_logic.logs.error import AngenError
from .animation import curves

# A leaf is upright if the cosine of its height's angle to Z is at least this.
UPRIGHT = 0.95
# The distance of a hinge from the leaf's middle is in this range of shares of the leaf's width.
HINGE_AT = (0.25, 0.75)
# A smaller rotation (rad) or motion (fraction of the width) does not count.
TURNED, MOVED = math.radians(2), 0.02
# How a leaf may move, as users choose it.
MOTIONS = [
    (
        "AUTO", "Automatic", "As its keyframes move it. Without keyframes, it turns about its "
        "origin if that is at an edge, otherwise about its left edge", 0,
    ),
    ("LEFT", "Hinge left", "It turns about its left edge, seen from the side that it opens to", 3),
    (
        "RIGHT", "Hinge right", "It turns about its right edge, seen from the side that it opens "
        "to", 4,
    ),
    ("SLIDING", "Sliding", "It slides along its width", 2),
]  # fmt: skip
# An object whose matrix has a smaller determinant is flat.
FLAT = 1e-12
ROTATIONS = ("rotation_euler", "rotation_quaternion")


@dataclass(frozen=True)
class Opening:
    """The motion of a leaf from closed to open, in Blender units.

    Attributes
    ----------
    way
        The displacement of the middle of the leaf.
    pivot
        The point about which the leaf rotates; None for a sliding leaf.
    turn
        Its rotation about Z, in radians.
    """

    way: Vector
    pivot: Vector | None
    turn: float = 0.0


@dataclass(frozen=True)
class Leaf:
    """A closed door leaf, in Blender units. All directions are unit vectors.

    Attributes
    ----------
    corner
        The free upper corner, on the face that looks towards `out`.
    out
        The direction in which that face looks.
    edge
        The level direction from the hinge to the free edge.
    up
        The upward direction.
    hand
        LEFT or RIGHT: the side of the hinge, seen from the side to which the leaf opens.
    guessed
        Whether `hand` is a guess, since neither the keyframes nor the origin show it.
    pivot
        A point on the axis of the hinge; None for a sliding leaf or an unknown axis.
    opening
        The motion by keyframes; None without keyframes.
    """

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
        """Return the same leaf, described from its other face."""
        corner, edge = self.corner - self.out * self.thickness, self.edge
        if self.hand:
            corner, edge = corner - edge * self.width, -edge
        return replace(self, corner=corner, edge=edge, out=-self.out)


def leaves_of(obj: Any, motion: str, shutting: Matrix | None = None) -> list[list[Leaf]]:
    """Return the possible descriptions of a door leaf as `Leaf`, the most likely ones first.

    Leaves in the same inner list are equally likely: they are one leaf, seen from both sides.

    Parameters
    ----------
    obj
        The object of the leaf.
    motion
        AUTO, LEFT, RIGHT or SLIDING. With AUTO, the keyframes and the origin decide, or a guess.
        LEFT and RIGHT are the edge with the hinge, seen from the side to which the leaf opens.
    shutting
        The matrix from the present pose to the closed one; None if the leaf is closed now.

    Raises
    ------
    AngenError
        If the object is not shaped like an upright leaf.
    """
    shutting = shutting or Matrix()
    middle, width, thickness, height = _leaf_box(obj, shutting)
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
        # A sliding leaf closes against the end that it leaves; without keyframes, either end.
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
    # Without keyframes, the leaf opens to the face that has the hinge.
    side = opening.way.dot(out) if opening else (pivot - middle).dot(out) if pivot else 0.0
    if abs(side) <= 0.1 * thickness.length:
        return [sides]
    return [sides[:1], sides[1:]] if side > 0.0 else [sides[1:], sides[:1]]


def shutting_of(obj: Any) -> Matrix:
    """Return the matrix that moves a leaf from its present pose to its closed pose.

    The pose at the first keyframe counts as closed. Without keyframes the result is the unit
    matrix.
    """
    for owner in _chain(obj):
        if motions := keyed_motions(owner):
            return motions[0]
    return Matrix()


def keyed_motions(owner: Any, between: int = 0) -> list[Matrix]:
    """Return the matrices that move an object from its present pose to those of its keyframes.

    `between` is the number of poses after each keyframe, before the next one, that are added. The
    list is empty without keyframes, or if the object is flat.
    """
    if abs(owner.matrix_basis.determinant()) < FLAT:
        return []
    now = owner.matrix_world
    above, back = now @ owner.matrix_basis.inverted(), now.inverted_safe()
    return [above @ basis @ back for basis in _keyed_bases(owner, between)]


def _leaf_box(obj: Any, shutting: Matrix) -> tuple[Vector, Vector, Vector, Vector]:
    """Return the middle of the leaf's box, and its width, thickness and height as vectors."""
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
    """Return the origin of the leaf or of a parent, if it lies at an edge of the leaf.

    Return None if no origin does.
    """
    for owner in _chain(obj):
        origin = shutting @ owner.matrix_world.translation
        away = abs((middle - origin).dot(edge)) / width
        if HINGE_AT[0] <= away <= HINGE_AT[1]:
            return origin.copy()
    return None


def _opening(obj: Any, shutting: Matrix, middle: Vector, width: float) -> Opening | None:
    """Return the motion from the closed pose to the keyframe that is farthest from this pose.

    Keyframes of the leaf and of its parents count. Return None if none of them moves the leaf.
    """
    best: Opening | None = None
    back = shutting.inverted()
    for owner in _chain(obj):
        origin = shutting @ owner.matrix_world.translation
        for motion in keyed_motions(owner):
            moved = motion @ back
            way = moved @ middle - middle
            if way.length < MOVED * width or (best and way.length <= best.way.length):
                continue
            about, turned = moved.to_quaternion().to_axis_angle()
            turn = math.copysign(turned, about.z)
            best = Opening(way, origin.copy() if turned > TURNED else None, turn)
    return best


def _keyed_bases(obj: Any, between: int) -> list[Matrix]:
    """Return the object's basis matrices (`matrix_basis`) at its keyframes, and some between."""
    paths = {"location", *ROTATIONS}
    found = curves(obj, paths)
    frames = sorted({point.co.x for curve in found for point in curve.keyframe_points})
    parts = [n / (between + 1) for n in range(between + 1)]
    times = [a + (b - a) * part for a, b in pairwise(frames) for part in parts] + frames[-1:]
    return [_basis_at(obj, found, frame) for frame in times]


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
