# SPDX-License-Identifier: GPL-3.0-or-later
"""What studies are held to."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

# MiB of a worker; of the driver in all, what it may grow by over the second half of its rows, and
# what writing the tables may take.
WORKER_MIB, DRIVER_MIB, GROWN_MIB, TABLES_MIB = 500.0, 250.0, 8.0, 40.0
# s that a run takes beside its simulation.
OVERHEAD_S = 0.2
# Frames of a run: some 0.05 s of simulation, and 0.3 s.
SHORT, LONG = 96, 576
ROWS, GLANCE_ROWS = 10_000, 400
# Frames of the home's story that runs live together; by how much less CPU at least.
STORY, SHARE = 480, 1.5


def check(data: dict[str, Any], bounds: Bounds) -> None:
    lengths = {length["frames"]: length for length in data["lengths"]}
    bounds.measured("frames of runs", lengths, (SHORT, LONG))
    for length in lengths.values():
        ways = {way["jobs"]: way for way in length["ways"]}
        runs = f"of {length['frames']} frames"
        bounds.measured(f"workers of runs {runs}", ways, (1, 2))
        same = f"rows {runs} that are the same with one and two workers"
        bounds.equal(same, length["same_rows"], data["runs"])
        for jobs, way in ways.items():
            of = f"{runs} with {jobs} worker{'s' if jobs > 1 else ''}"
            bounds.equal(f"rows {of}", way["rows"], data["runs"])
            bounds.equal(f"runs {of} that failed", way["failed"], 0)
            bounds.equal(f"runs {of} done again", way["run_again"], 0)
            bounds.at_most(f"overhead of a run {of}, s", way["overhead_s"], OVERHEAD_S)
            bounds.at_most(f"MiB of a worker {of}", way["worker_mib"], WORKER_MIB)
    together = data["together"]
    bounds.equal("rows that are the same together", together["same"], together["runs"])
    share = together["alone_s"] / together["once_s"]
    bounds.at_least("CPU of runs alone, together = 1", share, SHARE)
    driver = data["driver"]
    bounds.equal("rows of the driver", driver["rows"], GLANCE_ROWS if data["quick"] else ROWS)
    bounds.equal("rows written", driver["written"], driver["rows"])
    bounds.equal("runs of the driver that failed", driver["failed"], 0)
    bounds.at_most("MiB of the driver", driver["mib"], DRIVER_MIB)
    bounds.at_most("MiB that the driver grows by", driver["grown_mib"], GROWN_MIB)
    bounds.at_most("MiB that the tables take", driver["tables_mib"], TABLES_MIB)
