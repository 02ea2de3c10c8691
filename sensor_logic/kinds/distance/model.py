# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance sensor: it measures the time in which its light or sound returns, in each zone along a
bundle of rays.

The returned signal of a target at distance r falls with r²; a target of reflectance ρ that fills a
zone is detected up to R(ρ). Rays of a zone with k rays add up to a visibility of Σ (R(ρ)/r)²/k, and
targets with less than 1 are not detected. See docs/distance.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...kind import RAYS, REFLECTANCE
from ...model import Array, Model, PerPose, Pose, Reading, Update
from .parameters import GREY, WHITE, DistanceParameters

# The least visibility that is detected: rounding must not hide a target exactly at range_max.
JUST_SEEN = 1.0 - 1e-9


class DistanceSensor(Model):
    """One sensor. Its state is whether a target was near, for the hysteresis."""

    def __init__(self) -> None:
        self._near = False
        self._rays = PerPose(zone_rays)

    def update(self, parameters: DistanceParameters, update: Update) -> Reading:
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
            noise = _noise(parameters, update, len(zones))
            zones[seen] = _with_noise(parameters, zones[seen], noise[seen])
        nearest = float(zones[seen].min()) if len(seen) else parameters.range_max
        over = parameters.hysteresis if self._near else 0.0
        self._near = len(seen) > 0 and nearest < parameters.threshold + over
        zones_m = ";".join(f"{z:.4g}" if math.isfinite(z) else "" for z in zones.tolist())
        fields = {"distance_m": nearest, "near": self._near, "zones_m": zones_m}
        return Reading(self._near, nearest, fields)


def zone_rays(parameters: DistanceParameters, pose: Pose) -> tuple[Array, Array, Array]:
    """Origins (n, 3), unit directions (n, 3) and reach (n,) of all rays: zones row by row from the
    upper left one in the sensor's view, and in each zone its rays in the same order. The rays go
    through the middles of equal cells of a plane perpendicular to the axis."""
    k = parameters.rays
    x = _cell_middles(parameters.horizontal_fov, parameters.zones_across, k)
    y = -_cell_middles(parameters.vertical_fov, parameters.zones_up, k)
    zone = np.broadcast_to(
        np.stack(np.broadcast_arrays(x[None, :, None, :], y[:, None, :, None]), axis=-1),
        (parameters.zones_up, parameters.zones_across, k, k, 2),
    ).reshape(-1, 2)
    directions = np.column_stack([zone, np.full(len(zone), -1.0)]) @ pose.axes.T
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    origins = np.broadcast_to(pose.origin, directions.shape)
    return origins, directions, np.full(len(directions), reach(parameters))


def _cell_middles(angle: float, zones: int, rays: int) -> Array:
    """(zones, rays): coordinates at which rays cross a plane at distance 1."""
    cells = zones * rays
    middles = (np.arange(cells) + 0.5) / cells * 2.0 - 1.0
    return (math.tan(angle / 2.0) * middles).reshape(zones, rays)


def reach(parameters: DistanceParameters) -> float:
    """The greatest distance in m at which any target is detected, one of reflectance 1 included."""
    return max(parameters.range_max, float(range_of(parameters, np.ones(1))[0]))


def range_of(parameters: DistanceParameters, reflectance: Array) -> Array:
    """R(ρ) in m: the greatest distance of a target that fills a zone. A power of the reflectance ρ
    through the data sheet's values for white and grey; an ideal receiver in the dark has ½."""
    power = math.log(parameters.range_max / parameters.range_grey) / math.log(WHITE / GREY)
    found: Array = parameters.range_max * (reflectance / WHITE) ** power
    return np.where(reflectance > 0.0, found, 0.0)


def zone_distances(parameters: DistanceParameters, ranges: Array, reflectance: Array) -> Array:
    """The distance (z,) in m of each zone, without noise, from its rays' ranges (z, k) in m and
    reflectances (z, k); inf where no target is detected."""
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
        of_it = group == number
        power = np.where(of_it, visible, 0.0).sum(axis=1)
        better = power > strength
        best[better] = _weighted(near, visible, of_it)[better]
        strength = np.maximum(strength, power)
    return best


def _weighted(near: Array, visible: Array, which: NDArray[np.bool_]) -> Array:
    """(z,): means of the chosen ranges weighted by visibility; inf where their sum is too small."""
    weight = np.where(which, visible, 0.0)
    total = weight.sum(axis=1)
    mean = (weight * near).sum(axis=1) / np.maximum(total, 1e-300)
    return np.where(total >= JUST_SEEN, mean, np.inf)


def sigma(parameters: DistanceParameters, distance: ArrayLike) -> Array:
    """Standard deviation in m of readings at `distance` (m), from two independent noise terms."""
    found: Array = np.hypot(
        parameters.noise_sigma, parameters.noise_growth * np.asarray(distance, np.float64)
    )
    return found


def _noise(parameters: DistanceParameters, update: Update, zones: int) -> Array:
    """(zones,): a random number of variance 1 for each zone, whether or not it detects a target."""
    if parameters.noise_sigma == 0.0 and parameters.noise_growth == 0.0:
        return np.zeros(zones)
    return update.noise().normal(size=zones)


def _with_noise(parameters: DistanceParameters, distance: Array, noise: Array) -> Array:
    """Readings in m: with noise, rounded to the resolution, within range_min … range_max."""
    found = distance + noise * sigma(parameters, distance)
    if parameters.resolution > 0.0:
        found = np.round(found / parameters.resolution) * parameters.resolution
    return np.clip(found, parameters.range_min, parameters.range_max)
