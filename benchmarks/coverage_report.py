# SPDX-License-Identifier: GPL-3.0-or-later
"""The coverage maps' section of the page, from data."""

from __future__ import annotations

from typing import Any

from .tables import median, percent, spread, table

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
    return TEXT.format(
        detectors=data["rows"][0]["detectors"],
        cell=data["cell"],
        phases=5,
        rows=table(
            ("motion", "cells", "motions", "floor s", "rays s", "bodies s", "all s",
             "µs a cell and detector", "covered", "other phases", "cells that change"),
            (
                (
                    row["motion"], f"{row['cells']}", f"{row['motions']}",
                    *(spread(row[key]) for key in ("floor_s", "cast_s", "meet_s", "total_s")),
                    f"{row['us_a_cell_and_detector']:.0f}",
                    percent(row["covered"]),
                    f"{percent(row['phases_low'])} to {percent(row['phases_high'])}",
                    percent(row["phases_differ"]),
                )
                for row in data["rows"]
            ),
        ),
        sizes=table(
            ("cell", "cells", "bodies", "covered", "error of the share", "cells that differ"),
            (
                (
                    f"{row['size']:g} m", f"{row['cells']}", f"{row['seconds']:.2f} s",
                    percent(row["covered"]),
                    f"{100 * row['error']:+.1f} points".replace("-", "−"),
                    percent(row["disagree"]),
                )
                for row in data["sizes"]
            ),
        ),
        points=office["desk_points"],
        candidates=office["candidates"],
        office=table(
            ("detectors", "zones", "bound", "published", "arm"),
            (
                (
                    f"{zones['count']}", percent(zones["share"]), percent(zones["bound"]),
                    PUBLISHED.get(zones["count"], ""), percent(arm["share"]),
                )
                for zones, arm in zip(office["zones"], office["arm"], strict=True)
            ),
        ),
    )  # fmt: skip


def headline(data: dict[str, Any]) -> list[str]:
    step = data["rows"][0]
    return [
        f"A coverage map of the home's {step['detectors']} detectors, {step['cells']} cells of "
        f"{data['cell']:g} m in up to eight directions: {median(step['total_s']):.1f} s."
    ]
