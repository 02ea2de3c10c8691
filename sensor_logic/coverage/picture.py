# SPDX-License-Identifier: GPL-3.0-or-later
"""A coverage map as an SVG picture: a plan of each storey, a legend, and a table of the rooms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..model import Array
from ..report.facts import PlanStorey
from ..report.floor_plan import WIDTH, Frame, floor_plan
from ..report.svg import coordinate, plain_style, safe, shown_number, text_width
from .grid import CoverageMap, room_rows

# The colours of a coverage map (viridis) are brighter with better coverage. They are also distinct
# in grey and for the colour-blind.

# Matplotlib's viridis (CC0) at 0, 1/4, 1/2, 3/4 and 1, sRGB.
VIRIDIS = np.array(
    [
        (0.267, 0.005, 0.329),
        (0.230, 0.322, 0.546),
        (0.128, 0.567, 0.551),
        (0.369, 0.789, 0.383),
        (0.993, 0.906, 0.144),
    ]
)
# The levels of a cell: no detection; a share below `grid.ENOUGH`; covered by one, two, or more.
LEVELS = (
    "not noticed",
    "noticed in few directions",
    "covered by one",
    "by two",
    "by three or more",
)


def levels(coverage: CoverageMap) -> np.typing.NDArray[np.intp]:
    """Return the index (cells,) of each cell's level of coverage in LEVELS."""
    count = np.minimum(coverage.count, 3)
    partly = (coverage.best > 0.0).astype(np.intp)
    found: np.typing.NDArray[np.intp] = np.where(count > 0, count + 1, partly)
    return found


def linear(colour: Array) -> Array:
    """Return sRGB colours as linear values."""
    low, high = colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4
    result: Array = np.where(colour <= 0.04045, low, high)
    return result


def css(level: int) -> str:
    """Return the CSS colour of the level with this index."""
    return "#" + "".join(f"{round(255 * c):02x}" for c in VIRIDIS[level].tolist())


HEAD, LINE, MARGIN = 64.0, 18.0, 40.0
# Furniture is translucent, so that the cells above and below it stay visible.
SEE_THROUGH = ".low{fill-opacity:.35}.solid{fill-opacity:.5}"
# Cells without any detection are also hatched.
HATCH = (
    '<pattern id="dead" width="6" height="6" patternUnits="userSpaceOnUse" '
    'patternTransform="rotate(45)"><path d="M0 0V6" stroke="#fff" stroke-width="1.6"/></pattern>'
)


def svg(
    coverage: CoverageMap, storeys: Sequence[PlanStorey], title: str, kinds: Mapping[str, str]
) -> str:
    """Return the picture of a map.

    `storeys` are the floor plans of the map's storeys, in the same order. `kinds` has the kind of
    each sensor by its name.
    """
    numbers = {name: i + 1 for i, name in enumerate(coverage.sensors)}
    motion = coverage.motion
    y = HEAD
    parts: list[str] = []
    for number, storey in enumerate(storeys):
        drawn, height = floor_plan(storey, numbers, kinds, f"storey{number}")
        cells = _cells(coverage, number, Frame(storey.view))
        parts.append(f'<g transform="translate(0 {coordinate(y)})">{cells}{drawn}</g>')
        y += height
    legend, height = _legend(y + 4)
    parts.append(legend)
    y += height
    table, height = _table(coverage, y + 10)
    parts.append(table)
    y += height + 20
    tip = f"{motion.label}: {motion.tip[0].lower()}{motion.tip[1:]}. Cells of "
    tip += f"{shown_number(coverage.cells.size)} m."
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH:g}" height="{coordinate(y)}" '
        f'viewBox="0 0 {WIDTH:g} {coordinate(y)}" role="img">\n'
        f"<title>{safe(title)}</title>\n<style>{plain_style()}{SEE_THROUGH}</style>\n<defs>{HATCH}</defs>\n"
        f'<rect class="paper" width="{WIDTH:g}" height="{coordinate(y)}"/>\n'
        f'<text class="strong" x="{MARGIN:g}" y="24" style="font-size:16px">{safe(title)}</text>\n'
        f'<text class="quiet" x="{MARGIN:g}" y="44">{safe(tip)}</text>\n'
        + "\n".join(parts)
        + "\n</svg>\n"
    )


def _cells(coverage: CoverageMap, storey: int, frame: Frame) -> str:
    """Return the cells of a storey as SVG, with one path of squares for each level of coverage."""
    here = coverage.cells.storey == storey
    level = levels(coverage)
    side = coverage.cells.size * frame.scale
    corner = frame.px(coverage.cells.at[:, :2] + coverage.cells.size * np.array([-0.5, 0.5]))
    parts = []
    for number in range(len(LEVELS)):
        places = corner[here & (level == number)]
        path = "".join(
            f"M{coordinate(x)} {coordinate(y)}h{coordinate(side)}v{coordinate(side)}"
            f"h{coordinate(-side)}z"
            for x, y in places.tolist()
        )
        if path:
            parts.append(f'<path fill="{css(number)}" d="{path}"/>')
            if number == 0:
                parts.append(f'<path fill="url(#dead)" d="{path}"/>')
    return f'<g shape-rendering="crispEdges">{"".join(parts)}</g>'


def _legend(y: float) -> tuple[str, float]:
    parts, x = [], MARGIN
    for number, label in enumerate(LEVELS):
        box = f'x="{coordinate(x)}" y="{coordinate(y)}" width="14" height="14"'
        parts.append(f'<rect {box} fill="{css(number)}"/>')
        if number == 0:
            parts.append(f'<rect {box} fill="url(#dead)"/>')
        parts.append(
            f'<text class="small" x="{coordinate(x + 19)}" y="{coordinate(y + 11)}">{label}</text>'
        )
        x += 19 + text_width(label, 10.5) + 16
    return "".join(parts), 30.0


def _table(coverage: CoverageMap, y: float) -> tuple[str, float]:
    """Return a table of the rooms beside a list of the detectors, as SVG, and its height in px.

    The list has the area that each detector covers.
    """
    parts = []
    columns = (MARGIN, 220.0, 290.0, 360.0, 430.0)
    heads = ("room", "free m²", "covered", "dead m²", "overlap")
    rows = [heads, *room_rows(coverage)]
    for i, row in enumerate(rows):
        style = "small strong" if i in (0, len(rows) - 1) else "small"
        for j, cell in enumerate(row):
            end = "" if j == 0 else " end"
            at = f'x="{columns[j]:g}" y="{coordinate(y + LINE * (i + 1))}"'
            parts.append(f'<text class="{style}{end}" {at}>{safe(cell)}</text>')
    heading = f'<text class="small strong" x="500" y="{coordinate(y + LINE)}">detector</text>'
    parts.append(
        heading + f'<text class="small strong end" x="{WIDTH - MARGIN:g}" '
        f'y="{coordinate(y + LINE)}">covers m²</text>'
    )
    for i, name in enumerate(coverage.sensors):
        area = coverage.covered[i].sum() * coverage.cells.size**2
        at = coordinate(y + LINE * (i + 2))
        parts.append(
            f'<text class="small" x="500" y="{at}">{i + 1}  {safe(name)}</text>'
            f'<text class="small end" x="{WIDTH - MARGIN:g}" y="{at}">{area:.1f}</text>'
        )
    return "".join(parts), LINE * (max(len(rows), len(coverage.sensors) + 1) + 1)
