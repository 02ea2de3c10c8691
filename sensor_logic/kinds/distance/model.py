# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance sensor: light or sound that is sent out comes back, in each zone by a bundle of rays.

What a ray meets at a distance r throws back a share that falls with the square of r; a target of
reflectance ρ that fills a zone is seen up to R(ρ). So the visibility of some of a zone's k rays is
the sum of (R(ρ)/r)²/k, and what has less than 1 is not seen. See docs/distance.md.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...kind import RAYS, REFLECTANCE
from ...model import Array, Model, Pose, Reading, Update
from .parameters import GREY, WHITE, DistanceParameters

# Rounding must not hide what stands at the very range max.
JUST_SEEN = 1.0 - 1e-9


class DistanceSensor(Model):
    """One sensor; it knows whether something was near, for the hysteresis."""

    def __init__(self) -> None:
        self._near = False
        self._rays: tuple[DistanceParameters, Pose, tuple[Array, Array, Array]] | None = None

    def update(self, parameters: DistanceParameters, update: Update) -> Reading:
        rays = self._rays_of(parameters, update.pose)
        ranges = update.ask(RAYS, 0, *rays)
        if parameters.target == "MATERIAL":
            reflectance = update.ask(REFLECTANCE, 0, *rays)
        else:
            reflectance = np.full(len(ranges), parameters.reflectance)
        met = ranges < rays[2]
        shape = parameters.zones_across * parameters.zones_up, -1
        zones = zone_distances(
            parameters, *(a.reshape(shape) for a in (ranges, np.where(met, reflectance, 0.0)))
        )
        seen = np.flatnonzero(np.isfinite(zones))
        if len(seen):
            noise = _noise(parameters, update, len(zones))
            zones[seen] = _as_read(parameters, zones[seen], noise[seen])
        nearest = float(zones[seen].min()) if len(seen) else parameters.range_max
        over = parameters.hysteresis if self._near else 0.0
        self._near = nearest < parameters.threshold + over
        told = ";".join(f"{z:.4g}" if math.isfinite(z) else "" for z in zones.tolist())
        fields = {"distance_m": nearest, "near": self._near, "zones_m": told}
        return Reading(self._near, nearest, fields)

    def _rays_of(self, parameters: DistanceParameters, pose: Pose) -> tuple[Array, Array, Array]:
        """The same arrays as long as neither changes."""
        known = self._rays
        if known is None or known[0] is not parameters or known[1] is not pose:
            known = self._rays = parameters, pose, zone_rays(parameters, pose)
        return known[2]


def zone_rays(parameters: DistanceParameters, pose: Pose) -> tuple[Array, Array, Array]:
    """Origins (n, 3), unit directions (n, 3) and reach (n,) of all rays: the zones row by row from
    the upper left one, as the sensor sees it, and those of each zone likewise. They go through the
    middles of equal cells of a plane across the axis."""
    k = parameters.rays
    x = _places(parameters.horizontal_fov, parameters.zones_across, k)
    y = -_places(parameters.vertical_fov, parameters.zones_up, k)
    zone = np.broadcast_to(
        np.stack(np.broadcast_arrays(x[None, :, None, :], y[:, None, :, None]), axis=-1),
        (parameters.zones_up, parameters.zones_across, k, k, 2),
    ).reshape(-1, 2)
    ways = np.column_stack([zone, np.full(len(zone), -1.0)]) @ pose.axes.T
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    origins = np.broadcast_to(pose.origin, ways.shape)
    return origins, ways, np.full(len(ways), reach(parameters))


def _places(angle: float, zones: int, rays: int) -> Array:
    """(zones, rays): where rays go through a plane at a distance of 1."""
    cells = zones * rays
    middles = (np.arange(cells) + 0.5) / cells * 2.0 - 1.0
    return (math.tan(angle / 2.0) * middles).reshape(zones, rays)


def reach(parameters: DistanceParameters) -> float:
    """m: how far anything could be seen, a mirror's reflectance of 1 too."""
    return max(parameters.range_max, float(range_of(parameters, np.ones(1))[0]))


def range_of(parameters: DistanceParameters, reflectance: Array) -> Array:
    """R(ρ) in m: how far targets are seen that fill a zone. A power of the reflectance ρ, through
    what the data sheet tells of white and of grey; of the ideal receiver in the dark it is ½."""
    power = math.log(parameters.range_max / parameters.range_grey) / math.log(WHITE / GREY)
    found: Array = parameters.range_max * (reflectance / WHITE) ** power
    return np.where(reflectance > 0.0, found, 0.0)


def zone_distances(parameters: DistanceParameters, ranges: Array, reflectance: Array) -> Array:
    """(z,) m of each zone, without noise, from what its rays meet (z, k); inf where none is seen.
    A reflectance of 0 throws nothing back."""
    near = np.maximum(ranges, max(parameters.range_min, 1e-6))
    visible = (range_of(parameters, reflectance) / near) ** 2 / ranges.shape[1]
    if parameters.echo == "MEAN":
        return _weighted(near, visible, np.ones_like(near, bool))
    order = np.argsort(near, axis=1)
    near, visible = (np.take_along_axis(a, order, axis=1) for a in (near, visible))
    if parameters.echo == "FIRST":
        # The wave that comes back grows with each thing that throws some of it back.
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
    """(z,): means of the chosen ranges by their visibility; inf where all have too little."""
    weight = np.where(which, visible, 0.0)
    total = weight.sum(axis=1)
    mean = (weight * near).sum(axis=1) / np.maximum(total, 1e-300)
    return np.where(total >= JUST_SEEN, mean, np.inf)


def sigma(parameters: DistanceParameters, distance: ArrayLike) -> Array:
    """m: standard deviation of readings at distances; the two parts do not depend on each other."""
    found: Array = np.hypot(
        parameters.noise_sigma, parameters.noise_growth * np.asarray(distance, np.float64)
    )
    return found


def _noise(parameters: DistanceParameters, update: Update, zones: int) -> Array:
    """(zones,): random numbers of variance 1, one a zone whether it sees anything or not."""
    if parameters.noise_sigma == 0.0 and parameters.noise_growth == 0.0:
        return np.zeros(zones)
    return update.noise().normal(size=zones)


def _as_read(parameters: DistanceParameters, distance: Array, noise: Array) -> Array:
    told = distance + noise * sigma(parameters, distance)
    if parameters.resolution > 0.0:
        told = np.round(told / parameters.resolution) * parameters.resolution
    return np.clip(told, parameters.range_min, parameters.range_max)
