# SPDX-License-Identifier: GPL-3.0-or-later
"""Light without a render, for scrubbing: closed forms with shadow rays, and an estimate of what
walls send back (split flux: one mean brightness for the whole room).

Renders nothing and makes no datablock, so that it may be called in a frame handler.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..rays.solids import Solids
from .closed_forms import FAR, frame, shine, spread_points
from .faces import face_size
from .instances import light_housings
from .lamps import lamps_of
from .scene import shown_objects
from .shadow_rays import LightRays
from .unmodelled import constant_world, unmodelled

Array = NDArray[np.float64]
SKY_RAYS = 64
ROOM_RAYS = 64
# The room is looked at from this far ahead of the sensor's face, if nothing is nearer.
INTO_THE_ROOM = 0.3
# A lamp lights the room where this share of the room's surface sees it.
SEEN_SHARE = 0.4
LOOKS_AT_LAMP = 6
OFF_SURFACE = 0.02
WALLS = 4


class Direct:
    """Follows a scene from update to update; `solids` are those that the other sensors' rays
    meet. `rays` know what of these stands still; `note`: what is in the scene that this does not
    model."""

    def __init__(self, solids: Solids) -> None:
        self.rays = LightRays(solids)
        self._listing = -1
        self._scene: Any = None
        self._lamps: list[Any] = []
        self._sky = np.zeros(3)
        self.note = ""

    def update(self, depsgraph: Any) -> None:
        """To be called once an update, after `solids.sync(depsgraph)`."""
        scene = self._scene = depsgraph.scene.original
        view_layer = scene.view_layers[depsgraph.view_layer.name]
        shown = list(shown_objects(view_layer))
        self.rays.update(depsgraph, light_housings(view_layer))
        self._lamps = lamps_of(depsgraph, view_layer)
        self.note = unmodelled(view_layer, [obj.evaluated_get(depsgraph) for obj in shown])
        world = scene.world.evaluated_get(depsgraph) if scene.world else None
        radiance = constant_world(world) if world else None
        self._sky = np.nan_to_num(np.array(radiance or (0.0, 0.0, 0.0), np.float64))

    def light(self, request: Any) -> Array:
        """As the renders give it: radiance (4, 3) of four walls, or irradiance (3,)."""
        matrix, name = request.matrix, request.name
        normal = -matrix[:3, 2]
        if request.method == "FOUR_WALL":
            return self._walls(request, self.reflected(name, matrix[:3, 3], normal))
        place = matrix[:3, 3] + normal * face_size(self._scene, matrix)
        return self.direct(name, place, normal) + self.reflected(name, place, normal)

    def direct(self, bundle: Hashable, place: Array, normal: Array) -> Array:
        """W/m² (3,) straight from the lamps and a constant sky."""
        ends, weights, shadows = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0, bool)]
        for lamp in self._lamps:
            points, parts = shine(lamp, place, normal)
            ends.append(points[parts > 0.0])
            weights.append(np.outer(parts[parts > 0.0], lamp.power))
            shadows.append(np.full(len(ends[-1]), lamp.shadow))
        if self._sky.any():
            ends.append(place + FAR * _cosine_ways(normal))
            weights.append(np.tile(self._sky * math.pi / SKY_RAYS, (SKY_RAYS, 1)))
            shadows.append(np.ones(SKY_RAYS, bool))
        end, weight, shadow = np.concatenate(ends), np.concatenate(weights), np.concatenate(shadows)
        starts = np.tile(place, (int(shadow.sum()), 1))
        none = np.zeros(len(starts))
        weight[shadow] *= self.rays.passed((bundle, "direct"), starts, end[shadow], none)
        return np.asarray(weight.sum(axis=0), np.float64)

    def reflected(self, bundle: Hashable, place: Array, normal: Array) -> Array:
        """W/m² (3,) that the room sends back: Φ ρ / (A (1 − ρ)), its area, mean reflectance and
        light estimated with rays from the middle of the air ahead."""
        ahead = self.rays.nearest(
            (bundle, "ahead"), place[None], normal[None], np.array([2 * INTO_THE_ROOM])
        )
        middle = place + normal * (float(ahead.ranges[0]) / 2)
        starts, reach = np.tile(middle, (ROOM_RAYS, 1)), np.full(ROOM_RAYS, FAR)
        hits = self.rays.nearest((bundle, "room"), starts, ROOM_WAYS, reach)
        area, reflecting = 0.0, np.zeros(3)
        spots = []
        for i in hits.some:
            way, length = ROOM_WAYS[i], float(hits.ranges[i])
            normal_there, colour, _ = hits.surface(i)
            part = 4 * math.pi / ROOM_RAYS * length**2 / max(0.05, abs(float(normal_there @ way)))
            area += part
            reflecting += part * colour
            spots.append(middle + way * max(length - OFF_SURFACE, length / 2))
        if area == 0.0:
            return np.zeros(3)
        # Where rays leave, the room is taken to be as far as elsewhere, and black.
        opening = (ROOM_RAYS - len(spots)) * area / len(spots)
        mean = np.minimum(reflecting / (area + opening), 0.95)
        looked = np.array(spots[:: max(1, len(spots) // LOOKS_AT_LAMP)])
        flux = self._sky * math.pi * opening + self._lit(bundle, looked)
        # Only what the face looks at sends back light to it, not the open sky.
        cosines = np.maximum(ROOM_WAYS @ normal, 0.0)
        flux = flux * (cosines[hits.some].sum() / cosines.sum())
        return np.asarray(flux * mean / ((area + opening) * (1.0 - mean)), np.float64)

    def _lit(self, bundle: Hashable, looked: Array) -> Array:
        """W (3,) of the lamps that many of some places in a room see."""
        lamps = [lamp for lamp in self._lamps if lamp.type != "SUN"]
        if not lamps:
            return np.zeros(3)
        count = len(looked)
        starts = np.tile(looked, (len(lamps), 1))
        ends = np.repeat([lamp.place for lamp in lamps], count, axis=0)
        short = np.repeat([lamp.radius for lamp in lamps], count)
        share = self.rays.passed((bundle, "lamps"), starts, ends, short)
        seen = share.reshape(len(lamps), count, 3).mean(axis=1)
        seen = np.where(seen.max(axis=1, keepdims=True) >= SEEN_SHARE, np.minimum(seen, 1.0), 0.0)
        return np.asarray((seen * [lamp.flux for lamp in lamps]).sum(axis=0), np.float64)

    def _walls(self, request: Any, reflected: Array) -> Array:
        """Radiance (4, 3) in the middle of the four views, whose walls get as much reflected
        light as the room's others."""
        matrix = request.matrix
        x, z = matrix[:3, 0], matrix[:3, 2]
        ways = np.array([-z, -x, z, x])
        starts = matrix[:3, 3] + ways * request.clip_start
        reach = np.full(WALLS, request.clip_end - request.clip_start)
        hits = self.rays.nearest((request.name, "walls"), starts, ways, reach)
        found = np.tile(self._sky, (WALLS, 1))
        for i in hits.some:
            length = float(hits.ranges[i])
            normal, colour, _ = hits.surface(i)
            normal = -normal if float(normal @ ways[i]) > 0.0 else normal
            place = starts[i] + ways[i] * length + normal * face_size(self._scene, matrix)
            here = self.direct((request.name, i), place, normal)
            found[i] = colour / math.pi * (here + reflected)
        return found


# What rays meet that does not move is remembered as long as the solids live.
_direct: WeakKeyDictionary[Solids, Direct] = WeakKeyDictionary()


def direct_of(solids: Solids, depsgraph: Any) -> Direct:
    """The one of these solids, as they are synced with the depsgraph."""
    found = _direct.get(solids)
    if found is None:
        found = _direct[solids] = Direct(solids)
    found.update(depsgraph)
    return found


def _cosine_ways(normal: Array) -> Array:
    """Unit vectors (n, 3) over the half space ahead, as dense as their cosine."""
    across, along = frame(normal)
    u, v = spread_points(SKY_RAYS).T
    r, turn = np.sqrt(u), 2 * math.pi * v
    ways = np.outer(np.sqrt(1.0 - u), normal)
    return np.asarray(ways + np.outer(r * np.cos(turn), across) + np.outer(r * np.sin(turn), along))


def _sphere(count: int) -> Array:
    """Unit vectors (n, 3) to all sides, evenly: a Fibonacci lattice."""
    i = np.arange(count) + 0.5
    z = 1.0 - 2.0 * i / count
    turn = i * math.pi * (3.0 - math.sqrt(5.0))
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


ROOM_WAYS = _sphere(ROOM_RAYS)
