# SPDX-License-Identifier: GPL-3.0-or-later
"""The optical switch's section of the page and its plot, from data."""

from __future__ import annotations

from typing import Any

from .plot import BLACK, BLUE, GREEN, ORANGE, PURPLE, Panel, Series, figure
from .tables import columns, percent, spread, table

COLOURS = (BLUE, ORANGE, GREEN, PURPLE)
TEXT = """\
## The optical switch

**One ray or an aperture of k rays.** A slit of {aperture:g} mm: the worst error of the light that
passes a straight edge, and its bound 1/(2k); the number of output changes in {looks} updates while
the edge shakes by ± {shaking:g} mm about the middle; the time of a model update without its rays.

{apertures}
**Fast flags.** A flag of width w at speed v crosses a beam, at {fps} frames a second
and a number of substeps: the share of crossings with an update while the flag was in the beam, and
the exact value min(1, w·fps·substeps/v). *Substeps* multiply the number of frames; *time* is
relative to a run without them. *Swept* switches use whole frames and the flag's path between them
([switch.md](switch.md)): they must detect every crossing, at the right update (*wrong* counts the
others). Here one flag crosses {switches} beams within a few of 25 steps; where nothing moves near a
beam, only bounds are compared.

![Share of crossings seen over the substeps](pictures/bench_switch.svg)

{flags}
{swept}"""


def section(data: dict[str, Any]) -> str:
    whole_frames = {row["name"]: row for row in data["flags"] if row["substeps"] == 1}
    return TEXT.format(
        aperture=data["aperture_m"] * 1e3,
        looks=data["looks"],
        shaking=data["shaking_m"] * 1e3,
        fps=24,
        switches=data["swept"][0]["switches"],
        apertures=columns(
            data["aperture"],
            "rays",
            "worst error=worst_error:.3f",
            "bound=bound:.3f",
            "changes",
            "µs=us:spread",
        ),
        flags=table(
            ("flag", "substeps", "seen", "exact", "ms a step and 100 switches", "time of a run"),
            (
                (
                    row["name"],
                    f"{row['substeps']}",
                    f"{percent(row['seen'])} of {row['switches']}",
                    percent(row["exact"]),
                    f"{row['ms_a_step'] / row['switches'] * 100:.1f}",
                    f"× {_run_time(row) / _run_time(whole_frames[row['name']]):.1f}",
                )
                for row in data["flags"]
            ),
        ),
        swept=table(
            ("flag, swept", "seen", "wrong", "time of a run"),
            (
                (
                    row["name"],
                    f"{percent(row['seen'])} of {row['switches']}",
                    f"{row['wrong']}",
                    f"× {spread(row['cost'])}",
                )
                for row in data["swept"]
            ),
        ),
    )


def _run_time(row: dict[str, Any]) -> float:
    """Milliseconds."""
    return float(row["ms_a_step"] * row["steps"])


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
    panel = Panel("crossings seen, %", series, 260, legend="lines: exact\ndots: measured")
    return {
        "bench_switch.svg": figure(
            "Flags seen at 24 frames a second", "substeps", [panel], log_x=True
        )
    }
