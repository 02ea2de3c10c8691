# SPDX-License-Identifier: GPL-3.0-or-later
"""Light without a render, for scrubbing: closed forms with shadow rays, and an estimate of what
walls send back (split flux: one mean brightness for the whole room)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

from .light_bake import face_size
from .light_forms import FAR, frame, shine, spread_points
from .light_lamps import lamps_of
from .light_scene import Housings, shown_objects
from .light_surfaces import Surfaces
from .light_unmodelled import constant_world, unmodelled

Array = NDArray[np.float64]
SKY_RAYS = 64
ROOM_RAYS = 64
# The room is looked at from this far ahead of the sensor's face, if nothing is nearer.
INTO_THE_ROOM = 0.3
# A lamp lights the room where this share of the room's surface sees it.
SEEN_SHARE = 0.4
LOOKS_AT_LAMP = 6
OFF_SURFACE = 0.02
MOST_PASSED = 16


class Direct:
    """One state of a scene. `note`: what is in it that this does not model."""

    def __init__(self, scene: Any, view_layer: Any, depsgraph: Any) -> None:
        self._scene = scene
        self._depsgraph = depsgraph
        self._lamps = lamps_of(depsgraph, view_layer)
        self._surfaces = Surfaces()
        self._housings = Housings()
        shown = [obj.evaluated_get(depsgraph) for obj in shown_objects(view_layer)]
        self.note = unmodelled(view_layer, shown)
        world = scene.world.evaluated_get(depsgraph) if scene.world else None
        radiance = constant_world(world) if world else None
        self._sky = np.nan_to_num(np.array(radiance or (0.0, 0.0, 0.0), np.float64))

    def light(self, request: Any) -> Array:
        """As the renders give it: radiance (4, 3) of four walls, or irradiance (3,)."""
        if request.method == "FOUR_WALL":
            reflected = self.reflected(request.matrix[:3, 3], -request.matrix[:3, 2])
            return np.array([self._view(request, wall, reflected) for wall in range(4)])
        matrix = request.matrix
        normal = -matrix[:3, 2]
        place = matrix[:3, 3] + normal * face_size(self._scene, [matrix])
        return self.direct(place, normal) + self.reflected(place, normal)

    def direct(self, place: Array, normal: Array) -> Array:
        """W/m² (3,) straight from the lamps and a constant sky."""
        total = np.zeros(3)
        for lamp in self._lamps:
            points, weights = shine(lamp, place, normal)
            for point, weight in zip(points, weights.tolist(), strict=True):
                if weight <= 0.0:
                    continue
                passed = self._passed(place, point) if lamp.shadow else np.ones(3)
                total += lamp.power * weight * passed
        if self._sky.any():
            across, along = frame(normal)
            for u, v in spread_points(SKY_RAYS).tolist():
                r, turn = math.sqrt(u), 2 * math.pi * v
                way = normal * math.sqrt(1 - u) + r * (
                    across * math.cos(turn) + along * math.sin(turn)
                )
                total += self._sky * math.pi / SKY_RAYS * self._passed(place, place + FAR * way)
        return total

    def reflected(self, place: Array, normal: Array) -> Array:
        """W/m² (3,) that the room sends back: Φ ρ / (A (1 − ρ)), its area, mean reflectance and
        light estimated with rays from the middle of the air ahead."""
        ahead, _ = self._nearest(place, normal, 2 * INTO_THE_ROOM)
        middle = place + normal * (ahead / 2)
        area, reflecting, open_area = 0.0, np.zeros(3), 0.0
        spots = []
        for way in _sphere(ROOM_RAYS):
            length, hit = self._nearest(middle, way, FAR)
            if hit is None:
                open_area += 1.0
                continue
            hit_normal, colour, _ = hit
            part = 4 * math.pi / ROOM_RAYS * length**2 / max(0.05, abs(float(hit_normal @ way)))
            area += part
            reflecting += part * colour
            spots.append(middle + way * max(length - OFF_SURFACE, length / 2))
        if area == 0.0:
            return np.zeros(3)
        # Where rays leave, the room is taken to be as far as elsewhere, and black.
        opening = open_area * area / len(spots)
        mean = np.minimum(reflecting / (area + opening), 0.95)
        flux = self._sky * math.pi * opening
        looked = spots[:: max(1, len(spots) // LOOKS_AT_LAMP)]
        for lamp in self._lamps:
            if lamp.type == "SUN":
                continue
            seen = np.mean([self._passed(spot, lamp.place, lamp.radius) for spot in looked], axis=0)
            if float(seen.max()) >= SEEN_SHARE:
                flux = flux + lamp.flux * np.minimum(seen, 1.0)
        return flux * mean / ((area + opening) * (1.0 - mean))

    def _view(self, request: Any, wall: int, reflected: Array) -> Array:
        """Radiance (3,) in the middle of one of the four views, whose wall gets as much reflected
        light as the room's others."""
        matrix = request.matrix
        x, z = matrix[:3, 0], matrix[:3, 2]
        way = (-z, -x, z, x)[wall]
        start = matrix[:3, 3] + way * request.clip_start
        length, hit = self._nearest(start, way, request.clip_end - request.clip_start)
        if hit is None:
            return self._sky
        normal, colour, _ = hit
        normal = -normal if float(normal @ way) > 0.0 else normal
        place = start + way * length + normal * face_size(self._scene, [matrix])
        return colour / math.pi * (self.direct(place, normal) + reflected)

    def _nearest(self, start: Array, way: Array, length: float) -> tuple[float, Any]:
        """How far a ray gets, and the face it meets: normal, reflectance, transmittance."""
        gone = 0.0
        step = 1e-4
        while gone < length:
            hit, place, normal, face, seen, _ = self._scene.ray_cast(
                self._depsgraph,
                Vector(start + way * gone),
                Vector(way),
                distance=length - gone,
            )
            if not hit:
                return length, None
            there = float((np.array(place) - start) @ way)
            if self._counts(seen):
                return there, (np.array(normal, np.float64), *self._surfaces.of_hit(seen, face))
            gone = max(there, gone) + step
        return length, None

    def _passed(self, start: Array, end: Array, short: float = 0.0) -> Array:
        """Share (3,) of the light that gets from one point to another."""
        way = end - start
        length = float(np.linalg.norm(way))
        way = way / length
        length -= short + 1e-4
        share, gone = np.ones(3), 0.0
        for _ in range(MOST_PASSED):
            there, hit = self._nearest(start + way * gone, way, length - gone)
            if hit is None:
                return share
            share = share * hit[2]
            if not share.any():
                return share
            gone += there + 1e-4
        return np.zeros(3)

    def _counts(self, seen: Any) -> bool:
        original = seen.original
        return not (original.angen_ignored or original in self._housings)


def _sphere(count: int) -> Array:
    """Unit vectors (n, 3) to all sides, evenly: a Fibonacci lattice."""
    i = np.arange(count) + 0.5
    z = 1.0 - 2.0 * i / count
    turn = i * math.pi * (3.0 - math.sqrt(5.0))
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)
