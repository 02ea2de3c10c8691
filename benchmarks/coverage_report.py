# SPDX-License-Identifier: GPL-3.0-or-later
"""The coverage maps' section of the page, from data."""

from __future__ import annotations

from typing import Any

from .tables import columns, percent

TEXT = """\
## Coverage maps

The Ängen home, {detectors} detectors of 120 rays in nine tilts (saw-tooth, 10 Hz), cells of
{cell:g} m, each with up to eight possible directions. *Floor*: finding the cells; *rays*: casting
each detector's rays once; *bodies*: intersecting them with the moving bodies. A motion starts at
the first tilt of the sweep; the last two columns show the covered share for {phases} other starts,
and the largest share of cells that change.

{rows}
An arm in the living room by the size of the cells: the share covered, and the share of the densest
map's cells that differ from the cell that they lie in.

{sizes}
The office of Ouadjaout et al. (2016): a desk of {points} points 0.3 m apart under {candidates}
candidates that face down at a grid of 11 × 8 points. *Zones*: a point is covered if it lies in a
zone of the lens, as in the publication; *arm*: if NEMA's arm above it is detected.

{office}
Published: nearly 63 % by the best single detector, all by three. Not published: the position of the
desk, the heights, and the zones; ours are those of `EKMC1601111` ([coverage.md](coverage.md)).
"""
PUBLISHED = {1: "63 %", 3: "100 %"}


def section(data: dict[str, Any]) -> str:
    office = data["office"]
    rows = [
        {**row, "phases": f"{percent(row['phases_low'])} to {percent(row['phases_high'])}"}
        for row in data["rows"]
    ]
    sizes = [
        {**row, "off": f"{100 * row['error']:+.1f} points".replace("-", "−")}
        for row in data["sizes"]
    ]
    offices = [
        {**zones, "published": PUBLISHED.get(zones["count"], ""), "arm": arm["share"]}
        for zones, arm in zip(office["zones"], office["arm"], strict=True)
    ]
    return TEXT.format(
        detectors=data["rows"][0]["detectors"],
        cell=data["cell"],
        phases=5,
        rows=columns(
            rows,
            "motion",
            "cells",
            "motions",
            "floor s=floor_s:spread",
            "rays s=cast_s:spread",
            "bodies s=meet_s:spread",
            "all s=total_s:spread",
            "µs a cell and detector=us_a_cell_and_detector:.0f",
            "covered=covered:percent",
            "other phases=phases",
            "cells that change=phases_differ:percent",
        ),
        sizes=columns(
            sizes,
            "cell=size:g m",
            "cells",
            "bodies=seconds:.2f s",
            "covered=covered:percent",
            "error of the share=off",
            "cells that differ=disagree:percent",
        ),
        points=office["desk_points"],
        candidates=office["candidates"],
        office=columns(
            offices,
            "detectors=count",
            "zones=share:percent",
            "bound=bound:percent",
            "published",
            "arm=arm:percent",
        ),
    )
