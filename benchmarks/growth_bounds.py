# SPDX-License-Identifier: GPL-3.0-or-later
"""Growth is times and memory, which have no bounds here; only that all of it was measured."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

SWEEPS = ("objects", "triangles", "sensors", "frames")
FIGURES = ("sensing_ms", "evaluation_ms", "start_ms", "scene_mib", "run_mib")
# Readings a second of the home's 22 sensors at the thesis's rates.
READINGS = 85


def check(data: dict[str, Any], bounds: Bounds) -> None:
    bounds.measured("sweeps", data["sweeps"], SWEEPS)
    for name in SWEEPS:
        rows = data["sweeps"][name]
        bounds.at_least(f"sizes of {name}", len(rows), 2)
        for row in rows:
            bounds.measured(f"figures of {row['size']} {name}", row, FIGURES)
            bounds.at_least(f"first second with {row['size']} {name}, ms", _median(row), 1e-3)
    recording = data["recording"]
    bounds.equal("readings of the recording", recording["rows"], READINGS * recording["seconds"])
    bounds.at_least("its event log, MiB", recording["events_mib"], 1e-3)
    bounds.at_least("its file, MiB", recording["file_mib"], 1e-3)


def _median(row: dict[str, Any]) -> Any:
    return row["start_ms"]["median"]
