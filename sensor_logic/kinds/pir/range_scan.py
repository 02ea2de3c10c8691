# SPDX-License-Identifier: GPL-3.0-or-later
"""Passive infrared motion detector (PIR): the parameters of both models, and the range scan.

The range scan is the model of the thesis. It casts a fan of rays at each update. From update to
update, the fan is tilted further below the horizon, and then starts at the horizon again. Each scan
is compared with the previous scan at the same tilt. A range that changed by more than the threshold
means movement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ...kind import RAYS
from ...logs.error import InputError
from ...logs.wording import METRES, Lengths
from ...model import Array, Index, Model, PerPose, Pose, Readings, Updates
from ...parameters import Choice, Parameters, parameter
from ...physics import OutputTiming
from .lenses import LENSES, read_table
from .scan_evidence import Scan, ScanEvidence, stacked

THESIS = "range scan of the Gazebo plugin from the thesis behind this extension"
CHOSEN = "chosen: pass bands are 0.1 to 10 Hz (vendors' notes)"
MAX_RAYS = 100_000
SCAN: dict[str, Any] = {"used_when": (("model", "RANGE_SCAN"),)}
PYRO: dict[str, Any] = {"used_when": (("model", "PYROELECTRIC"),)}


@dataclass(frozen=True)
class PirParameters(Parameters):
    """The parameters of a motion detector, for both models."""

    model: str = parameter(
        "RANGE_SCAN",
        "Model",
        "How motion is detected",
        choices=(
            Choice("RANGE_SCAN", "Range scan", "Compares the ranges of a fan of rays", 0),
            Choice("PYROELECTRIC", "Pyroelectric", "Warm objects that move between zones", 1),
        ),
    )
    lens: str = parameter(
        "THREE_TIERS",
        "Lens",
        "The lens with its zones. A preset also sets the product's detection distance",
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
        "Text of this blend file with a row for each zone, used instead of the lens: azimuth, "
        "elevation, width, height (degrees), polarity (+ or -), gain",
        pointer="Text",
        **PYRO,
    )
    lens_blur: float = parameter(
        0.0,
        "Lens blur",
        "Angle by which the lens blurs the edges of its zones (standard deviation). Blur weakens "
        "movements that are small against a zone. 0: sharp edges",
        unit="rad",
        maximum=math.radians(10),
        short="Blur",
        **PYRO,
    )
    zone_rays: int = parameter(
        12,
        "Rays a zone",
        "Rays in each zone (one element behind one lenslet). More rays resolve small and distant "
        "objects better and take more time",
        minimum=1,
        maximum=1000,
        **PYRO,
    )
    horizontal_fov: float = parameter(
        math.radians(120),
        "Horizontal field of view",
        "Horizontal angle from the first to the last ray of the fan. Datasheets: horizontal "
        "detection angle",
        unit="rad",
        maximum=2 * math.pi,
        source=THESIS,
        short="Horizontal",
        **SCAN,
    )
    rays: int = parameter(
        120,
        "Rays",
        "Rays in the fan. More rays detect smaller movements and take more time",
        minimum=1,
        maximum=MAX_RAYS,
        source=THESIS,
        **SCAN,
    )
    range_min: float = parameter(
        0.05, "Range min", "Surfaces nearer than this are not detected", unit="m", source=THESIS
    )
    range_max: float = parameter(
        4.0,
        "Range max",
        "Reading of a ray that hits nothing nearer. For a pyroelectric detector: the distance at "
        "which it just detects the standard target. Datasheets: detection distance",
        other_labels=((PYRO["used_when"], "Detection distance", "Detection"),),
        unit="m",
        positive=True,
        source=THESIS,
    )
    vertical_fov: float = parameter(
        math.radians(90),
        "Vertical field of view",
        "Angle below the sensor's horizon that the tilts cover. "
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
            Choice("SAWTOOTH", "Saw-tooth", "One tilt at each update, in turn", 0),
            Choice("ALL", "All tilts", "Every tilt at every update: detects sooner", 1),
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
    target: str = parameter(
        "PLATE",
        "Standard target",
        "What is just detected at the detection distance when it passes at 1 m/s",
        choices=(
            Choice("PLATE", "Plate", "0.7 m by 0.25 m, as in Panasonic's data sheets", 0),
            Choice("PERSON", "Person", "Upright, 1.7 m by 0.4 m", 1),
        ),
        short="Target",
        **PYRO,
    )
    target_contrast: float = parameter(
        4.0,
        "Target contrast",
        "How much warmer than the room the standard target is. Clothes are about 3 K warmer than a "
        "room of 27 °C. Datasheets: temperature difference",
        unit="K",
        positive=True,
        source="Panasonic PaPIRs data sheets",
        short="Contrast",
        **PYRO,
    )
    signal_noise: float = parameter(
        0.0,
        "Signal noise",
        "Standard deviation of the noise on the signal (Gaussian), relative to the threshold",
        **PYRO,
    )
    thermal_time: float = parameter(
        0.15,
        "Thermal time constant",
        "Time in which the elements warm up. A longer time slows the signal",
        unit="s",
        positive=True,
        source=CHOSEN,
        short="Thermal",
        **PYRO,
    )
    electrical_time: float = parameter(
        1.0,
        "Electrical time constant",
        "Time in which the elements lose their charge. A shorter time suppresses slow movement",
        unit="s",
        positive=True,
        source=CHOSEN,
        short="Electrical",
        **PYRO,
    )
    low_cut: float = parameter(
        0.3,
        "Low cut",
        "Lowest frequency that the amplifier passes",
        unit="Hz",
        positive=True,
        source=CHOSEN,
        **PYRO,
    )
    high_cut: float = parameter(
        8.0,
        "High cut",
        "Highest frequency that the amplifier passes",
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
        "Movement during the hold time restarts the hold time. Datasheets: repeatable trigger (H)",
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
    blanking_time: float = parameter(
        0.0,
        "Radio blanking",
        "How long a wireless detector ignores movement after each message: the radio would disturb "
        "its elements",
        unit="s",
        short="Blanking",
        **PYRO,
    )
    message_delay: float = parameter(
        0.0,
        "Message delay",
        "Mean time until a message is received (exponential). Events have the time of arrival. "
        "0: wired, events have the time of the update",
        unit="s",
        short="Delay",
        **PYRO,
    )

    @property
    def is_wireless(self) -> bool:
        """Whether the output is sent in radio messages, each of which can be delayed."""
        return self.blanking_time > 0.0 or self.message_delay > 0.0

    @property
    def tilt_count(self) -> int:
        """The number of tilts: vertical_fov / vertical_step, rounded down, at least one."""
        return max(1, math.floor(self.vertical_fov / self.vertical_step + 1e-4))

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return sentences about parameters of the selected model that contradict each other."""
        problems = self.must_be_smaller("range_min", "range_max", lengths)
        if problems:
            return problems
        if self.model == "PYROELECTRIC":
            return self._wrong_lens()
        if self.rays * self.tilt_count > MAX_RAYS:
            return [
                f"{self.rays} rays times {self.tilt_count} tilts are more than {MAX_RAYS}: set "
                "fewer rays or a larger vertical_step"
            ]
        return []

    def _wrong_lens(self) -> list[str]:
        try:
            zones = LENSES[self.lens].zones
            if self.lens_table is not None:
                zones = read_table(self.lens_table)
        except InputError as error:
            return [str(error)]
        if self.zone_rays * len(zones) > MAX_RAYS:
            return [
                f"{self.zone_rays} rays in each of {len(zones)} zones are more than {MAX_RAYS}: "
                "set fewer rays per zone"
            ]
        return []


# Keyed by the parameters: without the cache, each update takes 2.5 ms more.
@lru_cache(maxsize=256)
def _local_directions(rays: int, fov: float, step: float, tilts: int) -> Array:
    """Return unit vectors (tilts, rays, 3) in the sensor's frame; see `fan_directions`."""
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
    """Return the ray directions (tilts, rays, 3), unit vectors in the sensor's frame.

    The sensor looks along −Z, with +Y up. With h the horizontal field of view, ray i of n has the
    azimuth −h/2 + i·h/(n−1), counter-clockwise seen from +Y. A single ray looks straight ahead.
    Tilt k rotates the fan by k·vertical_step about X, from −Z towards −Y.
    """
    return _local_directions(
        parameters.rays, parameters.horizontal_fov, parameters.vertical_step, parameters.tilt_count
    )


class _FanRays(NamedTuple):
    """World-space rays of some tilts: origins (n, 3), directions (n, 3), lengths (n,) in m."""

    origins: Array
    directions: Array
    reach: Array


class RangeScan(Model):
    """Model of one range scan. Its state is the last scan at each tilt, and its output timing."""

    def __init__(self) -> None:
        self._previous: dict[int, Scan] = {}
        self._output = OutputTiming()
        self._rays: dict[range, PerPose[PirParameters, _FanRays]] = {}
        # The ranges (n,) of each bundle at the last update; cleared when the parameters change.
        self._last: dict[int, Array] = {}
        self._parameters: PirParameters | None = None

    def sense(self, parameters: PirParameters, updates: Updates) -> Readings:
        """Return the readings; `updates` must follow the updates of the previous call."""
        if parameters != self._parameters:
            self._parameters, self._last = parameters, {}
        fan = fan_directions(parameters)
        evidence = ScanEvidence(updates, parameters.threshold)
        n = len(updates)
        change, tilt = np.zeros(n), np.zeros(n, np.intp)
        if parameters.sweep == "ALL":
            found = self._changes(parameters, updates, 0, range(len(fan)), np.arange(n), evidence)
            tilt = found.argmax(axis=1)
            change = found[np.arange(n), tilt]
            tilt[change <= parameters.threshold] = 0
        else:
            tilt = updates.numbers % len(fan)
            for one in sorted(set(tilt.tolist())):
                indices = np.flatnonzero(tilt == one)
                scans = range(one, one + 1)
                found = self._changes(parameters, updates, one, scans, indices, evidence)
                change[indices] = found[:, 0]
        angle = np.asarray(tilt * parameters.vertical_step, np.float64)
        moved = self._output.run(
            updates.times,
            change > parameters.threshold,
            parameters.hold_time,
            parameters.blocking_time,
            parameters.warm_up_time,
            parameters.retrigger,
        )
        fields = {"angle_rad": angle, "moved": moved, "signal": None}
        return Readings(moved, angle, fields, evidence=evidence.columns)

    def _changes(
        self,
        parameters: PirParameters,
        updates: Updates,
        bundle: int,
        tilts: range,
        indices: Index,
        evidence: ScanEvidence,
    ) -> Array:
        """Return the largest change of a range since the last scan at a tilt: (k, tilts) in m.

        The change is 0 if there was no scan at that tilt. Ranges are limited to range_min …
        range_max. `indices` (k,) are those of the updates to scan at. `bundle` is the number by
        which the query `RAYS` identifies rays that are cast together. The evidence of these updates
        is added to `evidence`.
        """
        rays = self._rays.setdefault(tilts, PerPose(partial(_fan_rays, tilts)))(
            parameters, updates.pose
        )
        answers = updates.ask(RAYS, bundle, *rays, indices=indices)
        change = np.zeros((len(indices), len(tilts)))
        last, newest = self._last.get(bundle), answers.table[-1]
        stays = len(answers.table) == 1 and last is not None and np.array_equal(last, newest)
        known = [self._previous.get(one) for one in tilts]
        if stays and not parameters.noise_sigma:
            old = stacked(known)
            assert old is not None
            first, last = updates.numbers[indices[[0, -1]]].tolist()
            evidence.add(indices, old, replace(old, number=first, pose=updates.pose), tilts)
            self._keep(tilts, replace(old, number=last, pose=updates.pose))
            return change
        self._last[bundle] = np.array(newest)
        rows, ranges = answers.rows, np.asarray(answers.table)
        # A ray without a hit reads exactly range_max, without the rounding error of a sum.
        ranges = np.where(ranges >= rays.reach, parameters.range_max, ranges + parameters.range_min)
        clean = ranges.reshape(len(ranges), len(tilts), -1)
        if parameters.noise_sigma > 0.0:
            numbers = updates.numbers[indices].tolist()
            size = ranges.shape[1]
            noise = [updates.noise(k).normal(0.0, parameters.noise_sigma, size) for k in numbers]
            ranges, rows = ranges[rows] + noise, np.arange(len(indices))
        ranges = np.minimum(np.maximum(ranges, parameters.range_min), parameters.range_max)
        scans = ranges.reshape(len(ranges), len(tilts), -1)
        other = np.flatnonzero(rows[1:] != rows[:-1]) + 1
        change[other] = np.abs(scans[rows[other]] - scans[rows[other - 1]]).max(axis=2)

        def scan(i: int) -> Scan:
            number, now = int(updates.numbers[indices[i]]), scans[rows[i]]
            solids = np.zeros(now.shape, np.intp)
            if answers.hits is not None:
                solids = answers.hits[i].solids.reshape(now.shape)
            return Scan(number, updates.pose, now, clean[answers.rows[i]], solids)

        first = scan(0)
        old = stacked(known, first)
        if old is not None:
            change[0] = np.abs(first.ranges - old.ranges).max(axis=1)
        ends = [*other.tolist(), len(indices)]
        for begin, end in pairwise([0, *ends]):
            if begin:
                first, old = scan(begin), scan(begin - 1)
            evidence.add(indices[begin:end], old, first, tilts)
        self._keep(tilts, scan(len(indices) - 1))
        return change

    def _keep(self, tilts: range, scan: Scan) -> None:
        """Keep a scan of some tilts, with which the next scans at these tilts are compared."""
        for i, tilt in enumerate(tilts):
            self._previous[tilt] = scan if len(tilts) == 1 else scan.of_tilt(i)


def _fan_rays(tilts: range, parameters: PirParameters, pose: Pose) -> _FanRays:
    fan = fan_directions(parameters)[tilts.start : tilts.stop]
    directions = fan.reshape(-1, 3) @ pose.axes.T
    origins = pose.origin + directions * parameters.range_min
    reach = np.full(len(directions), parameters.range_max - parameters.range_min)
    return _FanRays(origins, directions, reach)
