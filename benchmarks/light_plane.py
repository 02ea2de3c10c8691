# SPDX-License-Identifier: GPL-3.0-or-later
"""Cost and reading against the far clip plane: the Ängen home's seven sensors, four walls each.

From row to row nothing but the plane changes. All planes take turns, so that a busy moment of the
machine meets each of them.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.scene.light import probe
from angen_sensors.angen_addon.scene.light.cycles import CyclesLight
from angen_sensors.angen_addon.scene.light.probe import LightRequest
from mathutils import Vector

from .common import open_home, spread
from .light_speed import FRAME, number

# Metres; the thesis's sensor has 5.
PLANES = (1.0, 2.0, 5.0, 10.0)
# Light paths of an update that is timed (the default), and of the readings in the table.
TIMED, EXACT = 1024, 65_536
ROUNDS = 15


def measure(quick: bool) -> dict[str, Any]:
    """A row for each plane."""
    scene = open_home()
    scene.frame_set(FRAME)
    rows = [_reading(plane, TIMED if quick else EXACT) for plane in PLANES]
    for row, times in zip(rows, _times(2 if quick else ROUNDS), strict=True):
        row["ms_a_sensor"] = spread(times)
    return {"rows": rows, "samples": TIMED, "exact": TIMED if quick else EXACT}


def _requests(plane: float, samples: int) -> list[LightRequest]:
    own = sorted(
        (o for o in bpy.context.scene.objects if o.angen_sensor.kind == "LIGHT"),
        key=lambda o: o.name,
    )
    return [
        LightRequest(o.name, np.array(o.matrix_world, np.float64), samples=samples, clip_end=plane)
        for o in own
    ]


def _measured(requests: Sequence[LightRequest], kept: CyclesLight | None = None) -> Any:
    return probe.measure(bpy.context.scene, bpy.context.view_layer, requests, kept=kept)


def _reading(plane: float, samples: int) -> dict[str, Any]:
    requests = _requests(plane, samples)
    found = _measured(requests)
    return {
        "far_m": plane,
        "views": 4 * len(requests),
        "ended": sum(_ends(request, way) for request in requests for way in _ways(request)),
        "percent": {request.name: number(found[request.name]) for request in requests},
    }


def _ways(request: LightRequest) -> list[Any]:
    """Unit vectors (3,) along the middles of its views: −Z, −X, +Z, +X."""
    x, z = request.matrix[:3, 0], request.matrix[:3, 2]
    return [-z, -x, z, x]


def _ends(request: LightRequest, way: Any) -> bool:
    """Whether something stands between both clip planes, by Blender's own ray."""
    start = Vector(request.matrix[:3, 3] + request.clip_start * way)
    reach = request.clip_end - request.clip_start
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return bool(bpy.context.scene.ray_cast(depsgraph, start, Vector(way), distance=reach)[0])


def _times(rounds: int) -> list[list[float]]:
    """Milliseconds a sensor of further updates, as in a run, for each plane."""
    scene = bpy.context.scene
    asked = [_requests(plane, TIMED) for plane in PLANES]
    kept = [CyclesLight() for _ in PLANES]
    taken: list[list[float]] = [[] for _ in PLANES]
    for turn in range(rounds + 1):
        scene.frame_set(FRAME + turn)
        for requests, scenes, times in zip(asked, kept, taken, strict=True):
            start = time.perf_counter()
            _measured(requests, scenes)
            # The first update makes what the further ones keep.
            if turn:
                times.append((time.perf_counter() - start) * 1000.0 / len(requests))
    for scenes in kept:
        scenes.close()
    return taken
