# SPDX-License-Identifier: GPL-3.0-or-later
"""What live readings are held to: those of a run."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

CASES = {"7 PIRs": 7, "7 PIRs and 7 switches": 14, "and the pad": 15}


def check(data: dict[str, Any], bounds: Bounds) -> None:
    rows = {row["name"]: row for row in data["cases"]}
    bounds.measured("cases", rows, CASES)
    for name, sensors in CASES.items():
        row = rows.get(name)
        if row is None:
            continue
        bounds.equal(f"sensors of '{name}'", row["sensors"], sensors)
        bounds.at_least(f"rounds of '{name}'", row["cost_ms"]["runs"], 2)
        bounds.at_least(f"readings of '{name}'", row["read"], 1000)
        bounds.at_least(f"active ones of '{name}'", row["active"], 10)
        bounds.equal(f"readings as a run's of '{name}'", row["same"], row["read"])
