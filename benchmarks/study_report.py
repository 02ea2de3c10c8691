# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: the section of the page, from data."""

from __future__ import annotations

from typing import Any

from .study_bounds import STORY
from .tables import columns, short

TEXT = """\
## Studies

{runs} runs of {frames} frames of one detector, by worker processes of this machine. *Overhead*:
what a run takes beside its simulation, with handing it out and keeping its row; *start*: of the
workers, Blender in them, and the home's first opening.

{ways}
Two workers are {faster} times as fast as one; {same} of {runs} rows are the same to the byte, but
for the seconds. Over {rows} rows, of runs of one frame, the driver's memory grows by {grown} MiB in
the second half, and has {mib} MiB in the end; writing the tables of all of them adds {tables} MiB.

{settings} hold times of the seven detectors of the Ängen home, over {story} frames of its story: a
worker that simulates the home for each of them takes {share} times the CPU of one that does it once
for all ({alone} and {once} s), with the same rows.
"""


def section(data: dict[str, Any]) -> str:
    one, two = data["ways"]
    driver = data["driver"]
    return TEXT.format(
        runs=data["runs"],
        frames=data["frames"],
        ways=columns(
            data["ways"],
            "workers=jobs",
            "start s=start_s:.1f",
            "wall s=wall_s:.1f",
            "simulating s=simulating_s:.1f",
            "overhead a run s=overhead_s:.3f",
            "memory of a worker MiB=worker_mib:.0f",
        ),
        faster=short(one["wall_s"] / two["wall_s"], 2),
        same=data["same_rows"],
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
