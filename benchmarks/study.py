# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure studies: their cost beside the simulations, the gain by workers, and memory.

They are short runs of one detector of the sample `light_control.blend`, by `angen study run` and
its worker processes on this machine, which this program watches.
"""

from __future__ import annotations

import csv
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import psutil

from .common import MIB, ROOT, SAMPLES, progress

# Frames of a run: about 0.05 s of simulation, and 0.3 s.
LENGTHS = (96, 576)
# Frames of the home's story that the runs share, and the hold times of its detectors.
STORY, SETTINGS = 480, 6
# Seconds between two looks at the processes.
LOOK_S = 0.05


def measure(quick: bool) -> dict[str, Any]:
    runs, rows = (40, 400) if quick else (200, 10_000)
    with tempfile.TemporaryDirectory() as folder:
        place, lengths = Path(folder), []
        for frames in LENGTHS:
            ways = []
            for jobs in (1, 2):
                progress("study", len(lengths), 4, f"{frames} frames, {jobs} workers")
                ways.append(_by_workers(place, jobs, runs, frames))
            one, two = (way.pop("table") for way in ways)
            same = sum(a == b for a, b in zip(one, two, strict=True))
            lengths.append({"frames": frames, "ways": ways, "same_rows": same})
        progress("study", 2, 4, "living the home together")
        together = _together(place)
        progress("study", 3, 4, f"{rows} rows")
        return {
            "runs": runs,
            "lengths": lengths,
            "together": together,
            "driver": _driver(place, rows),
        }


def _study(place: Path, name: str, home: str, frames: int, text: str) -> Path:
    path = place / f"{name}.toml"
    path.write_text(f'home = "{(SAMPLES / home).as_posix()}"\nframes = [1, {frames}]\n{text}')
    return path


def _rays(place: Path, runs: int, frames: int) -> Path:
    text = f'seeds = {runs // 20}\ntogether = false\n[set]\nsensors = "PIR room"\n'
    text += '"PIR room.noise_sigma" = 0.01\n'
    text += '[vary]\n"PIR room.rays" = { from = 10, to = 29, steps = 20, whole = true }\n'
    return _study(place, f"rays {runs} {frames}", "light_control.blend", frames, text)


def _watched(study: Path, out: Path, jobs: int) -> dict[str, Any]:
    """Run a study and watch its processes.

    Returns the seconds until its runs begin (`start_s`) and those that the runs take (`wall_s`),
    the MiB of the driver at each look and at the end, the peak MiB of a worker, and the CPU seconds
    of the workers during the runs.
    """
    command = [sys.executable, "-m", "angen_addon", "study", "run", str(study), "--out", str(out)]
    runs, told = out / "runs.jsonl", out.with_suffix(".txt")
    begin = start = end = 0.0
    seen, worker_mib, now, first_cpu, cpu = [], 0.0, 0.0, 0.0, 0.0
    with open(told, "w", encoding="utf-8") as errors:
        begin = time.perf_counter()
        driver = psutil.Popen([*command, "--jobs", str(jobs)], cwd=ROOT, stderr=errors)
        while driver.poll() is None:
            time.sleep(LOOK_S)
            try:
                workers = driver.children(recursive=True)
                # A worker that has ended took no less than at the look before.
                now = max(now, sum(sum(worker.cpu_times()[:2]) for worker in workers))
                most = max((worker.memory_info().rss for worker in workers), default=0) / MIB
                mib = driver.memory_info().rss / MIB
            except psutil.Error:
                continue
            if not start and told.stat().st_size:
                start, first_cpu = time.perf_counter(), now
            if start and runs.exists() and runs.stat().st_mtime_ns != end:
                # The study still adds rows.
                end, last, cpu = runs.stat().st_mtime_ns, time.perf_counter(), now - first_cpu
                seen.append(mib)
            worker_mib = max(worker_mib, most)
    if driver.returncode:
        raise RuntimeError(f"{study.name} failed: {told.read_text()[-2000:]}")
    times = {"start_s": start - begin, "wall_s": last - start, "cpu_s": cpu}
    return {**times, "seen_mib": seen, "end_mib": mib, "worker_mib": worker_mib}


def _rows(out: Path) -> list[dict[str, str]]:
    with open(out / "results.csv", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _lines(out: Path) -> int:
    return (out / "runs.jsonl").read_bytes().count(b"\n")


def _by_workers(place: Path, jobs: int, runs: int, frames: int) -> dict[str, Any]:
    """Return the cost of all runs by `jobs` workers, and of the same command on finished runs."""
    study, out = _rays(place, runs, frames), place / f"jobs{jobs}-{frames}"
    found = _watched(study, out, jobs)
    kept = _lines(out)
    subprocess.run(
        [sys.executable, "-m", "angen_addon", "study", "run", str(study), "--out", str(out)],
        cwd=ROOT,
        check=True,
        capture_output=True,
    )
    rows = _rows(out)
    simulating_s = sum(float(row.pop("seconds")) for row in rows)
    return {
        "frames": frames, "jobs": jobs, "start_s": found["start_s"], "wall_s": found["wall_s"],
        "simulating_s": simulating_s, "overhead_s": (found["wall_s"] * jobs - simulating_s) / runs,
        "worker_mib": found["worker_mib"], "failed": sum(bool(row["error"]) for row in rows),
        "rows": len(rows), "run_again": _lines(out) - kept, "table": rows,
    }  # fmt: skip


def _together(place: Path) -> dict[str, Any]:
    """Return a worker's CPU seconds for many hold times of the Ängen home's detectors.

    Once it evaluates the home for each hold time, once for all together.
    """
    found = []
    for together in ("false", "true"):
        text = f'together = {together}\n[set]\nsensors = "PIR*"\n[vary]\n'
        text += f'"PIR*.hold_time" = {{ from = 0, to = 10, steps = {SETTINGS} }}\n'
        study = _study(place, f"together {together}", "angen.blend", STORY, text)
        out = place / f"together-{together}"
        cpu_s = _watched(study, out, 1)["cpu_s"]
        found.append((cpu_s, [row | {"seconds": ""} for row in _rows(out)]))
    (alone_s, alone), (once_s, once) = found
    same = sum(a == b for a, b in zip(alone, once, strict=True))
    return {"runs": SETTINGS, "alone_s": alone_s, "once_s": once_s, "same": same}


def _driver(place: Path, runs: int) -> dict[str, Any]:
    """Return the driver's memory over many rows, each of a run of one frame."""
    out = place / "driver"
    found = _watched(_rays(place, runs, 1), out, 2)
    rows, seen = _rows(out), found["seen_mib"]
    return {
        "rows": runs,
        "written": len(rows),
        "failed": sum(bool(row["error"]) for row in rows),
        "wall_s": found["wall_s"],
        # Of the second half, because the first loads modules.
        "grown_mib": seen[-1] - seen[len(seen) // 2],
        "tables_mib": found["end_mib"] - seen[-1],
        "mib": seen[-1],
    }
