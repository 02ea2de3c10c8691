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

from ...geometry.sweep import RayCrossings, no_crossings
from ...kind import CROSSINGS, RAYS
from ...model import Array, Model, PerPose, Pose, Reading, Readings, Update, Updates
from ...parameters import Parameters, parameter
from ...quantities import METRES, Lengths
from ...wording import Advice
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
        0.001, "Range min", "Anything nearer is not detected", unit="m", source=THESIS
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
        "Rays side by side in the aperture; the share that reaches the receiver is the light",
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
        "Difference between the light at which it opens and closes, as a share of the full light",
        maximum=0.95,
        source="Schmitt trigger: opens at 0.60, closes below 0.45",
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on every range (Gaussian)", unit="m"
    )
    swept: bool = parameter(
        False,
        "Swept",
        "Detect every rigid object that crosses the beam between two updates, however fast: the "
        "beam is checked at every frame and against paths from frame to frame. The later update "
        "reports the break",
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

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        if self.threshold > self.range_min:
            return []
        return [
            Advice(
                f"The threshold ({lengths.typed(self.threshold)}) is not above the range min "
                f"({lengths.typed(self.range_min)}): the switch never closes",
                "Raise the threshold or lower the range min",
            )
        ]


def aperture_offsets(parameters: OpticalSwitchParameters) -> Array:
    """Positions (k,) in metres of the rays across the aperture: the middles of k equal strips.

    The share of rays that pass then differs from the open share of the aperture by at most
    1/(2k) for one straight edge.
    """
    k = parameters.aperture_rays
    return ((np.arange(k) + 0.5) / k - 0.5) * parameters.aperture


def beam(parameters: OpticalSwitchParameters, pose: Pose) -> tuple[Array, Array, Array]:
    """The rays: starts (k, 3) at range_min, unit directions (k, 3), and lengths (k,) in m."""
    ahead = -pose.axes[:, 2]
    starts = pose.origin + np.outer(aperture_offsets(parameters), pose.axes[:, 0])
    reach = np.full(len(starts), parameters.range_max - parameters.range_min)
    return starts + ahead * parameters.range_min, np.broadcast_to(ahead, starts.shape), reach


@dataclass(frozen=True)
class BeamStep:
    """The beam at one step: `ranges` (k,) in m, and the `crossings` since the step before."""

    ranges: Array
    crossings: RayCrossings


@dataclass(frozen=True)
class LatchedBreak:
    """A break of the beam between two updates, where it was nearest: `range` in m, how many `steps`
    of the clock before the update, and the number of the `solid`, 0 where it is not known."""

    range: float
    steps: float
    solid: int


class SlottedSwitch(Model):
    """One switch. Its state is its comparator's output, and the steps since the last update.

    `latched_break`: the break that alone made the last reading a closed one.
    """

    def __init__(self) -> None:
        self.latched_break: LatchedBreak | None = None
        self._open: bool | None = None
        self._steps: list[BeamStep] = []
        self._rays = PerPose(beam)

    def sense(self, parameters: OpticalSwitchParameters, updates: Updates) -> Readings:
        if not parameters.swept:
            self._steps.clear()
            if parameters.noise_sigma == 0.0:
                return self._sense_plain(parameters, updates)
        found = []
        for i, due in enumerate(updates.due.tolist()):
            if due:
                found.append(self._read(parameters, updates[i]))
            elif parameters.swept:
                self._steps.append(self._step(parameters, updates[i]))
        return Readings.of(found)

    def _sense_plain(self, parameters: OpticalSwitchParameters, updates: Updates) -> Readings:
        """The readings without noise and without steps between the updates."""
        self.latched_break = None
        rays = self._rays(parameters, updates.pose)
        answers = updates.ask(RAYS, 0, *rays, which=np.flatnonzero(updates.due))
        ranges = np.asarray(answers.table)
        ranges = np.where(ranges >= rays[2], parameters.range_max, ranges + parameters.range_min)
        ranges = np.clip(ranges, parameters.range_min, parameters.range_max)
        light = (ranges >= parameters.threshold).mean(axis=1)[answers.rows]
        is_open = np.empty(len(light), bool)
        changes = np.append(True, light[1:] != light[:-1])
        for i in np.flatnonzero(changes).tolist():
            self._open = is_open[i:] = self._compare(parameters, float(light[i]))
        nearest = ranges.min(axis=1)[answers.rows]
        return Readings(is_open, nearest, {"open": is_open, "range_m": nearest})

    def _read(self, parameters: OpticalSwitchParameters, update: Update) -> Reading:
        now = self._step(parameters, update)
        # Steps with another number of rays belong to another beam.
        steps = [one for one in self._steps if len(one.ranges) == len(now.ranges)] + [now]
        self._steps.clear()
        noise = np.zeros(len(now.ranges))
        if parameters.noise_sigma > 0.0:
            noise = update.noise().normal(0.0, parameters.noise_sigma, len(noise))
        noisy = [_with_noise(parameters, step, noise) for step in steps]
        closed_meanwhile = False
        for step, (ranges, of_crossings) in zip(steps, noisy, strict=True):
            lights = [float(np.mean(ranges >= parameters.threshold))]
            if len(of_crossings):
                between = light_between(
                    step.crossings, of_crossings, parameters.threshold, len(ranges)
                )
                lights = between.tolist() + lights
            for light in lights:
                was_open, self._open = self._open, self._compare(parameters, light)
                closed_meanwhile |= bool(was_open) and not self._open
        is_open, nearest = bool(self._open), float(noisy[-1][0].min())
        self.latched_break = None
        if is_open and closed_meanwhile:
            self.latched_break = _nearest(steps, noisy)
            is_open, nearest = False, self.latched_break.range
        return Reading(is_open, nearest, {"open": is_open, "range_m": nearest})

    def _compare(self, parameters: OpticalSwitchParameters, light: float) -> bool:
        """The comparator's output (open) for `light`, a share of the full light."""
        half = parameters.hysteresis / 2
        if self._open is None:
            return light >= SWITCHING_LEVEL
        if light >= SWITCHING_LEVEL + half - LEVEL_TOLERANCE:
            return True
        return self._open and light >= SWITCHING_LEVEL - half - LEVEL_TOLERANCE

    def _step(self, parameters: OpticalSwitchParameters, update: Update) -> BeamStep:
        rays = self._rays(parameters, update.pose)
        ranges, reach = update.ask(RAYS, 0, *rays), rays[2]
        # A ray that hits nothing reads range_max itself, without the sum's rounding error.
        ranges = np.where(ranges >= reach, parameters.range_max, ranges + parameters.range_min)
        crossings = update.ask(CROSSINGS, *rays) if parameters.swept else None
        if crossings is None:
            # Earlier steps do not belong to this interval, or the switch is no longer swept.
            self._steps.clear()
            crossings = no_crossings()
        return BeamStep(ranges, crossings)


def _with_noise(
    parameters: OpticalSwitchParameters, step: BeamStep, noise: Array
) -> tuple[Array, Array]:
    """The ranges (k,) in m of a step, and those of its crossings at their begin and end (p, 2):
    with noise, within range_min … range_max."""
    lo, hi = parameters.range_min, parameters.range_max
    ranges = np.clip(step.ranges + noise, lo, hi)
    if not len(step.crossings):
        return ranges, NO_RANGES
    both = np.stack([step.crossings.near, step.crossings.far], axis=1) + lo
    both += noise[step.crossings.ray][:, None]
    return ranges, np.clip(both, lo, hi)


def _nearest(steps: list[BeamStep], noisy: list[tuple[Array, Array]]) -> LatchedBreak:
    """The nearest break between two updates; `noisy`: the steps' ranges by `_with_noise`."""
    found = []
    for back, (step, (ranges, of_crossings)) in enumerate(
        zip(reversed(steps), reversed(noisy), strict=True)
    ):
        found.append(LatchedBreak(float(ranges.min()), float(back), 0))
        if len(of_crossings):
            which, side = divmod(int(np.argmin(of_crossings)), 2)
            when = (step.crossings.begin, step.crossings.end)[side][which]
            solid, nearest = int(step.crossings.solid[which]), float(of_crossings[which, side])
            found.append(LatchedBreak(nearest, back + 1.0 - float(when), solid))
    # Of a step and a crossing at the same range, the crossing knows the solid.
    return min(found, key=lambda one: (round(one.range, 6), one.solid == 0))
