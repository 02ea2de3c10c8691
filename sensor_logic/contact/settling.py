# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the points where stiff bodies meet do touch, however small the steps between them.

A simulated body lies a little aslant or off, by the engine's doing; how high its supports are is
exact. So the bodies are first let down as far as their contacts allow, all springs very stiff:
then what supports them has no gap, and a floor half a millimetre below a pad has one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..model import Array
from .balance import Joint, Load, Points, balance

# m: a point less than this off touches, once the bodies have settled; of a body that moves, whose
# contacts wander within a frame, less than that.
TOUCHING, MOVING = 2e-5, 3e-4
# m: surfaces that differ in height by less are meant to be level; by more, but less than this many
# times what touches, it cannot be told which of them carries.
LEVEL, UNTOLD = 5e-6, 4.0
# Places are kept in single precision: they are off by as much of their distance from the origin.
ROUNDING = 4.0 * 2.0**-24
# m: mean indentation of the stiff springs.
INDENTATION = 1e-6
# Mean indentations: how far off what does not touch is taken to be.
OFF = 1e4


@dataclass(frozen=True)
class Settled:
    """`points` with their slack; for each of them (n,) in m: `left`, how far off it is once the
    bodies lie as low as they can, NaN where that was not asked; `limits`, up to which it touches;
    and `rounding`, what its height is known to."""

    points: Points
    left: Array
    limits: Array
    rounding: Array

    def undecided(self, one: slice, two: slice) -> float:
        """m: how much the nearest of some points and of others differ in height, where that is too
        little to tell which of them touches; 0 where they are level, or it can be told."""
        step = abs(float(self.left[one].min() - self.left[two].min()))
        level = LEVEL + float(self.rounding[one].max())
        untold = UNTOLD * float(max(self.limits[one].max(), self.limits[two].max()))
        return step if level < step < untold else 0.0


def settled(
    loads: Sequence[Load], points: Points, gaps: Array, joints: Sequence[Joint] = ()
) -> Settled:
    """The points with their slack: none for those that touch. `gaps` (n,) in m, as the bodies lie;
    NaN for what touches in any case."""
    moves = np.array([*(load.softness[3:].any() for load in loads), False], bool)
    rounding = ROUNDING * np.abs(np.einsum("ni,ni->n", points.places, points.normals))
    limits = np.where(moves[points.a] | moves[points.b], MOVING, TOUCHING) + rounding
    known = np.isfinite(gaps)
    if not known.any() or np.ptp(gaps[known]) <= LEVEL:
        return Settled(points, gaps, limits, rounding)
    slack = np.where(known, gaps, 0.0) / INDENTATION
    stiff = replace(points, stiffness=np.ones(len(gaps)), slack=slack)
    left = np.where(known, -INDENTATION * balance(loads, stiff, joints).depths, np.nan)
    return Settled(replace(points, slack=np.where(left > limits, OFF, 0.0)), left, limits, rounding)
