# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers of all benchmarks: the machine's name, spreads of repeated runs, the sample home."""

from __future__ import annotations

import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np

HOME = Path(__file__).resolve().parent.parent / "sample_blends" / "angen.blend"
CPU_INFO = Path("/proc/cpuinfo")


def machine() -> str:
    """The processor, the cores that this process may use, and the versions of Blender and numpy."""
    return (
        f"{_processor()}, {_cores()} cores, {platform.system()}, Blender "
        f"{bpy.app.version_string}, Python {platform.python_version()}, numpy {np.__version__}"
    )


def _processor() -> str:
    if CPU_INFO.exists():
        for line in CPU_INFO.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def spread(values: Sequence[float]) -> dict[str, float]:
    """Median, least and greatest of repeated runs."""
    return {
        "median": statistics.median(values),
        "low": min(values),
        "high": max(values),
        "runs": len(values),
    }


def timed(work: Callable[[], Any], runs: int) -> dict[str, float]:
    """Seconds of `work`, repeated."""
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return spread(seconds)


def open_home() -> Any:
    """The scene of the Ängen home as saved, with live readings off."""
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    return scene
