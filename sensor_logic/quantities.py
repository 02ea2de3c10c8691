# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of numbers with their units: the only place that makes them.

Values are SI, angles in radians. A measured value is rounded to the digits that matter, a typed one
is written as it was typed. Neither has an exponent where a person would write none.
"""

from __future__ import annotations

import math
from typing import NamedTuple

NOTHING = "–"
ZERO_CELSIUS = 273.15
# The unit of a signal as a share of its threshold: shown in percent, without its sign.
OF_THRESHOLD = "of threshold"
PREFIXES = ((1e6, "M"), (1e3, "k"), (1.0, ""))
# A short text has no decimals from this value on.
SHORT_FROM = 99.95
SIGNIFICANT = 3


class Lengths(NamedTuple):
    """The unit that lengths are written in: its name, and how many metres it is."""

    unit: str = "m"
    metres: float = 1.0

    def text(self, length: float) -> str:
        """A measured length (m), to a millimetre."""
        return measured(length, "m", 3, self)

    def typed(self, length: float) -> str:
        """A length (m) that a user typed."""
        return typed(length, "m", self)


METRES = Lengths()


def measured(
    value: float, unit: str, decimals: int | None = None, lengths: Lengths = METRES
) -> str:
    """A reading with its unit. `decimals` counts those of the SI unit, of degrees or of percent;
    None: three significant digits, or all digits before the point."""
    if not math.isfinite(value):
        return NOTHING
    value, unit, decimals = _as_shown(value, unit, decimals, lengths)
    if unit == "Ω":
        return _with_prefix(value, unit, SIGNIFICANT)
    if decimals is None:
        decimals = _decimals_of(value)
    return _joined(_fixed(value, decimals), unit)


def short(value: float, unit: str, lengths: Lengths = METRES) -> str:
    """A reading in three or four digits, for narrow places."""
    if not math.isfinite(value):
        return NOTHING
    value, shown, _ = _as_shown(value, unit, None, lengths)
    if shown == "Ω":
        return _with_prefix(value, shown, SIGNIFICANT)
    # One decimal is too coarse for lengths below 1 m.
    fine = unit == "m" and abs(value) < 1.0
    decimals = 0 if abs(value) >= SHORT_FROM or shown == "°" else 2 if fine else 1
    return _joined(_fixed(value, decimals), shown)


def typed(value: float, unit: str, lengths: Lengths = METRES) -> str:
    """A parameter's value as a user typed it: six digits, without trailing zeros."""
    if not math.isfinite(value):
        return _joined(f"{value}", unit)
    if unit == "m":
        # Blender stores lengths in single precision, also those typed in centimetres or feet.
        value, unit = value / lengths.metres, lengths.unit
    if unit == "Ω":
        return _with_prefix(value, unit, 6)
    if unit == "rad":
        value, unit = math.degrees(value), "°"
    text = f"{value:.6g}"
    return _joined(f"{value:.0f}" if "e+" in text else text, unit)


def _as_shown(
    value: float, unit: str, decimals: int | None, lengths: Lengths
) -> tuple[float, str, int | None]:
    """Value, unit and decimals in the unit that is shown: degrees, percent or the length unit."""
    if unit == "rad":
        return math.degrees(value), "°", 0 if decimals is None else decimals
    if unit == OF_THRESHOLD:
        return abs(value) * 100.0, f"% {OF_THRESHOLD}", 0 if decimals is None else decimals
    if unit == "m":
        if decimals is not None:
            # As fine as in metres: a millimetre is a tenth of a centimetre.
            decimals = max(0, math.ceil(decimals + math.log10(lengths.metres) - 1e-9))
        return value / lengths.metres, lengths.unit, decimals
    return value, unit, decimals


def _decimals_of(value: float) -> int:
    """How many decimals show three significant digits: at most three."""
    size = abs(value)
    if size < 1.0:
        return SIGNIFICANT if 0.0 < size < 0.1 else SIGNIFICANT - 1 if size else 0
    return max(0, SIGNIFICANT - 1 - math.floor(math.log10(size)))


def _fixed(value: float, decimals: int) -> str:
    text = f"{value:.{decimals}f}"
    # Not "-0.00".
    return text.removeprefix("-") if not any(c in "123456789" for c in text) else text


def _with_prefix(value: float, unit: str, digits: int) -> str:
    for size, prefix in PREFIXES:
        if abs(value) >= size * (1.0 - 10.0**-digits / 2.0):
            return f"{value / size:.{digits}g} {prefix}{unit}"
    return f"{value:.{digits}g} {unit}"


def _joined(number: str, unit: str) -> str:
    return f"{number}{unit}" if unit == "°" else f"{number} {unit}".rstrip()
