# SPDX-License-Identifier: GPL-3.0-or-later
"""What each lamp adds to a light sensor's reading, by the closed forms of the direct preview."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.physics.photometry import luminance
from ..scene.light.closed_forms import shine
from ..scene.light.direct import direct_of
from ..scene.light.faces import face_size
from ..scene.light.lamps import Lamp, lamps_of
from ..scene.light.shadow_rays import LightRays

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LampShare:
    """A lamp's part of a reading, in the reading's unit (lx, or percentage points before the
    rounding of pixels): as it is, and as if nothing stood between; the object that keeps most of
    the rest away; and the transparent one that it shines through, where no closed form tells how
    much passes. Names are empty for none."""

    name: str
    light: float
    unshaded: float
    blocker: str
    through: str


@dataclass(frozen=True)
class LightParts:
    """The `lamps` by name; `rest`: what the room sends back, and the sky; `note`: what is in the
    scene that the closed forms do not model."""

    lamps: dict[str, LampShare]
    rest: float
    note: str

    @property
    def total(self) -> float:
        return sum(lamp.light for lamp in self.lamps.values()) + self.rest


def light_parts(solids: Any, depsgraph: Any, request: Any, efficacy: float) -> LightParts:
    """The parts of what a sensor reads at the state that the solids were synced to."""
    direct = direct_of(solids, depsgraph)
    rays, scene = direct.rays, depsgraph.scene.original
    view_layer = scene.view_layers[depsgraph.view_layer.name]
    places = _places(rays, request, face_size(scene, request.matrix))
    unit = 100.0 * request.exposure / 4.0 if request.method == "FOUR_WALL" else efficacy
    total = unit * float(np.sum(luminance(direct.light(request))))
    lamps: dict[str, LampShare] = {}
    for lamp in lamps_of(depsgraph, view_layer):
        light, unshaded = 0.0, 0.0
        blocked: dict[str, float] = {}
        passed: dict[str, float] = {}
        for number, (place, normal, colour) in enumerate(places):
            bundle = request.name, number, lamp.name
            passing, whole = _shine(rays, bundle, lamp, place, normal, blocked, passed)
            light += unit * float(luminance(colour * passing))
            unshaded += unit * float(luminance(colour * whole))
        blocker, through = _most(blocked), _most(passed)
        known = lamps.get(lamp.name)
        if known is not None:
            # Several instances of one lamp.
            light, unshaded = light + known.light, unshaded + known.unshaded
            blocker, through = known.blocker or blocker, known.through or through
        lamps[lamp.name] = LampShare(lamp.name, light, unshaded, blocker, through)
    rest = total - sum(share.light for share in lamps.values())
    return LightParts(lamps, rest, direct.note)


def _places(rays: LightRays, request: Any, size: float) -> list[tuple[Array, Array, Array]]:
    """The point where light counts, the normal there, and the share of its irradiance that is read;
    (3,) each. Four walls: where the views end; else the sensor's own face."""
    matrix = request.matrix
    if request.method != "FOUR_WALL":
        normal = -matrix[:3, 2]
        return [(matrix[:3, 3] + normal * size, normal, np.ones(3))]
    x, z = matrix[:3, 0], matrix[:3, 2]
    ways = np.array([-z, -x, z, x])
    starts = matrix[:3, 3] + ways * request.clip_start
    reach = np.full(len(ways), request.clip_end - request.clip_start)
    hits = rays.nearest((request.name, "walls"), starts, ways, reach)
    found = []
    for i in hits.some:
        normal, colour, _ = hits.surface(i)
        normal = -normal if float(normal @ ways[i]) > 0.0 else normal
        place = starts[i] + ways[i] * float(hits.ranges[i]) + normal * size
        found.append((place, normal, colour / math.pi))
    return found


def _most(parts: dict[str, float]) -> str:
    return max(sorted(parts), key=lambda name: parts[name], default="")


def _shine(
    rays: LightRays,
    bundle: Hashable,
    lamp: Lamp,
    place: Array,
    normal: Array,
    blocked: dict[str, float],
    passed: dict[str, float],
) -> tuple[Array, Array]:
    """W/m² (3,) that reach a place, and that would if nothing stood between; adds the names of
    what keeps some away to `blocked`, of what is transparent to `passed`."""
    points, parts = shine(lamp, place, normal)
    points, parts = points[parts > 0.0], parts[parts > 0.0]
    whole = parts.sum() * lamp.power
    if not lamp.shadow or not len(parts):
        return whole, whole
    starts, none = np.tile(place, (len(parts), 1)), np.zeros(len(parts))
    shares = rays.passed((bundle, "lamp"), starts, points, none)
    passing = (parts[:, None] * shares).sum(axis=0) * lamp.power
    shaded = np.flatnonzero(shares.min(axis=1) < 1.0)
    if len(shaded):
        for ray, name, clear in _in_the_way(rays, bundle, starts[shaded], points[shaded]):
            found = passed if clear else blocked
            found[name] = found.get(name, 0.0) + float(parts[shaded[ray]])
    return passing, whole


def _in_the_way(
    rays: LightRays, bundle: Hashable, starts: Array, ends: Array
) -> list[tuple[int, str, bool]]:
    """On each way the first thing that lets no light pass; else the first that can, and that it
    does."""
    ways = ends - starts
    lengths = np.linalg.norm(ways, axis=1)
    ways = ways / lengths[:, None]
    found: dict[int, tuple[str, bool]] = {}
    on = np.arange(len(starts))
    begins, left = starts.copy(), lengths.copy()
    for turn in range(16):
        if not len(on):
            break
        hits = rays.nearest((bundle, turn), begins[on], ways[on], left[on])
        going = []
        for row in hits.some:
            ray, name = int(on[row]), rays.solids.name_of(int(hits.met[row]))
            if hits.is_clear(row):
                found.setdefault(ray, (name, True))
                gone = float(hits.ranges[row]) + 1e-4
                begins[ray] += ways[ray] * gone
                left[ray] -= gone
                going.append(ray)
            else:
                found[ray] = name, False
        on = np.array([ray for ray in going if left[ray] > 0.0], np.intp)
    return [(ray, *seen) for ray, seen in sorted(found.items())]
