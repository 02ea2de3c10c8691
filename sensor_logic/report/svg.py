# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers of all drawings: colours, escaped text, numbers, round ticks."""

from __future__ import annotations

import math
import re
import unicodedata
from html import escape

# The colours of Okabe and Ito for the colour-blind, and a brown.
BLUE, ORANGE, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#cc79a7"
YELLOW, SKY, BLACK, BROWN = "#e69f00", "#56b4e9", "#000000", "#7f4f24"

# Characters that XML 1.0 or UTF-8 cannot represent.
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


def safe(text: str) -> str:
    """Text for XML and HTML, also inside an attribute."""
    return escape(_FORBIDDEN.sub("\ufffd", text))


def shown_number(value: float) -> str:
    """A number with a real minus sign and without rounding errors."""
    return f"{0.0 if abs(value) < 1e-12 else value:.6g}".replace("-", "−")


def coordinate(value: float) -> str:
    """A coordinate of a drawing, to a tenth of a pixel."""
    text = f"{value:.1f}"
    text = text[:-2] if text.endswith(".0") else text
    return "0" if text == "-0" else text


def ticks(low: float, high: float, count: int) -> list[float]:
    """About `count` multiples of 1, 2 or 5 times a power of ten that span `low` to `high`."""
    rough = (high - low) / max(count, 1)
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(power * m for m in (1.0, 2.0, 5.0, 10.0) if power * m >= rough * (1 - 1e-9))
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return [step * i for i in range(first, last + 1)]


def place(value: float, low: float, high: float, first: float, last: float) -> float:
    """The position between `first` and `last` of a value on the axis from `low` to `high`."""
    return first + (value - low) / (high - low) * (last - first)


def text_width(text: str, size: float) -> float:
    """The approximate width of a text in a sans-serif font of this size; rather too large."""
    return sum(_width(character) for character in text) * size


def _width(character: str) -> float:
    if character in "iljtfr.,;:|!'()[] ":
        return 0.34
    if character in "mwMW@%" or unicodedata.east_asian_width(character) in "WF":
        return 1.0
    if unicodedata.combining(character):
        return 0.0
    return 0.7 if character.isupper() else 0.555


def fitting(text: str, width: float, size: float) -> str:
    """The text, shortened with an ellipsis where it is too wide."""
    if text_width(text, size) <= width:
        return text
    while text and text_width(text + "…", size) > width:
        text = text[:-1]
    return text.rstrip() + "…"
