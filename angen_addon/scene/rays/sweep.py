# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweep beams and rigid solids from their poses at the previous step to their poses at this step.

A mesh that changes shape is tested with its shape at this step. Left out are solids that have just
appeared, and solids that geometry nodes make. A solid that jumps is treated as if it flew to its
new pose.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.arrays import are_equal
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
from ..capture import Frames
from ..instances import Uid
from .caster import RayCaster
from .geometry import Geometry, Surface
from .reference import SceneRayCaster

Rows = NDArray[np.intp]
# Metres: the largest error of a beam's path through a solid. It is 4 % of the narrowest slit in the
# data sheets, which is 0.25 mm wide.
TOLERANCE = 1e-5
# A point on an arc of half a turn leaves the straight line between the ends of the arc by at most
# this fraction of the length of that line. Two poses cannot show a larger turn.
SAGITTA = 0.5
# In place of an earlier row: the solid did not move, or is new.
STANDS = -1


@dataclass(frozen=True)
class SolidsAtStep:
    """The surfaces and poses of n solids at one step.

    Attributes
    ----------
    numbers
        Numbers (n,) of the solids.
    shapes
        Their n surfaces.
    matrix
        Matrices (n, 4, 4) to the world.
    lo, hi
        World bounds (n, 3).
    """

    numbers: NDArray[np.int64]
    shapes: list[Any]
    matrix: Array
    lo: Array
    hi: Array


@dataclass(frozen=True)
class SolidMotion:
    """The motion of n solids from one step to the next.

    Attributes
    ----------
    before
        The row (n,) of each solid at the earlier step; STANDS if the solid did not move, or is new.
    lo, hi
        Bounds (n, 3) of the space that each solid swept.
    moved
        Rows (m,) of the solids that moved.
    """

    before: Rows
    lo: Array
    hi: Array
    moved: Rows


@dataclass(frozen=True)
class SweptRays:
    """The rays of a sensor at one step, in Blender units.

    Attributes
    ----------
    matrix
        The sensor's pose (4, 4), without scale.
    origins, directions, length
        The rays, as for `RayCaster.cast`.
    """

    matrix: Array
    origins: Array
    directions: Array
    length: Array

    def same(self, other: SweptRays) -> bool:
        """Return whether another object has equal rays and an equal pose."""
        mine = self.matrix, self.origins, self.directions, self.length
        its = other.matrix, other.origins, other.directions, other.length
        return are_equal(mine, its)

    @cached_property
    def ends(self) -> Array:
        """The start and end points (k, 2, 3) of the rays."""
        ends = self.origins + self.directions * self.length[:, None]
        return np.stack([self.origins, ends], axis=1)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """The bounds (3,), (3,) of the rays."""
        return _bounds(self.ends)


class Sweeper:
    """Finds the solids that crossed the beams of optical switches between two steps."""

    def __init__(self, caster: RayCaster | SceneRayCaster) -> None:
        self._caster = caster
        # The solids at the caster's present frames, shared by all switches.
        self._frames: Frames | None = None
        self._at_frames: dict[int, SolidsAtStep] = {}
        self._listing = -1
        self._numbers = np.zeros(0, np.int64)
        self._moves: tuple[SolidsAtStep, SolidsAtStep, SolidMotion] | None = None
        # Trees of the shapes near beams, while these are listed. Without them each update takes
        # 0.6 ms more for 2000 triangles.
        self._triangles: dict[Geometry, tuple[Any, TriangleTree]] = {}

    def solids_at(self, frame: int) -> SolidsAtStep:
        """Return the solids at one of the caster's frames, in the form that `sweep` takes."""
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
        sensor: Uid,
        before: SolidsAtStep,
        now: SolidsAtStep,
        start: SweptRays,
        beam: SweptRays,
        tolerance: float,
    ) -> RayCrossings:
        """Return the crossings of solids through the rays between two steps.

        Parameters
        ----------
        sensor
            Session uid of the sensor; its own solids do not count.
        before, now
            The solids at the earlier and the later step.
        start, beam
            The rays at the earlier and the later step.
        tolerance
            Largest error of the path of a ray through a solid, in Blender units.

        Returns
        -------
        RayCrossings
            The crossings, in Blender units.
        """
        moves = self._moves_since(before, now)
        stands = np.array_equal(start.matrix, beam.matrix)
        if stands and not _overlap(moves, moves.moved, *beam.bounds).any():
            return no_crossings()
        # Relative to the beam, numbers are small, and rounding errors too.
        centre = beam.origins[0]
        points = beam.ends - centre
        move = Movement(_relative_to(centre, start.matrix), _relative_to(centre, beam.matrix))
        lo, hi = _swept_bounds(move, points.reshape(-1, 3))
        everything = np.arange(len(moves.before))
        near = np.flatnonzero(_overlap(moves, everything, lo + centre, hi + centre))
        standing = moves.before[near] == STANDS if stands else np.zeros(len(near), bool)
        found: list[RayCrossings] = []
        for row in [*near[~standing].tolist(), *near[standing].tolist()]:
            solid = self._caster.solids.solids[row]
            earlier = int(moves.before[row])
            if stands and earlier == STANDS and not any(found):
                # A solid that has been in the beam before does not cross it.
                break
            if solid.is_passed_by(sensor) or not solid.geometry.lasting:
                continue
            matrix = _relative_to(centre, now.matrix[row])
            first = matrix if earlier == STANDS else _relative_to(centre, before.matrix[earlier])
            triangles = self._triangles_of(solid.geometry, now.shapes[row])
            ways = _ends_in_body(Movement(first, matrix), move, points, tolerance)
            found.append(crossings(ways, beam.length, triangles, solid.number))
        return joined(found)

    def _moves_since(self, before: SolidsAtStep, now: SolidsAtStep) -> SolidMotion:
        """Return the motion of the solids from the step `before` to the step `now`.

        It is computed once for all sensors.
        """
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
        # A solid that is flat or NaN at either step has no swept volume.
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
        # A solid that is suddenly mirrored has no rigid motion between the steps.
        sides = np.linalg.det(now.matrix[known, :3, :3] @ before.matrix[earlier, :3, :3])
        moved = known[rigid & (sides > 0.0)]
        earlier = rows[moved]
        standing = np.full(len(rows), STANDS, np.intp)
        standing[moved] = earlier
        lo, hi = now.lo.copy(), now.hi.copy()
        # A solid without bounds at the earlier step has swept nothing.
        lo[came], hi[came] = np.inf, -np.inf
        sagitta = _sagittas(before, earlier, now, moved)[:, None]
        lo[moved] = np.minimum(before.lo[earlier], now.lo[moved]) - sagitta
        hi[moved] = np.maximum(before.hi[earlier], now.hi[moved]) + sagitta
        return SolidMotion(standing, lo, hi, moved)

    def _triangles_of(self, geometry: Geometry, surface: Surface) -> TriangleTree:
        known = self._triangles.get(geometry)
        if known is None or known[0] is not surface:
            if geometry.deforms:
                corners = surface.points.T[surface.triangles[0].T].astype(np.float64)
            else:
                triangles = geometry.triangles(self._caster.frames.depsgraph)
                corners = geometry.vertices[triangles].astype(np.float64)
            known = self._triangles[geometry] = surface, TriangleTree(corners)
        return known[1]


def _ends_in_body(body: Movement, sensor: Movement, points: Array, tolerance: float) -> Array:
    """Return the end points of k rays in the space of a moving body, shape (n + 1, k, 2, 3).

    The time between the steps is split into n intervals, at whose limits the end points are given.
    Between the limits, the end points move straight within `tolerance`.

    Parameters
    ----------
    body, sensor
        The movements of the body and of the sensor.
    points
        The end points (k, 2, 3) in the sensor's space at the later step.
    tolerance
        The largest error, in Blender units.
    """
    ends = points.reshape(-1, 3)
    pieces = pieces_needed(body, sensor, ends, tolerance)
    seen = seen_from(body, sensor, np.linspace(0.0, 1.0, pieces + 1), ends)
    return seen.reshape(pieces + 1, *points.shape)


def _rows_of(numbers: NDArray[np.int64], before: SolidsAtStep) -> Rows:
    """Return the rows (n,) in `before` of the solids `numbers` (n,); STANDS for a new solid."""
    if np.array_equal(numbers, before.numbers):
        return np.arange(len(numbers))
    known = {number: row for row, number in enumerate(before.numbers.tolist())}
    return np.array([known.get(number, STANDS) for number in numbers.tolist()], np.intp)


def _sagittas(before: SolidsAtStep, earlier: Rows, now: SolidsAtStep, moved: Rows) -> Array:
    """Return the largest distance (m,) of points of the moved solids from straight paths.

    It is 0 for a solid that does not rotate. `earlier` and `moved` are the rows of the m solids in
    `before` and in `now`.
    """
    change = now.matrix[moved] - before.matrix[earlier]
    turns = (change[:, :3, :3] != 0.0).any(axis=(1, 2))
    # The corners of the bounds enclose the points of the solids, at both steps.
    middle = (before.lo[earlier] + before.hi[earlier]) / 2.0
    shift = (now.lo[moved] + now.hi[moved]) / 2.0 - middle
    sizes = [
        np.linalg.norm(solids.hi[at] - solids.lo[at], axis=1)
        for solids, at in ((before, earlier), (now, moved))
    ]
    farthest = np.linalg.norm(shift, axis=1) + (sizes[0] + sizes[1]) / 2.0
    return np.where(turns, SAGITTA * farthest, 0.0)


def _swept_bounds(move: Movement, ends: Array) -> tuple[Array, Array]:
    """Return the bounds (3,), (3,) of the space that points sweep.

    `move` is the movement of the points, and `ends` (k, 3) are their positions at its end.
    """
    start = seen_from(Movement(np.eye(4), np.eye(4)), move, np.zeros(1), ends)[0]
    lo, hi = _bounds(np.stack([start, ends]))
    sagitta = SAGITTA * float(np.linalg.norm(ends - start, axis=1).max()) if move.angle else 0.0
    return lo - sagitta, hi + sagitta


def _bounds(points: Array) -> tuple[Array, Array]:
    """Return the bounds (3,), (3,) of points (n, m, 3)."""
    return points.min(axis=(0, 1)), points.max(axis=(0, 1))


def _overlap(moves: SolidMotion, rows: Rows, lo: Array, hi: Array) -> NDArray[np.bool_]:
    """Return the mask (m,) of the solids `rows` (m,) whose swept bounds overlap a box."""
    return np.asarray(((moves.lo[rows] <= hi) & (moves.hi[rows] >= lo)).all(axis=1))


def _relative_to(centre: Array, matrix: Array) -> Array:
    """Return a matrix (4, 4) whose translation is relative to the point `centre` (3,)."""
    seen = matrix.copy()
    seen[:3, 3] -= centre
    return seen
