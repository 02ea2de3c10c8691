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
    (n,). `rows`: how many equal rows they stand in, for a motion detector its tilts; `bundles`: how
    many equal parts of them are cast apart; `apart`: each stands for itself, they span no fan."""

    origins: Array
    directions: Array
    reach: Array
    rows: int = 1
    bundles: int = 1
    apart: bool = False

    def same(self, other: SensorRays | None) -> bool:
        return (
            other is not None
            and (self.rows, self.bundles) == (other.rows, other.bundles)
            and np.array_equal(self.origins, other.origins)
            and np.array_equal(self.directions, other.directions)
            and np.array_equal(self.reach, other.reach)
        )

    def bundle(self, number: int) -> slice:
        """Which of the rays are those of a bundle."""
        size = len(self.reach) // self.bundles
        return slice(number * size, (number + 1) * size)

    def box(self) -> tuple[Array, Array]:
        """Bounds (3,), (3,) of all that they could reach; of no rays: nowhere."""
        both = np.concatenate([self.origins, self.origins + self.directions * self.reach[:, None]])
        return both.min(axis=0, initial=np.inf), both.max(axis=0, initial=-np.inf)


# With these all rays are asked for at once.
EVERYTHING = {"sweep": "ALL"}
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
    these parameters; none of a model that casts none. None while it is switched off. Raises
    SensorError.

    They are those that the model asks for first; of a detector all tilts at once, which are those
    that its saw-tooth takes in turn.
    """
    runner.reset()
    taken = runner.take(0, 0, depsgraph, None)
    if taken is None:
        return None
    parameters, pose = taken.parameters, taken.update.pose
    if not runner.sensor.kind.requires(RAYS, parameters):
        return Sight(parameters, pose, NO_RAYS, taken.request)
    rows = getattr(parameters, "tilt_count", 1)
    every = {name: value for name, value in EVERYTHING.items() if hasattr(parameters, name)}
    metres, asked = unit_scale(depsgraph.scene), []

    def note(bundle: int, origins: Array, directions: Array, length: Array) -> Array:
        asked.append(SensorRays(origins / metres, np.array(directions), length / metres))
        raise _Enough

    with suppress(_Enough):
        runner.model.update(replace(parameters, **every), replace(taken.update, scene={RAYS: note}))
    bundles = 1 if getattr(parameters, "sweep", "") == "ALL" else rows
    return Sight(parameters, pose, replace(asked[0], rows=rows, bundles=bundles))
