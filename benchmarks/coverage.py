# SPDX-License-Identifier: GPL-3.0-or-later
"""Coverage maps of the Ängen home, and the office of the literature.

For the home: what maps cost, and how far coarse cells and other phases of the sweep are from a
dense map.

The office is that of Ouadjaout, Lasla, Djenouri and Zizoua, "On the Effect of Sensing-holes in
PIR-based Occupancy Detection Systems" (SENSORNETS 2016): how many detectors does a desk need? They
published: 3.3 × 2.4 m, points 0.3 m apart (11 × 8), Panasonic EKMB detectors. A point is covered if
it lies in a detection zone. The best single detector covers nearly 63 % of the desk, three
detectors cover all of it. They did not publish, and we chose, the desk's place and size, the
heights, the places for detectors, and the zones themselves.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.coverage.floor_cells import cells_of
from angen_sensors.angen_addon.coverage.maps import Views, detectors, whole_map
from angen_sensors.angen_addon.scene.home.evaluated_home import EvaluatedHome
from angen_sensors.sensor_logic.coverage.grid import Cells, CoverageMap, choose
from angen_sensors.sensor_logic.coverage.motions import (
    DIRECTIONS,
    HEADINGS,
    MOTIONS,
    Start,
    Walker,
)
from angen_sensors.sensor_logic.kinds.pir.coverage import RangeView, WarmView
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import (
    rays_of,
    response_of,
    threshold_of,
    zones_of,
)
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters
from angen_sensors.sensor_logic.logs.wording import ZERO_CELSIUS
from angen_sensors.sensor_logic.physics import STEFAN_BOLTZMANN
from angen_sensors.sensor_logic.progress import finished

from .common import open_home, progress, sensors_of, spread

Array = np.typing.NDArray[np.float64]
SIZE = 0.25
SIZES = (0.5, 0.25, 0.125)
REFERENCE = 0.0625
PHASES = 6
STEP, POINTS = 0.3, (11, 8)
CEILING, DESK_TOP, OVER_DESK = 2.7, 0.75, 0.15
# The desk's points: 1.8 × 0.9 m against the middle of a long wall.
DESK = (slice(3, 9), slice(0, 3))
# Detectors hang at all points of the grid, look down, and are turned by multiples of 15°.
ROLLS = tuple(math.radians(a) for a in range(0, 90, 15))
LENS = PirParameters(model="PYROELECTRIC", lens="EKMC1601111", range_max=5.0)
AMBIENT = 20.0 + ZERO_CELSIUS


def measure(quick: bool) -> dict[str, Any]:
    open_home()
    names = ("STEP", "ARM") if quick else tuple(MOTIONS)
    return {
        "rows": [_row(name, 1 if quick else 3) for name in names],
        "sizes": _sizes(quick),
        # Share of the desk by number of detectors: by zones, as published, and by an arm.
        "office": {
            "zones": _shares(_in_zones),
            "arm": _shares(_by_an_arm),
            "desk_points": len(_points(0.0)[DESK].reshape(-1, 3)),
            "candidates": POINTS[0] * POINTS[1] * len(ROLLS),
        },
        "cell": SIZE,
    }


def _row(name: str, rounds: int) -> dict[str, Any]:
    """Return the seconds of each stage, and how much the start of the motion changes the map."""
    progress("coverage", list(MOTIONS).index(name), len(MOTIONS), name)
    motion, taken = MOTIONS[name], []
    for _ in range(rounds):
        begin = time.perf_counter()
        home, cells = _floor(name, SIZE)
        floor = time.perf_counter()
        views = _views(home)
        cast = time.perf_counter()
        found = whole_map(views, cells, motion)
        done = time.perf_counter()
        taken.append((floor - begin, cast - floor, done - cast, done - begin))
    stages = ("floor_s", "cast_s", "meet_s", "total_s")
    spans = {n: spread(times) for n, times in zip(stages, zip(*taken, strict=True), strict=True)}
    covered = found.count > 0
    others = [
        whole_map({n: _later(view, phase / PHASES) for n, view in views.items()}, cells, motion)
        for phase in range(1, PHASES)
    ]
    shares = [float((other.count > 0).mean()) for other in (found, *others)]
    each = spans["meet_s"]["median"] / (len(cells) * len(views))
    return {
        "motion": motion.label, "cells": len(cells), "motions": int((cells.lengths > 0.0).sum()),
        "detectors": len(views), **spans, "us_a_cell_and_detector": each * 1e6,
        "covered": shares[0],
        "phases_differ": max(float(((o.count > 0) != covered).mean()) for o in others),
        "phases_low": min(shares), "phases_high": max(shares),
    }  # fmt: skip


def _later(view: Any, share: float) -> Any:
    """Return the detector with the phase of its sweep shifted by a share of its period."""
    assert isinstance(view, RangeView)
    return replace(view, offsets=(view.offsets + share * view.period) % view.period)


def _floor(name: str, size: float) -> tuple[EvaluatedHome, Cells]:
    home = EvaluatedHome(bpy.context.evaluated_depsgraph_get())
    return home, finished(cells_of(home, sensors_of(), MOTIONS[name], size))


def _views(home: EvaluatedHome) -> dict[str, Any]:
    views = Views(home)
    return {sensor.name: views.of(sensor) for sensor in detectors(sensors_of())}


def _sizes(quick: bool) -> list[dict[str, Any]]:
    """Compare maps of an arm in the living room, by the size of their cells, with a dense map."""
    reference = SIZES[-1] if quick else REFERENCE
    maps = {}
    for size in dict.fromkeys((*SIZES, reference)):
        progress("coverage", len(maps), len(SIZES) + 1, f"cells of {size:g} m")
        home, cells = _floor("ARM", size)
        inside, views = cells.of(["living room"]), _views(home)
        begin = time.perf_counter()
        maps[size] = (whole_map(views, inside, MOTIONS["ARM"]), time.perf_counter() - begin)
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
    """Return the share of dense cells whose coarse cell has another value."""

    def keys(found: CoverageMap) -> list[tuple[int, int]]:
        places = np.floor(found.cells.at[:, :2] / coarse.cells.size).astype(int)
        return [(x, y) for x, y in places.tolist()]

    said = {k: bool(count) for k, count in zip(keys(coarse), coarse.count.tolist(), strict=True)}
    pairs = [
        (said[key], bool(count))
        for key, count in zip(keys(dense), dense.count.tolist(), strict=True)
        if key in said
    ]
    return float(np.mean([a != b for a, b in pairs]))


def _points(height: float) -> Array:
    x, y = np.meshgrid(*((np.arange(n) + 0.5) * STEP for n in POINTS), indexing="ij")
    return np.stack([x, y, np.full(x.shape, height)], axis=-1)


def _shares(covers: Callable[[Array, Array], Array]) -> list[dict[str, float]]:
    """Return the share of the desk that the best 1, 2 and 3 detectors cover, with its bound."""
    desk = _points(0.0)[DESK].reshape(-1, 3)
    sets, found = [], []
    for place in _points(CEILING).reshape(-1, 3):
        for roll in ROLLS:
            top = np.array([math.cos(roll), math.sin(roll), 0.0])
            up = np.array([0.0, 0.0, 1.0])
            sets.append(covers(np.column_stack([np.cross(top, up), top, up]), desk - place))
    for count in (1, 2, 3):
        choice = choose(np.array(sets), count)
        share, bound = (number / len(desk) for number in (choice.covered, choice.bound))
        found.append({"count": count, "share": share, "bound": bound})
    return found


def _in_zones(axes: Array, towards: Array) -> Array:
    """Return whether points of the desk's top, relative to the detector, lie in a zone."""
    local = (towards + np.array([0.0, 0.0, DESK_TOP])) @ axes
    inside = np.zeros(len(local), bool)
    for zone in zones_of(LENS):
        up = np.cross(zone.right, zone.axis)
        depth = local @ zone.axis
        across, along = np.abs(local @ zone.right), np.abs(local @ up)
        inside |= (
            (depth > 0.0)
            & (across <= depth * math.tan(zone.width / 2))
            & (along <= depth * math.tan(zone.height / 2))
        )
    return inside


def _by_an_arm(axes: Array, towards: Array) -> Array:
    """Return whether the detector notices an arm over each point from half of its bearings.

    The arm turns by 90°.
    """
    local = rays_of(LENS)
    directions, walker = local.directions @ axes.T, Walker()
    warm = (walker.celsius + ZERO_CELSIUS) ** 4 - AMBIENT**4
    view = WarmView(
        np.zeros(3),
        directions,
        local.weights,
        np.full(len(directions), 50.0),
        np.zeros(len(directions)),
        STEFAN_BOLTZMANN * walker.emissivity * warm,
        0.05,
        response_of(LENS),
        threshold_of(LENS),
        0.1,
    )
    arm, count = MOTIONS["ARM"].at_height(DESK_TOP + OVER_DESK), len(towards)
    places, headings = np.repeat(towards, DIRECTIONS, axis=0), np.tile(HEADINGS, count)
    start = Start(places, headings, np.full(count * DIRECTIONS, arm.step))
    noticed = view.strengths(arm, start).reshape(count, DIRECTIONS) > 1.0
    return np.asarray(noticed.mean(axis=1) >= 0.5)
