# SPDX-License-Identifier: GPL-3.0-or-later
"""What days in the home are held to: no error, and the memory of one."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

# What real homes move, and a little around that.
LEAST_MOVING, MOST_MOVING = 0.03, 0.15
# MiB of a process at most: 700 MB, however many days and sensors.
MOST_MIB = 667.0
# Case, sensors, whether a glance has it.
CASES = (("7 PIRs, 7 switches and a pad", 15, True), ("and 7 light sensors", 22, False))
# Sensors of the studio but those for light.
STUDIO = 9


def check(data: dict[str, Any], bounds: Bounds) -> None:
    checked = data["checked"]
    bounds.equal("tracks as at every frame", checked["same"], checked["sensors"])
    count = len(checked["stretches"])
    bounds.at_least("stretches checked", count, 2 if data["quick"] else 6)
    bounds.equal("sensors checked", checked["sensors"], count * (CASES[0][1] + STUDIO) / 2)
    bounds.at_least("active readings in the stretch", checked["active"], 10)
    bounds.at_least("seconds checked", checked["seconds"], 300.0)
    bounds.at_least(
        "times faster than every frame", checked["plain_s"] / checked["skipping_s"], 0.1
    )
    cases = {row["name"]: row for row in data["cases"]}
    wanted = [case for case in CASES if case[2] or not data["quick"]]
    bounds.measured("cases", cases, [name for name, *_ in wanted])
    for name, sensors, _ in wanted:
        row = cases.get(name)
        if row is None:
            continue
        bounds.equal(f"sensors of '{name}'", row["sensors"], sensors)
        bounds.at_least(f"days of '{name}'", row["days"], 1)
        bounds.at_least(f"steps of '{name}'", row["steps"], 10 * row["seconds"] * row["days"])
        most = 0.9 if data["quick"] else MOST_MOVING
        bounds.at_least(f"least movement of a day of '{name}'", min(row["moving"]), LEAST_MOVING)
        bounds.at_most(f"most movement of a day of '{name}'", max(row["moving"]), most)
        bounds.equal(
            f"days of '{name}' with events", sum(n > 15 for n in row["events"]), row["days"]
        )
        bounds.equal(
            f"days of '{name}' that took time", sum(s > 0.0 for s in row["day_s"]), row["days"]
        )
        bounds.at_least(f"seconds of '{name}'", row["seconds"], 900.0)
        most = 1.3 * sum(row["moving"]) / len(row["moving"])
        share = row["evaluated"] / row["steps"]
        bounds.at_most(f"share evaluated of '{name}'", share, most)
        bounds.at_most(f"MiB with '{name}'", row["most_mib"], MOST_MIB)
