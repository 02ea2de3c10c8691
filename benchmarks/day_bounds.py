# SPDX-License-Identifier: GPL-3.0-or-later
"""What a day in the home is held to."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

# Case, sensors, readings a second of all of them together, whether a glance has it.
CASES = (
    ("7 PIRs and 7 switches", 14, 77, True),
    ("and a pad", 15, 78, False),
    ("and 7 light sensors", 22, 85, False),
)
# The story takes 172 s of 1728.
FRESH = 0.0994
# MiB that a run may add to what Blender has with the file, and that a reading may take: the columns
# of it that repeat take none.
RUN_MIB, READING_BYTES = 150.0, 6.0


def check(data: dict[str, Any], bounds: Bounds) -> None:
    told = -(-data["seconds"] // data["every_s"])
    forms = {row["form"]: row for row in data["forms"]}
    bounds.measured("forms of the day", forms, ("keys", "strips"))
    for name, row in forms.items():
        bounds.equal(f"spans of movement, as {name}", row["spans"], told)
        bounds.within(f"share of frames with movement, as {name}", row["fresh"], 0.99 * FRESH, 0.11)
    checked = data["checked"]
    bounds.equal("sensors checked", checked["sensors"], CASES[0][1])
    bounds.equal("tracks as without skipping", checked["same"], checked["sensors"])
    bounds.equal("share evaluated without skipping", checked["plain_share"], 1.0)
    cases = {row["name"]: row for row in data["cases"]}
    bounds.measured(
        "cases", cases, [name for name, *_, glance in CASES if glance or not data["quick"]]
    )
    for name, sensors, rate, _ in CASES:
        if name not in cases:
            continue
        row = cases[name]
        due = rate * data["seconds"]
        bounds.equal(f"sensors of '{name}'", row["sensors"], sensors)
        bounds.within(f"readings of '{name}'", row["readings"], due, due + sensors)
        bounds.at_least(f"active readings of '{name}'", row["active"], 0.004 * row["readings"])
        bounds.at_most(f"share evaluated of '{name}'", row["evaluated"] / row["steps"], 0.11)
        size = row["tracks_mib"] * 2**20 / row["readings"]
        bounds.at_most(f"bytes a reading of '{name}'", size, READING_BYTES)
        grown = row["most_mib"] - row["before_mib"]
        bounds.at_most(f"MiB that '{name}' adds", grown, RUN_MIB)
