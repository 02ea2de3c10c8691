# SPDX-License-Identifier: GPL-3.0-or-later
"""Markdown tables from numbers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [_line(head), _line("---" for _ in head)]
    return "".join([*lines, *(_line(row) for row in rows)])


def columns(rows: Iterable[Mapping[str, Any]], *specs: str) -> str:
    """A table with a column for each of `specs`: "head=key:format", where a single name is both
    head and key, and the format is one of WAYS or of Python's; text after it follows the number,
    such as "reading=percent:.2f %"."""
    columns = [(head, key or head) for head, _, key in (spec.partition("=") for spec in specs)]
    heads = [head for head, _ in columns]
    return table(heads, ([_cell(row, key) for _, key in columns] for row in rows))


def _cell(row: Mapping[str, Any], spec: str) -> str:
    key, _, how = spec.partition(":")
    how, space, unit = how.partition(" ")
    if how in WAYS:
        return WAYS[how](row[key])
    return f"{row[key]:{how}}{space}{unit}"


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cells)} |\n"


def spread(found: dict[str, Any] | float, digits: int = 3) -> str:
    """Median (least–greatest) of repeated runs; for a single run only the number."""
    if not isinstance(found, dict) or found["runs"] == 1:
        return short(median(found), digits)
    low, high = short(found["low"], digits), short(found["high"], digits)
    return f"{short(found['median'], digits)} ({low}–{high})"


def median(found: dict[str, Any] | float) -> float:
    return float(found["median"]) if isinstance(found, dict) else found


def short(value: float, digits: int = 3) -> str:
    """A number with so many significant digits; with an exponent only below 0.001 or from 1e6
    on."""
    if value and not 1e-3 <= abs(value) < 1e6:
        return f"{value:.{digits - 1}e}"
    size = len(str(int(abs(value)))) if abs(value) >= 1 else 0
    if abs(value) < 1:
        return f"{value:.{digits}g}"
    return f"{value:.{max(digits - size, 0)}f}"


def percent(share: float) -> str:
    return f"{share:.0%}" if share in (0.0, 1.0) else f"{share:.1%}"


WAYS: Mapping[str, Callable[[Any], str]] = {
    "spread": spread,
    "median": lambda found: short(median(found)),
    "percent": percent,
}


def filled_in(page: str, command: str, texts: Mapping[str, str]) -> str:
    """The page with new tables, each between its two markers; the first marker names the command
    that measures it."""
    for name, text in texts.items():
        first, last = f"<!-- {name}: {command} -->", f"<!-- end of {name} -->"
        before, _, rest = page.partition(first)
        _, found, after = rest.partition(last)
        assert found, f"the page has no place for {name}: {first} … {last}"
        page = f"{before}{first}\n\n{text}\n{last}{after}"
    return page
