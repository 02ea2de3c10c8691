# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: the section of the page, from data."""

from __future__ import annotations

from typing import Any

from .study_bounds import STORY
from .tables import columns, short

TEXT = """\
## Studies

{runs} runs of one detector, by worker processes of this machine. *Overhead*: what a run takes
beside its simulation, with handing it out and keeping its row; *start*: of the workers, Blender in
them, and the home's first opening.

{ways}
{faster} Over {rows} rows, of runs of one frame, the driver's memory grows by {grown} MiB in
the second half, and has {mib} MiB in the end; writing the tables of all of them adds {tables} MiB.

{settings} hold times of the seven detectors of the Ängen home, over {story} frames of its story: a
worker that simulates the home for each of them takes {share} times the CPU of one that does it once
for all ({alone} and {once} s), with the same rows.
"""


def section(data: dict[str, Any]) -> str:
    driver = data["driver"]
    return TEXT.format(
        runs=data["runs"],
        ways=columns(
            [way for length in data["lengths"] for way in length["ways"]],
            "frames of a run=frames",
            "workers=jobs",
            "start s=start_s:.1f",
            "wall s=wall_s:.1f",
            "simulating s=simulating_s:.1f",
            "overhead a run s=overhead_s:.3f",
            "memory of a worker MiB=worker_mib:.0f",
        ),
        faster=" ".join(_faster(length, data["runs"]) for length in data["lengths"]),
        rows=f"{driver['rows']:,}",
        grown=f"{driver['grown_mib']:.1f}",
        mib=f"{driver['mib']:.0f}",
        settings=data["together"]["runs"],
        story=STORY,
        share=short(data["together"]["alone_s"] / data["together"]["once_s"], 2),
        alone=short(data["together"]["alone_s"], 2),
        once=short(data["together"]["once_s"], 2),
        tables=f"{max(driver['tables_mib'], 0.0):.1f}",
    )


def _faster(length: dict[str, Any], runs: int) -> str:
    one, two = (way["wall_s"] for way in length["ways"])
    return (
        f"Of runs of {length['frames']} frames two workers do {short(one / two, 2)} times as many "
        f"a second as one; {length['same_rows']} of {runs} rows are the same to the byte, but for "
        "the seconds."
    )
