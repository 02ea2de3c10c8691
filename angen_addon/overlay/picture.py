# SPDX-License-Identifier: GPL-3.0-or-later
"""Joins the figures of all sensors into a few arrays of coloured lines and triangles, which the
GPU draws at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...panels.readings import ACTIVE, Shown
from .figures import Figure
from .looks import BROKEN, LOOKS, Look

Array = NDArray[np.float32]
# How opaque the lines of a meaning are; those in BOLD are thick, those ON_TOP show through walls
# and people.
LINES = {
    "edge": 0.14,
    "ray": 0.3,
    "outline": 0.5,
    "limit": 0.3,
    "now": 0.95,
    "lit": 0.9,
    "beam": 0.85,
    "axis": 0.45,
    "dark": 0.35,
    "break": 1.0,
    "gate": 0.7,
    "picture": 0.9,
    "pad": 0.8,
    "force": 1.0,
}
FILLS = {"sheet": 0.012, "now": 0.04, "lit": 0.30, "picture": 0.3, "pad": 0.12, "force": 1.0}
BOLD = {"now", "lit", "break", "force", "beam"}
ON_TOP = {"force"}
# What is selected stands out; what is not steps back.
SELECTED, OTHER = 1.0, 0.8
# Whether movement was seen is told by the reading.
ONLY_ACTIVE = {"lit"}
# Looks (frames) without a change after which a field is taken for still. Few, and a walker's steps
# make the many still ones anew; many, and these stay with those that are made anew.
CALM = 24


@dataclass(frozen=True)
class Part:
    """`points` (n, 3) in the world, `colours` (n, 4); `corners`: 2, lines, or 3, triangles."""

    points: Array
    colours: Array
    corners: int


def picture(
    figures: list[tuple[Figure, str, bool]],
) -> dict[str, Part]:
    """The parts to draw, by how: `fills`, `thin`, `bold` and `top_fills`, `top`. Each figure with
    the icon of its sensor's state and whether it is selected."""
    lines: dict[str, list[tuple[Array, Any]]] = {}
    for figure, icon, selected in figures:
        look = LOOKS[icon]
        emphasis = look.strength * (SELECTED if selected else OTHER)
        for meaning, found in figure.lines.items():
            if meaning in ONLY_ACTIVE and icon != ACTIVE:
                continue
            if icon in BROKEN:
                found = found[::2]
            colour = _rgba(look, LINES[meaning] * emphasis)
            name = "top" if meaning in ON_TOP else "bold" if meaning in BOLD else "thin"
            lines.setdefault(name, []).append((found, colour))
        for meaning, found in figure.fills.items():
            if meaning in ONLY_ACTIVE and icon != ACTIVE:
                continue
            colour = _rgba(look, FILLS[meaning] * emphasis)
            name = "top_fills" if meaning in ON_TOP else "fills"
            lines.setdefault(name, []).append((found, colour))
    return {name: _join(parts, 3 if "fills" in name else 2) for name, parts in lines.items()}


def _rgba(look: Look, alpha: float) -> Array:
    return np.array([*look.colour, min(alpha, 1.0)], np.float32)


def _join(parts: list[tuple[Array, Array]], corners: int) -> Part:
    points = np.concatenate([part.reshape(-1, 3) for part, _ in parts])
    counts = [part.shape[0] * corners for part, _ in parts]
    colours = np.repeat(np.array([colour for _, colour in parts]), counts, axis=0)
    return Part(np.ascontiguousarray(points, np.float32), colours, corners)


def is_still(seen: Any) -> bool:
    """Whether what a sensor sees has not changed of late."""
    return bool(seen.calm >= CALM)


def still_figures(field: Any, states: list[Shown | None]) -> list[tuple[Figure, str, bool]]:
    """The fields of those sensors whose state is given, as far as they are still."""
    return [
        (seen.figure, shown.icon, seen.selected)
        for seen, shown in zip(field.seen, states, strict=True)
        if shown is not None and seen.figure is not None and is_still(seen)
    ]


def lively_figures(field: Any, states: list[Shown | None]) -> list[tuple[Figure, str, bool]]:
    """What changes with every update: the other fields, what is scanned and seen to move, and
    forces."""
    found = []
    for seen, shown in zip(field.seen, states, strict=True):
        if shown is None or seen.figure is None:
            continue
        if not is_still(seen):
            found.append((seen.figure, shown.icon, seen.selected))
        for figure in (seen.extra, _of_reading(seen, shown, field.metres)):
            if figure is not None:
                found.append((figure, shown.icon, seen.selected))
    return found


def _of_reading(seen: Any, shown: Shown, metres: float) -> Figure | None:
    """What a valid reading adds to the figure of its sensor."""
    look, fields = seen.appearance, shown.fields
    if fields is None or shown.problem or seen.pose is None or not look.drawn_fields:
        return None
    if not all(name in fields for name in look.drawn_fields):
        return None
    found: Figure | None = look.reading_figure(seen.pose, fields, metres)
    return found
