# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that results are as accurate as before, by the bounds of every part. Times have none."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from typing import Any

from .bounds import Bounds, CheckedFigure

# In the order of the page. Each has the modules PART_bounds, PART_report and PART, which measures
# it (for rays: ray_benchmark). The light sensor has its own program and page.
PARTS = (
    "home",
    "day",
    "days",
    "live",
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


def checked(name: str, data: dict[str, Any]) -> list[CheckedFigure]:
    """Every figure of a part that has a bound; missing data break a bound too."""
    bounds = Bounds()
    for place in _no_numbers(data):
        bounds.missing(f"a number at {place}")
    try:
        CHECKS[name](data, bounds)
    except (AttributeError, KeyError, IndexError, TypeError, ValueError, ZeroDivisionError) as e:
        bounds.missing(f"data for the bounds ({type(e).__name__}: {e})")
    return bounds.checked


def broken(name: str, data: dict[str, Any]) -> list[str]:
    """The figures that break their bounds."""
    return [f"{name}: {figure}" for figure in checked(name, data) if not figure.holds]


def _no_numbers(data: Any, place: str = "") -> Iterator[str]:
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _no_numbers(value, f"{place}.{key}" if place else key)
    elif isinstance(data, list):
        for index, value in enumerate(data):
            yield from _no_numbers(value, f"{place}[{index}]")
    elif isinstance(data, float) and not math.isfinite(data):
        yield place
