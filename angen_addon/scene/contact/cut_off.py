# SPDX-License-Identifier: GPL-3.0-or-later
"""Weight that a pad should feel, but that ends in something without a mass which lies on the pad.

A floor carries whoever stands on it, however thin it is. A rug, a mattress or a board on the pad
would pass the weight on to it, and without its mass nobody can tell how much.
"""

from __future__ import annotations

import numpy as np

from ....sensor_logic.contact.shapes import perpendiculars
from ....sensor_logic.contact.world import Ground
from ..rays.solids import Solid
from . import columns
from .moments import Moment
from .standing import DEPTH, FLUSH, Surroundings
from .things import Key

Array = np.typing.NDArray[np.float64]
# A pad's upper side is looked at in a grid of this many points a side.
POINTS = 5


class CutOff:
    """Looks for such weights at one frame."""

    def __init__(self, around: Surroundings, moment: Moment) -> None:
        self._around, self._moment = around, moment
        self._solids, self._things = around.solids, around.things
        self._up, self._metres = around.up, around.metres

    def problem(self, pad: Key) -> str:
        """Why the pad's reading is not known; empty where it is."""
        row = self._solids.row_of(pad)
        if row is None:
            return ""
        solid = self._solids.solids[row]
        for key, supports in self._moment.standing.items():
            thing = self._things.by_key[key]
            for ground in (g for s in supports for g in s.ground) if not thing.pad else ():
                if self._ends_above(solid, self._things.by_key[pad].tolerance, ground):
                    return (
                        f"the weight of '{thing.original.name}' ends in '{ground.name}', which "
                        "lies on the pad and has no mass: give it one (Weight on Sensors)"
                    )
        return ""

    def _ends_above(self, pad: Solid, tolerance: float, ground: Ground) -> bool:
        """Whether weight on a thing without a mass would go on to the pad."""
        thing = next((s for s in self._solids.solids if s.number == ground.number), None)
        lo, hi = (bound[pad.row] * self._metres for bound in (self._solids.lo, self._solids.hi))
        top = max(float(lo @ self._up), float(hi @ self._up))
        if thing is None or (ground.places @ self._up <= top + FLUSH).all():
            return False
        gap = self._gap_between(pad, lo, hi, thing, tolerance)
        if gap is None:
            return False
        if np.isfinite(self._meet(ground.places + FLUSH * self._up, pad, -1.0, DEPTH)).any():
            return True
        # It may be stiff, and rest on the pad from afar, unless it rests on something nearer.
        others = [
            solid
            for solid in self._solids.solids
            if solid.number not in (thing.number, pad.number)
            and self._things.of_solid[solid.number] not in self._moment.standing
        ]
        return not (self._gap_below(ground.places, thing, others) <= gap + FLUSH)

    def _gap_between(
        self, pad: Solid, lo: Array, hi: Array, thing: Solid, tolerance: float
    ) -> float | None:
        """As `_gap_above`, found once for as long as both stay as they are."""
        versions = [int(self._solids.version[solid.row]) for solid in (pad, thing)]
        state = (*versions, tolerance, self._metres, *self._up.tolist())
        known = self._around.surfaces.gaps.get((pad.number, thing.number))
        if known is None or known[0] != state:
            known = state, self._gap_above(self._upper_side(pad, lo, hi), thing, tolerance)
            self._around.surfaces.gaps[pad.number, thing.number] = known
        return known[1]

    def _upper_side(self, pad: Solid, lo: Array, hi: Array) -> Array:
        """(k, 3): places on the pad's upper side."""
        across = np.stack([*perpendiculars(self._up), self._up])
        corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        seen = (lo + corners * (hi - lo)) @ across.T
        ends = seen.min(axis=0), seen.max(axis=0)
        shares = (np.arange(POINTS) + 0.5) / POINTS
        grid = np.stack(np.meshgrid(shares, shares, [1.0], indexing="ij"), axis=-1).reshape(-1, 3)
        starts = (ends[0] + grid * (ends[1] - ends[0])) @ across + FLUSH * self._up
        far = self._meet(starts, pad, -1.0, float(ends[1][2] - ends[0][2]) + 2.0 * FLUSH)
        met = np.isfinite(far)
        return starts[met] - far[met, None] * self._up

    def _gap_above(self, tops: Array, thing: Solid, tolerance: float) -> float | None:
        """How far above the pad's upper side a thing that lies on it is, 0 where the pad is in
        it; None where it does not lie there."""
        if not len(tops):
            return None
        near = self._meet(tops - FLUSH * self._up, thing, 1.0, tolerance + FLUSH) - FLUSH
        over = np.isfinite(self._meet(tops + FLUSH * self._up, thing, 1.0, DEPTH))
        under = np.isfinite(self._meet(tops - FLUSH * self._up, thing, -1.0, DEPTH))
        within = over & under & ~np.isfinite(near)
        if within.any():
            return 0.0
        lies = np.isfinite(near)
        return max(float(near[lies].min()), 0.0) if lies.any() else None

    def _gap_below(self, places: Array, thing: Solid, others: list[Solid]) -> float:
        """The most that a thing is above what is below it, at any of some places on it."""
        bounds = np.stack([self._solids.lo[thing.row], self._solids.hi[thing.row]]) * self._metres
        reach = float(np.abs(np.ptp(bounds, axis=0) @ np.abs(self._up))) + DEPTH
        low = reach - self._meet(places - reach * self._up, thing, 1.0, reach + FLUSH)
        far = [self._meet(places + FLUSH * self._up, other, -1.0, 2.0 * reach) for other in others]
        return float((np.min(far, axis=0, initial=np.inf) - FLUSH - low).max())

    def _meet(self, starts: Array, solid: Solid, sign: float, length: float) -> Array:
        triangles = self._around.surfaces.of(self._around.depsgraph, solid, self._metres)
        return columns.meet(triangles, starts, sign * self._up, np.full(len(starts), length))
