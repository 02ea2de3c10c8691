# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and sentences in messages."""

from __future__ import annotations

from collections.abc import Iterable
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
