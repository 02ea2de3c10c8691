# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of a whole run: the Ängen home's story with its seven sensors, once a second of it.

Each run is a process of its own, in turns, by several seeds, and by the code of another checkout
beside, where one is given. Errors are against readings of far more light paths by other seeds.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = Path(__file__).with_name("light_story.py")
METHODS = ("FOUR_WALL", "ILLUMINANCE")
# Light paths of an update, and of the reference; the last is what the home has, and what the other
# checkout is measured by with half the reference, as it had.
WAYS = ((1024, 0), (256, 8_192), (256, 65_536), (256, 32_768))
BESIDE = (256, 16_384)
SEEDS, TRUE_SEEDS = 4, 4
# Frames from update to update, and of those that are compared.
STEP, COMPARED = 24, 288
# Of the home's own way, rms and median error; of a glance, whose other readings err too.
RMS, MEDIAN, QUICK_RMS = 0.025, 0.015, 0.08


def measure(paths: int, quick: bool, beside: Path | None = None) -> dict[str, Any]:
    """A row for each method and way; `paths`: of what they are compared with."""
    step, ways, seeds = (COMPARED, WAYS[-1:], 1) if quick else (STEP, WAYS, SEEDS)
    asked = [("this", ROOT, way) for way in ways]
    asked += [("beside", beside, BESIDE)] if beside else []
    rows = []
    for method in METHODS:
        true, noise = _true(method, paths)
        runs: dict[Any, list[dict[str, Any]]] = {}
        for seed in range(seeds):
            for code, root, way in asked:
                run = _story(root, method, *way, seed, step)
                runs.setdefault((code, way), []).append(run)
        rows += [_row(method, *key, found, true, noise) for key, found in runs.items()]
    updates = len(next(iter(runs.values()))[0]["frames"])
    told = {"updates": updates, "compared": len(true), "paths": paths, "seeds": seeds}
    return {"rows": rows, **told, "quick": quick}


def problems(data: dict[str, Any]) -> list[str]:
    """What of the home's own way is worse than it was found to be."""
    found = []
    for row in data["rows"]:
        told = f"light of a run, {row['method']}"
        own = row["code"] == "this" and (row["samples"], row["reference"]) == WAYS[-1]
        limit = QUICK_RMS if data["quick"] else RMS
        if own and row["rms"] > limit:
            found.append(f"{told}: rms error {row['rms']:.1%}, more than {limit:.1%}")
        if own and not data["quick"] and row["median"] > MEDIAN:
            found.append(f"{told}: median error {row['median']:.1%}, more than {MEDIAN:.1%}")
    return found


def _row(
    method: str,
    code: str,
    way: tuple[int, int],
    runs: list[dict[str, Any]],
    true: Any,
    noise: float,
) -> dict[str, Any]:
    error = np.array([_compared(run) for run in runs]) / true - 1.0
    updates, sensors = len(runs[0]["frames"]), true.shape[1]
    return {
        "method": method,
        "code": code,
        "samples": way[0],
        "reference": way[1],
        "ms_a_sensor": 1000.0 * min(run["wall_s"] for run in runs) / sensors / updates,
        "cpu_s": float(np.median([run["cpu_s"] for run in runs])),
        "to_bare": float(np.median([run["cpu_s"] / run["bare_s"] for run in runs])),
        "rms": float(np.sqrt(np.mean(error**2))),
        "median": float(np.median(np.abs(error))),
        "worst": float(np.abs(error).max()),
        "noise_rms": noise,
    }


def _true(method: str, paths: int) -> tuple[Any, float]:
    """Means over seeds (frames, sensors), and their relative noise, rms."""
    seeds = range(2000, 2000 + TRUE_SEEDS)
    found = np.array([_compared(_story(ROOT, method, paths, 0, s, COMPARED)) for s in seeds])
    mean = np.maximum(found.mean(axis=0), 1e-9)
    spread = found.std(axis=0, ddof=1) / np.sqrt(TRUE_SEEDS) / mean
    return mean, float(np.sqrt(np.mean(spread**2)))


def _compared(run: dict[str, Any]) -> Any:
    """Values (frames, sensors) of the updates that are compared."""
    pairs = zip(run["frames"], run["values"], strict=True)
    return np.array([values for frame, values in pairs if (frame - 1) % COMPARED == 0])


def _story(
    root: Path, method: str, samples: int, reference: int, seed: int, step: int
) -> dict[str, Any]:
    numbers = [str(number) for number in (samples, reference, seed, step)]
    command = [sys.executable, str(SCRIPT), str(root), method, *numbers]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip() or done.stdout[-500:]}")
    found: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return found
