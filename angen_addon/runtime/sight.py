# SPDX-License-Identifier: GPL-3.0-or-later
"""The rays of one sensor, as its own model asks for them."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...sensor_logic.kind import RAYS
from ...sensor_logic.model import Array, Pose
from ..scene.sensors import unit_scale
from .sensor_runner import SensorRunner


@dataclass(frozen=True)
class SensorRays:
    """Rays in the world, in Blender units: `origins` (n, 3), unit `directions` (n, 3), `reach`
    (n,). `rows`: how many equal rows they stand in, for a motion detector its tilts; `apart`: each
    stands for itself, they span no fan."""

    origins: Array
    directions: Array
    reach: Array
    rows: int = 1
    apart: bool = False


NO_RAYS = SensorRays(np.empty((0, 3)), np.empty((0, 3)), np.empty(0))


@dataclass(frozen=True)
class Sight:
    """What one sensor looks with. `request`: what a light sensor asks of the scene."""

    parameters: Any
    pose: Pose
    rays: SensorRays
    request: Any = None


class _Enough(Exception):
    """Raised as soon as a model has named its rays."""


def sight_of(runner: SensorRunner, depsgraph: Any) -> Sight | None:
    """What the sensor looks with at the depsgraph's frame: all rays that its model ever casts with
    these parameters, a row for each bundle; none of a model that casts none. None while it is
    switched off. Raises AngenError.

    They are those that the model asks for first, update after update until they repeat.
    """
    runner.reset()
    taken = runner.take(0, 0, depsgraph, None)
    if taken is None:
        return None
    parameters, pose = taken.parameters, taken.update.pose
    if not runner.sensor.kind.requires(RAYS, parameters):
        return Sight(parameters, pose, NO_RAYS, taken.request)
    metres = unit_scale(depsgraph.scene)
    bundles: dict[int, tuple[Array, Array, Array]] = {}

    def note(bundle: int, origins: Array, directions: Array, length: Array) -> Array:
        bundles[bundle] = origins / metres, np.array(directions), length / metres
        raise _Enough

    known = -1
    while len(bundles) > known:
        known = len(bundles)
        update = replace(taken.update, number=known, scene={RAYS: note})
        with suppress(_Enough):
            runner.model.update(parameters, update)
    origins, directions, reach = (
        np.concatenate(part) for part in zip(*bundles.values(), strict=True)
    )
    rays = SensorRays(origins, directions, reach, len(bundles))
    return Sight(parameters, pose, rays, taken.request)
