# SPDX-License-Identifier: GPL-3.0-or-later
"""The thesis's own figures: the section of the page and its plots, from data."""

from __future__ import annotations

from typing import Any

from .plot import BLACK, BLUE, ORANGE, Panel, Series, bars, figure
from .tables import columns, short, table

# The thesis's figures 8.1 and 8.3, read off: speed of the home with PIRs alone and with all.
THESIS_FIRST, THESIS_LAST = 70, 10

TEXT = """\
## The thesis's own figures

{seconds:.0f} s of the story of the Ängen home, simulated by the operator *Simulate*, with Blender's
evaluation of every frame. *Speed* is simulated time over real time. Rates are the thesis's: PIRs
10 Hz with 120 rays, one tilt per update; switches, pads and light 1 Hz.

**The whole home** (the thesis's figure 8.3, where Gazebo fell from {first} to {last} times real
time)

{cases}
*Bare frames*: Blender evaluates the frames of the updates, without the extension's handlers; the
ratio is of the quickest run to the quickest of as many tries. *Command line*: `angen simulate` from
its start to the written log, with Blender's start and the file's opening.

Seconds by part, one run each with a stopwatch that itself costs some percent. *Evaluation of the
scene* is Blender's; sensors can only reduce it by using fewer frames; with light it includes the
frames that Blender evaluates again for a render. *Alone*: the same frames without sensing.

![Where the time of a run goes](pictures/bench_home.svg)

{parts}
**The rays of a fan** (figure 8.1: 160 rays ten times as fast as 640, 90 % kept). A fan of
{dense} rays detected movement at {motion} of {updates} updates. *Kept*: the share of these at which
this fan detected it at the same tilt; *extra*: the share of this fan's detections without one of
the dense fan.

![Speed and what is kept, over the number of rays](pictures/bench_rays.svg)

{rays}
**The number of detectors** (figure 8.2), 120 rays each:

![Speed over the number of detectors](pictures/bench_pirs.svg)

{counts}
**The far plane of a light sensor** (the bathroom's, four walls). The cost of a path tracer depends
on its paths, not on their length; the thesis's rasteriser draws everything nearer than the plane. A
view with nothing nearer shows the bright sky. All seven sensors:
[light_benchmarks.md](light_benchmarks.md).

{far}"""


def section(data: dict[str, Any]) -> str:
    dense = data["rays"][-1]
    return TEXT.format(
        seconds=data["seconds"],
        first=THESIS_FIRST,
        last=THESIS_LAST,
        motion=dense["updates_with_motion"],
        updates=dense["updates"],
        dense=dense["rays"],
        cases=columns(
            [row | {"times_bare": _times_bare(row)} for row in data["cases"]],
            "sensors=name",
            "count=sensors",
            "updates",
            "real time s=wall_s:spread",
            "speed=speed:spread",
            "bare frames s=evaluation_alone_s:.2f",
            "times bare=times_bare:.2f",
            "command line s=command_line_s:spread",
        ),
        parts=table(
            ("seconds", *data["cases"][0]["parts_s"], "alone"),
            (
                (
                    row["name"],
                    *(f"{value:.2f}" for value in row["parts_s"].values()),
                    f"{row['evaluation_alone_s']:.2f}",
                )
                for row in data["cases"]
            ),
        ),
        rays=columns(
            data["rays"], "rays", "speed=speed:spread", "kept=kept:percent", "extra=extra:percent"
        ),
        counts=columns(data["counts"], "PIRs=pirs", "speed=speed:spread"),
        far=columns(
            data["far"],
            "far plane m=far_m:g",
            "ms an update=ms:spread",
            "luminance (median)=percent:.2f %",
        ),
    )


def _times_bare(row: dict[str, Any]) -> float:
    return float(row["wall_s"]["low"] / row["evaluation_alone_s"])


def ratios(data: dict[str, Any]) -> list[tuple[str, str, str]]:
    return [
        (
            f"*Simulate* of the home with {row['sensors']} sensors",
            "bare evaluation of its frames",
            f"{short(_times_bare(row), 2)} times its time",
        )
        for row in data["cases"]
    ]


def figures(data: dict[str, Any]) -> dict[str, str]:
    rays = [row["rays"] for row in data["rays"]]
    counts = [row["pirs"] for row in data["counts"]]
    return {
        "bench_home.svg": bars(
            f"Where {data['seconds']:.0f} s of the Ängen home go",
            "seconds of real time",
            [
                (row["name"], row["parts_s"], f"{short(row['speed']['median'])} ×")
                for row in data["cases"]
            ],
        ),
        "bench_rays.svg": figure(
            "Speed and accuracy over the rays of a fan, seven detectors",
            "rays",
            [
                Panel("times real time", _ranged(rays, data["rays"], "seven PIRs"), 200, log=True),
                Panel(
                    "updates kept, %",
                    [Series("kept", rays, [100 * row["kept"] for row in data["rays"]], BLUE)],
                    160,
                ),
            ],
            log_x=True,
        ),
        "bench_pirs.svg": figure(
            "Speed over the number of motion detectors, 120 rays each",
            "motion detectors",
            [Panel("times real time", _ranged(counts, data["counts"], "home"), 220, log=True)],
            log_x=True,
        ),
    }


def _ranged(x: list[int], rows: list[dict[str, Any]], label: str) -> list[Series]:
    """The median as a line, the least and the greatest as dots."""
    found = [Series(label, x, [row["speed"]["median"] for row in rows], ORANGE)]
    if rows[0]["speed"]["runs"] > 1:
        for bound in ("low", "high"):
            found.append(Series("", x, [row["speed"][bound] for row in rows], BLACK, "dots"))
    return found
