# SPDX-License-Identifier: GPL-3.0-or-later
"""How each state of a sensor looks: a colour that colour-blind people can tell from the others
(after Okabe and Ito), a sign of its own shape, and whether its lines are whole or broken."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ....panels import readings

Colour = tuple[float, float, float]
Points = NDArray[np.float32]


def _ring(radius: float, parts: int = 16, gaps: int = 1) -> list[list[tuple[float, float]]]:
    """A circle as lines; `gaps` 2: every other one is missing."""
    at = [2 * math.pi * n / parts for n in range(parts + 1)]
    points = [(radius * math.cos(a), radius * math.sin(a)) for a in at]
    return [[points[n], points[n + 1]] for n in range(0, parts, gaps)]


def _disc(radius: float, parts: int = 16) -> list[list[tuple[float, float]]]:
    return [[(0.0, 0.0), *edge] for edge in _ring(radius, parts)]


def disc() -> Points:
    """(n, 3, 2): a filled circle of radius 1."""
    return _array(_disc(1.0), 3)


def _array(shape: list[list[tuple[float, float]]], corners: int) -> Points:
    return np.array(shape, np.float32).reshape(-1, corners, 2)


@dataclass(frozen=True)
class Look:
    """`lines` (n, 2, 2) and `faces` (m, 3, 2) are those of its sign, about the origin, of a radius
    of about 1. `strength` multiplies how opaque the field is."""

    colour: Colour
    strength: float
    lines: Points = field(default_factory=lambda: _array([], 2))
    faces: Points = field(default_factory=lambda: _array([], 3))


_CROSS = [[(-0.7, -0.7), (0.7, 0.7)], [(-0.7, 0.7), (0.7, -0.7)]]
_TRIANGLE = [(-1.0, -0.8), (1.0, -0.8), (0.0, 1.0)]
_SIDES = [[_TRIANGLE[n], _TRIANGLE[(n + 1) % 3]] for n in range(3)]
_HANDS = [[(0.0, 0.65), (0.0, 0.0)], [(0.0, 0.0), (0.5, 0.0)]]
_DOTS = [[(x - 0.12, 0.0), (x + 0.12, 0.0)] for x in (-0.5, 0.0, 0.5)]
_DIAMOND = [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)]
_EXCLAMATION = [[(0.0, 0.45), (0.0, -0.2)], [(0.0, -0.45), (0.0, -0.6)]]

# By the icons that panels show, so that both always agree.
LOOKS = {
    readings.ACTIVE: Look((1.0, 0.62, 0.05), 1.0, _array(_ring(1.0), 2), _array(_disc(1.0), 3)),
    readings.IDLE: Look((0.34, 0.71, 0.96), 0.75, _array(_ring(1.0), 2)),
    readings.OFF: Look((0.62, 0.62, 0.62), 0.4, _array(_CROSS, 2)),
    readings.DOUBTFUL: Look((0.80, 0.80, 0.76), 0.5, _array(_SIDES + _EXCLAMATION, 2)),
    readings.WRONG: Look((0.93, 0.53, 0.80), 0.75, _array(_SIDES + _EXCLAMATION, 2)),
    readings.UNKNOWN: Look((0.80, 0.80, 0.76), 0.5, _array(_ring(1.0, 12, 2), 2)),
    readings.NOT_SURE: Look((0.80, 0.80, 0.76), 0.5, _array(_ring(1.0) + _DOTS, 2)),
    readings.OLD: Look((0.94, 0.89, 0.26), 0.5, _array(_ring(1.0) + _HANDS, 2)),
    readings.BAKED: Look(
        (0.80, 0.80, 0.76), 0.5, _array([[_DIAMOND[n], _DIAMOND[n - 1]] for n in range(4)], 2)
    ),
}
# States whose fields are drawn in broken lines: what they show is not what is sensed.
BROKEN = {
    readings.NOT_SURE,
    readings.DOUBTFUL,
    readings.WRONG,
    readings.UNKNOWN,
    readings.OLD,
    readings.BAKED,
}
