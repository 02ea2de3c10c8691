# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion detector with pyroelectric elements behind a lens: warm objects that move from one zone
to the next change the power on its elements, which respond only to changes."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ....kind import WARMTH
from ....model import Array, Model, PerPose, Pose, Readings, Updates
from ....physics.output_timing import OutputTiming, RadioTiming
from .calibration import threshold
from .lenses import LENSES
from .radiance import net_power
from .response import Chain, Response
from .zones import Zones, read_table, zone_rays

if TYPE_CHECKING:
    from ..range_scan import PirParameters

# m: length of the rays; beyond it everything has the ambient temperature.
SIGHT = 50.0


def zones_of(parameters: PirParameters) -> Zones:
    """The zones of the detector's lens. Raises InputError where the user's table is invalid."""
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
    """The threshold in W per m² of lenslet: a signal of larger size is movement."""
    return threshold(
        zones_of(parameters),
        response_of(parameters),
        parameters.range_max,
        parameters.target_contrast,
    )


class _Optics(NamedTuple):
    """The rays of all zones in the world with their weights in sr, and the detector's response."""

    zones: Zones
    origins: Array
    directions: Array
    reach: Array
    weights: Array
    response: Response
    threshold: float


class PyroelectricDetector(Model):
    """One detector. Its state is that of its elements and amplifier, and its output stage."""

    def __init__(self) -> None:
        self._wired, self._radio = OutputTiming(), RadioTiming()
        self._optics = PerPose(_optics)
        self._zones: Zones = ()
        self._chain: Chain | None = None
        self._time = 0.0

    def sense(self, parameters: PirParameters, updates: Updates) -> Readings:
        optics = self._optics(parameters, updates.pose)
        if optics.zones != self._zones:
            # The change of power by another lens is no movement.
            self._zones, self._chain = optics.zones, None
        answers = updates.ask(WARMTH, 0, optics.origins, optics.directions, optics.reach)
        powers = np.array([net_power(optics.weights, emission) for emission in answers.table])
        signal = self._filter(optics.response, powers[answers.rows], updates.times)
        signal /= optics.threshold
        if parameters.signal_noise > 0.0:
            numbers = updates.numbers.tolist()
            signal += [updates.noise(k).normal(0.0, parameters.signal_noise) for k in numbers]
        module = (
            parameters.hold_time,
            parameters.blocking_time,
            parameters.warm_up_time,
            parameters.retrigger,
        )
        triggered, arrivals = np.abs(signal) > 1.0, None
        if parameters.is_wireless:
            blanking, delay = parameters.blanking_time, partial(_delay, parameters, updates)
            radio = self._radio.run(updates.times, triggered, *module, blanking, delay)
            moved, arrivals = radio
        else:
            moved = self._wired.run(updates.times, triggered, *module)
        fields = {"angle_rad": None, "moved": moved, "signal": signal}
        return Readings(moved, signal, fields, arrivals)

    def _filter(self, response: Response, power: Array, times: Array) -> Array:
        """The largest signal (n,) since the update before, in W per m² of lenslet, from the power
        (n,) at `times` (n,). A changed response starts from its steady state."""
        if self._chain is None or self._chain.response != response:
            self._chain = Chain(response)
        peaks = self._chain.advance(power, np.diff(times, prepend=self._time))
        self._time = float(times[-1])
        return peaks


def _delay(parameters: PirParameters, updates: Updates, i: int) -> float:
    """How long a message of update i takes (s): exponential, as waits for a free channel are."""
    # The first number of an update is the signal's noise.
    return float(updates.noise(int(updates.numbers[i])).exponential(size=2)[1]) * (
        parameters.message_delay
    )


def _optics(parameters: PirParameters, pose: Pose) -> _Optics:
    zones = zones_of(parameters)
    local = zone_rays(zones, parameters.zone_rays)
    directions = local.directions @ pose.axes.T
    origins = pose.origin + directions * parameters.range_min
    reach = np.full(len(directions), SIGHT)
    rays = zones, origins, directions, reach, local.weights
    return _Optics(*rays, response_of(parameters), threshold_of(parameters))
