# SPDX-License-Identifier: GPL-3.0-or-later
"""Markdown from numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [_line(head), _line("---" for _ in head)]
    return "".join([*lines, *(_line(row) for row in rows)])


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |\n"


def spread(found: dict[str, Any], digits: int = 3) -> str:
    """Median (least–greatest) of repeated runs; of a single one, the number alone."""
    median = short(found["median"], digits)
    if found["runs"] == 1:
        return median
    return f"{median} ({short(found['low'], digits)}–{short(found['high'], digits)})"


def short(value: float, digits: int = 3) -> str:
    """So many digits that count, and no exponents for numbers that people read as they are."""
    if value and not 1e-3 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}"
    size = len(str(int(abs(value)))) if abs(value) >= 1 else 0
    if abs(value) < 1:
        return f"{value:.{digits}g}"
    return f"{value:.{max(digits - size, 0)}f}"


def percent(share: float) -> str:
    return f"{share:.0%}" if share in (0.0, 1.0) else f"{share:.1%}"
