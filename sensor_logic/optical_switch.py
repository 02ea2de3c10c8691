# SPDX-License-Identifier: GPL-3.0-or-later
"""Slotted optical switch: a beam across a gap that a flag on the door breaks.

One ray is the thesis's sensor: open where the range is at least the threshold, without memory.
Several rays across the aperture resolve a flag that covers part of it: the share of rays that
pass is the light, and a comparator with hysteresis (a Schmitt trigger) decides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .model import Array, Reading, Update
from .parameters import Parameters, parameter

THESIS = "laser switch of the thesis's Gazebo plugin"
# Middle of the comparator's two levels, 0.60 and 0.45 of the full light at the default hysteresis.
SWITCHING_LEVEL = 0.525
# Blender stores the hysteresis in single precision: 3 of 5 rays must still reach the level 0.60.
LEVEL_TOLERANCE = 1e-6


@dataclass(frozen=True)
class OpticalSwitchParameters(Parameters):
    range_min: float = parameter(
        0.001,
        "Range min",
        "Nearer than this is not seen",
        unit="m",
        minimum=0.0,
        source=THESIS,
    )
    range_max: float = parameter(
        0.5,
        "Range max",
        "How far the beam reaches",
        unit="m",
        minimum=0.0,
        above_minimum=True,
        source=THESIS,
    )
    threshold: float = parameter(
        0.05,
        "Threshold",
        "Open where the beam reaches at least this far. Datasheets: gap",
        unit="m",
        minimum=0.0,
        source=THESIS,
    )
    aperture_rays: int = parameter(
        1,
        "Aperture rays",
        "Rays side by side in the aperture; their share that passes is the light",
        minimum=1,
        maximum=10_000,
    )
    aperture: float = parameter(
        0.0,
        "Aperture",
        "Width of the slit, along the sensor's X axis. Datasheets: aperture or slit width",
        unit="m",
        minimum=0.0,
    )
    hysteresis: float = parameter(
        0.15,
        "Hysteresis",
        "Difference of the light at which it opens and closes, as a share of the full light",
        minimum=0.0,
        maximum=0.95,
        source="Schmitt trigger: opens at 0.60, closes below 0.45",
    )
    noise_sigma: float = parameter(
        0.0,
        "Noise",
        "Standard deviation of the noise on every range (Gaussian)",
        unit="m",
        minimum=0.0,
    )

    def contradictions(self) -> list[str]:
        if self.range_min >= self.range_max:
            return [
                f"range_min ({self.range_min:.6g} m) must be smaller than "
                f"range_max ({self.range_max:.6g} m)"
            ]
        if self.threshold > self.range_max:
            return [
                f"threshold ({self.threshold:.6g} m) is beyond range_max "
                f"({self.range_max:.6g} m): the switch could never open"
            ]
        return []


def aperture_offsets(parameters: OpticalSwitchParameters) -> Array:
    """Positions (k,) in metres of the rays across the aperture: the middles of k equal strips.

    The share of rays that pass then differs from the open share of the aperture by at most
    1/(2k) for one straight edge.
    """
    k = parameters.aperture_rays
    return ((np.arange(k) + 0.5) / k - 0.5) * parameters.aperture


class SlottedSwitch:
    """The state of one switch: what its comparator last said."""

    def __init__(self) -> None:
        self._open: bool | None = None

    def update(self, parameters: OpticalSwitchParameters, update: Update) -> Reading:
        ranges = self._ranges(parameters, update)
        light = float(np.mean(ranges >= parameters.threshold))
        half = parameters.hysteresis / 2
        if self._open is None:
            self._open = light >= SWITCHING_LEVEL
        elif light >= SWITCHING_LEVEL + half - LEVEL_TOLERANCE:
            self._open = True
        elif light < SWITCHING_LEVEL - half - LEVEL_TOLERANCE:
            self._open = False
        nearest = float(ranges.min())
        return Reading(self._open, nearest, {"open": self._open, "range_m": nearest})

    def _ranges(self, parameters: OpticalSwitchParameters, update: Update) -> Array:
        """Ranges (k,) in metres, within range_min … range_max."""
        pose = update.pose
        beam = -pose.axes[:, 2]
        starts = pose.origin + np.outer(aperture_offsets(parameters), pose.axes[:, 0])
        directions = np.broadcast_to(beam, starts.shape)
        reach = np.full(len(starts), parameters.range_max - parameters.range_min)
        ranges = update.cast(0, starts + beam * parameters.range_min, directions, reach)
        # What meets nothing reads range_max itself, not what rounding makes of the sum.
        ranges = np.where(ranges >= reach, parameters.range_max, ranges + parameters.range_min)
        if parameters.noise_sigma > 0.0:
            ranges = ranges + update.noise().normal(0.0, parameters.noise_sigma, len(ranges))
        return np.clip(ranges, parameters.range_min, parameters.range_max)
