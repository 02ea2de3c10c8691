# SPDX-License-Identifier: GPL-3.0-or-later
"""What coverage maps of the Ängen home cost, and how far coarse cells and other phases of the
sweep are from a dense map; and the office of the literature."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.coverage.floor import cells_of
from angen_sensors.angen_addon.coverage.maps import at_once, detectors, view_of
from angen_sensors.angen_addon.scene.home import EvaluatedHome
from angen_sensors.angen_addon.scene.sensors import all_sensors
from angen_sensors.sensor_logic.coverage.detect import RangeView
from angen_sensors.sensor_logic.coverage.grid import Cells, CoverageMap
from angen_sensors.sensor_logic.coverage.motions import MOTIONS

from . import office
from .common import open_home, spread
from .progress import progress

SIZE = 0.25
SIZES = (0.5, 0.25, 0.125)
REFERENCE = 0.0625
PHASES = 6


def measure(quick: bool) -> dict[str, Any]:
    open_home()
    sensors = all_sensors(bpy.context.view_layer)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    names = ("STEP", "ARM") if quick else tuple(MOTIONS)
    return {
        "rows": [_row(depsgraph, sensors, name, 1 if quick else 3) for name in names],
        "sizes": _sizes(depsgraph, sensors, quick),
        "office": office.measure(),
        "cell": SIZE,
    }


def _row(depsgraph: Any, sensors: Any, name: str, rounds: int) -> dict[str, Any]:
    """Time of each stage, and what changes where the motion sets off at other times."""
    progress("coverage", list(MOTIONS).index(name), len(MOTIONS), name)
    motion = MOTIONS[name]
    taken = []
    for _ in range(rounds):
        begin = time.perf_counter()
        home, cells = _floor(depsgraph, sensors, name, SIZE)
        floor = time.perf_counter()
        views = {s.name: view_of(home, s) for s in detectors(sensors)}
        cast = time.perf_counter()
        found = at_once(views, cells, motion)
        done = time.perf_counter()
        taken.append((floor - begin, cast - floor, done - cast, done - begin))
    floors, casts, meets, totals = (spread(times) for times in zip(*taken, strict=True))
    motions = int((cells.lengths > 0.0).sum())
    covered = found.count > 0
    others = [
        at_once({n: _later(view, phase / PHASES) for n, view in views.items()}, cells, motion)
        for phase in range(1, PHASES)
    ]
    differ = [float(((other.count > 0) != covered).mean()) for other in others]
    return {
        "motion": motion.label,
        "cells": len(cells),
        "motions": motions,
        "detectors": len(views),
        "floor_s": floors,
        "cast_s": casts,
        "meet_s": meets,
        "total_s": totals,
        "us_a_cell_and_detector": meets["median"] / (len(cells) * len(views)) * 1e6,
        "covered": float(covered.mean()),
        "phases_differ": max(differ),
        "phases_low": min(float((other.count > 0).mean()) for other in [found, *others]),
        "phases_high": max(float((other.count > 0).mean()) for other in [found, *others]),
    }


def _later(view: Any, share: float) -> Any:
    """The same detector when the motion sets off at another moment of its sweep."""
    assert isinstance(view, RangeView)
    return replace(view, offsets=(view.offsets + share * view.period) % view.period)


def _floor(depsgraph: Any, sensors: Any, name: str, size: float) -> tuple[EvaluatedHome, Cells]:
    home = EvaluatedHome(depsgraph)
    *_, cells = cells_of(home, sensors, MOTIONS[name], size)
    assert isinstance(cells, Cells)
    return home, cells


def _sizes(depsgraph: Any, sensors: Any, quick: bool) -> list[dict[str, Any]]:
    """Maps of an arm in the living room by the size of the cells, against dense ones."""
    room, reference = "living room", SIZES[-1] if quick else REFERENCE
    maps = {}
    for size in dict.fromkeys((*SIZES, reference)):
        progress("coverage", len(maps), len(SIZES) + 1, f"cells of {size:g} m")
        home, cells = _floor(depsgraph, sensors, "ARM", size)
        inside = cells.of([room])
        views = {s.name: view_of(home, s) for s in detectors(sensors)}
        begin = time.perf_counter()
        maps[size] = (at_once(views, inside, MOTIONS["ARM"]), time.perf_counter() - begin)
    dense = maps[reference][0]
    return [
        {
            "size": size,
            "cells": len(found.cells),
            "seconds": seconds,
            "covered": found.total().share,
            "error": found.total().share - dense.total().share,
            "disagree": _disagreement(found, dense),
        }
        for size, (found, seconds) in maps.items()
    ]


def _disagreement(coarse: CoverageMap, dense: CoverageMap) -> float:
    """Share of the dense cells that lie in a coarse one which says otherwise."""
    size = coarse.cells.size
    said = {
        tuple(key): bool(count)
        for key, count in zip(
            np.floor(coarse.cells.at[:, :2] / size).astype(int).tolist(),
            coarse.count.tolist(),
            strict=True,
        )
    }
    keys = np.floor(dense.cells.at[:, :2] / size).astype(int).tolist()
    pairs = [
        (said[tuple(key)], bool(count))
        for key, count in zip(keys, dense.count.tolist(), strict=True)
        if tuple(key) in said
    ]
    return float(np.mean([a != b for a, b in pairs]))
