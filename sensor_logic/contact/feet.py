# SPDX-License-Identifier: GPL-3.0-or-later
"""The supports of a stiff body's feet: a pad higher than the floor carries a leg alone."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from ..arrays import Array
from .settling import TOUCHING
from .shapes import perpendiculars

Mask = npt.NDArray[np.bool_]
# m: parts of an underside farther apart than about this are separate feet.
APART = 0.05
DIRECTIONS = 32


def held_by_pads(points: Array, gaps: Array, areas: Array, on_pad: Mask, up: Array) -> Array:
    """The areas (n,) in m² of an underside's points (n, 3), `gaps` (n,) in m above their supports,
    after this rule: a pad beneath the middle of a leg that is higher than the support beside it
    carries the whole leg.

    A leg among others stays upright. A body with a single foot may be a cushion: its areas stay.
    """
    held = areas.copy()
    axes = np.stack(perpendiculars(up))
    seen = points @ axes.T
    feet = _feet(seen, max(APART, 2.0 * float(np.sqrt(areas.mean()))))
    for foot in range(int(feet.max()) + 1 if feet.any() else 0):
        own = feet == foot
        pad = own & on_pad
        if not pad.any():
            continue
        lower = own & ~on_pad & (gaps > gaps[pad].min() + TOUCHING)
        middle = areas[own] @ seen[own] / areas[own].sum()
        # Each point represents the area around it.
        around = 0.75 * float(np.sqrt(areas[own].mean()))
        if lower.any() and _among(seen[pad], middle, around):
            held[pad] *= 1.0 + areas[lower].sum() / areas[pad].sum()
            held[lower] = 0.0
    return held


def _among(places: Array, place: Array, around: float) -> bool:
    """Whether a place (2,) is inside the hull of `places` (n, 2), or less than `around` outside."""
    angles = np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS
    ways = np.stack([np.cos(angles), np.sin(angles)])
    return bool((((places - place) @ ways).max(axis=0) > -around).all())


def _feet(seen: Array, apart: float) -> npt.NDArray[np.intp]:
    """The number of the foot (n,) of each point (n, 2): points in neighbouring cells, `apart` m
    wide, belong to one foot."""
    cells = np.floor(seen / apart).astype(int)
    left = {tuple(cell) for cell in cells.tolist()}
    number: dict[tuple[int, ...], int] = {}
    foot = 0
    while left:
        waiting = [left.pop()]
        while waiting:
            cell = waiting.pop()
            number[cell] = foot
            beside = {(cell[0] + i, cell[1] + j) for i in (-1, 0, 1) for j in (-1, 0, 1)} & left
            left -= beside
            waiting += beside
        foot += 1
    return np.array([number[tuple(cell)] for cell in cells.tolist()], np.intp)
