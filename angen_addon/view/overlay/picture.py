# SPDX-License-Identifier: GPL-3.0-or-later
"""What is drawn of a sensor, as arrays of coloured lines and triangles for the GPU."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....panels.readings import ACTIVE, ReadingText
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
FILLS = {"sheet": 0.03, "now": 0.04, "lit": 0.30, "picture": 0.3, "pad": 0.12, "force": 1.0}
BOLD = {"now", "lit", "break", "force", "beam"}
ON_TOP = {"force"}
# What is selected stands out; what is not steps back.
SELECTED, OTHER = 1.0, 0.8


@dataclass(frozen=True)
class Primitives:
    """`points` (n, 3) in the world, `colours` (n, 4); `corners`: 2, lines, or 3, triangles."""

    points: Array
    colours: Array
    corners: int


def picture(figure: Figure, icon: str, selected: bool) -> dict[str, Primitives]:
    """The parts of a figure, by how they are drawn: `fills`, `thin`, `bold` and `top_fills`, `top`;
    `icon`: that of its sensor's state. The figure keeps those of the look that it had last."""
    look = icon, selected
    if figure.pictured is None or figure.pictured[0] != look:
        figure.pictured = look, _picture(figure, icon, selected)
    made: dict[str, Primitives] = figure.pictured[1]
    return made


def _picture(figure: Figure, icon: str, selected: bool) -> dict[str, Primitives]:
    found: dict[str, list[tuple[Array, Any]]] = {}
    look = LOOKS[icon]
    emphasis = look.strength * (SELECTED if selected else OTHER)
    for meaning, lines in figure.lines.items():
        if icon in BROKEN:
            lines = lines[::2]
        name = "top" if meaning in ON_TOP else "bold" if meaning in BOLD else "thin"
        found.setdefault(name, []).append((lines, _rgba(look, LINES[meaning] * emphasis)))
    for meaning, faces in figure.fills.items():
        name = "top_fills" if meaning in ON_TOP else "fills"
        found.setdefault(name, []).append((faces, _rgba(look, FILLS[meaning] * emphasis)))
    made = {name: _join(parts, 3 if "fills" in name else 2) for name, parts in found.items()}
    return {name: part for name, part in made.items() if len(part.points)}


def _rgba(look: Look, alpha: float) -> Array:
    return np.array([*look.colour, min(alpha, 1.0)], np.float32)


def _join(parts: list[tuple[Array, Array]], corners: int) -> Primitives:
    points = np.concatenate([part.reshape(-1, 3) for part, _ in parts])
    counts = [part.shape[0] * corners for part, _ in parts]
    colours = np.repeat(np.array([colour for _, colour in parts]), counts, axis=0)
    return Primitives(np.ascontiguousarray(points, np.float32), colours, corners)


def joined(pictures: Iterable[dict[str, Primitives]]) -> dict[str, Primitives]:
    """All parts that are drawn alike as one."""
    found: dict[str, list[Primitives]] = {}
    for one in pictures:
        for name, part in one.items():
            found.setdefault(name, []).append(part)
    return {name: _one(parts) for name, parts in found.items()}


def _one(parts: list[Primitives]) -> Primitives:
    if len(parts) == 1:
        return parts[0]
    points = np.concatenate([part.points for part in parts])
    return Primitives(points, np.concatenate([part.colours for part in parts]), parts[0].corners)


def passing(seen: Any, shown: ReadingText, metres: float) -> list[Figure]:
    """What is drawn of a sensor (DrawnSensor) that reads so beside its `figures`, and changes from
    update to update."""
    found = [*seen.now]
    # Whether movement was seen is told by the reading.
    if shown.icon == ACTIVE:
        found += seen.lit
    of_reading = _of_reading(seen, shown, metres)
    return found if of_reading is None else [*found, of_reading]


def _of_reading(seen: Any, shown: ReadingText, metres: float) -> Figure | None:
    """The figure that a valid reading adds to its sensor's; the same object while the reading is
    equal."""
    look, fields = seen.appearance, shown.fields
    if fields is None or shown.problem or seen.pose is None or not look.drawn_fields:
        return None
    if not all(name in fields for name in look.drawn_fields):
        return None
    read = [str(fields[name]) for name in look.drawn_fields]
    if seen.of_reading is None or seen.of_reading[0] != read:
        seen.of_reading = read, look.reading_figure(seen.pose, fields, metres)
    found: Figure | None = seen.of_reading[1]
    return found
