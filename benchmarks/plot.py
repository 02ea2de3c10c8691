# SPDX-License-Identifier: GPL-3.0-or-later
"""Small line plots as SVG, from numbers alone: panels below each other over one axis."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

# Okabe and Ito: told apart by the colour-blind too.
BLUE, ORANGE, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#cc79a7"
YELLOW, SKY, BLACK = "#e69f00", "#56b4e9", "#000000"
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
    least to both sides of zero; `legend`: a line of text at the top."""

    label: str
    series: Sequence[Series]
    height: float
    least: float = 0.0
    legend: str = ""


def figure(title: str, x_label: str, panels: Sequence[Panel], about: str = "") -> str:
    """The whole SVG; `about` is what a screen reader says of it."""
    height = TOP + BOTTOM + sum(p.height for p in panels) + BETWEEN * (len(panels) - 1)
    x_low, x_high = _span(x for p in panels for s in p.series for x in s.x)
    ticks_x = [tick for tick in ticks(x_low, x_high, 10) if x_low <= tick <= x_high]
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
        x = _place(tick, x_low, x_high, LEFT, right)
        parts.append(_text(x, base + 18, number(tick), "middle"))
    parts.append(_text((LEFT + right) / 2, base + 38, x_label, "middle"))
    return "\n".join([*parts, "</svg>"]) + "\n"


def _panel(
    panel: Panel, top: float, x_low: float, x_high: float, ticks_x: Sequence[float]
) -> list[str]:
    right, bottom = float(WIDTH - RIGHT), top + panel.height
    low, high = _span((y for s in panel.series for y in s.y), panel.least)
    steps = ticks(low, high, max(2, int(panel.height / 45)))
    low, high = min(low, steps[0]), max(high, steps[-1])
    parts = []
    for tick in steps:
        y = _place(tick, low, high, bottom, top)
        parts.append(f'<path class="grid" d="M{LEFT} {y:.1f}H{right:g}"/>')
        parts.append(_text(LEFT - 8, y + 4, number(tick), "end"))
    for tick in ticks_x:
        x = _place(tick, x_low, x_high, LEFT, right)
        parts.append(f'<path class="grid" d="M{x:.1f} {top:g}V{bottom:g}"/>')
    ends: list[tuple[float, Series]] = []
    for series in panel.series:
        places = [
            (_place(x, x_low, x_high, LEFT, right), _place(y, low, high, bottom, top))
            for x, y in zip(series.x, series.y, strict=True)
        ]
        parts.append(_drawn(series, places))
        if series.label:
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


def ticks(low: float, high: float, count: int) -> list[float]:
    """Round numbers (1, 2 or 5 times a power of ten) from at or below `low` to `high` or above,
    about `count` of them."""
    rough = (high - low) / max(count, 1)
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * m for m in (1.0, 2.0, 5.0, 10.0) if power * m >= rough * (1 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return [step * i for i in range(first, last + 1)]


def number(value: float) -> str:
    """With a real minus sign, and no noise of floats."""
    return f"{0.0 if abs(value) < 1e-12 else value:.6g}".replace("-", "−")


def _span(values: Iterable[float], least: float = 0.0) -> tuple[float, float]:
    found = [value for value in values if math.isfinite(value)]
    low, high = min([*found, -least] if least else found), max([*found, least] if least else found)
    return (low, high) if high > low else (low - 0.5, high + 0.5)


def _place(value: float, low: float, high: float, first: float, last: float) -> float:
    return first + (value - low) / (high - low) * (last - first)


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
