# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of evidence: the objects that decided a reading, each with its share.

A recording stores such a text for each reading; *Explain* reads it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable

Shares = tuple[tuple[str, float], ...]


def shares_text(shares: Iterable[tuple[str, float]]) -> str:
    """Return pairs of an object's name and its share as a text; empty for none."""
    found = [[name, share] for name, share in shares]
    return json.dumps(found, ensure_ascii=False, separators=(",", ":")) if found else ""


def shares_of(text: str) -> Shares:
    """Return the pairs that `shares_text` has written."""
    return tuple((name, share) for name, share in json.loads(text or "[]"))
