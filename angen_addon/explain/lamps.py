# SPDX-License-Identifier: GPL-3.0-or-later
"""What each lamp adds to a light sensor's reading, by the closed forms of the direct preview."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.physics.photometry import luminance
from ..scene.light.direct import SKY, Arriving, direct_of
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

    @property
    def given(self) -> float:
        """What comes, without what lamps of negative power take away again."""
        return sum(max(lamp.light, 0.0) for lamp in self.lamps.values()) + max(self.rest, 0.0)


class _Shading(NamedTuple):
    """An object in the way of a ray to a lamp (its number): whether it lets light pass, and how
    much the ray would bring."""

    lamp: int
    name: str
    clear: bool
    light: float


def light_parts(solids: Any, depsgraph: Any, request: Any, efficacy: float) -> LightParts:
    """The parts of what a sensor reads at the state that the solids were synced to."""
    direct = direct_of(solids, depsgraph)
    unit = 100.0 * request.exposure / 4.0 if request.method == "FOUR_WALL" else efficacy
    arriving = direct.arriving(request)
    total = unit * float(np.sum(luminance(direct.light_of(request, arriving))))
    shaded = [_shading(direct.rays, one) for one in arriving]
    lamps: dict[str, LampShare] = {}
    for number, lamp in enumerate(direct.lamps):
        light, unshaded = (
            unit * sum(float(luminance(a.place.share * a.sum(passing, number))) for a in arriving)
            for passing in (True, False)
        )
        blocker, through = (_most(shaded, number, clear) for clear in (False, True))
        known = lamps.get(lamp.name)
        if known is not None:
            # Several instances of one lamp.
            light, unshaded = light + known.light, unshaded + known.unshaded
            blocker, through = known.blocker or blocker, known.through or through
        lamps[lamp.name] = LampShare(lamp.name, light, unshaded, blocker, through)
    rest = total - sum(share.light for share in lamps.values())
    return LightParts(lamps, rest, direct.note)


def _shading(rays: LightRays, arriving: Arriving) -> list[_Shading]:
    """What stands in the way of the light that arrives at a place, ray by ray."""
    which = np.flatnonzero((arriving.of != SKY) & (arriving.passing.min(axis=1) < 1.0))
    if not len(which):
        return []
    here = np.tile(arriving.place.middle, (len(which), 1))
    found = _in_the_way(rays, arriving.place.bundle, here, arriving.starts[which])
    return [
        _Shading(int(arriving.of[i]), name, clear, float(arriving.whole[i].sum()))
        for i, name, clear in ((which[ray], name, clear) for ray, name, clear in found)
    ]


def _most(shaded: Iterable[Iterable[_Shading]], lamp: int, clear: bool) -> str:
    """Of what is in the way of a lamp, what takes most; empty for nothing. `clear`: of what lets
    light pass."""
    parts: dict[str, float] = {}
    for one in chain.from_iterable(shaded):
        if one.lamp == lamp and one.clear == clear:
            parts[one.name] = parts.get(one.name, 0.0) + one.light
    return max(sorted(parts), key=lambda name: parts[name], default="")


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
