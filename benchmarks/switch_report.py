# SPDX-License-Identifier: GPL-3.0-or-later
"""The optical switch's section of the page and its plot, from data."""

from __future__ import annotations

from typing import Any

from .plot import BLACK, BLUE, GREEN, ORANGE, PURPLE, Panel, Series, figure
from .tables import percent, spread, table

COLOURS = (BLUE, ORANGE, GREEN, PURPLE)
TEXT = """\
## The optical switch

**One ray or an aperture of several.** A slit of {aperture:g} mm; the worst error of the light
that passes a straight edge, against its bound 1/(2k); how often the output changes in {looks}
looks while the edge shakes by ± {shaking:g} mm about the middle; the time of an update of the
model, rays left out.

{apertures}
**Fast flags.** A flag of width w at speed v, seen at {fps} frames a second and a number of
substeps: the share of crossings at which the beam was looked at while the flag was in it, and
min(1, w·fps·substeps/v). There is no swept test: what no look falls on is not seen, so *Substeps*
is the setting for fast things, and costs its number times the frames.

![Share of crossings seen over the substeps](pictures/bench_switch.svg)

{flags}"""


def section(data: dict[str, Any]) -> str:
    return TEXT.format(
        aperture=data["aperture_m"] * 1e3,
        looks=data["looks"],
        shaking=data["shaking_m"] * 1e3,
        fps=24,
        apertures=table(
            ("rays", "worst error", "bound", "changes", "µs"),
            (
                (
                    f"{row['rays']}",
                    f"{row['worst_error']:.3f}",
                    f"{row['bound']:.3f}",
                    f"{row['changes']}",
                    spread(row["us"]),
                )
                for row in data["aperture"]
            ),
        ),
        flags=table(
            ("flag", "substeps", "seen", "exact", "ms a step and 100 switches"),
            (
                (
                    row["name"],
                    f"{row['substeps']}",
                    f"{percent(row['seen'])} of {row['switches']}",
                    percent(row["exact"]),
                    f"{row['ms_a_step'] / row['switches'] * 100:.1f}",
                )
                for row in data["flags"]
            ),
        ),
    )


def figures(data: dict[str, Any]) -> dict[str, str]:
    series = []
    for name, colour in zip(
        dict.fromkeys(row["name"] for row in data["flags"]), COLOURS, strict=True
    ):
        rows = [row for row in data["flags"] if row["name"] == name]
        substeps = [row["substeps"] for row in rows]
        exact = [100 * row["exact"] for row in rows]
        series.append(Series(name.partition(",")[0], substeps, exact, colour))
        series.append(Series("", substeps, [100 * row["seen"] for row in rows], BLACK, "dots"))
    panel = Panel("crossings seen, %", series, 260, legend="lines: exact; dots: measured")
    return {
        "bench_switch.svg": figure(
            "Flags seen at 24 frames a second", "substeps", [panel], log_x=True
        )
    }
