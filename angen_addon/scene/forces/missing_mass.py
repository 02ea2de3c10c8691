# SPDX-License-Identifier: GPL-3.0-or-later
"""Find weights that do not reach a pad, although they would in reality.

There are two kinds of such weights. One is an active rigid body that physics does not move. The
other is a body on a stiff object without a mass whose other parts lie on the pad, such as a chair
with its legs on it: an object without a mass passes a weight only straight down.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ....sensor_logic.forces.shapes import perpendiculars
from ....sensor_logic.forces.underside import underside
from ....sensor_logic.forces.world import BareSurface
from ....sensor_logic.model import Array
from ..rays.solids import Solid
from . import posed_bodies
from .bodies import GROUND, Key
from .frame_state import FrameState
from .supports import DEPTH, FLUSH, THICKEST, Surroundings

# What carries a smaller share of a body, such as a pillow behind a back, spoils no reading.
LEAST_SHARE = 0.1
# Points along a side of the grid on which rays sample a pad's upper side.
POINTS = 5


class MissingMass:
    """Finds the weights that in reality would press on pads, but do not in the scene."""

    def __init__(self, around: Surroundings, state: FrameState) -> None:
        self._around, self._state = around, state
        self._solids, self._bodies = around.solids, around.bodies
        self._up, self._metres = around.up, around.metres
        self._moved = {body.original for body in self._bodies.by_key.values() if body.rigid}

    def problem(self, pad: Key, near: set[Key]) -> str:
        """Return a text for the user if a missing weight makes the reading unknown; "" if not.

        `near` are the keys of the bodies that may press on the pad.
        """
        row = self._solids.row_of(pad)
        if row is None:
            return ""
        solid = self._solids.solids[row]
        for key, supports in self._state.supports.items():
            if key not in near:
                continue
            body = self._bodies.by_key[key]
            for ground in (g for s in supports for g in s.ground) if not body.pad else ():
                if self._would_reach_pad(solid, self._bodies.by_key[pad].tolerance, ground):
                    return (
                        f"'{body.original.name}' stands on '{ground.name}', which lies on the pad "
                        f"and has no mass, so neither is weighed: give '{ground.name}' a mass "
                        "(Physics tab, Weight on Sensors)"
                    )
        return self._resting_problem(solid, self._bodies.by_key[pad].tolerance)

    def furniture(self, pad: Key) -> Iterator[str]:
        """Yield the names of stiff objects without a mass that stand on a pad with some parts.

        Their other parts have nothing below them, so the weight of who uses them is unknown.
        """
        row = self._solids.row_of(pad)
        if row is None:
            return
        solids, tolerance = self._solids, self._bodies.by_key[pad].tolerance
        reach = tolerance / self._metres
        near = (solids.lo <= solids.hi[row] + reach) & (solids.hi >= solids.lo[row] - reach)
        for cover in (solids.solids[other] for other in np.flatnonzero(near.all(axis=1)).tolist()):
            if cover.row == row or self._bodies.of_solid[cover.number] != GROUND:
                continue
            lo, hi = (bound[cover.row] * self._metres for bound in (solids.lo, solids.hi))
            surface = BareSurface(cover.name, cover.number, self._upper_side(cover, lo, hi))
            if len(surface.places) and self._would_reach_pad(
                solids.solids[row], tolerance, surface
            ):
                yield cover.original.name

    def _resting_problem(self, pad: Solid, tolerance: float) -> str:
        """Return a text if an active rigid body on the pad is not simulated; "" if all are.

        The body may lie on the pad itself, or on objects that lie on the pad. `tolerance` is the
        largest gap in m.
        """
        idle = [
            (s, body, why)
            for s, body in self._bodies.resting
            if (why := self._why_not_simulated(s, body))
        ]
        heavy = self._state.settings if idle else {}
        left = [s for s in self._solids.solids if self._bodies.of_solid[s.number] in heavy]
        below = [pad]
        while idle and below:
            base = below.pop()
            for solid, body, why in idle:
                if self._lies_on(base, solid, tolerance):
                    return (
                        f"the weight of the active rigid body '{body.name}' is missing, since "
                        f"{why}; or give it a mass (Physics tab, Weight on Sensors), or make it "
                        "passive"
                    )
            lying = [s for s in left if s is not base and self._lies_on(base, s, tolerance)]
            left = [solid for solid in left if solid not in (base, *lying)]
            below += lying
        return ""

    def _why_not_simulated(self, solid: Solid, original: Any) -> str:
        """Return why physics does not move an active rigid body, and the remedy; "" if it does."""
        depsgraph = self._around.depsgraph
        body, world = original.evaluated_get(depsgraph).rigid_body, depsgraph.scene.rigidbody_world
        if world is None or not world.enabled or world.collection is None:
            return "the rigid-body world is off: switch it on (Scene tab)"
        if len(solid.key) > 1 or original not in self._moved:
            return "physics moves neither instances nor objects outside the rigid-body collection"
        if not body.enabled:
            return "it is not Dynamic: tick that (Physics tab)"
        return "it is Animated: untick that (Physics tab)" if body.kinematic else ""

    def _lies_on(self, base: Solid, solid: Solid, tolerance: float) -> bool:
        lo, hi = (bound[base.row] * self._metres for bound in (self._solids.lo, self._solids.hi))
        return self._gap_between(base, lo, hi, solid, tolerance) is not None

    def _would_reach_pad(self, pad: Solid, tolerance: float, ground: BareSurface) -> bool:
        """Return whether a weight would reach the pad if the surface `ground` passed it on.

        `ground` has no mass and carries the weight. `tolerance` is the largest gap in m.
        """
        if ground.share < LEAST_SHARE:
            return False
        cover = next((s for s in self._solids.solids if s.number == ground.number), None)
        lo, hi = (bound[pad.row] * self._metres for bound in (self._solids.lo, self._solids.hi))
        top = max(float(lo @ self._up), float(hi @ self._up))
        if cover is None or (ground.places @ self._up <= top + FLUSH).all():
            return False
        gap = self._gap_between(pad, lo, hi, cover, tolerance)
        # What is below the pad, too, carries the pad.
        if gap is None or self._carries(cover, pad, lo, hi):
            return False
        below = self._cast(ground.places + FLUSH * self._up, pad, -1.0, THICKEST)
        if np.isfinite(below).any():
            return True
        # A stiff object may rest on the pad elsewhere, unless another solid is nearer below it.
        others = [
            solid
            for solid in self._solids.solids
            if solid.number not in (cover.number, pad.number)
            and self._bodies.of_solid[solid.number] not in self._state.supports
        ]
        return not (self._gap_below(ground.places, cover, others) <= max(gap + FLUSH, tolerance))

    def _carries(self, cover: Solid, pad: Solid, lo: Array, hi: Array) -> bool:
        """Return whether the solid `cover` is also below a pad with the bounds `lo`, `hi` (3,)."""
        tops = self._upper_side(pad, lo, hi)
        return bool(np.isfinite(self._cast(tops - FLUSH * self._up, cover, -1.0, THICKEST)).any())

    def _gap_between(
        self, pad: Solid, lo: Array, hi: Array, cover: Solid, tolerance: float
    ) -> float | None:
        """Return the result of `_gap_above` for a pad and the solid `cover`, stored if possible.

        `lo` and `hi` (3,) are the bounds of the pad in m, and `tolerance` is the largest gap in m.
        """
        versions = [int(self._solids.version[solid.row]) for solid in (pad, cover)]
        state = (*versions, tolerance, self._metres, *self._up.tolist())
        known = self._around.surfaces.gaps.get((pad.number, cover.number))
        if known is None or known[0] != state:
            gap = self._gap_above(self._upper_side(pad, lo, hi), cover, tolerance)
            if gap is None:
                gap = self._gap_below_legs(pad, lo, hi, cover, tolerance)
            known = state, gap
            self._around.surfaces.gaps[pad.number, cover.number] = known
        return known[1]

    def _upper_side(self, pad: Solid, lo: Array, hi: Array) -> Array:
        """Return points (k, 3) on the pad's upper side, in m. `lo`, `hi` are its bounds in m."""
        across = np.stack([*perpendiculars(self._up), self._up])
        corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        seen = (lo + corners * (hi - lo)) @ across.T
        ends = seen.min(axis=0), seen.max(axis=0)
        shares = (np.arange(POINTS) + 0.5) / POINTS
        grid = np.stack(np.meshgrid(shares, shares, [1.0], indexing="ij"), axis=-1).reshape(-1, 3)
        starts = (ends[0] + grid * (ends[1] - ends[0])) @ across + FLUSH * self._up
        far = self._cast(starts, pad, -1.0, float(ends[1][2] - ends[0][2]) + 2.0 * FLUSH)
        hit = np.isfinite(far)
        return starts[hit] - far[hit, None] * self._up

    def _gap_above(self, tops: Array, cover: Solid, tolerance: float) -> float | None:
        """Return the least gap in m between a pad's upper side and the solid `cover` on it.

        Return 0 if the pad is inside the solid, and None if the solid does not lie on the pad.
        `tops` are points (k, 3) on the pad's upper side, and `tolerance` is the largest gap in m.
        """
        if not len(tops):
            return None
        near = self._cast(tops - FLUSH * self._up, cover, 1.0, tolerance + FLUSH) - FLUSH
        over = np.isfinite(self._cast(tops + FLUSH * self._up, cover, 1.0, DEPTH))
        under = np.isfinite(self._cast(tops - FLUSH * self._up, cover, -1.0, DEPTH))
        within = over & under & ~np.isfinite(near)
        if within.any():
            return 0.0
        lies = np.isfinite(near)
        return max(float(near[lies].min()), 0.0) if lies.any() else None

    def _gap_below_legs(
        self, pad: Solid, lo: Array, hi: Array, cover: Solid, tolerance: float
    ) -> float | None:
        """Return the least gap in m below faces of the solid `cover` that point down to a pad.

        These can be the ends of legs, which a grid on the pad misses. Return None if there are
        none. The other parameters are as in `_gap_between`.
        """
        depsgraph, metres = self._around.depsgraph, self._metres
        triangles = self._around.surfaces.of(depsgraph, cover, metres).corners
        closed = self._around.surfaces.facing(depsgraph, cover, metres) != 0.0
        reach = np.abs(self._up) * (tolerance + FLUSH)
        ends = underside(triangles, closed, self._up, lo - reach, hi + reach).points
        if not len(ends):
            return None
        gaps = self._cast(ends + FLUSH * self._up, pad, -1.0, tolerance + FLUSH) - FLUSH
        near = gaps[np.isfinite(gaps)]
        return max(float(near.min()), 0.0) if len(near) else None

    def _gap_below(self, places: Array, cover: Solid, others: list[Solid]) -> float:
        """Return the widest gap in m between the solid `cover` and the solids `others` below it.

        The gaps are measured below the points `places` (k, 3) on `cover`.
        """
        bounds = np.stack([self._solids.lo[cover.row], self._solids.hi[cover.row]]) * self._metres
        reach = float(np.abs(np.ptp(bounds, axis=0) @ np.abs(self._up))) + DEPTH
        low = reach - self._cast(places - reach * self._up, cover, 1.0, reach + FLUSH)
        far = [self._cast(places + FLUSH * self._up, other, -1.0, 2.0 * reach) for other in others]
        return float((np.min(far, axis=0, initial=np.inf) - FLUSH - low).max())

    def _cast(self, starts: Array, solid: Solid, sign: float, length: float) -> Array:
        triangles = self._around.surfaces.of(self._around.depsgraph, solid, self._metres)
        return posed_bodies.hit_distances(
            triangles, starts, sign * self._up, np.full(len(starts), length)
        )
