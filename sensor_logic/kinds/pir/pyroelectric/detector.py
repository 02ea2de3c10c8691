# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion detector with two elements behind a lens: warm things that move from one zone to the
next change the power on its elements, and only the change is felt."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ....kind import WARMTH
from ....model import Array, Model, Pose, Readings, Updates
from ....physics.output_timing import OutputTiming
from .calibration import threshold
from .lenses import LENSES
from .radiance import net_power
from .response import Chain, Response
from .zones import Zones, read_table, zone_rays

if TYPE_CHECKING:
    from ..range_scan import PirParameters

# m: how far it looks for what is warm, or hides it; beyond is the ambient.
SIGHT = 50.0


def zones_of(parameters: PirParameters) -> Zones:
    """The zones of the detector's lens. Raises LensError where its own table cannot be used."""
    if parameters.lens_table is not None:
        return read_table(parameters.lens_table)
    return LENSES[parameters.lens].zones


def response_of(parameters: PirParameters) -> Response:
    return Response(
        parameters.electrical_time,
        parameters.thermal_time,
        parameters.low_cut,
        parameters.high_cut,
    )


def threshold_of(parameters: PirParameters) -> float:
    """W per m² of lenslet: a signal above it, either way, is movement."""
    return threshold(
        zones_of(parameters),
        response_of(parameters),
        parameters.range_max,
        parameters.target_contrast,
    )


class _Aimed(NamedTuple):
    """Rays in the world with their weights, and how their power is answered; kept while parameters
    and pose stay the same."""

    parameters: PirParameters
    pose: Pose
    zones: Zones
    origins: Array
    directions: Array
    reach: Array
    weights: Array
    response: Response
    threshold: float


class PyroelectricDetector(Model):
    """The state of one detector: what its elements feel, and its output stage."""

    def __init__(self) -> None:
        self._output = OutputTiming()
        self._aimed: _Aimed | None = None
        self._chain: Chain | None = None
        self._time = 0.0

    def sense(self, parameters: PirParameters, updates: Updates) -> Readings:
        rays = self._aim(parameters, updates.pose)
        seen = updates.ask(WARMTH, 0, rays.origins, rays.directions, rays.reach)
        power = np.array([net_power(rays.weights, emission) for emission in seen.table])[seen.rows]
        signal = self._feel(rays.response, power, updates.times) / rays.threshold
        if parameters.signal_noise > 0.0:
            numbers = updates.numbers.tolist()
            signal += [updates.noise(k).normal(0.0, parameters.signal_noise) for k in numbers]
        moved = self._output.run(
            updates.times,
            np.abs(signal) > 1.0,
            parameters.hold_time,
            parameters.blocking_time,
            parameters.warm_up_time,
            parameters.retrigger,
            parameters.hold_from_onset,
        )
        return Readings(moved, signal, {"angle_rad": None, "moved": moved, "signal": signal})

    def _feel(self, response: Response, power: Array, times: Array) -> Array:
        """The largest signals (n,), each since the update before; another amplifier starts at
        rest."""
        if self._chain is None or self._chain.response != response:
            self._chain = Chain(response)
        peaks = self._chain.advance(power, np.diff(times, prepend=self._time))
        self._time = float(times[-1])
        return peaks

    def _aim(self, parameters: PirParameters, pose: Pose) -> _Aimed:
        known = self._aimed
        if known is None or known.parameters is not parameters or known.pose is not pose:
            zones = zones_of(parameters)
            local = zone_rays(zones, parameters.zone_rays)
            if known is not None and known.zones != zones:
                # Through another lens the same room is no movement.
                self._chain = None
            directions = local.directions @ pose.axes.T
            origins = pose.origin + directions * parameters.range_min
            reach = np.full(len(directions), SIGHT)
            rays = zones, origins, directions, reach, local.weights
            known = _Aimed(
                parameters, pose, *rays, response_of(parameters), threshold_of(parameters)
            )
            self._aimed = known
        return known
