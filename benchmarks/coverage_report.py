# SPDX-License-Identifier: GPL-3.0-or-later
"""The coverage maps' section of the page, from data."""

from __future__ import annotations

from typing import Any

from .tables import columns, percent

TEXT = """\
## Coverage maps

The Ängen home, {detectors} detectors of 120 rays in nine tilts (saw-tooth, 10 Hz), cells of
{cell:g} m, each in the up to eight directions in which there is room. *Floor*: finding the cells;
*rays*: casting each detector's rays once; *bodies*: meeting them with what moves. A motion sets
off at the first tilt of the sweep; the last two columns tell by how much the covered share
changes where it sets off at {phases} other moments, and the largest share of cells that do.

{rows}
An arm in the living room by the size of the cells: the share covered, and the share of the
densest map's cells that lie in a cell which says otherwise.

{sizes}
The office of Ouadjaout et al. (2016): a desk of {points} points 0.3 m apart under {candidates}
candidates, which look down from a grid of 11 × 8 points. *Zones*: a point is covered where it lies
in a zone of the lens, as published; *arm*: where NEMA's arm is noticed over it.

{office}
Published: nearly 63 % by the best single detector, all by three. Not published: where the desk
stands, the heights, and the zones; ours are those of `EKMC1601111` ([coverage.md](coverage.md)).
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
