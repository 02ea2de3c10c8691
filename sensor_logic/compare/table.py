# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison as text, and as data for programs."""

from __future__ import annotations

import math
from typing import Any

from .intervals import HomeIntervals
from .statistics import QUANTILES, Measure, quantiles

HEADS = ("n", *(f"{100 * q:g} %" for q in QUANTILES))


def text(one: HomeIntervals, two: HomeIntervals, found: list[Measure]) -> str:
    """For each measure a line with the distance, and a row for each home."""
    width = max(len(one.name), len(two.name), 8)
    lines = [f"{'':<{width}}" + "".join(f"{head:>10}" for head in HEADS)]
    for measure in found:
        distance = measure.distance
        shown = "no values on one side" if math.isnan(distance) else f"distance {distance:.3f}"
        lines.append(f"\n{measure.group}: {measure.name} ({measure.unit}): {shown}")
        for home, values in zip((one, two), measure.values, strict=True):
            figures = [f"{len(values)}", *(_short(q) for q in quantiles(values))]
            lines.append(f"{home.name:<{width}}" + "".join(f"{figure:>10}" for figure in figures))
    return "\n".join(lines) + "\n"


def _short(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.4g}"


def data(one: HomeIntervals, two: HomeIntervals, found: list[Measure]) -> dict[str, Any]:
    """The comparison for programs; null where there are no values."""
    return {
        "logs": [one.name, two.name],
        "measures": [
            {
                "group": measure.group,
                "measure": measure.name,
                "unit": measure.unit,
                "ks_distance": _plain(measure.distance),
                "logs": [
                    {
                        "n": len(values),
                        "quantiles": {
                            f"{q:g}": _plain(v)
                            for q, v in zip(QUANTILES, quantiles(values), strict=True)
                        },
                    }
                    for values in measure.values
                ],
            }
            for measure in found
        ],
    }


def _plain(value: float) -> float | None:
    return None if math.isnan(value) else value
