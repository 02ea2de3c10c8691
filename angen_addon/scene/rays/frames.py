# SPDX-License-Identifier: GPL-3.0-or-later
"""Batches of frames, with the poses and shapes of the moving solids at each frame.

Python code between two frames evicts Blender's data from the processor's caches: the next frame
then takes two to three times as long. So each frame only copies the data that change, and arrays
are computed for many frames together.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array
from .geometry import Surface, read_surface
from .solids import Solids, invertible, matrices_of, pointers_of, world_bounds

Index = NDArray[np.intp]
# The most frames in a batch, and the most bytes that their copies take.
MOST_FRAMES = 256
MOST_BYTES = 1 << 26


class Frames:
    """Poses and shapes of the m moving solids (visible objects and instances) at k frames.

    All other solids keep their state in `Solids`.

    Attributes
    ----------
    rows
        Rows (m,) of the solids in `Solids`.
    matrix
        Matrices (k, m, 4, 4) to the world.
    lo, hi
        World bounds (k, m, 3).
    version
        A number (k, m) that changes whenever the solid moves or changes shape.
    column
        The index of each solid along the axis of length m, by its row in `Solids`.
    """

    def __init__(self, rows: Index, matrix: Array, lo: Array, hi: Array, version: Index) -> None:
        self.rows = rows
        self.matrix, self.lo, self.hi, self.version = matrix, lo, hi, version
        self.column = {row: column for column, row in enumerate(rows.tolist())}
        # Surfaces at each frame, by row of the solids that change shape.
        self.surfaces: dict[int, list[Surface]] = {}

    @classmethod
    def present(cls, solids: Solids) -> Frames:
        """Return a single frame, with the solids as at the last synchronisation."""
        rows = np.flatnonzero(solids.moving)
        matrix, lo, hi = solids.matrix[None, rows], solids.lo[None, rows], solids.hi[None, rows]
        return cls(rows, matrix, lo, hi, solids.version[None, rows])

    @classmethod
    def unchanged(cls, solids: Solids, count: int) -> Frames:
        """Return `count` equal frames, with the solids as at the last synchronisation."""
        one = cls.present(solids)
        matrix, lo, hi = (np.repeat(part, count, axis=0) for part in (one.matrix, one.lo, one.hi))
        return cls(one.rows, matrix, lo, hi, np.repeat(one.version, count, axis=0))

    def __len__(self) -> int:
        return len(self.version)

    def show(self, solids: Solids, frame: int) -> None:
        """Set the moving solids in `solids` to their poses and shapes at a frame."""
        at = self.matrix[frame], self.lo[frame], self.hi[frame], self.version[frame]
        solids.show(self.rows, *at)
        for row, surfaces in self.surfaces.items():
            solids.solids[row].geometry.take_over(surfaces[frame])

    def surface(self, solids: Solids, row: int, frame: int) -> Surface:
        """Return the surface that a solid, given by its row in `solids`, has at a frame."""
        kept = self.surfaces.get(row)
        surface: Surface = kept[frame] if kept else solids.solids[row].geometry.state
        return surface


class FrameCopies:
    """Collects copies of the moving solids frame by frame, and returns them as `Frames`."""

    def __init__(self, solids: Solids, depsgraph: Any) -> None:
        self._solids = solids
        objects = list(depsgraph.objects)
        uids = [evaluated.original.session_uid for evaluated in objects]
        self._uids = set(uids)
        self._listed = pointers_of(depsgraph)
        self._solid_of = [solids.row_of((uid,)) for uid in uids]
        self._world = self._read_matrices(depsgraph)
        self._worlds: list[NDArray[np.float32]] = []
        # Surfaces of the objects that change shape, by session uid: before the first frame, and
        # at each frame at which Blender reported a change.
        self._before: dict[int, Surface] = {}
        self._shapes: list[dict[int, Surface]] = []
        self._keeps_faces: dict[int, bool] = {}
        self._bytes = 0

    def __len__(self) -> int:
        return len(self._worlds)

    @property
    def full(self) -> bool:
        """Whether the batch has reached its limit of frames or of memory."""
        return len(self) >= MOST_FRAMES or self._bytes >= MOST_BYTES

    def _read_matrices(self, depsgraph: Any) -> NDArray[np.float32]:
        world = np.empty(len(self._solid_of) * 16, np.float32)
        depsgraph.objects.foreach_get("matrix_world", world)
        return world

    def add(self, depsgraph: Any) -> bool:
        """Copy the solids at the present frame; return False if they must be listed again first.

        They must be listed again after objects appeared or vanished, or a mesh got other faces.
        """
        solids, shapes = self._solids, {}
        if not (solids.is_settled and solids.has_objects_of(depsgraph, self._listed)):
            return False
        for uid in solids.reshaped:
            geometry = solids.shape_of(uid) if uid in self._uids else None
            if geometry is None:
                continue
            known = self._before.setdefault(uid, geometry.state)
            if uid not in self._keeps_faces:
                self._keeps_faces[uid] = geometry.keeps_faces
            like = known if self._keeps_faces[uid] else None
            surface = read_surface(geometry.original.evaluated_get(depsgraph), True, like)
            if known is None or not surface.has_faces_of(known):
                return False
            geometry.deforms = geometry.deforms or uid in solids.bends
            shapes[uid] = surface
        solids.clear_noted()
        world = self._read_matrices(depsgraph)
        self._worlds.append(world)
        self._shapes.append(shapes)
        self._bytes += world.nbytes + sum(surface.bytes for surface in shapes.values())
        return True

    def finish(self) -> Frames:
        """Return the copied frames, start a new batch, and set the solids to the last frame."""
        solids, count = self._solids, len(self)
        worlds = np.stack([self._world, *self._worlds]).reshape(count + 1, -1, 16)
        changed = (worlds[1:] != worlds[:-1]).any(axis=2)
        moved = np.flatnonzero(changed.any(axis=0)).tolist()
        moves = {row: o for o in moved if (row := self._solid_of[o]) is not None}
        kept, bends = self._changed_surfaces()
        solids.set_moving(np.array(sorted({*moves, *kept}), np.intp))
        frames = Frames.unchanged(solids, count)
        steps = solids.syncs + 1 + np.arange(count)
        for row, at in moves.items():
            column = frames.column[row]
            frames.matrix[:, column] = matrices_of(worlds[1:, at])
            frames.version[:, column] = np.where(changed[:, at], steps, frames.version[:, column])
        for row, surfaces in kept.items():
            column = frames.column[row]
            newer = np.where(bends[row], steps, 0)
            frames.version[:, column] = np.maximum(newer, frames.version[:, column])
            frames.surfaces[row] = surfaces
        frames.version[:] = np.maximum.accumulate(frames.version, axis=0)
        self._update_bounds(frames, sorted({*moves, *kept}))
        self._start_again(frames)
        return frames

    def _start_again(self, frames: Frames) -> None:
        solids = self._solids
        solids.syncs += len(frames)
        frames.show(solids, -1)
        self._world = self._worlds[-1]
        self._worlds, self._shapes, self._before, self._bytes = [], [], {}, 0

    def _changed_surfaces(self) -> tuple[dict[int, list[Surface]], dict[int, NDArray[np.bool_]]]:
        """Return the surfaces of solids that changed shape, and masks of the frames with a change.

        Both are by row of the solid in `Solids`, and have one entry for each frame.
        """
        kept: dict[int, list[Surface]] = {}
        bends: dict[int, NDArray[np.bool_]] = {}
        for uid, last in self._before.items():
            each, other = [], np.zeros(len(self), bool)
            for frame, shapes in enumerate(self._shapes):
                surface = shapes.get(uid, last)
                if surface is not last and not surface.same(last):
                    last, other[frame] = surface, True
                each.append(last)
            if other.any():
                for row in self._solids.rows_of_shape(uid):
                    kept[row], bends[row] = each, other
        return kept, bends

    def _update_bounds(self, frames: Frames, rows: list[int]) -> None:
        for row in rows:
            column = frames.column[row]
            shapes: list[Any] = [self._solids.solids[row].geometry]
            shapes = list(frames.surfaces.get(row, shapes))
            lo, hi = np.stack([s.lo for s in shapes]), np.stack([s.hi for s in shapes])
            matrix = frames.matrix[:, column]
            bounds = world_bounds(matrix, invertible(matrix), lo, hi)
            frames.lo[:, column], frames.hi[:, column] = bounds
