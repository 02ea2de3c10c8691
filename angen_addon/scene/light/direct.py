# SPDX-License-Identifier: GPL-3.0-or-later
"""Light without a render, for scrubbing: closed forms with shadow rays, and an estimate of what
walls send back (split flux: one mean brightness for the whole room).

Renders nothing and makes no datablock, so that it may be called in a frame handler.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..rays.solids import Solids
from .closed_forms import FAR, frame, shine, spread_points
from .faces import face_size
from .instances import light_housings
from .lamps import Lamp, lamps_of
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
SKY = -1


@dataclass(frozen=True)
class LitPlace:
    """A place whose light a sensor reads: its middle (3,) and normal (3,), the `share` (3,) of the
    irradiance there that counts, and in which `row` of the result. `bundle`: what rays from there
    are known by."""

    bundle: Hashable
    row: int
    middle: Array
    normal: Array
    share: Array


@dataclass(frozen=True)
class Arriving:
    """Light on its way to a place, along rays (n): where each comes from, `starts` (n, 3), the
    number `of` (n,) of the lamp, or SKY, how much it would bring if nothing stood between, `whole`
    (n, 3) in W/m², and the share (n, 3) of that which gets through, `passing`."""

    place: LitPlace
    starts: Array
    of: NDArray[np.intp]
    whole: Array
    passing: Array

    def sum(self, passing: bool = True, of: int | None = None) -> Array:
        """W/m² (3,) in all, or of one lamp, that get through or, if not, would."""
        which = slice(None) if of is None else self.of == of
        light = self.whole[which] * self.passing[which] if passing else self.whole[which]
        return np.asarray(light.sum(axis=0), np.float64)


class Direct:
    """Follows a scene from update to update; `solids` are those that the other sensors' rays
    meet. `rays` know what of these stands still; `lamps`: those that shine; `note`: what is in the
    scene that this does not model."""

    def __init__(self, solids: Solids) -> None:
        self.rays = LightRays(solids)
        self._listing = -1
        self._scene: Any = None
        self.lamps: list[Lamp] = []
        self._sky = np.zeros(3)
        self.note = ""

    def update(self, depsgraph: Any) -> None:
        """To be called once an update, after `solids.sync(depsgraph)`."""
        scene = self._scene = depsgraph.scene.original
        view_layer = scene.view_layers[depsgraph.view_layer.name]
        shown = list(shown_objects(view_layer))
        self.rays.update(depsgraph, light_housings(view_layer))
        self.lamps = lamps_of(depsgraph, view_layer)
        self.note = unmodelled(view_layer, [obj.evaluated_get(depsgraph) for obj in shown])
        world = scene.world.evaluated_get(depsgraph) if scene.world else None
        radiance = constant_world(world) if world else None
        self._sky = np.nan_to_num(np.array(radiance or (0.0, 0.0, 0.0), np.float64))

    def light(self, request: Any) -> Array:
        """As the renders give it: radiance (4, 3) of four walls, or irradiance (3,)."""
        return self.light_of(request, self.arriving(request))

    def arriving(self, request: Any) -> list[Arriving]:
        """The light of lamps and sky at the places that a sensor reads."""
        return [self._arriving(place) for place in self._places(request)]

    def light_of(self, request: Any, arriving: Sequence[Arriving]) -> Array:
        """As `light`, of what arrives, and of what the room sends back."""
        matrix, is_walls = request.matrix, request.method == "FOUR_WALL"
        normal = -matrix[:3, 2]
        start = matrix[:3, 3] if is_walls else arriving[0].place.middle
        reflected = self._reflected(request.name, start, normal)
        # Where a view meets no wall, it looks at the sky.
        found = np.tile(self._sky, (WALLS if is_walls else 1, 1))
        for one in arriving:
            found[one.place.row] = one.place.share * (one.sum() + reflected)
        return found if is_walls else found[0]

    def _places(self, request: Any) -> Iterator[LitPlace]:
        """The sensor's own face; of four walls, the middles of those views that meet one."""
        matrix, size = request.matrix, face_size(self._scene, request.matrix)
        if request.method != "FOUR_WALL":
            normal = -matrix[:3, 2]
            yield LitPlace(request.name, 0, matrix[:3, 3] + normal * size, normal, np.ones(3))
            return
        x, z = matrix[:3, 0], matrix[:3, 2]
        ways = np.array([-z, -x, z, x])
        starts = matrix[:3, 3] + ways * request.clip_start
        reach = np.full(WALLS, request.clip_end - request.clip_start)
        hits = self.rays.nearest((request.name, "walls"), starts, ways, reach)
        for i in hits.some:
            normal, colour, _ = hits.surface(i)
            normal = -normal if float(normal @ ways[i]) > 0.0 else normal
            middle = starts[i] + ways[i] * float(hits.ranges[i]) + normal * size
            yield LitPlace((request.name, i), i, middle, normal, colour / math.pi)

    def _arriving(self, place: LitPlace) -> Arriving:
        starts, whole = [np.empty((0, 3))], [np.empty((0, 3))]
        of, shadows = [np.empty(0, np.intp)], [np.empty(0, bool)]
        for number, lamp in enumerate(self.lamps):
            points, parts = shine(lamp, place.middle, place.normal)
            starts.append(points[parts > 0.0])
            whole.append(parts[parts > 0.0][:, None] * lamp.power)
            of.append(np.full(len(starts[-1]), number))
            shadows.append(np.full(len(starts[-1]), lamp.shadow))
        if self._sky.any():
            starts.append(place.middle + FAR * _cosine_ways(place.normal))
            whole.append(np.tile(self._sky * math.pi / SKY_RAYS, (SKY_RAYS, 1)))
            of.append(np.full(SKY_RAYS, SKY))
            shadows.append(np.ones(SKY_RAYS, bool))
        start, shadow = np.concatenate(starts), np.concatenate(shadows)
        passing, here = np.ones((len(start), 3)), np.tile(place.middle, (int(shadow.sum()), 1))
        bundle, none = (place.bundle, "direct"), np.zeros(len(here))
        passing[shadow] = self.rays.passed(bundle, here, start[shadow], none)
        return Arriving(place, start, np.concatenate(of), np.concatenate(whole), passing)

    def _reflected(self, bundle: Hashable, place: Array, normal: Array) -> Array:
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
        lamps = [lamp for lamp in self.lamps if lamp.type != "SUN"]
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
