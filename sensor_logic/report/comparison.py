# SPDX-License-Identifier: GPL-3.0-or-later
"""The distributions of two compared logs as SVG, with a panel for each statistic."""

from __future__ import annotations

import numpy as np

from ..logs.comparison.compare import HomeIntervals, Measure, Values
from ..palette import BLUE, ORANGE
from .svg import coordinate, safe, shown_number

PANEL_WIDTH, PANEL_HEIGHT, GAP, COLUMNS = 300.0, 190.0, 40.0, 4
COLOURS = (BLUE, ORANGE)
POINTS = 200


def svg(one: HomeIntervals, two: HomeIntervals, found: list[Measure]) -> str:
    """Return an SVG picture that compares the logs `one` and `two`.

    Each statistic in `found` has a panel with a curve for each log. At each x, the curve shows the
    fraction of values that are at most x. The x axis is logarithmic.
    """
    shown = [m for m in found if any(len(values) for values in m.values)]
    rows = -(-len(shown) // COLUMNS)
    width = COLUMNS * (PANEL_WIDTH + GAP) + GAP
    height = rows * (PANEL_HEIGHT + 2 * GAP) + 3 * GAP
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
        'font-family="sans-serif" font-size="11">',
        f'<rect width="{width:g}" height="{height:g}" fill="#fff"/>',
    ]
    x = GAP
    for home, colour in zip((one, two), COLOURS, strict=True):
        parts.append(
            f'<text x="{x:g}" y="20" fill="{colour}" font-size="13">{safe(home.name)}</text>'
        )
        x += 320.0
    for index, measure in enumerate(shown):
        left = GAP + index % COLUMNS * (PANEL_WIDTH + GAP)
        top = 2.5 * GAP + index // COLUMNS * (PANEL_HEIGHT + 2 * GAP)
        parts.append(f'<g transform="translate({left:g} {top:g})">{_panel(measure)}</g>')
    return "".join([*parts, "</svg>\n"])


def _panel(measure: Measure) -> str:
    values = np.concatenate(measure.values)
    positive = values[values > 0.0]
    low, high = (positive.min(), positive.max()) if len(positive) else (1.0, 10.0)
    low, high = np.floor(np.log10(low)), np.ceil(np.log10(high) + 1e-9)
    distance = measure.distance
    shown = "" if np.isnan(distance) else f", distance {distance:.2f}"
    title = f"{measure.group}: {measure.name} ({measure.unit}){shown}"
    parts = [
        f'<text y="-6" fill="#222">{safe(title)}</text>',
        f'<rect width="{PANEL_WIDTH:g}" height="{PANEL_HEIGHT:g}" fill="none" stroke="#bbb"/>',
    ]
    for power in range(int(low), int(high) + 1):
        x = _x(10.0**power, low, high)
        parts.append(
            f'<line x1="{x}" x2="{x}" y2="{PANEL_HEIGHT:g}" stroke="#eee"/>'
            f'<text x="{x}" y="{PANEL_HEIGHT + 14:g}" text-anchor="middle" fill="#666">'
            f"{shown_number(10.0**power)}</text>"
        )
    for of, colour in zip(measure.values, COLOURS, strict=True):
        if len(of):
            points = _steps(of, low, high)
            parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}"/>')
    return "".join(parts)


def _x(value: float, low: float, high: float) -> str:
    power = np.log10(max(value, 10.0**low))
    return coordinate(float((power - low) / (high - low) * PANEL_WIDTH))


def _steps(values: Values, low: float, high: float) -> str:
    """Return the points of a distribution's staircase curve, with at most POINTS steps."""
    ordered = np.sort(values)
    picked = np.unique(np.linspace(0, len(ordered) - 1, min(len(ordered), POINTS)).astype(int))
    points, y = [], PANEL_HEIGHT
    for index in picked:
        x = _x(float(ordered[index]), low, high)
        points.append(f"{x},{coordinate(y)}")
        y = PANEL_HEIGHT * (1.0 - (index + 1) / len(ordered))
        points.append(f"{x},{coordinate(y)}")
    return " ".join(points)
