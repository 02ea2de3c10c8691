# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether what was measured is as accurate as it was: the bounds of every part. Times have none."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from typing import Any

from .bounds import Bounds, Held

# In the order of the page; each has modules of its name: PART_bounds, PART_report and, but for
# rays, PART, which measures it. The light sensor has a program and a page of its own.
PARTS = (
    "home",
    "day",
    "days",
    "rays",
    "pir",
    "pir_pyroelectric",
    "switch",
    "pressure",
    "peers",
    "growth",
    "coverage",
    "study",
)
CHECKS: Mapping[str, Callable[[dict[str, Any], Bounds], None]] = {
    part: import_module(f"{__package__}.{part}_bounds").check for part in PARTS
}


def held(name: str, data: dict[str, Any]) -> list[Held]:
    """Every figure of a part that has a bound. What is missing in its data is told as broken."""
    bounds = Bounds()
    for place in _no_numbers(data):
        bounds.missing(f"a number at {place}")
    try:
        CHECKS[name](data, bounds)
    except (AttributeError, KeyError, IndexError, TypeError, ValueError, ZeroDivisionError) as e:
        bounds.missing(f"what the bounds are for ({type(e).__name__}: {e})")
    return bounds.held


def broken(name: str, data: dict[str, Any]) -> list[str]:
    """What is out of its bound: the figure, and what it must be."""
    return [f"{name}: {figure}" for figure in held(name, data) if not figure.holds]


def _no_numbers(data: Any, place: str = "") -> Iterator[str]:
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _no_numbers(value, f"{place}.{key}" if place else key)
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _no_numbers(value, f"{place}[{index}]")
    elif isinstance(data, float) and not math.isfinite(data):
        yield place
