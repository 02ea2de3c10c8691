# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison as text, and as data for programs."""

from __future__ import annotations

import math
from typing import Any

from ..wording import shown_duration
from .intervals import DAY_S, HomeIntervals
from .statistics import QUANTILES, Measure, quantiles

HEADS = ("n", *(f"{100 * q:g} %" for q in QUANTILES))


def text(one: HomeIntervals, two: HomeIntervals, found: list[Measure]) -> str:
    """For each measure a line with the distance, and a row for each home; last, which logs are
    shorter than a day."""
    width = max(len(one.name), len(two.name), 8)
    lines = [f"{'':<{width}}" + "".join(f"{head:>10}" for head in HEADS)]
    for measure in found:
        shown = _distance(measure)
        lines.append(f"\n{measure.group}: {measure.name} ({measure.unit}): {shown}")
        for home, values in zip((one, two), measure.values, strict=True):
            figures = [f"{len(values)}", *(_short(q) for q in quantiles(values))]
            lines.append(f"{home.name:<{width}}" + "".join(f"{figure:>10}" for figure in figures))
    for home in (one,) if one == two else (one, two):
        if home.length < DAY_S:
            lines.append(
                f"\n{home.name} lasts {shown_duration(home.length)}: its times and % of a day are "
                "scaled up from that to 24 hours"
            )
    return "\n".join(lines) + "\n"


def _distance(measure: Measure) -> str:
    if not all(map(len, measure.values)):
        return "no values on one side"
    if not measure.has_enough_values:
        return "too few values for a distance"
    return f"distance {measure.distance:.3f}"


def _short(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.4g}"


def data(one: HomeIntervals, two: HomeIntervals, found: list[Measure]) -> dict[str, Any]:
    """The comparison for programs; null where there are too few values. Figures a day of a log of
    less than one day are scaled up to it."""
    return {
        "logs": [one.name, two.name],
        "days": [home.length / DAY_S for home in (one, two)],
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
