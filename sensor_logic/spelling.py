# SPDX-License-Identifier: GPL-3.0-or-later
"""Suggestions for a misspelt name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

SHOWN = 5


def hint(name: str, known: Iterable[str], most: int = SHOWN) -> str:
    """A hint for a `name` that is not among the `known` ones: the most similar, else the first, at
    `most` so many."""
    known = list(known)
    lower = {other.lower(): other for other in known}
    close = [other for text, other in lower.items() if name and name.lower() in text]
    close = close or [lower[m] for m in difflib.get_close_matches(name.lower(), lower, n=3)]
    if close:
        return f"did you mean {', '.join(close[:most])}?"
    if not known:
        return "there are none"
    return f"there are {', '.join(known[:most])}{' …' if len(known) > most else ''}"
