# SPDX-License-Identifier: GPL-3.0-or-later
"""What coverage maps are held to: dense maps, other moments of the sweep, and the published office.

The shares covered are those of the home as it is: who refurnishes it sets them anew.
"""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

DETECTORS = 7
# Measured: 99.0, 98.6, 69.6, 98.7 and 68.0 %.
COVERED = {
    "Step": (0.98, 1.0),
    "Chest": (0.975, 1.0),
    "Arm": (0.66, 0.73),
    "Crawling": (0.975, 1.0),
    "Cat": (0.65, 0.71),
}
IN_A_GLANCE = ("Step", "Arm")
# Share of cells that another moment of the sweep changes: 0.7 % for an arm.
PHASES = 0.015
# By the size of a cell in m: error of the share covered, share of dense cells that say otherwise.
# Measured against 0.0625 m: 0, 0.1 and 0.8 points, 11, 6 and 3 %; a glance has a coarser one.
SIZES = {0.5: (0.03, 0.15), 0.25: (0.015, 0.09), 0.125: (0.015, 0.06)}
# The office as published: nearly 63 % of the desk by one detector, all by three.
ONE, ONE_OFF = 0.63, 0.1


def check(data: dict[str, Any], bounds: Bounds) -> None:
    rows = {row["motion"]: row for row in data["rows"]}
    bounds.measured("motions", rows, IN_A_GLANCE if data["quick"] else COVERED)
    for name, row in rows.items():
        bounds.equal(f"{name}: detectors", row["detectors"], DETECTORS)
        bounds.within(f"{name}: share covered", row["covered"], *COVERED[name])
        bounds.at_most(f"{name}: cells that another moment changes", row["phases_differ"], PHASES)
    sizes = {row["size"]: row for row in data["sizes"]}
    bounds.measured("sizes of cells", sizes, SIZES)
    for size, (error, disagree) in SIZES.items():
        name = f"cells of {size:g} m"
        bounds.within(f"{name}: error of the share", sizes[size]["error"], -error, error)
        bounds.at_most(f"{name}: share that differs", sizes[size]["disagree"], disagree)
    # A cell takes a quarter of the area of the next larger one.
    for large, small in ((0.5, 0.25), (0.25, 0.125)):
        ratio = sizes[small]["cells"] / sizes[large]["cells"]
        bounds.within(f"cells of {small:g} m for one of {large:g} m", ratio, 3.5, 4.5)
    zones, arm = data["office"]["zones"], data["office"]["arm"]
    bounds.within("office, zones, one detector", zones[0]["share"], ONE - ONE_OFF, ONE + ONE_OFF)
    for what, found in (("zones", zones), ("an arm", arm)):
        bounds.equal(f"office, {what}, three detectors", found[2]["share"], 1.0)
        for row in found:
            name = f"office, {what}, {row['count']}: share above the bound"
            bounds.at_most(name, row["share"] - row["bound"], 1e-9)
