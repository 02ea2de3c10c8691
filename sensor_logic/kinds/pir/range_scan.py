# SPDX-License-Identifier: GPL-3.0-or-later
"""Passive infrared motion detector (PIR): the parameters of both its models, and the range scan.

The range scan is the thesis's: a fan of rays, tilted a step further below the horizon at every
update and back (a saw-tooth), each scan compared with the previous scan at the same tilt.
Movement is any ray whose range changed by more than the threshold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ...kind import RAYS
from ...model import Array, Index, Model, Pose, Readings, Updates
from ...parameters import Choice, Parameters, parameter
from ...physics.output_timing import OutputTiming
from ...quantities import METRES, Lengths
from .pyroelectric.lenses import LENSES
from .pyroelectric.zones import LensError, read_table

THESIS = "range scan of the thesis's Gazebo plugin"
CHOSEN = "chosen: pass bands are 0.1 to 10 Hz (vendors' notes)"
MAX_RAYS = 100_000
SCAN: dict[str, Any] = {"used_when": (("model", "RANGE_SCAN"),)}
PYRO: dict[str, Any] = {"used_when": (("model", "PYROELECTRIC"),)}


@dataclass(frozen=True)
class PirParameters(Parameters):
    model: str = parameter(
        "RANGE_SCAN",
        "Model",
        "How motion is found",
        choices=(
            Choice("RANGE_SCAN", "Range scan", "Compares the ranges of a fan of rays", 0),
            Choice("PYROELECTRIC", "Pyroelectric", "Feels warm things move from zone to zone", 1),
        ),
    )
    lens: str = parameter(
        "THREE_TIERS",
        "Lens",
        "The zones that it sees. A preset sets the detection distance of the part too",
        choices=tuple(
            Choice(
                lens.identifier, lens.label, f"{lens.source}. Assumed: {lens.assumed}", lens.number
            )
            for lens in LENSES.values()
        ),
        **PYRO,
    )
    lens_table: str | None = parameter(
        None,
        "Own lens",
        "A text with a row for each zone in place of the lens: azimuth, elevation, width, height "
        "(degrees), polarity (+ or -), gain",
        pointer="Text",
        **PYRO,
    )
    zone_rays: int = parameter(
        12,
        "Rays a zone",
        "Rays in what one element sees through one lenslet. More feel small and far things more "
        "smoothly and cost more time",
        minimum=1,
        maximum=1000,
        **PYRO,
    )
    horizontal_fov: float = parameter(
        math.radians(120),
        "Horizontal field of view",
        "Angle of the whole fan about the sensor's up axis. Datasheets: horizontal detection angle",
        unit="rad",
        maximum=2 * math.pi,
        source=THESIS,
        short="Horizontal",
        **SCAN,
    )
    rays: int = parameter(
        120,
        "Rays",
        "Rays in the fan. More find smaller movements and cost more time",
        minimum=1,
        maximum=MAX_RAYS,
        source=THESIS,
        **SCAN,
    )
    range_min: float = parameter(
        0.05, "Range min", "Nearer than this is not seen", unit="m", source=THESIS
    )
    range_max: float = parameter(
        4.0,
        "Range max",
        "How far the sensor sees: a ray that meets nothing reads this; a pyroelectric detector "
        "just notices the standard target there. Datasheets: detection distance",
        unit="m",
        positive=True,
        source=THESIS,
    )
    vertical_fov: float = parameter(
        math.radians(90),
        "Vertical field of view",
        "Angle below the sensor's horizon that the tilts sweep. "
        "Datasheets: vertical detection angle",
        unit="rad",
        maximum=math.pi,
        source=THESIS,
        short="Vertical",
        **SCAN,
    )
    vertical_step: float = parameter(
        math.radians(10),
        "Vertical step",
        "Angle between two tilts of the fan. Large steps leave dead zones between the fans",
        unit="rad",
        positive=True,
        maximum=math.pi,
        source=THESIS,
        short="Tilt step",
        **SCAN,
    )
    sweep: str = parameter(
        "SAWTOOTH",
        "Sweep",
        "Which tilts are scanned at an update",
        choices=(
            Choice("SAWTOOTH", "Saw-tooth", "One tilt an update, each in turn", 0),
            Choice("ALL", "All tilts", "Every tilt at every update: quicker to notice", 1),
        ),
        source=THESIS,
        **SCAN,
    )
    threshold: float = parameter(
        0.05,
        "Threshold",
        "A range must change by more than this to count as movement",
        unit="m",
        source=THESIS,
        **SCAN,
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on every range (Gaussian)", unit="m", **SCAN
    )
    target_contrast: float = parameter(
        4.0,
        "Target contrast",
        "How much warmer than the room the standard target is that is just noticed at the "
        "detection distance (a plate of 0.7 m by 0.25 m that passes at 1 m/s). "
        "Datasheets: temperature difference",
        unit="K",
        positive=True,
        source="Panasonic PaPIRs data sheets",
        short="Contrast",
        **PYRO,
    )
    signal_noise: float = parameter(
        0.0,
        "Signal noise",
        "Standard deviation of the noise on the signal (Gaussian), against the threshold",
        **PYRO,
    )
    thermal_time: float = parameter(
        0.15,
        "Thermal time constant",
        "How long the elements take to warm up; slows the signal",
        unit="s",
        positive=True,
        source=CHOSEN,
        short="Thermal",
        **PYRO,
    )
    electrical_time: float = parameter(
        1.0,
        "Electrical time constant",
        "How long the elements keep their charge; slow movement is lost",
        unit="s",
        positive=True,
        source=CHOSEN,
        short="Electrical",
        **PYRO,
    )
    low_cut: float = parameter(
        0.3,
        "Low cut",
        "Lowest frequency that the amplifier lets pass",
        unit="Hz",
        positive=True,
        source=CHOSEN,
        **PYRO,
    )
    high_cut: float = parameter(
        8.0,
        "High cut",
        "Highest frequency that the amplifier lets pass",
        unit="Hz",
        positive=True,
        source=CHOSEN,
        **PYRO,
    )
    hold_time: float = parameter(
        0.0,
        "Hold time",
        "How long the output stays on after the last movement. Datasheets: delay time",
        unit="s",
    )
    retrigger: bool = parameter(
        True,
        "Retrigger",
        "Movement during the hold time starts it anew. Datasheets: repeatable trigger (H)",
    )
    hold_from_onset: bool = parameter(
        False,
        "Hold from Onset",
        "The hold time begins where the signal passes the threshold, as in a circuit that an edge "
        "triggers; else it begins anew for as long as the signal is above",
        **PYRO,
    )
    blocking_time: float = parameter(
        0.0,
        "Blocking time",
        "How long movement is ignored after the output went off. Datasheets: block time",
        unit="s",
    )
    warm_up_time: float = parameter(
        0.0,
        "Warm-up time",
        "How long the output stays off after the start. Datasheets: stabilisation time",
        unit="s",
    )

    @property
    def tilt_count(self) -> int:
        """vertical_fov / vertical_step whole tilts, at least one."""
        return max(1, math.floor(self.vertical_fov / self.vertical_step + 1e-4))

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        problems = self.must_be_smaller("range_min", "range_max", lengths)
        if problems:
            return problems
        if self.model == "PYROELECTRIC":
            return self._wrong_lens()
        if self.rays * self.tilt_count > MAX_RAYS:
            return [
                f"{self.rays} rays times {self.tilt_count} tilts are more than {MAX_RAYS}: "
                "take fewer rays or a larger vertical_step"
            ]
        return []

    def _wrong_lens(self) -> list[str]:
        try:
            zones = LENSES[self.lens].zones
            if self.lens_table is not None:
                zones = read_table(self.lens_table)
        except LensError as error:
            return [str(error)]
        if self.zone_rays * len(zones) > MAX_RAYS:
            return [
                f"{self.zone_rays} rays in each of {len(zones)} zones are more than {MAX_RAYS}: "
                "take fewer rays a zone"
            ]
        return []


# One a set of parameters; without it 2.5 ms an update.
@lru_cache(maxsize=256)
def _local_directions(rays: int, fov: float, step: float, tilts: int) -> Array:
    """Unit vectors (tilts, rays, 3) in the sensor's frame; see `fan_directions`."""
    spacing = fov / (rays - 1) if rays > 1 else 0.0
    start = -fov / 2 if rays > 1 else 0.0
    out = np.empty((tilts, rays, 3))
    for k in range(tilts):
        sin_tilt, cos_tilt = math.sin(k * step), math.cos(k * step)
        for i in range(rays):
            azimuth = start + i * spacing
            ahead = math.cos(azimuth)
            out[k, i] = (-math.sin(azimuth), -ahead * sin_tilt, -ahead * cos_tilt)
    out.flags.writeable = False
    return out


def fan_directions(parameters: PirParameters) -> Array:
    """Ray directions (tilts, rays, 3), unit vectors in the sensor's frame (looks along −Z, +Y up).

    Ray i of n has azimuth −h/2 + i·h/(n−1), counter-clockwise seen from +Y; tilt k turns the
    whole fan by k·vertical_step about X, from −Z towards −Y. A single ray looks straight ahead.
    """
    return _local_directions(
        parameters.rays, parameters.horizontal_fov, parameters.vertical_step, parameters.tilt_count
    )


class _AimedRays(NamedTuple):
    """Rays of one bundle in the world, kept while parameters and pose stay the same objects."""

    parameters: PirParameters
    pose: Pose
    origins: Array
    directions: Array
    reach: Array


class _LastSeen(NamedTuple):
    """What a bundle's rays met last: their ranges, and what was made of them for its first tilt."""

    rays: _AimedRays
    ranges: Array
    scan: Array


class RangeScan(Model):
    """The state of one detector: the last scan at each tilt, and its output stage."""

    def __init__(self) -> None:
        self._previous: dict[int, Array] = {}
        self._output = OutputTiming()
        self._aimed: dict[int, _AimedRays] = {}
        self._last: dict[int, _LastSeen] = {}

    def sense(self, parameters: PirParameters, updates: Updates) -> Readings:
        fan = fan_directions(parameters)
        n = len(updates)
        change, tilt = np.zeros(n), np.zeros(n, np.intp)
        if parameters.sweep == "ALL":
            found = self._changes(parameters, updates, 0, range(len(fan)), np.arange(n))
            tilt = found.argmax(axis=1)
            change = found[np.arange(n), tilt]
            tilt[change <= parameters.threshold] = 0
        else:
            tilt = updates.numbers % len(fan)
            for one in np.unique(tilt).tolist():
                which = np.flatnonzero(tilt == one)
                scans = range(one, one + 1)
                change[which] = self._changes(parameters, updates, one, scans, which)[:, 0]
        angle = np.asarray(tilt * parameters.vertical_step, np.float64)
        moved = self._output.run(
            updates.times,
            change > parameters.threshold,
            parameters.hold_time,
            parameters.blocking_time,
            parameters.warm_up_time,
            parameters.retrigger,
        )
        return Readings(moved, angle, {"angle_rad": angle, "moved": moved, "signal": None})

    def _changes(
        self, parameters: PirParameters, updates: Updates, bundle: int, tilts: range, which: Index
    ) -> Array:
        """By update in `which` (k,) and tilt, (k, tilts): the largest |range − range of the
        previous scan at that tilt|, 0 at the first. Ranges are in metres, within range_min …
        range_max."""
        rays = self._aim(parameters, updates.pose, bundle, tilts)
        seen = updates.ask(RAYS, bundle, rays.origins, rays.directions, rays.reach, which=which)
        change = np.zeros((len(which), len(tilts)))
        last, newest = self._last.get(bundle), seen.table[-1]
        if last is not None and len(seen.table) == 1 and not parameters.noise_sigma:
            same = last.rays is rays and last.ranges is newest and not newest.flags.writeable
            if same and self._previous.get(tilts.start) is last.scan:
                return change
        rows, ranges = seen.rows, np.asarray(seen.table)
        # What meets nothing reads range_max itself, not what rounding makes of the sum.
        ranges = np.where(ranges >= rays.reach, parameters.range_max, ranges + parameters.range_min)
        if parameters.noise_sigma > 0.0:
            numbers = updates.numbers[which].tolist()
            size = ranges.shape[1]
            noise = [updates.noise(k).normal(0.0, parameters.noise_sigma, size) for k in numbers]
            ranges, rows = ranges[rows] + noise, np.arange(len(which))
        ranges = np.minimum(np.maximum(ranges, parameters.range_min), parameters.range_max)
        scans = ranges.reshape(len(ranges), len(tilts), -1)
        other = np.flatnonzero(rows[1:] != rows[:-1]) + 1
        change[other] = np.abs(scans[rows[other]] - scans[rows[other - 1]]).max(axis=2)
        scan = list(scans[rows[-1]])
        for i, one in enumerate(tilts):
            before, first = self._previous.get(one), scans[rows[0], i]
            if before is not None and before.shape == first.shape:
                change[0, i] = np.abs(first - before).max()
            self._previous[one] = scan[i]
        self._last[bundle] = _LastSeen(rays, newest, scan[0])
        return change

    def _aim(self, parameters: PirParameters, pose: Pose, bundle: int, tilts: range) -> _AimedRays:
        known = self._aimed.get(bundle)
        if known is None or known.parameters is not parameters or known.pose is not pose:
            fan = fan_directions(parameters)[tilts.start : tilts.stop]
            directions = fan.reshape(-1, 3) @ pose.axes.T
            origins = pose.origin + directions * parameters.range_min
            reach = np.full(len(directions), parameters.range_max - parameters.range_min)
            known = _AimedRays(parameters, pose, origins, directions, reach)
            self._aimed[bundle] = known
        return known
