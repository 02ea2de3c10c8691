# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance sensor: time of flight or ultrasound, in one zone or many.

- Model: `DistanceSensor`, with its parameters and presets in this file.
- Scene: rays by angen_addon/scene/rays/caster.py; the reflectance at their hits by `Reflectance` in
  angen_addon/scene/surfaces/reflectance.py.
- Window: angen_addon/kinds/distance.py.
- Physics: docs/distance.md.
- Tests: tests/pure/test_distance_and_contact.py, tests/blender/test_distance_contact.py.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..evidence import Cause, measured_cause, rows_of, rows_text
from ..geometry.pixels import all_cells, pixel_directions
from ..kind import RAYS, REFLECTANCE, Field, Kind, Preset, parts_with
from ..logs.wording import METRES, Advice, Lengths
from ..model import Array, Index, Model, PerPose, Pose, Reading, Update
from ..parameters import Choice, Parameters, parameter

# Parameters of the distance sensor.

# The reflectance of the white and the grey target in data sheets, measured at 940 nm.
WHITE, GREY = 0.88, 0.17
MOST_ZONES = 16
FIXED: dict[str, Any] = {"used_when": (("target", "FIXED"),)}
SEVERAL = "VL53L5CX data sheet DS13754: 8 × 8 zones"


@dataclass(frozen=True)
class DistanceParameters(Parameters):
    """The parameters of a distance sensor."""

    threshold: float = parameter(
        1.0, "Threshold", "The output is on while a target is closer than this", unit="m"
    )
    hysteresis: float = parameter(
        0.0,
        "Hysteresis",
        "The output goes off again when the distance exceeds the threshold by this much",
        unit="m",
    )
    report_step: float = parameter(
        0.05,
        "Report step",
        "Least change of the distance that the event log records",
        unit="m",
        short="Report by",
    )
    range_min: float = parameter(0.04, "Range min", "Closer targets read this distance", unit="m")
    range_max: float = parameter(
        3.6,
        "Range max",
        "Greatest distance of a white target that fills a zone; the reading without a target",
        unit="m",
        positive=True,
    )
    range_grey: float = parameter(
        1.7,
        "Range of grey",
        "Greatest distance of a target that reflects 17 %; ultrasound: the same as of a white one",
        unit="m",
        positive=True,
        short="Of grey",
    )
    target: str = parameter(
        "MATERIAL",
        "Target",
        "How the reflectance of targets is chosen",
        choices=(
            Choice("MATERIAL", "Materials", "From the colours of their materials", 0),
            Choice("FIXED", "Fixed", "One value for all targets", 1),
        ),
    )
    reflectance: float = parameter(
        WHITE, "Reflectance", "Share that targets reflect", minimum=0.01, maximum=1.0, **FIXED
    )
    horizontal_fov: float = parameter(
        math.radians(19.3),
        "Horizontal FOV",
        "Horizontal angle of all zones together",
        unit="rad",
        maximum=math.radians(120),
        short="FOV Across",
    )
    vertical_fov: float = parameter(
        math.radians(19.3),
        "Vertical FOV",
        "Vertical angle of all zones together",
        unit="rad",
        maximum=math.radians(120),
        short="FOV Up",
    )
    zones_across: int = parameter(
        1, "Zones across", "Zones in a row", minimum=1, maximum=MOST_ZONES, source=SEVERAL
    )
    zones_up: int = parameter(1, "Zones up", "Rows of zones", minimum=1, maximum=MOST_ZONES)
    rays: int = parameter(
        5,
        "Rays",
        "Rays of each zone horizontally, and as many vertically",
        minimum=1,
        maximum=32,
    )
    echo: str = parameter(
        "MEAN",
        "Echo",
        "Distance that a zone reads if its rays hit several targets",
        choices=(
            Choice("MEAN", "Mean", "The mean, weighted by the signal that each returns", 0),
            Choice("STRONGEST", "Strongest", "The target that returns the strongest signal", 1),
            Choice("FIRST", "First", "The nearest at which enough signal has returned", 2),
        ),
    )
    separation: float = parameter(
        0.6,
        "Separation",
        "Targets closer together than this give one echo",
        unit="m",
        used_when=(("echo", "STRONGEST"),),
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of a reading at distance 0", unit="m"
    )
    noise_growth: float = parameter(
        0.0,
        "Noise growth",
        "Growth of the standard deviation with each metre of distance, in metres",
    )
    offset_sigma: float = parameter(
        0.0,
        "Offset",
        "Standard deviation, from device to device, of a constant error of all readings",
        unit="m",
    )
    offset_growth: float = parameter(
        0.0,
        "Offset growth",
        "Standard deviation, from device to device, of an error for each metre of distance, in "
        "metres",
    )
    resolution: float = parameter(
        0.0, "Resolution", "Readings are multiples of this; 0: exact", unit="m"
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return sentences about ranges that contradict each other."""
        problems = self.must_be_smaller("range_min", "range_max", lengths)
        if problems:
            return problems
        if self.range_grey > self.range_max:
            return [
                f"range_grey ({lengths.typed(self.range_grey)}) is beyond range_max "
                f"({lengths.typed(self.range_max)}): a white target must be seen at least as far "
                "as a grey one"
            ]
        return []

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if the output never switches on, or hardly ever switches off."""
        threshold, most = lengths.typed(self.threshold), lengths.typed(self.range_max)
        if self.threshold <= self.range_min:
            return [
                Advice(
                    f"The threshold ({threshold}) is not above the range min "
                    f"({lengths.typed(self.range_min)}), so the output near never goes on",
                    "Raise the threshold",
                )
            ]
        if self.threshold + self.hysteresis <= self.range_max:
            return []
        added = f" plus the hysteresis ({lengths.typed(self.hysteresis)})" * bool(self.hysteresis)
        return [
            Advice(
                f"The threshold ({threshold}){added} is beyond the range max ({most}), so the "
                "output near goes off only when no zone detects a target",
                "Lower the threshold or the hysteresis",
            )
        ]


# The model: the time until light or sound returns, in each zone along a bundle of rays.
#
# The returned signal of a target at distance r falls with r². A target of reflectance ρ that fills
# a zone is detected up to R(ρ). The k rays of a zone add up to a visibility of Σ (R(ρ)/r)²/k.
# Targets with a visibility below 1 are not detected. See docs/distance.md.

# The least detected visibility; below 1, so that rounding cannot hide a target at range_max.
JUST_SEEN = 1.0 - 1e-9


class DistanceSensor(Model):
    """Model of one distance sensor.

    Its state is whether a target was near at the last update, on which the hysteresis depends.
    """

    def __init__(self) -> None:
        self._near = False
        self._rays = PerPose(zone_rays)
        self._device: Array | None = None
        # The solids hit at the last update, the nearest zone, and the objects in it as a text.
        self._hits: tuple[Index | None, int, str] = None, -1, ""

    def update(self, parameters: DistanceParameters, update: Update) -> Reading:
        """Return the nearest distance, whether a target is near, and the distance of each zone."""
        rays = self._rays(parameters, update.pose)
        ranges = update.ask(RAYS, 0, *rays)
        if parameters.target == "MATERIAL":
            reflectance = update.ask(REFLECTANCE, 0, *rays)
        else:
            reflectance = np.full(len(ranges), parameters.reflectance)
        hit = ranges < rays[2]
        shape = parameters.zones_across * parameters.zones_up, -1
        zones = zone_distances(
            parameters, *(a.reshape(shape) for a in (ranges, np.where(hit, reflectance, 0.0)))
        )
        seen = np.flatnonzero(np.isfinite(zones))
        if len(seen):
            if self._device is None:
                self._device = update.device_noise().normal(size=2)
            noise = _noise(parameters, update, len(zones))
            zones[seen] = _with_noise(parameters, zones[seen], noise[seen], self._device)
        nearest = float(zones[seen].min()) if len(seen) else parameters.range_max
        over = parameters.hysteresis if self._near else 0.0
        self._near = len(seen) > 0 and nearest < parameters.threshold + over
        zones_m = ";".join(f"{z:.4g}" if math.isfinite(z) else "" for z in zones.tolist())
        fields = {"distance_m": nearest, "near": self._near, "zones_m": zones_m}
        # Of zones that are equally near, but for rounding errors, the first.
        zone = int(np.argmin(np.round(zones, 12))) if len(seen) else -1
        solids = update.solids_hit(RAYS, 0, *rays)
        if zone < 0 or solids is None:
            self._hits = None, zone, ""
        elif self._hits[0] is not solids or self._hits[1] != zone:
            each = solids.reshape(shape)[zone].tolist()
            names = Counter(name for number in each if (name := update.name_of(number)))
            self._hits = solids, zone, rows_text(names.most_common())
        evidence = {"zone": zone, "hits": self._hits[2]}
        return Reading(self._near, nearest, fields, evidence)


def zone_rays(parameters: DistanceParameters, pose: Pose) -> tuple[Array, Array, Array]:
    """Return the rays of all zones: origins (n, 3), unit directions (n, 3), lengths (n,) in m.

    Zones are listed by row, from the upper left as seen from the sensor. The rays in each zone are
    listed in the same way.
    """
    directions = pixel_directions(
        pose.axes,
        (parameters.horizontal_fov, parameters.vertical_fov),
        (parameters.zones_across, parameters.zones_up),
        parameters.rays,
        all_cells(parameters.rays),
    )
    origins = np.broadcast_to(pose.origin, directions.shape)
    return origins, directions, np.full(len(directions), reach(parameters))


def reach(parameters: DistanceParameters) -> float:
    """Return the greatest distance in m at which the sensor detects any target."""
    return max(parameters.range_max, float(range_of(parameters, np.ones(1))[0]))


def range_of(parameters: DistanceParameters, reflectance: Array) -> Array:
    """Return the greatest distance in m at which a target that fills a zone is detected.

    This distance is a power of the reflectance, fitted to the data sheet's values for white and
    grey targets. For an ideal receiver in the dark, the exponent is ½.
    """
    power = math.log(parameters.range_max / parameters.range_grey) / math.log(WHITE / GREY)
    found: Array = parameters.range_max * (reflectance / WHITE) ** power
    return np.where(reflectance > 0.0, found, 0.0)


def zone_distances(parameters: DistanceParameters, ranges: Array, reflectance: Array) -> Array:
    """Return the distance (z,) in m that each zone reads, without noise.

    The distance is inf if the zone detects no target. Each zone has k rays, with `ranges` (z, k) in
    m. `reflectance` (z, k) is the reflectance of the surfaces that the rays hit, 0 to 1.
    """
    near = np.maximum(ranges, max(parameters.range_min, 1e-6))
    visible = (range_of(parameters, reflectance) / near) ** 2 / ranges.shape[1]
    if parameters.echo == "MEAN":
        return _weighted(near, visible, np.ones_like(near, bool))
    order = np.argsort(near, axis=1)
    near, visible = (np.take_along_axis(a, order, axis=1) for a in (near, visible))
    if parameters.echo == "FIRST":
        # Each nearer target adds to the returned wave.
        enough = np.cumsum(visible, axis=1) >= JUST_SEEN
        first = np.take_along_axis(near, np.argmax(enough, axis=1)[:, None], axis=1)[:, 0]
        return np.where(enough.any(axis=1), first, np.inf)
    apart = np.diff(near, axis=1, prepend=near[:, :1]) > parameters.separation
    group = np.cumsum(apart, axis=1)
    best, strength = np.full(len(near), np.inf), np.zeros(len(near))
    for number in range(int(group.max(initial=0)) + 1):
        is_member = group == number
        power = np.where(is_member, visible, 0.0).sum(axis=1)
        better = power > strength
        best[better] = _weighted(near, visible, is_member)[better]
        strength = np.maximum(strength, power)
    return best


def _weighted(ranges: Array, visible: Array, which: NDArray[np.bool_]) -> Array:
    """Return the mean range (z,) of each zone's rays, weighted by their visibility.

    Only rays in the mask `which` (z, k) count. The mean is inf if their visibilities add up to less
    than `JUST_SEEN`.
    """
    weight = np.where(which, visible, 0.0)
    total = weight.sum(axis=1)
    mean = (weight * ranges).sum(axis=1) / np.maximum(total, 1e-300)
    return np.where(total >= JUST_SEEN, mean, np.inf)


def sigma(parameters: DistanceParameters, distance: ArrayLike) -> Array:
    """Return the standard deviation in m of readings at `distance` (m).

    It combines two independent kinds of noise. One is constant, and the other is proportional to
    the distance.
    """
    found: Array = np.hypot(
        parameters.noise_sigma, parameters.noise_growth * np.asarray(distance, np.float64)
    )
    return found


def _noise(parameters: DistanceParameters, update: Update, zones: int) -> Array:
    """Return a standard normal number for each zone, or zeros if the sensor has no noise."""
    if parameters.noise_sigma == 0.0 and parameters.noise_growth == 0.0:
        return np.zeros(zones)
    return update.noise().normal(size=zones)


def _with_noise(
    parameters: DistanceParameters, distance: Array, noise: Array, device: Array
) -> Array:
    """Return distances in m with errors, rounded to the resolution and limited to the range.

    `noise` (z,) has a standard normal number for each distance (z,). `device` (2,) has those of the
    device: of its offset, and of the growth of its offset.
    """
    offset = device[0] * parameters.offset_sigma
    growth = device[1] * parameters.offset_growth
    found: Array = distance * (1.0 + growth) + offset + noise * sigma(parameters, distance)
    if parameters.resolution > 0.0:
        found = np.round(found / parameters.resolution) * parameters.resolution
    return np.clip(found, parameters.range_min, parameters.range_max)


# Presets of commercial distance sensors.
#
# Data sheets give bounds of a reading's error. It is mostly the device's own offset: readings of a
# still target differ far less. A third of the bound is used as the standard deviation of the
# offset.
MEASURED_NOISE = (
    "Measured: noise of 2.1 mm, of a VL53L0X at 76 mm in 5 h at 50 Hz "
    "(tomisuarez2/TimeOfFlightCalibration)"
)


def _side(diagonal: float) -> float:
    """Return the side in rad of a square field of view with a diagonal in degrees."""
    return 2.0 * math.atan(math.tan(math.radians(diagonal) / 2.0) / math.sqrt(2.0))


_part = parts_with(
    target="MATERIAL",
    zones_across=1,
    zones_up=1,
    rays=5,
    echo="MEAN",
    noise_sigma=0.0,
    noise_growth=0.0,
    offset_sigma=0.0,
    offset_growth=0.0,
    resolution=0.001,
)
PRESETS: tuple[Preset, ...] = (
    _part(
        "VL53L1X",
        "ST VL53L1X (long distance mode)",
        "ST, VL53L1X data sheet DocID031281 (27° from corner to corner) and the user's manual of "
        "STEVAL-BCN002V1, p. 21: in the dark 1.7 to 3.6 m for targets of 17 to 88 %, 40 mm at "
        f"least, ±20 mm. {MEASURED_NOISE}. Assumed: the ±20 mm are three standard deviations of "
        "the offset of a device; the noise is that of the VL53L0X and grows by 2 mm for each metre",
        range_min=0.04,
        range_max=3.6,
        range_grey=1.7,
        horizontal_fov=_side(27.0),
        vertical_fov=_side(27.0),
        noise_sigma=0.0021,
        noise_growth=0.002,
        offset_sigma=0.02 / 3,
    ),
    _part(
        "VL53L0X",
        "ST VL53L0X (long range mode, 33 ms)",
        "ST, VL53L0X data sheet DocID029104, tables 11, 12 and 14: 25°, indoors 2 m white and "
        "0.8 m grey, offset below 3 % if calibrated at 10 cm, accuracy of 4 % at 1.2 m. "
        f"{MEASURED_NOISE}. Assumed: offset and accuracy are bounds, three standard deviations; "
        "25° are from corner to corner; 30 mm at least",
        range_min=0.03,
        range_max=2.0,
        range_grey=0.8,
        horizontal_fov=_side(25.0),
        vertical_fov=_side(25.0),
        noise_sigma=0.0018,
        noise_growth=0.04 / 3,
        offset_growth=0.03 / 3,
    ),
    _part(
        "VL53L5CX",
        "ST VL53L5CX (8 × 8 zones, 15 Hz)",
        "ST, VL53L5CX data sheet DS13754, tables 2 and 18: 45° × 45°, inner zones in the dark "
        "3.5 m white and 1.3 m grey; the ±11 mm and ±5 % of the VL53L8CX (DS14161). "
        f"{MEASURED_NOISE}. Assumed: ±11 mm and ±5 % are three standard deviations of the offset "
        "of a device; the noise is that of the VL53L0X and grows by 5 mm for each metre",
        range_min=0.02,
        range_max=3.5,
        range_grey=1.3,
        horizontal_fov=math.radians(45.0),
        vertical_fov=math.radians(45.0),
        zones_across=8,
        zones_up=8,
        rays=3,
        echo="STRONGEST",
        noise_sigma=0.0021,
        noise_growth=0.005,
        offset_sigma=0.011 / 3,
        offset_growth=0.05 / 3,
    ),
    _part(
        "HC_SR04",
        "HC-SR04 (ultrasound)",
        "HC-SR04 data sheet: 2 cm to 4 m, 15°, up to 3 mm; targets reflect sound whatever their "
        "colour. Assumed: its 3 mm are noise as well as resolution; where the first echo is not "
        "enough, the next one counts",
        range_min=0.02,
        range_max=4.0,
        range_grey=4.0,
        horizontal_fov=math.radians(15.0),
        vertical_fov=math.radians(15.0),
        echo="FIRST",
        noise_sigma=0.003,
        resolution=0.003,
    ),
)


DISTANCE = Field(
    "distance_m",
    float,
    "m",
    3,
    step="report_step",
    quantity="distance",
    tip="Distance of the nearest zone",
)
NEAR = Field("near", bool, quantity="proximity", tip="Whether the distance is below the threshold")


def cause(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: what the rays of the nearest zone hit."""
    zone = track.evidence.value("zone", index)
    names = [name for name, _ in rows_of(track.evidence.value("hits", index))]
    return measured_cause(track, index, names, f"zone {zone}" if zone >= 0 else "")


KIND = Kind(
    "DISTANCE",
    5,
    "Distance sensor",
    "Distance sensor: time of flight or ultrasound",
    "DRIVER_DISTANCE",
    "distance",
    10.0,
    "Near",
    "Clear",
    DistanceParameters,
    events=(NEAR, DISTANCE),
    samples=(
        DISTANCE,
        NEAR,
        Field(
            "zones_m",
            str,
            quantity="distances",
            tip="Distance of each zone in m, row by row from the upper left one, with semicolons. "
            "A zone without a target is empty",
        ),
    ),
    evidence=(
        Field("zone", int, tip="Number of the nearest zone, row by row from the upper left one"),
        Field("hits", str, tip="Objects that its rays hit, with their numbers of rays"),
    ),
    cause=cause,
    model=DistanceSensor,
    needs={RAYS: (), REFLECTANCE: (("target", "MATERIAL"),)},
    in_room=True,
    presets=PRESETS,
    part="VL53L1X",
)
