# SPDX-License-Identifier: GPL-3.0-or-later
"""Slotted optical switch: a beam across a gap that a flag on the door breaks.

One ray is the thesis's sensor: open where the range is at least the threshold, without memory.
Several rays across the aperture resolve a flag that covers part of it: the share of rays that
pass is the light, and a comparator with hysteresis (a Schmitt trigger) decides.

A swept switch is one whose output is latched, as by an input that interrupts on an edge: what
breaks its beam between two updates makes it read closed at the next one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...geometry.sweep import Passes, no_passes
from ...kind import CROSSINGS, RAYS
from ...model import Array, Model, Pose, Reading, Readings, Update, Updates
from ...parameters import Parameters, parameter
from ...quantities import METRES, Lengths
from .breaks import light_between

THESIS = "laser switch of the thesis's Gazebo plugin"
# Middle of the comparator's two levels, 0.60 and 0.45 of the full light at the default hysteresis.
SWITCHING_LEVEL = 0.525
# Blender stores the hysteresis in single precision: 3 of 5 rays must still reach the level 0.60.
LEVEL_TOLERANCE = 1e-6
NO_RANGES = np.zeros((0, 2))


@dataclass(frozen=True)
class OpticalSwitchParameters(Parameters):
    range_min: float = parameter(
        0.001, "Range min", "Nearer than this is not seen", unit="m", source=THESIS
    )
    range_max: float = parameter(
        0.5, "Range max", "How far the beam reaches", unit="m", positive=True, source=THESIS
    )
    threshold: float = parameter(
        0.05,
        "Threshold",
        "Open where the beam reaches at least this far. Datasheets: gap",
        unit="m",
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
    )
    hysteresis: float = parameter(
        0.15,
        "Hysteresis",
        "Difference of the light at which it opens and closes, as a share of the full light",
        maximum=0.95,
        source="Schmitt trigger: opens at 0.60, closes below 0.45",
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on every range (Gaussian)", unit="m"
    )
    swept: bool = parameter(
        False,
        "Swept",
        "Miss nothing rigid that goes through the beam between two updates, however fast: the "
        "beam is watched at every frame, and things are swept from each frame to the next. The "
        "break is told at the later update",
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        problems = self.must_be_smaller("range_min", "range_max", lengths)
        if problems:
            return problems
        if self.threshold > self.range_max:
            return [
                f"threshold ({lengths.typed(self.threshold)}) is beyond range_max "
                f"({lengths.typed(self.range_max)}): the switch could never open"
            ]
        return []


def aperture_offsets(parameters: OpticalSwitchParameters) -> Array:
    """Positions (k,) in metres of the rays across the aperture: the middles of k equal strips.

    The share of rays that pass then differs from the open share of the aperture by at most
    1/(2k) for one straight edge.
    """
    k = parameters.aperture_rays
    return ((np.arange(k) + 0.5) / k - 0.5) * parameters.aperture


def beam(parameters: OpticalSwitchParameters, pose: Pose) -> tuple[Array, Array, Array]:
    """The rays: starts (k, 3) at range_min, directions (k, 3), and how far they reach (k,)."""
    ahead = -pose.axes[:, 2]
    starts = pose.origin + np.outer(aperture_offsets(parameters), pose.axes[:, 0])
    reach = np.full(len(starts), parameters.range_max - parameters.range_min)
    return starts + ahead * parameters.range_min, np.broadcast_to(ahead, starts.shape), reach


@dataclass(frozen=True)
class Look:
    """The beam at one step: `ranges` (k,) in m, and what went through it since the step before."""

    ranges: Array
    passes: Passes


@dataclass(frozen=True)
class Caught:
    """What broke the beam between two updates, at its nearest: `range` in m, how many `steps` of
    the clock before the update, and the number of the `thing`, 0 where that is not known."""

    range: float
    steps: float
    thing: int


class SlottedSwitch(Model):
    """The state of one switch: what its comparator last said, and what was seen since.

    `caught`: what alone made the last reading a closed one.
    """

    def __init__(self) -> None:
        self.caught: Caught | None = None
        self._open: bool | None = None
        self._looks: list[Look] = []
        self._beam: tuple[OpticalSwitchParameters, Pose, tuple[Array, Array, Array]] | None = None

    def sense(self, parameters: OpticalSwitchParameters, updates: Updates) -> Readings:
        if not parameters.swept:
            self._looks.clear()
            if parameters.noise_sigma == 0.0:
                return self._sense_plain(parameters, updates)
        found = []
        for i, due in enumerate(updates.due.tolist()):
            if due:
                found.append(self._read(parameters, updates[i]))
            elif parameters.swept:
                self._looks.append(self._look(parameters, updates[i]))
        return Readings.of(found)

    def _sense_plain(self, parameters: OpticalSwitchParameters, updates: Updates) -> Readings:
        """The same without noise, and of what is seen at the updates alone."""
        self.caught = None
        rays = self._rays(parameters, updates.pose)
        seen = updates.ask(RAYS, 0, *rays, which=np.flatnonzero(updates.due))
        ranges = np.asarray(seen.table)
        ranges = np.where(ranges >= rays[2], parameters.range_max, ranges + parameters.range_min)
        ranges = np.clip(ranges, parameters.range_min, parameters.range_max)
        light = (ranges >= parameters.threshold).mean(axis=1)[seen.rows]
        is_open = np.empty(len(light), bool)
        changes = np.append(True, light[1:] != light[:-1])
        for i in np.flatnonzero(changes).tolist():
            self._open = is_open[i:] = self._compared(parameters, float(light[i]))
        nearest = ranges.min(axis=1)[seen.rows]
        return Readings(is_open, nearest, {"open": is_open, "range_m": nearest})

    def _read(self, parameters: OpticalSwitchParameters, update: Update) -> Reading:
        now = self._look(parameters, update)
        # A look with another number of rays is none of this beam.
        looks = [one for one in self._looks if len(one.ranges) == len(now.ranges)] + [now]
        self._looks.clear()
        noise = np.zeros(len(now.ranges))
        if parameters.noise_sigma > 0.0:
            noise = update.noise().normal(0.0, parameters.noise_sigma, len(noise))
        seen = [_with_noise(parameters, look, noise) for look in looks]
        closed_meanwhile = False
        for look, (ranges, of_passes) in zip(looks, seen, strict=True):
            steps = [float(np.mean(ranges >= parameters.threshold))]
            if len(of_passes):
                before = light_between(look.passes, of_passes, parameters.threshold, len(ranges))
                steps = before.tolist() + steps
            for light in steps:
                was_open, self._open = self._open, self._compared(parameters, light)
                closed_meanwhile |= bool(was_open) and not self._open
        is_open, nearest = bool(self._open), float(seen[-1][0].min())
        self.caught = None
        if is_open and closed_meanwhile:
            self.caught = _nearest(looks, seen)
            is_open, nearest = False, self.caught.range
        return Reading(is_open, nearest, {"open": is_open, "range_m": nearest})

    def _compared(self, parameters: OpticalSwitchParameters, light: float) -> bool:
        """What the comparator says of a share of the full light."""
        half = parameters.hysteresis / 2
        if self._open is None:
            return light >= SWITCHING_LEVEL
        if light >= SWITCHING_LEVEL + half - LEVEL_TOLERANCE:
            return True
        return self._open and light >= SWITCHING_LEVEL - half - LEVEL_TOLERANCE

    def _rays(self, parameters: OpticalSwitchParameters, pose: Pose) -> tuple[Array, Array, Array]:
        """Its beam; the same arrays as long as neither changes."""
        known = self._beam
        if known is None or known[0] is not parameters or known[1] is not pose:
            known = self._beam = parameters, pose, beam(parameters, pose)
        return known[2]

    def _look(self, parameters: OpticalSwitchParameters, update: Update) -> Look:
        rays = self._rays(parameters, update.pose)
        ranges, reach = update.ask(RAYS, 0, *rays), rays[2]
        # What meets nothing reads range_max itself, not what rounding makes of the sum.
        ranges = np.where(ranges >= reach, parameters.range_max, ranges + parameters.range_min)
        passes = update.ask(CROSSINGS, *rays) if parameters.swept else None
        if passes is None:
            # What was seen before is not of this interval, or no longer asked for.
            self._looks.clear()
            passes = no_passes()
        return Look(ranges, passes)


def _with_noise(
    parameters: OpticalSwitchParameters, look: Look, noise: Array
) -> tuple[Array, Array]:
    """Ranges (k,) of a look and of its passes, at their begin and their end (p, 2), as the sensor
    has them: with noise, within range_min … range_max."""
    lo, hi = parameters.range_min, parameters.range_max
    ranges = np.clip(look.ranges + noise, lo, hi)
    if not len(look.passes):
        return ranges, NO_RANGES
    both = np.stack([look.passes.near, look.passes.far], axis=1) + lo
    both += noise[look.passes.ray][:, None]
    return ranges, np.clip(both, lo, hi)


def _nearest(looks: list[Look], seen: list[tuple[Array, Array]]) -> Caught:
    """What was nearest between two updates."""
    found = []
    for back, (look, (ranges, of_passes)) in enumerate(
        zip(reversed(looks), reversed(seen), strict=True)
    ):
        found.append(Caught(float(ranges.min()), float(back), 0))
        if len(of_passes):
            which, side = divmod(int(np.argmin(of_passes)), 2)
            when = (look.passes.begin, look.passes.end)[side][which]
            thing = int(look.passes.thing[which])
            found.append(Caught(float(of_passes[which, side]), back + 1.0 - float(when), thing))
    # A look at what is passing, of which the thing is not known, is no nearer than its pass.
    return min(found, key=lambda one: (round(one.range, 6), one.thing == 0))
