# SPDX-License-Identifier: GPL-3.0-or-later
"""Several names in one field of a log, such as the partners of a pressure pad."""

from __future__ import annotations

import re
from collections.abc import Iterable

# A name up to the next semicolon that no backslash escapes.
NAME = re.compile(r"(?:[^;\\]|\\.)*", re.DOTALL)
ESCAPED = re.compile(r"\\(.)", re.DOTALL)


def joined(names: Iterable[str]) -> str:
    """The names, sorted and separated by `;`. A backslash escapes `;` and backslashes in a name, so
    that `split` returns the same names."""
    escaped = (name.replace("\\", "\\\\").replace(";", "\\;") for name in sorted(names))
    return ";".join(escaped)


def split(text: str) -> list[str]:
    """The names in a text by `joined`."""
    found = []
    at = 0
    while text and at <= len(text):
        name = NAME.match(text, at)
        assert name is not None
        found.append(ESCAPED.sub(r"\1", name.group()))
        at = name.end() + 1
    return found
