# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and sentences in messages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

MOST_NAMES = 4


class Advice(NamedTuple):
    """A problem and how to solve it, each a sentence without its full stop."""

    problem: str
    mend: str

    @property
    def text(self) -> str:
        return f"{self.problem}. {self.mend}"


def quoted(name: str) -> str:
    return f"'{name}'"


def capital(text: str) -> str:
    """The text with its first letter in upper case."""
    return text[:1].upper() + text[1:]


def uncapitalized(text: str) -> str:
    """The text with its first letter in lower case, to follow a name and a colon."""
    return text[:1].lower() + text[1:]


def named(names: Iterable[str], most: int = MOST_NAMES) -> str:
    """Names in quotes, without repetitions: the first ones, and how many more there are."""
    return listed(list(dict.fromkeys(map(quoted, names))), most)


def listed(texts: list[str], most: int = MOST_NAMES) -> str:
    """The first of the texts, and how many more there are."""
    more = len(texts) - most
    return ", ".join(texts[:most]) + (f" and {more} more" if more > 0 else "")


def plural(count: int, noun: str) -> str:
    """A count and its noun, such as 1 run or 3 runs."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def part_is(part: int, whole: int, noun: str) -> str:
    """The begin of a sentence, such as 1 of 1 run is, or 2 of 3 runs are."""
    return f"{part} of {plural(whole, noun)} {'is' if whole == 1 else 'are'}"


def shown_duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def aligned(rows: Sequence[Sequence[str]], left: int = 1) -> list[str]:
    """The lines of a text table: the first `left` columns aligned to the left, the others right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.ljust(width) if i < left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
