# SPDX-License-Identifier: GPL-3.0-or-later
"""Several names in one field of a log, such as the partners of a pressure pad."""

from __future__ import annotations

import re
from collections.abc import Iterable

# A semicolon that ends a name: not one that a backslash makes a part of it.
PART = re.compile(r"(?:[^;\\]|\\.)*", re.DOTALL)
ESCAPED = re.compile(r"\\(.)", re.DOTALL)


def joined(names: Iterable[str]) -> str:
    """Names, sorted, with `;` between them; a `;` or a backslash in a name has a backslash before
    it, so that `split` gives the same names."""
    escaped = (name.replace("\\", "\\\\").replace(";", "\\;") for name in sorted(names))
    return ";".join(escaped)


def split(text: str) -> list[str]:
    """The names in what `joined` gave."""
    found = []
    at = 0
    while text and at <= len(text):
        part = PART.match(text, at)
        assert part is not None
        found.append(ESCAPED.sub(r"\1", part.group()))
        at = part.end() + 1
    return found
