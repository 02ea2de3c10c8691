# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare simulated sensors with real ones, in situations that were measured.

People before a radar and a motion detector, infrared arrays, force resistors, and light. Each of
`SOURCES` is a pair of files. NAME.csv has the measured values with their tolerances, which were
chosen before anything was simulated, and NAME.py rebuilds the situations. docs/measured.md shows
both side by side.
"""

from __future__ import annotations

import csv
import math
from importlib import import_module
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parent
SOURCES = ("measured_people", "measured_thermal", "measured_force_light")


def measure(quick: bool) -> dict[str, Any]:
    """Return all rows, each with its measured and its simulated value.

    With `quick`, rows that a quick run leaves out are left out.
    """
    found = []
    for name in SOURCES:
        found += rows_of(name, import_module(f"{__package__}.{name}").simulate(quick))
    return {"rows": [row for row in found if not quick or row["simulated"] is not None]}


def rows_of(name: str, figures: dict[str, float]) -> list[dict[str, Any]]:
    """Return the rows of a source's table with the simulated figures.

    A row without a tolerance cannot be rebuilt: `low`, `high` and `simulated` are None.
    """
    rows = []
    with (FOLDER / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        for line in csv.DictReader(file):
            kind, _, group = line["group"].rpartition(": ")
            low, high = (float(line[key]) if line[key] else None for key in ("low", "high"))
            value = float(figures.get(line["id"], math.nan))
            within = low is not None and high is not None and low <= value <= high
            rows.append({
                "id": line["id"], "kind": kind or group, "group": group,
                "situation": line["situation"], "quantity": line["quantity"],
                "measured": float(line["measured"]),
                "simulated": value if math.isfinite(value) else None,
                "low": low, "high": high, "within": within,
                "why": line["why"], "source": line["source"],
            })  # fmt: skip
    return rows
