# SPDX-License-Identifier: GPL-3.0-or-later
"""Slotted optical switch: a flag on the door breaks the beam.

- Model: `SlottedSwitch`, with its parameters and presets in this file.
- Scene: rays by angen_addon/scene/rays/caster.py; solids that cross a swept beam between two steps
  by angen_addon/scene/rays/sweep.py and sensor_logic/geometry/.
- Interface: angen_addon/kinds/optical_switch.py; fitting a door: operators/door.py.
- Physics: docs/switch.md.
- Tests: tests/pure/test_optical_switch.py, tests/blender/test_swept_switch.py and test_door.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..evidence import Cause, measured_cause, names_hit
from ..geometry.sweep import RayCrossings, no_crossings
from ..geometry.trees import Index
from ..kind import CROSSINGS, RAYS, Field, Kind, Preset
from ..logs.wording import METRES, Advice, Lengths
from ..model import Array, Model, PerPose, Pose, Reading, Readings, Update, Updates
from ..parameters import Parameters, parameter

# The light of a beam between two steps, from the solids that crossed it.

# As a share of the time between two steps: a shorter gap in a break is a rounding error. At 24
# frames a second it is 0.4 µs, too short for any switch.
NO_GAP = 1e-5


def light_between(crossings: RayCrossings, ranges: Array, threshold: float, rays: int) -> Array:
    """Return the fraction of unblocked rays (n,) in n successive intervals since the previous step.

    The intervals are those in which this fraction is constant. There are none if no ray was
    blocked.

    Parameters
    ----------
    crossings
        The p crossings of the beam by solids since the previous step.
    ranges
        The distance (p, 2) in m from the sensor, at the begin and the end of each crossing.
    threshold
        A solid blocks a ray if it is nearer than this distance in m.
    rays
        The number of rays in the beam.
    """
    ray, begin, end = _blocked_intervals(crossings, ranges, threshold)
    if not len(ray):
        return np.zeros(0)
    begin, end = _merge_intervals(ray, begin, end)
    times = np.concatenate([begin, end])
    order = np.argsort(times, kind="stable")
    stopped = np.cumsum(np.repeat([1, -1], len(begin))[order])
    # Empty intervals are dropped. Before the first break and after the last one, the light is full.
    lasts = np.diff(times[order]) > 0.0
    light = 1.0 - stopped[:-1][lasts] / rays
    before = [1.0] if times[order[0]] > NO_GAP else []
    after = [1.0] if times[order[-1]] < 1.0 - NO_GAP else []
    return np.concatenate([before, light, after])


def _blocked_intervals(
    crossings: RayCrossings, ranges: Array, threshold: float
) -> tuple[Index, Array, Array]:
    """Return the intervals in which a ray is blocked: the ray's index, the begin and the end.

    A ray is blocked while the solid that crosses it is nearer than `threshold` (m).
    """
    one, two = ranges[:, 0], ranges[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.clip((threshold - one) / (two - one), 0.0, 1.0)
    at_threshold = crossings.begin + share * (crossings.end - crossings.begin)
    begin = np.where(one < threshold, crossings.begin, at_threshold)
    end = np.where(two < threshold, crossings.end, at_threshold)
    stops = (one < threshold) | (two < threshold)
    return crossings.ray[stops], begin[stops], end[stops]


def _merge_intervals(ray: Index, begin: Array, end: Array) -> tuple[Array, Array]:
    """Return begins and ends (n,) after merging the intervals of a ray that overlap or adjoin."""
    # Each ray has its own section of a common time axis.
    starts, stops = begin + 2.0 * ray, end + 2.0 * ray
    order = np.argsort(starts, kind="stable")
    starts, furthest = starts[order], np.maximum.accumulate(stops[order])
    new = np.flatnonzero(np.append(True, starts[1:] > furthest[:-1] + NO_GAP))
    last = np.append(new[1:], len(starts)) - 1
    shift = 2.0 * ray[order][new]
    return starts[new] - shift, furthest[last] - shift


# The parameters and the model.
#
# One ray is the sensor of the thesis: open if the range is at least the threshold, without memory.
# Several rays across the aperture resolve a flag that covers a part of it. The share of rays that
# pass is the light, and a comparator with hysteresis (a Schmitt trigger) gives the output.
#
# A swept switch has a latched output, as with an input that interrupts on an edge: an object that
# breaks the beam between two updates makes the switch read closed at the next update.

THESIS = "laser switch of the Gazebo plugin from the thesis behind this extension"
# The middle of the comparator's levels, 0.60 and 0.45 of the full light at the default hysteresis.
SWITCHING_LEVEL = 0.525
# Tolerance for the hysteresis, stored in single precision: 3 of 5 rays must reach the level 0.60.
LEVEL_TOLERANCE = 1e-6
NO_RANGES = np.zeros((0, 2))


@dataclass(frozen=True)
class OpticalSwitchParameters(Parameters):
    """The parameters of an optical switch."""

    range_min: float = parameter(
        0.001, "Range min", "Surfaces nearer than this are not detected", unit="m", source=THESIS
    )
    range_max: float = parameter(
        0.5, "Range max", "How far the beam reaches", unit="m", positive=True, source=THESIS
    )
    threshold: float = parameter(
        0.05,
        "Threshold",
        "The switch is open while the beam reaches at least this far. Datasheets: gap",
        unit="m",
        source=THESIS,
    )
    aperture_rays: int = parameter(
        1,
        "Aperture rays",
        "Number of rays side by side in the aperture. The light is the share of the rays that "
        "reach the receiver",
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
        """Return sentences about ranges that contradict each other."""
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
        """Return advice if no object can close the switch."""
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
    """Return the positions (k,) in m of the rays along the sensor's X axis.

    The rays are at the centres of k equal strips of the aperture. An object with one straight edge
    leaves a part of the aperture open. The fraction of rays that pass differs from this part by at
    most 1/(2k).
    """
    k = parameters.aperture_rays
    return ((np.arange(k) + 0.5) / k - 0.5) * parameters.aperture


def beam(parameters: OpticalSwitchParameters, pose: Pose) -> tuple[Array, Array, Array]:
    """Return the rays of the beam: origins (k, 3), unit directions (k, 3) and lengths (k,) in m.

    The rays start at the distance range_min from the sensor.
    """
    ahead = -pose.axes[:, 2]
    starts = pose.origin + np.outer(aperture_offsets(parameters), pose.axes[:, 0])
    reach = np.full(len(starts), parameters.range_max - parameters.range_min)
    return starts + ahead * parameters.range_min, np.broadcast_to(ahead, starts.shape), reach


@dataclass(frozen=True)
class BeamStep:
    """The beam at one step.

    Attributes
    ----------
    ranges
        The range (k,) of each ray, in m.
    crossings
        What crossed the rays since the step before.
    solids
        The numbers (k,) of the solids that the rays hit, 0 for none; None if they are unknown.
    """

    ranges: Array
    crossings: RayCrossings
    solids: Index | None = None


@dataclass(frozen=True)
class LatchedBreak:
    """An interruption of the beam between two updates.

    Attributes
    ----------
    range
        The distance in m from the sensor to the solid that interrupts the beam.
    steps
        The time from the interruption to the later update, in steps of the clock.
    solid
        The number of that solid, or 0 if it is unknown.
    """

    range: float
    steps: float
    solid: int


class SlottedSwitch(Model):
    """Model of one slotted optical switch.

    Its state is the output of its comparator, and the steps since the last update.
    """

    def __init__(self) -> None:
        self._open: bool | None = None
        self._steps: list[BeamStep] = []
        self._rays = PerPose(beam)

    def sense(self, parameters: OpticalSwitchParameters, updates: Updates) -> Readings:
        """Return the readings at the updates that are due."""
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
        """Return the readings of a switch that has no noise and is not swept."""
        rays = self._rays(parameters, updates.pose)
        answers = updates.ask(RAYS, 0, *rays, indices=np.flatnonzero(updates.due))
        ranges = np.asarray(answers.table)
        hit = ranges < rays[2]
        ranges = np.where(hit, ranges + parameters.range_min, parameters.range_max)
        ranges = np.clip(ranges, parameters.range_min, parameters.range_max)
        light = (ranges >= parameters.threshold).mean(axis=1)[answers.rows]
        is_open = np.empty(len(light), bool)
        changes = np.append(True, light[1:] != light[:-1])
        for i in np.flatnonzero(changes).tolist():
            self._open = is_open[i:] = self._compare(parameters, float(light[i]))
        ray, every = ranges.argmin(axis=1), np.arange(len(ranges))
        nearest = ranges[every, ray][answers.rows]
        names = names_hit(answers, ray, hit[every, ray], updates.name_of)
        evidence = {"object": names, "light": light, "steps_ago": None}
        fields = {"open": is_open, "range_m": nearest}
        return Readings(is_open, nearest, fields, evidence=evidence)

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
        ranges = noisy[-1][0]
        ray = int(np.argmin(ranges))
        is_open, nearest, ago = bool(self._open), float(ranges[ray]), math.nan
        hit = now.solids is not None and now.ranges[ray] < parameters.range_max
        solid = int(now.solids[ray]) if now.solids is not None and hit else 0
        if is_open and closed_meanwhile:
            latched = _nearest_break(steps, noisy)
            is_open, nearest, ago, solid = False, latched.range, latched.steps, latched.solid
        light = float(np.mean(ranges >= parameters.threshold))
        evidence = {"object": update.name_of(solid), "light": light, "steps_ago": ago}
        return Reading(is_open, nearest, {"open": is_open, "range_m": nearest}, evidence)

    def _compare(self, parameters: OpticalSwitchParameters, light: float) -> bool:
        """Return whether the comparator's output is open at `light` (1: full light)."""
        half = parameters.hysteresis / 2
        if self._open is None:
            return light >= SWITCHING_LEVEL
        if light >= SWITCHING_LEVEL + half - LEVEL_TOLERANCE:
            return True
        return self._open and light >= SWITCHING_LEVEL - half - LEVEL_TOLERANCE

    def _step(self, parameters: OpticalSwitchParameters, update: Update) -> BeamStep:
        rays = self._rays(parameters, update.pose)
        ranges, reach = update.ask(RAYS, 0, *rays), rays[2]
        # A ray without a hit reads exactly range_max, without the rounding error of a sum.
        ranges = np.where(ranges >= reach, parameters.range_max, ranges + parameters.range_min)
        crossings = update.ask(CROSSINGS, *rays) if parameters.swept else None
        if crossings is None:
            # Earlier steps do not belong to this interval, or the switch is no longer swept.
            self._steps.clear()
            crossings = no_crossings()
        return BeamStep(ranges, crossings, update.solids_hit(RAYS, 0, *rays))


def _with_noise(
    parameters: OpticalSwitchParameters, step: BeamStep, noise: Array
) -> tuple[Array, Array]:
    """Return a step's ranges (k,) and the ranges (p, 2) of its crossings, in m, with noise.

    A crossing has one range at its begin and one at its end. All are limited to range_min …
    range_max.
    """
    lo, hi = parameters.range_min, parameters.range_max
    ranges = np.clip(step.ranges + noise, lo, hi)
    if not len(step.crossings):
        return ranges, NO_RANGES
    both = np.stack([step.crossings.near, step.crossings.far], axis=1) + lo
    both += noise[step.crossings.ray][:, None]
    return ranges, np.clip(both, lo, hi)


def _nearest_break(steps: list[BeamStep], noisy: list[tuple[Array, Array]]) -> LatchedBreak:
    """Return the interruption nearest to the sensor, over all steps between two updates.

    `noisy` has the result of `_with_noise` for each step.
    """
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
    # At equal ranges, prefer a crossing to a step, because it has the number of the solid.
    return min(found, key=lambda one: (round(one.range, 6), one.solid == 0))


# Presets of commercial slotted switches, and of the thesis.


def _slotted(identifier: str, label: str, gap_mm: float, aperture_mm: float, source: str) -> Preset:
    """Return a preset of a slotted switch that is open while its gap is empty.

    It opens at 0.60 and closes at 0.45 of the full light, a ratio of 0.75 as in Sharp's data
    sheets. The part's response time of microseconds is neglected.
    """
    values = {
        "range_min": 0.0,
        "range_max": gap_mm / 1000,
        "threshold": gap_mm / 1000,
        "aperture_rays": 9 if aperture_mm else 1,
        "aperture": aperture_mm / 1000,
        "hysteresis": 0.15,
        "noise_sigma": 0.0,
    }
    return Preset(identifier, label, values, source)


ASSUMED = "Assumed: switching at half of the light in the middle of the hysteresis, and no noise"
VISHAY_83764 = (
    "Vishay data sheet TCST1103, TCST1202, TCST1300, document 83764: gap, aperture. "
    f"{ASSUMED}; hysteresis as that of Sharp's parts"
)
SHARP_GP1A50 = (
    "Sharp GP1A50HR/51HR/52HR/53HR data sheet: gap, slit, hysteresis 0.75 typical. " + ASSUMED
)
OMRON_EE_SX67 = (
    "Omron EE-SX47/67 data sheet CSM_EE-SX47/67_DS_E: slot; its aperture is not given. "
    f"{ASSUMED}; one ray; hysteresis as that of Sharp's parts"
)

PRESETS: tuple[Preset, ...] = (
    Preset(
        "THESIS",
        "Thesis (Gazebo laser switch)",
        {
            "range_min": 0.001,
            "range_max": 0.5,
            "threshold": 0.05,
            "aperture_rays": 1,
            "aperture": 0.0,
            "noise_sigma": 0.0,
        },
        "laser switch of the Gazebo plugin from the thesis behind this extension",
    ),
    _slotted("TCST1103", "Vishay TCST1103 (3.1 mm)", 3.1, 1.0, VISHAY_83764),
    _slotted("TCST1202", "Vishay TCST1202 (3.1 mm, fine)", 3.1, 0.5, VISHAY_83764),
    _slotted("TCST1300", "Vishay TCST1300 (3.1 mm, finest)", 3.1, 0.25, VISHAY_83764),
    _slotted("GP1A51HR", "Sharp GP1A51HR (3 mm)", 3.0, 0.5, SHARP_GP1A50),
    _slotted("GP1A53HR", "Sharp GP1A53HR (5 mm)", 5.0, 0.5, SHARP_GP1A50),
    _slotted("EE_SX670", "Omron EE-SX670 (5 mm)", 5.0, 0.0, OMRON_EE_SX67),
)


def cause(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: what breaks the beam, or did before."""
    objects, ranges = [track.evidence.value("object", index)], track.columns["range_m"]
    if track.active[index]:
        # An open switch was opened by what broke the beam at the update before.
        threshold = track.parameters_at(index).threshold
        broken = index > 0 and ranges[index - 1] < threshold
        objects = [track.evidence.value("object", index - 1)] if broken else []
    return measured_cause(track, index, filter(None, objects))


KIND = Kind(
    "OPTICAL_SWITCH",
    2,
    "Optical switch",
    "Slotted optical switch, for doors and shutters",
    "SNAP_EDGE",
    "optical_switch",
    1.0,
    "Open",
    "Closed",
    OpticalSwitchParameters,
    events=(Field("open", bool, quantity="opening", tip="Whether the beam is not broken"),),
    samples=(
        Field("open", bool),
        Field(
            "range_m",
            float,
            "m",
            3,
            tip="How far the beam reaches; the range max if nothing breaks it",
        ),
    ),
    evidence=(
        Field("object", str, tip="The object that the nearest ray hits, or that crossed the beam"),
        Field("light", float, tip="Share of the light that passes at the update"),
        Field("steps_ago", float, tip="Steps from the crossing to the update, if one closed it"),
    ),
    cause=cause,
    model=SlottedSwitch,
    needs={RAYS: (), CROSSINGS: (("swept", True),)},
    presets=PRESETS,
    part="TCST1103",
)
