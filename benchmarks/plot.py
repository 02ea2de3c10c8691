# SPDX-License-Identifier: GPL-3.0-or-later
"""Small line plots as SVG, from numbers alone: panels below each other over one axis."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from html import escape

from sensor_logic.report.svg import (  # noqa: F401  (figures take their colours from here)
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    YELLOW,
    place,
    ticks,
)
from sensor_logic.report.svg import shown_number as number

WIDTH, LEFT, RIGHT, TOP, BOTTOM, BETWEEN = 860, 80, 118, 44, 46, 24
STYLE = (
    "text{font-family:system-ui,sans-serif;font-size:13px;fill:#222}"
    ".grid{stroke:#ddd;stroke-width:1}.frame{stroke:#666;fill:none}.small{font-size:12px}"
)
# Labels at the end of lines stay this far apart.
LABEL_HEIGHT = 16.0


@dataclass(frozen=True)
class Series:
    """One line, `thin` line, or row of `dots`; its label stands at its right end."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    colour: str
    style: str = "line"


@dataclass(frozen=True)
class Panel:
    """Series over one y axis, with its label and unit; `least`: the axis spans this much at
    least to both sides of zero; `legend`: a line of text at the top; `log`: a logarithmic axis."""

    label: str
    series: Sequence[Series]
    height: float
    least: float = 0.0
    legend: str = ""
    log: bool = False


def figure(
    title: str, x_label: str, panels: Sequence[Panel], about: str = "", log_x: bool = False
) -> str:
    """The whole SVG; `about` is what a screen reader says of it."""
    panels = [_logarithmic(panel, log_x) for panel in panels]
    height = TOP + BOTTOM + sum(p.height for p in panels) + BETWEEN * (len(panels) - 1)
    x_low, x_high = _span(x for p in panels for s in p.series for x in s.x)
    marks = decades(x_low, x_high) if log_x else ticks(x_low, x_high, 10)
    ticks_x = [tick for tick in marks if x_low - 1e-9 <= tick <= x_high + 1e-9]
    right = WIDTH - RIGHT
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:g}" role="img" '
        f'width="{WIDTH}" height="{height:g}"><title>{escape(title)}</title>'
        f"<desc>{escape(about)}</desc><style>{STYLE}</style>",
        '<rect width="100%" height="100%" fill="#fff"/>',
        f'<text x="{LEFT}" y="24" style="font-weight:600">{escape(title)}</text>',
    ]
    top = float(TOP)
    for panel in panels:
        parts += _panel(panel, top, x_low, x_high, ticks_x)
        top += panel.height + BETWEEN
    base = top - BETWEEN
    for tick in ticks_x:
        x = place(tick, x_low, x_high, LEFT, right)
        parts.append(_text(x, base + 18, number(10.0**tick if log_x else tick), "middle"))
    parts.append(_text((LEFT + right) / 2, base + 38, x_label, "middle"))
    return "\n".join([*parts, "</svg>"]) + "\n"


def _panel(
    panel: Panel, top: float, x_low: float, x_high: float, ticks_x: Sequence[float]
) -> list[str]:
    right, bottom = float(WIDTH - RIGHT), top + panel.height
    low, high = _span((y for s in panel.series for y in s.y), panel.least)
    steps = decades(low, high) if panel.log else ticks(low, high, max(2, int(panel.height / 45)))
    low, high = min(low, steps[0]), max(high, steps[-1])
    parts = []
    for tick in steps:
        y = place(tick, low, high, bottom, top)
        parts.append(f'<path class="grid" d="M{LEFT} {y:.1f}H{right:g}"/>')
        parts.append(_text(LEFT - 8, y + 4, number(10.0**tick if panel.log else tick), "end"))
    for tick in ticks_x:
        x = place(tick, x_low, x_high, LEFT, right)
        parts.append(f'<path class="grid" d="M{x:.1f} {top:g}V{bottom:g}"/>')
    ends: list[tuple[float, Series]] = []
    for series in panel.series:
        places = [
            (place(x, x_low, x_high, LEFT, right), place(y, low, high, bottom, top))
            for x, y in zip(series.x, series.y, strict=True)
        ]
        parts.append(_drawn(series, places))
        if series.label and places:
            ends.append((places[-1][1], series))
    parts.append(
        f'<rect class="frame" x="{LEFT}" y="{top:g}" width="{right - LEFT:g}" '
        f'height="{panel.height:g}"/>'
    )
    for y, series in _apart(ends):
        parts.append(_text(right + 8, y + 4, series.label, "start", series.colour))
    middle = (top + bottom) / 2
    parts.append(
        f'<text transform="translate(20 {middle:g}) rotate(-90)" text-anchor="middle">'
        f"{escape(panel.label)}</text>"
    )
    if panel.legend:
        parts.append(
            f'<rect x="{LEFT + 8}" y="{top + 6:g}" width="{7.2 * len(panel.legend):g}" height="20" '
            f'fill="#fff" fill-opacity="0.85"/>'
            f'<text class="small" x="{LEFT + 14}" y="{top + 20:g}" xml:space="preserve">'
            f"{escape(panel.legend)}</text>"
        )
    return parts


def _drawn(series: Series, places: Sequence[tuple[float, float]]) -> str:
    if series.style == "dots":
        return "".join(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="#fff" stroke="{series.colour}" '
            f'stroke-width="1.3"/>'
            for x, y in places
        )
    width = 1.0 if series.style == "thin" else 1.6
    line = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    return f'<path d="M{line}" fill="none" stroke="{series.colour}" stroke-width="{width}"/>'


def decades(low: float, high: float) -> list[float]:
    """Logarithms of 1, 2 and 5 times powers of ten, or of these alone where there are many, from
    at or below `low` to at or above `high`."""
    steps = (1.0, 2.0, 5.0) if high - low < 2.5 else (1.0,)
    powers = range(math.floor(low) - 1, math.ceil(high) + 2)
    marks = [math.log10(step) + power for power in powers for step in steps]
    below = max(mark for mark in marks if mark <= low + 1e-9)
    above = min(mark for mark in marks if mark >= high - 1e-9)
    return [mark for mark in marks if below <= mark <= above]


def _logarithmic(panel: Panel, log_x: bool) -> Panel:
    """The panel with the logarithms of its numbers; those that are not above zero go."""

    def moved(series: Series) -> Series:
        pairs = [
            (math.log10(x) if log_x else x, math.log10(y) if panel.log else y)
            for x, y in zip(series.x, series.y, strict=True)
            if (x > 0.0 or not log_x) and (y > 0.0 or not panel.log)
        ]
        return replace(series, x=[x for x, _ in pairs], y=[y for _, y in pairs])

    return replace(panel, series=[moved(series) for series in panel.series])


def _span(values: Iterable[float], least: float = 0.0) -> tuple[float, float]:
    found = [value for value in values if math.isfinite(value)]
    if not found:
        # All of it was left out of a logarithmic axis.
        return 0.0, 1.0
    low, high = min([*found, -least] if least else found), max([*found, least] if least else found)
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _apart(ends: list[tuple[float, Series]]) -> list[tuple[float, Series]]:
    """Labels moved down until none covers another."""
    found: list[tuple[float, Series]] = []
    for y, series in sorted(ends, key=lambda end: end[0]):
        lowest = found[-1][0] + LABEL_HEIGHT if found else y
        found.append((max(y, lowest), series))
    return found


def _text(x: float, y: float, text: str, anchor: str, colour: str = "#222") -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" style="fill:{colour}">'
        f"{escape(text)}</text>"
    )
