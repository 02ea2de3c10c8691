# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of messages: names, sentences, and numbers with units."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Sequence
from decimal import ROUND_HALF_UP, Context, Decimal
from typing import NamedTuple

MOST_NAMES = 4


class Advice(NamedTuple):
    """A problem and its solution, each a sentence without a full stop."""

    problem: str
    mend: str

    @property
    def text(self) -> str:
        """The text of both sentences."""
        return f"{self.problem}. {self.mend}"


def quoted(name: str) -> str:
    """Return the name in quotation marks."""
    return f"'{name}'"


def capital(text: str) -> str:
    """Return the text with its first letter in upper case."""
    return text[:1].upper() + text[1:]


def uncapitalized(text: str) -> str:
    """Return the text with its first letter in lower case, as after a name and a colon."""
    return text[:1].lower() + text[1:]


def named(names: Iterable[str], most: int = MOST_NAMES) -> str:
    """Return the first `most` different names, in quotes, and how many more there are."""
    return listed(list(dict.fromkeys(map(quoted, names))), most)


def listed(texts: list[str], most: int = MOST_NAMES) -> str:
    """Return the first `most` texts, and how many more there are."""
    more, shown = len(texts) - most, ", ".join(texts[:most])
    return f"{shown} and {more} more" if more > 0 else shown


def plural(count: int, noun: str) -> str:
    """Return a number and a noun, such as "1 run" or "3 runs"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def part_is(part: int, whole: int, noun: str) -> str:
    """Return the beginning of a sentence, such as "1 of 1 run is" or "2 of 3 runs are"."""
    return f"{part} of {plural(whole, noun)} {'is' if whole == 1 else 'are'}"


def percent(share: float) -> str:
    """Return the fraction `share` in percent, without a minus sign.

    There is one decimal for values near 0 or 100 %, else none.
    """
    value = 100.0 * abs(share)
    is_near = 0.0 < value < 1.0 or 0.0 < abs(value - 100.0) < 1.0
    return f"{value:.{int(is_near)}f} %"


def shown_duration(seconds: float) -> str:
    """Return a duration as text, in seconds, minutes or hours, depending on its length."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def aligned(rows: Sequence[Sequence[str]], left: int = 1) -> list[str]:
    """Return the lines of a text table.

    The first `left` columns are aligned to the left, all others to the right.
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.ljust(width) if i < left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


# Suggestions for a misspelt name.

SHOWN = 5


def hint(name: str, known: Iterable[str], most: int = SHOWN) -> str:
    """Return a hint for an unknown `name`: the most similar known names, or else the first ones.

    At most `most` names are shown.
    """
    known = list(known)
    lower = {other.lower(): other for other in known}
    close = [other for text, other in lower.items() if name and name.lower() in text]
    close = close or [lower[m] for m in difflib.get_close_matches(name.lower(), lower, n=3)]
    if close:
        return f"did you mean {', '.join(close[:most])}?"
    if not known:
        return "there are none"
    return f"there are {', '.join(known[:most])}{' …' if len(known) > most else ''}"


# Numbers with units as text; no other module formats them.
#
# Values are in SI units, angles in radians. Measured values are rounded to significant digits;
# typed values keep their digits. Exponents appear only where a person would write one.

NOTHING = "–"
ZERO_CELSIUS = 273.15
# The unit of a signal as a share of its threshold: shown in percent, without its sign.
OF_THRESHOLD = "of threshold"
PREFIXES = ((1e6, "M"), (1e3, "k"), (1.0, ""))
# From this value on, a short text has no decimals.
SHORT_FROM = 99.95
SIGNIFICANT = 3


class Lengths(NamedTuple):
    """The unit in which lengths are shown: its name, and its size in metres."""

    unit: str = "m"
    metres: float = 1.0

    def text(self, length: float) -> str:
        """Return a measured length (m) in this unit as text, precise to a millimetre."""
        return measured(length, "m", 3, self)

    def typed(self, length: float) -> str:
        """Return a length (m) in this unit as text, as a user typed it."""
        return typed(length, "m", self)


METRES = Lengths()


def measured(
    value: float, unit: str, decimals: int | None = None, lengths: Lengths = METRES
) -> str:
    """Return a reading with its unit.

    `decimals` is the number of decimals in the SI unit, in degrees for an angle, or in percent.
    None means three significant digits. All digits before the decimal point are shown.
    """
    if not math.isfinite(value):
        return NOTHING
    value, unit, decimals = _as_shown(value, unit, decimals, lengths)
    if unit == "Ω":
        return _with_prefix(value, unit, SIGNIFICANT)
    if decimals is None:
        decimals = _decimals_of(value)
    return _joined(_fixed(value, decimals), unit)


def short(value: float, unit: str, lengths: Lengths = METRES) -> str:
    """Return a reading with its unit in three or four digits, for narrow spaces."""
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
    """Return a parameter's value with its unit, in up to six digits."""
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
    """Return a value in the unit in which it is shown, that unit, and the number of decimals.

    Angles are shown in degrees, fractions of a threshold in percent, lengths in the unit of
    `lengths`.
    """
    if unit == "rad":
        return math.degrees(value), "°", 0 if decimals is None else decimals
    if unit == OF_THRESHOLD:
        return abs(value) * 100.0, f"% {OF_THRESHOLD}", 0 if decimals is None else decimals
    if unit == "m":
        if decimals is not None:
            # Keep the precision in metres: 3 decimals in metres are 1 decimal in centimetres.
            decimals = max(0, math.ceil(decimals + math.log10(lengths.metres) - 1e-9))
        return value / lengths.metres, lengths.unit, decimals
    return value, unit, decimals


def _decimals_of(value: float) -> int:
    """Return the number of decimals at which a value has three significant digits, at most 3."""
    size = abs(value)
    if size < 1.0:
        return SIGNIFICANT if 0.0 < size < 0.1 else SIGNIFICANT - 1 if size else 0
    return max(0, SIGNIFICANT - 1 - math.floor(math.log10(size)))


# The context keeps all digits of a float.
_EXACT = Context(prec=400, rounding=ROUND_HALF_UP)


def _fixed(value: float, decimals: int) -> str:
    # Halves are rounded up, as people do: Python would round 27.25 to 27.2.
    text = f"{_EXACT.quantize(Decimal(value), Decimal(1).scaleb(-decimals)):f}"
    # Avoid "-0.00".
    return text.removeprefix("-") if not any(c in "123456789" for c in text) else text


def _with_prefix(value: float, unit: str, digits: int) -> str:
    for size, prefix in PREFIXES:
        if abs(value) >= size * (1.0 - 10.0**-digits / 2.0):
            return f"{value / size:.{digits}g} {prefix}{unit}"
    return f"{value:.{digits}g} {unit}"


def _joined(number: str, unit: str) -> str:
    return f"{number}{unit}" if unit == "°" else f"{number} {unit}".rstrip()


# Several names in one field of a log, such as the objects on a pressure pad.

# A name up to the next semicolon that no backslash escapes.
NAME = re.compile(r"(?:[^;\\]|\\.)*", re.DOTALL)
ESCAPED = re.compile(r"\\(.)", re.DOTALL)


def joined(names: Iterable[str]) -> str:
    """Return the names, sorted, as one text in which `;` separates them; `split` is the inverse.

    In a name, a backslash is put before each `;` and each backslash.
    """
    escaped = (name.replace("\\", "\\\\").replace(";", "\\;") for name in sorted(names))
    return ";".join(escaped)


def split(text: str) -> list[str]:
    """Return the names in a text that `joined` returned."""
    found = []
    at = 0
    while text and at <= len(text):
        name = NAME.match(text, at)
        assert name is not None
        found.append(ESCAPED.sub(r"\1", name.group()))
        at = name.end() + 1
    return found
