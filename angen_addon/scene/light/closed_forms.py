# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance that one lamp sends to a point, in closed form, and where to look for what shades it.

Every form gives the unshaded irradiance for a power of 1, and points on the lamp with weights that
add up to it: the shaded irradiance is the weight of the points that are seen.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .lamps import Lamp

Array = NDArray[np.float64]
# A lamp's disk or rectangle is looked at in this many points.
POINTS = 16
# One that is smaller than this, in its size over its distance, in one: its edge of shadow is thin.
SMALL = 0.1
CORNERS = 64
FAR = 1e5
TINY = 1e-6


def spread_points(count: int) -> Array:
    """Points (n, 2) that fill the unit square evenly: Roberts's R2 sequence."""
    g = 1.32471795724474602596
    i = np.arange(count) + 0.5
    return np.stack([(0.5 + i / g) % 1.0, (0.5 + i / g**2) % 1.0], axis=1)


def shine(lamp: Lamp, place: Array, normal: Array) -> tuple[Array, Array]:
    """Points (n, 3) to look at and weights (n,): irradiance at a place on a face, power 1."""
    if lamp.type == "SUN":
        return _sun(lamp, place, normal)
    if lamp.type == "AREA":
        return _area(lamp, place, normal)
    return _ball(lamp, place, normal)


def _disk(normal: Array, count: int) -> Array:
    """Points (n, 3) of the unit disk about the origin across a direction."""
    across, along = frame(normal)
    u, v = spread_points(count).T
    r, turn = np.sqrt(u), 2 * math.pi * v
    return np.outer(r * np.cos(turn), across) + np.outer(r * np.sin(turn), along)


def frame(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors across a unit vector and each other."""
    away = np.zeros(3)
    away[int(np.argmin(np.abs(normal)))] = 1.0
    turned = np.cross(normal, away)
    across = np.asarray(turned / np.linalg.norm(turned), np.float64)
    along = np.asarray(np.cross(normal, across), np.float64)
    return across, along


def _sun(lamp: Lamp, place: Array, normal: Array) -> tuple[Array, Array]:
    count = POINTS if lamp.angle > SMALL else 1
    radius = math.tan(min(lamp.angle, math.pi - 1e-3) / 2)
    disk = radius * _disk(lamp.axis, count) if count > 1 else np.zeros((1, 3))
    ways: Array = disk - lamp.axis
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    strength = 1.0 if lamp.normalize else math.pi * math.sin(min(lamp.angle, math.pi) / 2) ** 2
    cosines = ways @ normal
    whole = max(float(-lamp.axis @ normal), 0.0)
    return place + FAR * ways, strength * _scaled(cosines, whole)


def _scaled(cosines: Array, whole: float) -> Array:
    """Weights of equal parts, whose sum is `whole` unless the horizon cuts some off."""
    weights = np.maximum(cosines, 0.0) / len(cosines)
    if (cosines > 0.0).all():
        weights = weights * (whole / weights.sum())
    return weights


def _ball(lamp: Lamp, place: Array, normal: Array) -> tuple[Array, Array]:
    way = lamp.place - place
    distance = float(np.linalg.norm(way))
    if distance < TINY:
        return lamp.place[None], np.zeros(1)
    way = way / distance
    square = distance**2 + (lamp.radius**2 if lamp.soft else 0.0)
    if lamp.radius <= SMALL / 2 * distance:
        weight = lamp.intensity * max(float(way @ normal), 0.0) / square
        if lamp.type == "SPOT" and weight > 0.0:
            weight *= float(_spot(lamp, way[None])[0])
        return lamp.place[None], np.array([weight])
    points = lamp.place + lamp.radius * _disk(way, POINTS)
    ways = points - place
    lengths = np.linalg.norm(ways, axis=1)
    ways = ways / lengths[:, None]
    cosines = ways @ normal
    # The soft ball is a disk that faces the receiver; the other is as bright as its centre.
    falloff = (ways @ way) / lengths**2 if lamp.soft else np.full(len(ways), 1 / distance**2)
    weights = np.maximum(cosines, 0.0) * falloff / len(ways)
    if (cosines > 0.0).all():
        weights = weights * (float(way @ normal) / square / weights.sum())
    if lamp.type == "SPOT":
        weights = weights * _spot(lamp, ways)
    return points, lamp.intensity * weights


def _spot(lamp: Lamp, ways: Array) -> Array:
    edge = math.cos(lamp.angle / 2)
    inside = -ways @ lamp.axis - edge
    if lamp.blend * (1.0 - edge) <= 0.0:
        return (inside > 0.0).astype(float)
    t = np.clip(inside / ((1.0 - edge) * lamp.blend), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _area(lamp: Lamp, place: Array, normal: Array) -> tuple[Array, Array]:
    x, y = lamp.sides
    u, v = spread_points(POINTS).T
    if lamp.round:
        r, turn = np.sqrt(u) / 2, 2 * math.pi * v
        u, v = r * np.cos(turn), r * np.sin(turn)
        turns = 2 * math.pi * np.arange(CORNERS) / CORNERS
        # As large as the ellipse itself.
        swell = math.sqrt(math.pi / (CORNERS / 2 * math.sin(2 * math.pi / CORNERS)))
        outline = swell / 2 * (np.outer(np.cos(turns), x) + np.outer(np.sin(turns), y))
    else:
        u, v = u - 0.5, v - 0.5
        outline = np.array([-x - y, x - y, x + y, y - x]) / 2
    points = lamp.place + np.outer(u, x) + np.outer(v, y)
    area = lamp.area
    if area <= 0.0 or (place - lamp.place) @ lamp.axis <= 0.0:
        return points, np.zeros(len(points))
    radiance = 1.0 / (math.pi * area) if lamp.normalize else 1.0 / math.pi
    whole = radiance * polygon_irradiance(lamp.place + outline - place, normal)
    ways = points - place
    lengths = np.linalg.norm(ways, axis=1)
    weights = np.maximum(ways @ normal, 0.0) * np.maximum(-ways @ lamp.axis, 0.0) / lengths**4
    total = float(weights.sum())
    return points, weights * (whole / total if total > 0.0 else 0.0)


def polygon_irradiance(corners: Array, normal: Array) -> float:
    """∫ cos over the solid angle of a polygon (n, 3) seen from the origin, above the horizon.

    Lambert 1760, as in Baum, Rushmeier and Winget 1989.
    """
    heights = corners @ normal
    clipped = []
    for i in range(len(corners)):
        a, b = corners[i], corners[(i + 1) % len(corners)]
        above, next_above = heights[i], heights[(i + 1) % len(corners)]
        if above >= 0.0:
            clipped.append(a)
        if (above > 0.0) != (next_above > 0.0) and above != next_above:
            clipped.append(a + (b - a) * (above / (above - next_above)))
    if len(clipped) < 3:
        return 0.0
    one = np.array(clipped)
    two = np.roll(one, -1, axis=0)
    across = np.cross(one, two)
    sines = np.linalg.norm(across, axis=1)
    angles = np.arctan2(sines, np.einsum("ij,ij->i", one, two))
    good = sines > 1e-20
    return abs(float((angles[good] / sines[good]) @ (across[good] @ normal))) / 2
