# SPDX-License-Identifier: GPL-3.0-or-later
"""Decides which contact points of stiff bodies touch, also where heights differ very little.

The physics engine leaves a simulated body slightly tilted or above its supports, whose heights are
exact. So the bodies are first lowered as far as their contacts allow, with very stiff springs: then
their supports have no gap, and a floor half a millimetre below a pad has one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from .balance import Joint, Load, Points, balance
from .directions import FLAT
from .shapes import Shape

# m: the largest gap at which a point touches once the bodies have settled; and that of a moving
# body, whose contacts shift within a frame.
TOUCHING, MOVING = 2e-5, 3e-4
# m: surfaces whose heights differ by less count as level. With a larger difference, up to UNTOLD
# times TOUCHING, it is uncertain which of them carries a body at rest.
LEVEL, UNTOLD = 1e-6, 4.0
# Positions are in single precision: the rounding error per metre of distance from the origin.
ROUNDING = 4.0 * 2.0**-24
# m: mean indentation of the stiff springs.
INDENTATION = 1e-6
# The slack of points that do not touch, in mean indentations.
OFF = 1e4


@dataclass(frozen=True)
class Settled:
    """`points` with their slack; for each of them (n,) in m, the largest height difference of
    supports that are `level`, and the largest at which it is uncertain (`untold`) which of them
    carries. `converged`: whether the solver found its end."""

    points: Points
    level: Array
    untold: Array
    converged: bool = True


def settled(
    loads: Sequence[Load], points: Points, gaps: Array, joints: Sequence[Joint] = ()
) -> Settled:
    """The points with their slack, which is 0 for those that touch. `gaps` (n,) in m between the
    bodies where they are; NaN for points that touch in any case."""
    moves = np.array([*(load.softness[3:].any() for load in loads), False], bool)
    moves = moves[points.a] | moves[points.b]
    rounding = ROUNDING * np.abs(np.einsum("ni,ni->n", points.places, points.normals))
    untold = np.where(moves, MOVING, UNTOLD * TOUCHING) + UNTOLD * rounding
    known = np.isfinite(gaps)
    if not known.any() or np.ptp(gaps[known]) <= TOUCHING / 4.0:
        return Settled(points, LEVEL + rounding, untold)
    slack = np.where(known, gaps, 0.0) / INDENTATION
    stiff = replace(points, stiffness=np.ones(len(gaps)), slack=slack)
    found = balance(loads, stiff, joints)
    left = -INDENTATION * found.depths
    limits = np.where(moves, MOVING, TOUCHING) + rounding
    slack = np.where(known & (left > limits), OFF, 0.0)
    return Settled(replace(points, slack=slack), LEVEL + rounding, untold, found.settled)


def height_between(one: Shape, two: Shape, places: Array, normal: Array) -> float:
    """The largest height difference in m, at places (n, 3), between the faces of two shapes that
    face a normal (3,), extended beyond their edges; inf where a shape has no such face."""
    heights = []
    for shape in (one, two):
        facing = shape.normals @ normal
        if not len(facing) or facing.max() < FLAT:
            return math.inf
        face = int(facing.argmax())
        from_places = shape.vertices[shape.faces[face][0]] - places
        heights.append(from_places @ shape.normals[face] / facing[face] + shape.radius)
    return float(np.abs(heights[0] - heights[1]).max())
