# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the points where stiff bodies meet do touch, however small the steps between them.

A simulated body lies a little aslant or off, by the engine's doing; how high its supports are is
exact. So the bodies are first let down as far as their contacts allow, all springs very stiff:
then what supports them has no gap, and a floor half a millimetre below a pad has one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import Array
from .balance import Joint, Load, Points, balance
from .directions import FLAT
from .shapes import Shape

# m: a point less than this off touches, once the bodies have settled; of a body that moves, whose
# contacts wander within a frame, less than that.
TOUCHING, MOVING = 2e-5, 3e-4
# m: surfaces that differ in height by less are meant to be level; by more, but less than this many
# times what touches, it cannot be told which of them carries a body at rest.
LEVEL, UNTOLD = 1e-6, 4.0
# Places are kept in single precision: they are off by as much of their distance from the origin.
ROUNDING = 4.0 * 2.0**-24
# m: mean indentation of the stiff springs.
INDENTATION = 1e-6
# Mean indentations: how far off what does not touch is taken to be.
OFF = 1e4


@dataclass(frozen=True)
class Settled:
    """`points` with their slack; of each of them (n,) in m, how little supports must differ in
    height to be `level`, and up to which height it is `untold` which of them carries."""

    points: Points
    level: Array
    untold: Array


def settled(
    loads: Sequence[Load], points: Points, gaps: Array, joints: Sequence[Joint] = ()
) -> Settled:
    """The points with their slack: none for those that touch. `gaps` (n,) in m, as the bodies lie;
    NaN for what touches in any case."""
    moves = np.array([*(load.softness[3:].any() for load in loads), False], bool)
    moves = moves[points.a] | moves[points.b]
    rounding = ROUNDING * np.abs(np.einsum("ni,ni->n", points.places, points.normals))
    untold = np.where(moves, MOVING, UNTOLD * TOUCHING) + UNTOLD * rounding
    known = np.isfinite(gaps)
    if not known.any() or np.ptp(gaps[known]) <= TOUCHING / 4.0:
        return Settled(points, LEVEL + rounding, untold)
    slack = np.where(known, gaps, 0.0) / INDENTATION
    stiff = replace(points, stiffness=np.ones(len(gaps)), slack=slack)
    left = -INDENTATION * balance(loads, stiff, joints).depths
    limits = np.where(moves, MOVING, TOUCHING) + rounding
    slack = np.where(known & (left > limits), OFF, 0.0)
    return Settled(replace(points, slack=slack), LEVEL + rounding, untold)


def height_between(one: Shape, two: Shape, places: Array, normal: Array) -> float:
    """m: the most that the faces of two shapes which look along a normal (3,) differ in height at
    places (n, 3), carried on beyond their rims; inf where one has no such face."""
    heights = []
    for shape in (one, two):
        facing = shape.normals @ normal
        if not len(facing) or facing.max() < FLAT:
            return math.inf
        face = int(facing.argmax())
        from_places = shape.vertices[shape.faces[face][0]] - places
        heights.append(from_places @ shape.normals[face] / facing[face] + shape.radius)
    return float(np.abs(heights[0] - heights[1]).max())
