# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweeps beams and rigid solids from where they were a step ago to where they are now.

What changes its shape is taken as it stands now; what appears, and what nodes make, is left out.
What jumps is taken to fly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.geometry.sweep import (
    Movement,
    RayCrossings,
    crossings,
    joined,
    no_crossings,
    pieces_needed,
    seen_from,
)
from ....sensor_logic.geometry.trees import TriangleTree
from ....sensor_logic.model import Array
from ..instances import Uid
from .caster import RayCaster
from .frames import Frames
from .geometry import Geometry, Surface
from .reference import SceneRayCaster

Rows = NDArray[np.intp]
# Metres by which the beam may stray from its way through a solid: 4 % of the narrowest slit in the
# data sheets, 0.25 mm.
TOLERANCE = 1e-5
# By how much of a point's straight way half a turn, the most that two poses tell, goes beside it.
BULGE = 0.5
STANDS = -1


@dataclass(frozen=True)
class SolidsAtStep:
    """The solids at one step: numbers (n,), their surfaces, matrices (n, 4, 4) and world bounds
    (n, 3)."""

    numbers: NDArray[np.int64]
    shapes: list[Any]
    matrix: Array
    lo: Array
    hi: Array


@dataclass(frozen=True)
class SolidMotion:
    """How solids moved from one step to the next: by its row now, the row of each `before` (n,), or
    STANDS where it did not move, and the bounds (n, 3) of the space that it swept; `moved` (m,):
    the rows of those that moved."""

    before: Rows
    lo: Array
    hi: Array
    moved: Rows


@dataclass(frozen=True)
class SweptRays:
    """The rays of a sensor at one step, in Blender units: its matrix (4, 4) without scale, and the
    rays as to `RayCaster.cast`."""

    matrix: Array
    origins: Array
    directions: Array
    length: Array

    def same(self, other: SweptRays) -> bool:
        """Whether another is equal."""
        mine = self.matrix, self.origins, self.directions, self.length
        its = other.matrix, other.origins, other.directions, other.length
        return all(map(np.array_equal, mine, its))

    @cached_property
    def ends(self) -> Array:
        """(k, 2, 3): where the rays start and end."""
        there = self.origins + self.directions * self.length[:, None]
        return np.stack([self.origins, there], axis=1)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        return _bounds(self.ends)


class Sweeper:
    """Finds what went through the beams of all switches of a scene."""

    def __init__(self, caster: RayCaster | SceneRayCaster) -> None:
        self._caster = caster
        # Of the frames that are cast at now, until others are: all switches share them.
        self._frames: Frames | None = None
        self._at_frames: dict[int, SolidsAtStep] = {}
        self._listing = -1
        self._numbers = np.zeros(0, np.int64)
        self._moves: tuple[SolidsAtStep, SolidsAtStep, SolidMotion] | None = None
        # Of each shape that was met, while it is listed; without it 0.6 ms for 2000 triangles at
        # each update at which they pass the beam.
        self._triangles: dict[Geometry, tuple[Any, TriangleTree]] = {}

    def solids_at(self, frame: int) -> SolidsAtStep:
        """The solids at one of the caster's frames, an argument of `sweep`."""
        solids, frames = self._caster.solids, self._caster.frames
        if self._frames is not frames:
            self._frames, self._at_frames = frames, {}
        if frame not in self._at_frames:
            if self._listing != solids.listing:
                self._listing = solids.listing
                self._numbers = np.array([s.number for s in solids.solids], np.int64)
                listed = {s.geometry for s in solids.solids}
                self._triangles = {g: t for g, t in self._triangles.items() if g in listed}
            shapes = [s.geometry.state for s in solids.solids]
            for row in frames.surfaces:
                shapes[row] = frames.surface(solids, row, frame)
            matrix, lo, hi = solids.matrix.copy(), solids.lo.copy(), solids.hi.copy()
            matrix[frames.rows] = frames.matrix[frame]
            lo[frames.rows], hi[frames.rows] = frames.lo[frame], frames.hi[frame]
            self._at_frames[frame] = SolidsAtStep(self._numbers, shapes, matrix, lo, hi)
        return self._at_frames[frame]

    def sweep(
        self,
        depsgraph: Any,
        sensor: Uid,
        before: SolidsAtStep,
        now: SolidsAtStep,
        start: SweptRays,
        beam: SweptRays,
        tolerance: float,
    ) -> RayCrossings:
        """The crossings of the rays between the steps `before`, when the beam was `start`, and
        `now`; in Blender units, the `tolerance` too. `sensor` is the session uid of the object
        whose own solids do not count."""
        moves = self._moves_since(before, now)
        stands = np.array_equal(start.matrix, beam.matrix)
        if stands and not _overlap(moves, moves.moved, *beam.bounds).any():
            return no_crossings()
        # Seen from the beam, numbers are small wherever in the world it is.
        centre = beam.origins[0]
        points = beam.ends - centre
        move = Movement(_about(centre, start.matrix), _about(centre, beam.matrix))
        lo, hi = _swept_bounds(move, points.reshape(-1, 3))
        everything = np.arange(len(moves.before))
        near = np.flatnonzero(_overlap(moves, everything, lo + centre, hi + centre))
        standing = moves.before[near] == STANDS if stands else np.zeros(len(near), bool)
        found: list[RayCrossings] = []
        for row in [*near[~standing].tolist(), *near[standing].tolist()]:
            solid = self._caster.solids.solids[row]
            earlier = int(moves.before[row])
            if stands and earlier == STANDS and not any(found):
                # What only stands in the beam does not break it.
                break
            if sensor in solid.owners or not solid.geometry.lasting:
                continue
            matrix = _about(centre, now.matrix[row])
            first = matrix if earlier == STANDS else _about(centre, before.matrix[earlier])
            triangles = self._triangles_of(depsgraph, solid.geometry, now.shapes[row])
            ways = _ways(Movement(first, matrix), move, points, tolerance)
            found.append(crossings(ways, beam.length, triangles, solid.number))
        return joined(found)

    def _moves_since(self, before: SolidsAtStep, now: SolidsAtStep) -> SolidMotion:
        """The same for all sensors that looked last at the same step."""
        known = self._moves
        if known is None or known[0] is not before or known[1] is not now:
            known = before, now, self._compare(before, now)
            self._moves = known
        return known[2]

    def _compare(self, before: SolidsAtStep, now: SolidsAtStep) -> SolidMotion:
        rows = _rows_of(now.numbers, before)
        known = np.flatnonzero(rows != STANDS)
        earlier = rows[known]
        came = np.ones(len(rows), bool)
        came[known] = ~np.isfinite(before.lo[earlier]).all(axis=1)
        other = (now.matrix[known] != before.matrix[earlier]).any(axis=(1, 2))
        # What was flattened or not a number at either step was never hit.
        for solids, at in ((now, known), (before, earlier)):
            other &= np.isfinite(solids.lo[at]).all(axis=1)
        known, earlier = known[other], earlier[other]
        rigid = np.array(
            [
                self._caster.solids.solids[row].geometry.lasting
                and before.shapes[was] is now.shapes[row]
                for row, was in zip(known.tolist(), earlier.tolist(), strict=True)
            ],
            bool,
        )
        # What is mirrored all of a sudden would have to go through itself.
        sides = np.linalg.det(now.matrix[known, :3, :3] @ before.matrix[earlier, :3, :3])
        moved = known[rigid & (sides > 0.0)]
        earlier = rows[moved]
        standing = np.full(len(rows), STANDS, np.intp)
        standing[moved] = earlier
        lo, hi = now.lo.copy(), now.hi.copy()
        # What was nowhere the step before was on nothing's way.
        lo[came], hi[came] = np.inf, -np.inf
        bulge = _bulges(before, earlier, now, moved)[:, None]
        lo[moved] = np.minimum(before.lo[earlier], now.lo[moved]) - bulge
        hi[moved] = np.maximum(before.hi[earlier], now.hi[moved]) + bulge
        return SolidMotion(standing, lo, hi, moved)

    def _triangles_of(self, depsgraph: Any, geometry: Geometry, surface: Surface) -> TriangleTree:
        """The triangles of a shape in its own space, as it was then."""
        known = self._triangles.get(geometry)
        if known is None or known[0] is not surface:
            if geometry.deforms:
                corners = surface.points.T[surface.triangles[0].T].astype(np.float64)
            else:
                corners = geometry.vertices[geometry.triangles(depsgraph)].astype(np.float64)
            known = self._triangles[geometry] = surface, TriangleTree(corners)
        return known[1]


def _ways(body: Movement, sensor: Movement, points: Array, tolerance: float) -> Array:
    """The ends of rays, `points` (k, 2, 3) at last, as a moving body sees them: (n + 1, k, 2, 3),
    at the bounds of n times between which they go straight enough."""
    ends = points.reshape(-1, 3)
    pieces = pieces_needed(body, sensor, ends, tolerance)
    seen = seen_from(body, sensor, np.linspace(0.0, 1.0, pieces + 1), ends)
    return seen.reshape(pieces + 1, *points.shape)


def _rows_of(numbers: NDArray[np.int64], before: SolidsAtStep) -> Rows:
    """The earlier rows of solids with these numbers (n,); STANDS for those that were not listed."""
    if np.array_equal(numbers, before.numbers):
        return np.arange(len(numbers))
    known = {number: row for row, number in enumerate(before.numbers.tolist())}
    return np.array([known.get(number, STANDS) for number in numbers.tolist()], np.intp)


def _bulges(before: SolidsAtStep, earlier: Rows, now: SolidsAtStep, moved: Rows) -> Array:
    """How far (m,) solids that turn may go beside the straight ways of their points."""
    change = now.matrix[moved] - before.matrix[earlier]
    turns = (change[:, :3, :3] != 0.0).any(axis=(1, 2))
    # Of the corners of the boxes, which hold those of the solids, at both steps.
    middle = (before.lo[earlier] + before.hi[earlier]) / 2.0
    shift = (now.lo[moved] + now.hi[moved]) / 2.0 - middle
    sizes = [
        np.linalg.norm(solids.hi[at] - solids.lo[at], axis=1)
        for solids, at in ((before, earlier), (now, moved))
    ]
    farthest = np.linalg.norm(shift, axis=1) + (sizes[0] + sizes[1]) / 2.0
    return np.where(turns, BULGE * farthest, 0.0)


def _swept_bounds(move: Movement, ends: Array) -> tuple[Array, Array]:
    """Bounds (3,), (3,) of the way of points (k, 3), as they are at last."""
    there = seen_from(Movement(np.eye(4), np.eye(4)), move, np.zeros(1), ends)[0]
    lo, hi = _bounds(np.stack([there, ends]))
    bulge = BULGE * float(np.linalg.norm(ends - there, axis=1).max()) if move.angle else 0.0
    return lo - bulge, hi + bulge


def _bounds(points: Array) -> tuple[Array, Array]:
    """Bounds (3,), (3,) of points (n, m, 3)."""
    return points.min(axis=(0, 1)), points.max(axis=(0, 1))


def _overlap(moves: SolidMotion, rows: Rows, lo: Array, hi: Array) -> NDArray[np.bool_]:
    """Mask (m,) of the solids in `rows` (m,) that went through a box."""
    return np.asarray(((moves.lo[rows] <= hi) & (moves.hi[rows] >= lo)).all(axis=1))


def _about(centre: Array, matrix: Array) -> Array:
    """A matrix (4, 4) as seen from a point."""
    seen = matrix.copy()
    seen[:3, 3] -= centre
    return seen
