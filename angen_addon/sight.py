# SPDX-License-Identifier: GPL-3.0-or-later
"""The rays of one sensor, as its own model asks for them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..sensor_logic.kind import RAYS
from ..sensor_logic.model import Array, Pose
from .station import Station


@dataclass(frozen=True)
class Rays:
    """Rays in the world, in Blender units: `origins` (n, 3), unit `directions` (n, 3), `reach`
    (n,). `rows`: how many equal rows they stand in, for a motion detector its tilts; `bundles`: how
    many equal parts of them are cast apart; `apart`: each stands for itself, they span no fan."""

    origins: Array
    directions: Array
    reach: Array
    rows: int = 1
    bundles: int = 1
    apart: bool = False

    def same(self, other: Rays | None) -> bool:
        return (
            other is not None
            and self.rows == other.rows
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


NO_RAYS = Rays(np.empty((0, 3)), np.empty((0, 3)), np.empty(0))


@dataclass(frozen=True)
class Sight:
    """What one sensor looks with. `request`: what a light sensor asks of the scene."""

    parameters: Any
    pose: Pose
    rays: Rays
    request: Any = None


class _Asked:
    """Stands for the probes: takes down the rays that a model asks for; nothing is met."""

    def __init__(self) -> None:
        self.caster = self
        self.rays: list[Rays] = []

    def cast(
        self, sensor: int, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Array:
        self.rays.append(Rays(np.array(origins), np.array(directions), np.array(length)))
        return length


def sight_of(station: Station, depsgraph: Any) -> Sight | None:
    """What the sensor looks with at the depsgraph's frame: all rays that its model ever casts with
    these parameters; none of a model that casts none. None while it is switched off. Raises
    SensorError.

    The model senses once, where nothing is met; a detector with all tilts at once, which are those
    that its saw-tooth takes in turn.
    """
    asked: Any = _Asked()
    station.reset()
    taken = station.take(0, 0, depsgraph, asked)
    if taken is None:
        return None
    parameters, pose = taken.parameters, taken.update.pose
    if not station.sensor.kind.asks_for(RAYS, parameters):
        return Sight(parameters, pose, NO_RAYS, taken.request)
    rows = getattr(parameters, "tilt_count", 1)
    if hasattr(parameters, "sweep"):
        taken = replace(taken, parameters=replace(parameters, sweep="ALL"))
    if getattr(parameters, "swept", False):
        # What it sweeps are the same rays.
        taken = replace(taken, parameters=replace(parameters, swept=False))
    taken.reading()
    return Sight(parameters, pose, replace(asked.rays[0], rows=rows, bundles=rows))
