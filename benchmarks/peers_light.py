# SPDX-License-Identifier: GPL-3.0-or-later
"""The home's seven light sensors by this program and by Radiance's `rtrace`: seconds for one
reading of all of them, with everything that must be done anew when something has moved.

The home is that of `light_radiance.py`, diffuse and grey, at one moment by its lamps. Each engine's
errors are against what it says itself with many more rays.
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from . import light_radiance
from .common import open_home, spread
from .peers_report import LIGHT_OURS, RADIANCE
from .progress import progress

# Rms error at which both are compared.
SAME = 0.03
# Faces with less are not counted, W/m².
LEAST = 0.01
# Cycles's paths, and Radiance's ambient divisions; the last are what errors are against.
RAYS = {LIGHT_OURS: (32, 128, 512, 2048, 8192), RADIANCE: (16, 64, 256, 1024)}
EXACT = {LIGHT_OURS: 65_536, RADIANCE: 4_096}


def measure(rounds: int, quick: bool) -> dict[str, Any]:
    scene = open_home()
    scene.frame_set(light_radiance.FRAME)
    light_radiance.simplify("lamp")
    light_radiance.set_reflecting(True)
    faces = [face for face in light_radiance.faces() if face.name.endswith("down")]
    with tempfile.TemporaryDirectory() as folder:
        text = light_radiance.exported(Path(folder), True)

        def theirs(divisions: int) -> list[float]:
            octree = light_radiance.compiled(text)
            return light_radiance.traced(octree, faces, light_radiance.BOUNCES, divisions)

        engines: dict[str, Callable[[int], list[float]]] = {
            LIGHT_OURS: lambda samples: light_radiance.rendered(faces, samples),
            RADIANCE: theirs,
        }
        compile_s, _ = _timed(lambda: light_radiance.compiled(text))
        true = {
            name: np.array(work(EXACT[name] // (8 if quick else 1)))
            for name, work in engines.items()
        }
        lit = np.minimum(*true.values()) > LEAST
        ways = [
            (n, count)
            for n in engines
            for count in RAYS[n][: -1 if quick and n == LIGHT_OURS else None]
        ]
        runs: dict[tuple[str, int], list[tuple[float, Any]]] = {way: [] for way in ways}
        for turn in range(rounds):
            for name, count in ways:
                progress("peers", turn, rounds, f"{name}, {count}")
                runs[name, count].append(_timed(lambda w=engines[name], c=count: w(c)))
    rows = [
        {
            "engine": name,
            "rays": count,
            "seconds": spread([seconds for seconds, _ in found]),
            "rms": _rms([np.array(values)[lit] / true[name][lit] - 1.0 for _, values in found]),
        }
        for (name, count), found in runs.items()
    ]
    apart = true[LIGHT_OURS][lit] / true[RADIANCE][lit] - 1.0
    return {
        "rows": rows,
        "faces": int(lit.sum()),
        "apart_rms": _rms(apart),
        "compile_s": compile_s,
        "same": SAME,
        "seconds": {n: _seconds_at(SAME, [r for r in rows if r["engine"] == n]) for n in engines},
    }


def _rms(errors: Any) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    begin = time.perf_counter()
    found = work()
    return time.perf_counter() - begin, found


def _seconds_at(error: float, rows: list[dict[str, Any]]) -> float:
    """Seconds for an rms error, between the rows that were measured by powers."""
    known = sorted((-math.log(row["rms"]), math.log(row["seconds"]["median"])) for row in rows)
    return math.exp(np.interp(-math.log(error), *zip(*known, strict=True)))
