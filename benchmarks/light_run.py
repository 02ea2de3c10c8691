# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of a whole run: the Ängen home's story with its seven sensors.

Errors are told at moments that are drawn from the story, by several seeds, against far more light
paths by other seeds, without any reference. These err too: their own noise is told, and taken out
of the rms. Seconds are those of the story once a second of it, after one another with the code of
another checkout, where one is given.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from .progress import progress

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = Path(__file__).with_name("light_story.py")
METHODS = ("FOUR_WALL", "ILLUMINANCE")
# Light paths of an update, and of the reference; the last is what the home has, and what the other
# checkout is measured by is what it had.
WAYS = ((1024, 0), (64, 16_384), (128, 32_768), (256, 32_768))
BESIDE = (256, 16_384)
SEEDS, TRUE_SEEDS = 4, 4
# The story has so many frames, of which one in each second is timed, and these are compared.
FRAMES, STEP, MOMENTS = 4120, 24, 12
# Of the home's own way: rms and median error, and processor time beside former code.
RMS, MEDIAN, TO_BESIDE = 0.025, 0.015, 0.6
# Of a glance.
QUICK_RMS = 0.08


def moments(count: int) -> list[int]:
    """Frames, one from each of as many parts of the story."""
    edges = np.linspace(1, FRAMES + 1, count + 1).astype(int).tolist()
    drawn = np.random.default_rng(1)
    return [int(drawn.integers(*part)) for part in pairwise(edges)]


def measure(paths: int, quick: bool, beside: Path | None = None) -> dict[str, Any]:
    """A row for each method and way; `paths`: of what they are compared with."""
    ways, seeds = (WAYS[-1:], 1) if quick else (WAYS, SEEDS)
    asked = [("this", ROOT, way) for way in ways]
    asked += [("beside", beside, BESIDE)] if beside else []
    at = moments(2 if quick else MOMENTS)
    timed = at if quick else list(range(1, FRAMES + 1, STEP))
    rows = []
    for method in METHODS:
        true, noise = _true(method, paths, at)
        for code, root, way in asked:
            progress("light of a run", len(rows), len(METHODS) * len(asked), f"{method} {code}")
            found = np.array([r["values"] for r in _story(root, method, *way, range(seeds), at)])
            told = {"method": method, "code": code, "samples": way[0], "reference": way[1]}
            rows.append(told | _errors(found / true - 1.0, noise))
        for row, (_, root, way) in zip(rows[-len(asked) :], asked, strict=True):
            (run,) = _story(root, method, *way, range(1), timed)
            row |= _cost(run, true.shape[1] * len(timed))
    told = {"updates": len(timed), "moments": len(at), "paths": paths, "seeds": seeds}
    return {"rows": rows, **told, "true_seeds": TRUE_SEEDS, "quick": quick}


def problems(data: dict[str, Any]) -> list[str]:
    """What of the home's own way is worse than it was found to be."""
    limits = {"rms": QUICK_RMS} if data["quick"] else {"rms": RMS, "median": MEDIAN}
    return list(_problems(data["rows"], limits))


def _problems(rows: list[dict[str, Any]], limits: dict[str, float]) -> Iterator[str]:
    beside = {row["method"]: row["cpu_s"] for row in rows if row["code"] == "beside"}
    for row in rows:
        if row["code"] == "beside" or (row["samples"], row["reference"]) != WAYS[-1]:
            continue
        told = f"light of a run, {row['method']}"
        for name, limit in limits.items():
            if not row[name] <= limit:
                yield f"{told}: {name} error {row[name]:.2%}, more than {limit:.1%}"
        share = row["cpu_s"] / beside.get(row["method"], np.inf)
        if share > TO_BESIDE:
            yield f"{told}: {share:.2f} of the processor time beside, more than {TO_BESIDE}"


def _errors(error: Any, noise: Any) -> dict[str, float]:
    """Of relative errors (seeds, moments, sensors) against what itself errs by `noise` (moments,
    sensors): that is taken out of the rms, whose standard error is that over seeds; what the rms
    is of each sensor tells where it comes from."""
    of_seeds = np.mean(error**2, axis=(1, 2)) - np.mean(noise**2)
    square, count = max(float(of_seeds.mean()), 0.0), len(of_seeds)
    spread = float(of_seeds.std(ddof=1)) / np.sqrt(count) if count > 1 else float("nan")
    sensors = np.mean(error**2, axis=(0, 1)) - np.mean(noise**2, axis=0)
    return {
        "rms": float(np.sqrt(square)),
        "rms_error": spread / (2.0 * np.sqrt(square)) if square else float("nan"),
        "median": float(np.median(np.abs(error))),
        "worst": float(np.abs(error).max()),
        "noise_rms": float(np.sqrt(np.mean(noise**2))),
        "rms_of_sensors": np.sqrt(np.maximum(sensors, 0.0)).tolist(),
    }


def _cost(run: dict[str, Any], readings: int) -> dict[str, float]:
    return {
        "ms_a_sensor": 1000.0 * run["wall_s"] / readings,
        "cpu_s": run["cpu_s"],
        "to_bare": run["cpu_s"] / run["bare_s"],
    }


def _true(method: str, paths: int, at: list[int]) -> tuple[Any, Any]:
    """Means over seeds (moments, sensors), and their relative standard errors."""
    seeds = range(2000, 2000 + TRUE_SEEDS)
    found = np.array([run["values"] for run in _story(ROOT, method, paths, 0, seeds, at)])
    mean = np.maximum(found.mean(axis=0), 1e-9)
    return mean, found.std(axis=0, ddof=1) / np.sqrt(TRUE_SEEDS) / mean


def _story(
    root: Path | None, method: str, samples: int, reference: int, seeds: range, frames: list[int]
) -> list[dict[str, Any]]:
    """What `light_story.py` tells for each seed."""
    job = {"root": str(root), "method": method, "samples": samples, "reference": reference}
    text = json.dumps({**job, "seeds": list(seeds), "frames": frames})
    done = subprocess.run(
        [sys.executable, str(SCRIPT), text], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{text}: {done.stderr.strip() or done.stdout[-500:]}")
    found: list[dict[str, Any]] = json.loads(done.stdout.strip().splitlines()[-1])
    return found
