# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and sentences as messages have them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

MOST_NAMES = 4


class Advice(NamedTuple):
    """`wrong`: what is wrong; `mend`: the way to mend it. A sentence each, without its stop."""

    wrong: str
    mend: str

    @property
    def text(self) -> str:
        return f"{self.wrong}. {self.mend}"


def quoted(name: str) -> str:
    return f"'{name}'"


def capital(text: str) -> str:
    """The text with a capital at its beginning."""
    return text[:1].upper() + text[1:]


def uncapped(text: str) -> str:
    """The text without a capital at its beginning, as it stands after a name and a colon."""
    return text[:1].lower() + text[1:]


def named(names: Iterable[str], most: int = MOST_NAMES) -> str:
    """Names in quotes, each once and in their order: the first of them and how many more."""
    return listed(list(dict.fromkeys(map(quoted, names))), most)


def listed(texts: list[str], most: int = MOST_NAMES) -> str:
    """The first of some texts, and how many more there are."""
    more = len(texts) - most
    return ", ".join(texts[:most]) + (f" and {more} more" if more > 0 else "")
