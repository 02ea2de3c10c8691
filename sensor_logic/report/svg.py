# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers for all drawings: colours, escaped text, numbers, round ticks, marks."""

from __future__ import annotations

import math
import re
import unicodedata
from html import escape

import numpy as np

from ..kinds import KINDS
from ..model import Array
from ..palette import KIND_COLOURS

# Characters that XML 1.0 or UTF-8 cannot represent.
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


def safe(text: str) -> str:
    """Return a text escaped for XML and HTML, so that it can also stand in an attribute."""
    return escape(_FORBIDDEN.sub("\ufffd", text))


def shown_number(value: float) -> str:
    """Return a number with at most six digits as text, with a minus sign instead of a hyphen."""
    return f"{0.0 if abs(value) < 1e-12 else value:.6g}".replace("-", "−")


def coordinate(value: float) -> str:
    """Return a coordinate in a drawing as text, rounded to a tenth of a pixel."""
    text = f"{value:.1f}"
    text = text[:-2] if text.endswith(".0") else text
    return "0" if text == "-0" else text


def ticks(low: float, high: float, count: int) -> list[float]:
    """Return about `count` round numbers for an axis from `low` to `high`.

    The numbers are multiples of 1, 2 or 5 times a power of ten.
    """
    rough = (high - low) / max(count, 1)
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * m for m in (1.0, 2.0, 5.0, 10.0) if power * m >= rough * (1 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return [step * i for i in range(first, last + 1)]


def place(value: float, low: float, high: float, first: float, last: float) -> float:
    """Return the position of a value on an axis, by linear interpolation.

    The axis has the value `low` at the position `first`, and `high` at `last`.
    """
    return first + (value - low) / (high - low) * (last - first)


def text_width(text: str, size: float) -> float:
    """Return an estimate of the width of a text in a sans-serif font, which is mostly too large."""
    return sum(_width(character) for character in text) * size


def _width(character: str) -> float:
    if character in "iljtfr.,;:|!'()[] ":
        return 0.34
    if character in "mwMW@%" or unicodedata.east_asian_width(character) in "WF":
        return 1.0
    if unicodedata.combining(character):
        return 0.0
    return 0.7 if character.isupper() else 0.555


def shortened(text: str, width: float, size: float) -> str:
    """Return the text, with an ellipsis in its middle if it is wider than `width`.

    Names of sensors often differ only at their end.
    """
    if text_width(text, size) <= width:
        return text
    for letters in range(len(text) - 1, 0, -1):
        end = letters // 2
        cut = f"{text[: letters - end].rstrip()}…{text[len(text) - end :].lstrip()}"
        if text_width(cut, size) <= width:
            return cut
    return "…"


# Colours, and a mark for each kind of sensor; marks differ in shape too.

# The colours by name, on white and on black.
INKS = {
    "paper": ("#ffffff", "#14171a"),
    "ink": ("#1c2024", "#e8eaec"),
    "quiet": ("#5b636b", "#a3abb3"),
    "grid": ("#e4e7ea", "#2a2f35"),
    "rule": ("#b9c0c6", "#454c54"),
    "wall": ("#3b4248", "#98a0a8"),
    "solid": ("#cfd4d8", "#4b535b"),
    "low": ("#f3f5f6", "#1d2125"),
    "line": ("#a9b1b8", "#5d656d"),
    **{f"kind{n}": pair for n, pair in enumerate(KIND_COLOURS, 1)},
    "onkind": ("#ffffff", "#14171a"),
}
HUES = len(KIND_COLOURS)

STYLE = """
text{font-family:"Inter","Helvetica Neue",Helvetica,Arial,"DejaVu Sans",sans-serif;font-size:12px;
fill:$ink}
.small{font-size:10.5px}.quiet{fill:$quiet}.strong{font-weight:600}
.mark{font-size:9.5px;font-weight:600;fill:$onkind;text-anchor:middle}
.end{text-anchor:end}.mid{text-anchor:middle}
.grid{stroke:$grid;fill:none}.rule{stroke:$rule;fill:none}.hatch{stroke:$ink;stroke-width:1.1}
.dot{fill:$quiet}.paper{fill:$paper}.lead{stroke:$quiet;stroke-width:.7;fill:none}
.wall{fill:$wall;stroke:$wall;stroke-width:.8;stroke-linejoin:round}
.solid{fill:$solid;stroke:$wall;stroke-width:.7;stroke-linejoin:round}
.hollow{fill:none;stroke:$wall;stroke-width:.9}
.low{fill:$low;stroke:$line;stroke-width:.7;stroke-linejoin:round}
.floor{fill:none;stroke:$grid;stroke-width:.7}
.moving{fill:$paper;stroke:$wall;stroke-width:.7;stroke-dasharray:2.5 1.5}
.fields{opacity:.55}.first{stroke-opacity:1;stroke-width:1.2}
.scale{stroke:$ink;stroke-width:1.4;fill:none}
"""
HUE_STYLE = """
.bar$n{stroke:$kind$n;fill:none}.fill$n{fill:$kind$n}
.curve$n{stroke:$kind$n;stroke-width:1.1;fill:$kind$n;fill-opacity:.16;stroke-linejoin:round}
.fan$n{fill:$kind$n;fill-opacity:.1;stroke:$kind$n;stroke-opacity:.6;stroke-width:.5}
.beam$n{stroke:$kind$n;stroke-width:1.2;fill:none}
.pad$n{fill:$kind$n;fill-opacity:.35;stroke:$kind$n;stroke-width:1}
"""


def style(colours: dict[str, str]) -> str:
    """Return the CSS of all drawings, with a CSS colour for each name in `INKS`."""
    text = "".join(HUE_STYLE.replace("$n", str(n)) for n in range(1, HUES + 1)) + STYLE
    for name in sorted(colours, key=len, reverse=True):
        text = text.replace(f"${name}", colours[name])
    return text.strip()


def plain_style() -> str:
    """Return the CSS for a drawing outside the HTML page, black on white."""
    return style({name: light for name, (light, _) in INKS.items()})


def hue(kind_name: str) -> int:
    """Return the number, from 1 to HUES, of the colour in which a kind of sensor is drawn."""
    return (KINDS[kind_name].number - 1) % HUES + 1


def mark(kind_name: str, x: float, y: float, label: str, about: str = "") -> str:
    """Return an SVG shape with a label, centred at (x, y); colour and shape depend on the kind.

    `about` is the tooltip.
    """
    kind = f'class="fill{hue(kind_name)}"'
    half = 8.0 if len(label) < 3 else 9.5
    shapes = {
        1: f'<circle {kind} r="{half}"/>',
        2: f'<rect {kind} x="{-half}" y="-7" width="{2 * half}" height="14" rx="1"/>',
        3: f'<path {kind} d="M{-half - 3} 0L0 {-half - 1.5}L{half + 3} 0L0 {half + 1.5}Z"/>',
        4: f'<path {kind} d="M{-half - 1} 7L{1 - half} -7H{half - 1}L{half + 1} 7Z"/>',
        5: f'<path {kind} d="M{-half} -4L0 -9L{half} -4V4L0 9L{-half} 4Z"/>',
        6: f'<path {kind} d="M{-half - 4} 7L0 {-half - 3}L{half + 4} 7Z"/>',
        7: f'<path {kind} d="M{-half} -3.5L{4 - half} -8H{half - 4}L{half} -3.5V3.5L{half - 4} 8'
        f'H{4 - half}L{-half} 3.5Z"/>',
        8: f'<path {kind} d="M{-half - 1} -7H{half + 1}L{half - 1} 7H{1 - half}Z"/>',
        9: f'<rect {kind} x="{-half - 2}" y="-7" width="{2 * half + 4}" height="14" rx="7"/>',
        10: f'<path {kind} d="M0 {-half - 4}C{half + 4} -2 {half + 2} 8 0 8C{-half - 2} 8 '
        f'{-half - 4} -2 0 {-half - 4}Z"/>',
    }
    title = f"<title>{safe(about)}</title>" if about else ""
    return (
        f'<g transform="translate({coordinate(x)} {coordinate(y)})">{title}'
        f'{shapes[hue(kind_name)]}<text class="mark" y="3.4">{safe(label)}</text></g>'
    )


# The positions of marks near the points that they label, so that marks do not overlap.

# The distances (px) and directions to try, the nearest first.
RINGS = (0.0, 17.0, 26.0, 38.0, 54.0, 76.0, 108.0)
DIRECTIONS = 16


def spread(
    places: Array, size: tuple[float, float], box: tuple[float, float, float, float]
) -> Array:
    """Return positions (n, 2) of marks near the points `places` (n, 2), so that no marks overlap.

    Marks are placed in order. Each gets the free position nearest to its point. If none is free, it
    gets the position farthest from all other marks. Lengths are in px.

    Parameters
    ----------
    places
        The points (n, 2) that the marks label.
    size
        Width and height of a mark.
    box
        Left, top, right and bottom of the area in which marks stay, if they fit into it.
    """
    offsets = np.array(
        [(0.0, 0.0)]
        + [
            (r * math.cos(2 * math.pi * k / DIRECTIONS), r * math.sin(2 * math.pi * k / DIRECTIONS))
            for r in RINGS[1:]
            for k in range(DIRECTIONS)
        ]
    )
    half = np.array(size) / 2
    low, high = np.array(box[:2]) + half, np.array(box[2:]) - half
    found = np.empty((len(places), 2))
    for i, at in enumerate(places):
        spots = np.clip(at + offsets, low, np.maximum(high, low))
        gaps = np.abs(spots[:, None, :] - found[None, :i, :]) / np.array(size)
        apart = gaps.max(axis=2).min(axis=1, initial=np.inf)
        free = np.flatnonzero(apart >= 1.0)
        found[i] = spots[free[0] if len(free) else int(np.argmax(apart))]
    return found
