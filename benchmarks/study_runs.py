# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: what a run costs beside its simulation, how many workers help, who needs what memory.

Short runs of one detector of the sample `light_control.blend`, by Dask's processes of this machine.
A program of its own: it must be one that has no Blender in it.
"""

from __future__ import annotations

import csv
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import psutil

from angen_addon.process.standalone import load_extension

load_extension()
from angen_sensors.studies import engine, results  # noqa: E402
from angen_sensors.studies.engine import Driver  # noqa: E402
from angen_sensors.studies.study import read  # noqa: E402

from .study_bounds import LONG, SHORT, STORY  # noqa: E402

HOME = Path(__file__).resolve().parent.parent / "sample_blends" / "light_control.blend"
MIB = 2**20
ANGEN = HOME.with_name("angen.blend")
# The driver's memory is looked at so many times.
LOOKS = 20


def measure(quick: bool) -> dict[str, Any]:
    runs = 40 if quick else 200
    rows = 400 if quick else 10_000
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for frames in (SHORT, LONG):
            ways = [_way(Path(folder), jobs, runs, frames) for jobs in (1, 2)]
            one, two = (way.pop("table") for way in ways)
            found.append(
                {
                    "frames": frames,
                    "ways": ways,
                    "same_rows": sum(a == b for a, b in zip(one, two, strict=True)),
                }
            )
        return {
            "runs": runs,
            "lengths": found,
            "together": _together(Path(folder), 6),
            "driver": _driver(Path(folder), rows),
        }


def _study(folder: Path, runs: int, frames: int) -> Path:
    path = folder / "study.toml"
    path.write_text(
        f'home = "{HOME.as_posix()}"\nframes = [1, {frames}]\nseeds = {runs // 20}\n'
        "together = false\n"
        '[set]\nsensors = "PIR room"\n"PIR room.noise_sigma" = 0.01\n'
        '[vary]\n"PIR room.rays" = { from = 10, to = 29, steps = 20, whole = true }\n'
    )
    return path


def _way(folder: Path, jobs: int, runs: int, frames: int) -> dict[str, Any]:
    """All runs by this many workers, some before them apart, in which each opens the home."""
    out = folder / f"jobs{jobs}-{frames}"
    begin = time.perf_counter()
    with results.Store(out) as store, engine.here(jobs) as client:
        Driver(read(_study(folder, 20, 1)), store, client).run(lambda *_: None)
        start_s = time.perf_counter() - begin
        driver = Driver(read(_study(folder, runs, frames)), store, client)
        begin, own = time.perf_counter(), time.process_time()
        driver.run(lambda *_: None)
        wall_s, driver_s = time.perf_counter() - begin, time.process_time() - own
        kept = _lines(out)
        driver.run(lambda *_: None)
        again = _lines(out) - kept
        driver.write_tables()
        told = client.run(_memory_mib)
    with open(out / results.CSV, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    simulating_s = sum(float(row.pop("seconds")) for row in rows)
    return {
        "frames": frames,
        "jobs": jobs,
        "start_s": start_s,
        "wall_s": wall_s,
        "driver_ms": 1000 * driver_s / runs,
        "simulating_s": simulating_s,
        "overhead_s": (wall_s * jobs - simulating_s) / runs,
        "worker_mib": max(told.values()),
        "failed": sum(bool(row["error"]) for row in rows),
        "rows": len(rows),
        "run_again": again,
        "table": rows,
    }


def _together(folder: Path, settings: int) -> dict[str, Any]:
    """So many hold times of the Ängen home's detectors: CPU of a worker that lives the home for
    each of them, and of one that lives it once."""
    path, found = folder / "together.toml", {}
    for together in ("false", "true"):
        path.write_text(
            f'home = "{ANGEN.as_posix()}"\nframes = [1, {STORY}]\ntogether = {together}\n'
            f'[set]\nsensors = "PIR*"\n[vary]\n'
            f'"PIR*.hold_time" = {{ from = 0, to = 10, steps = {settings} }}\n'
        )
        out = folder / f"together-{together}"
        with results.Store(out) as store, engine.here(1) as client:
            driver = Driver(read(path), store, client)
            begin = _cpu_s(client)
            driver.run(lambda *_: None)
            cpu_s = _cpu_s(client) - begin
            driver.write_tables()
        with open(out / results.CSV, encoding="utf-8", newline="") as file:
            rows = [row | {"seconds": ""} for row in csv.DictReader(file)]
        found[together] = cpu_s, rows
    (alone_s, alone), (once_s, once) = found["false"], found["true"]
    same = sum(a == b for a, b in zip(alone, once, strict=True))
    return {"runs": settings, "alone_s": alone_s, "once_s": once_s, "same": same}


def _cpu_s(client: Any) -> float:
    """Of all workers until now."""
    return sum(client.run(time.process_time).values())


def _lines(folder: Path) -> int:
    return (folder / results.RUNS).read_bytes().count(b"\n")


def _memory_mib() -> float:
    """The most that this process ever had."""
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _driver(folder: Path, runs: int) -> dict[str, Any]:
    """The driver's memory over many rows, of runs of a single frame."""
    process, seen = psutil.Process(), []

    def look(done: int, total: int, failed: int) -> None:
        if done % (total // LOOKS) == 0:
            seen.append(process.memory_info().rss / MIB)

    with results.Store(folder / "driver") as store, engine.here(2) as client:
        driver = Driver(read(_study(folder, runs, 1)), store, client)
        begin = time.perf_counter()
        driver.run(look)
        wall_s = time.perf_counter() - begin
        driver.write_tables()
        written = process.memory_info().rss / MIB
        failed = len(store.failed)
    return {
        "rows": runs,
        "written": (folder / "driver" / results.CSV).read_bytes().count(b"\n") - 1,
        "failed": failed,
        "wall_s": wall_s,
        # Of the second half: the first has what is loaded once.
        "grown_mib": seen[-1] - seen[len(seen) // 2],
        "tables_mib": written - seen[-1],
        "mib": seen[-1],
    }


if __name__ == "__main__":
    json.dump(measure(sys.argv[1] == "quick"), sys.stdout)
