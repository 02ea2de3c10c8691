# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the evaluated scene frame by frame, into batches of frames that the sensors sense together.

A batch has the poses and shapes of the moving solids at each frame, and the parameters and poses of
the sensors. A run captures batches of many frames, and live sensors a batch of a single frame.

Python code between two frames evicts Blender's data from the processor's caches: the next frame
then takes two to three times as long. So each frame only copies the data that change, and arrays
are computed for many frames together.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.kind import USES
from ...sensor_logic.model import Array
from .rays.geometry import Surface, read_surface
from .rays.solids import Solids, invertible, matrices_of, pointers_of, world_bounds
from .sensor_reader import Read, SensorReader
from .sensors import Sensor
from .uses import is_in_use, may_change

Index = NDArray[np.intp]
# The most frames in a batch, and the most bytes that their copies take.
MOST_FRAMES = 256
MOST_BYTES = 1 << 26


class Frames:
    """A batch of k captured frames: the m moving solids (visible objects, instances) and sensors.

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
    depsgraph
        The evaluated depsgraph of the whole scene at the last frame; None for an empty scene.
    steps
        The first step (k,) of each frame. A frame lasts until the first step of the next.
    last
        The last step of the last frame.
    reads
        What was read of the sensors that can change, by the index of the frame.
    used
        Whether the object that a sensor watches is in use at each frame (k,), by the sensor's
        name. Objects whose use cannot change with the frame are left out.
    edits
        The number of possible edits of the scene so far.
    column
        The index of each solid along the axis of length m, by its row in `Solids`.
    """

    def __init__(
        self,
        rows: Index,
        matrix: Array,
        lo: Array,
        hi: Array,
        version: Index,
        depsgraph: Any = None,
    ) -> None:
        self.rows = rows
        self.depsgraph = depsgraph
        self.matrix, self.lo, self.hi, self.version = matrix, lo, hi, version
        self.column = {row: column for column, row in enumerate(rows.tolist())}
        # Surfaces at each frame, by row of the solids that change shape.
        self.surfaces: dict[int, list[Surface]] = {}
        self.steps: Sequence[int] = ()
        self.last = -1
        self.reads: dict[tuple[SensorReader, int], Read | None] = {}
        self.used: dict[str, NDArray[np.bool_]] = {}
        self.edits = 0

    @classmethod
    def unchanged(cls, solids: Solids, depsgraph: Any = None, count: int = 1) -> Frames:
        """Return `count` equal frames, with the solids as they were read last."""
        rows = np.flatnonzero(solids.moving)
        placed = solids.matrix[rows], solids.lo[rows], solids.hi[rows]
        matrix, lo, hi = (np.repeat(part[None], count, axis=0) for part in placed)
        version = np.repeat(solids.version[None, rows], count, axis=0)
        return cls(rows, matrix, lo, hi, version, depsgraph)

    def __len__(self) -> int:
        return len(self.version)

    def at(self, steps: Index) -> Index:
        """Return the index (n,) of the frame at each step (n,)."""
        return np.searchsorted(np.array(self.steps), steps, side="right") - 1

    def part(self, steps: Index) -> Index:
        """Return the part of the ascending `steps` (n,) that lies within the batch."""
        return steps[slice(*np.searchsorted(steps, (self.steps[0], self.last + 1)))]

    def reads_of(self, reader: SensorReader, frames: Index) -> list[Read | None]:
        """Return the parameters and poses of a sensor at frames, given by index (n,).

        They are a single item for all frames if the sensor was not read at each frame. It is read
        now in that case. Raise AngenError if it cannot be read.
        """
        if (reader, int(frames[0])) not in self.reads:
            return [reader.read(self.depsgraph, self.edits)]
        return [self.reads[reader, frame] for frame in frames.tolist()]

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


class Capture:
    """Reads an evaluated scene frame by frame: its solids and sensors become batches, as `Frames`.

    Parameters
    ----------
    single
        Whether each batch is a single frame.

    Attributes
    ----------
    solids
        The list of solids. It has their state at the last frame of the last finished batch.
    steps
        The first step of each frame so far.
    last
        The last step of the newest frame.
    """

    def __init__(self, solids: Solids, single: bool = False) -> None:
        self.solids = solids
        self._single = single
        # The pointer of the depsgraph that was copied last, and of its objects the pointers, the
        # session uids, and the row of each one's solid.
        self._watched = 0
        self._listed: list[int] = []
        self._uids: set[int] = set()
        self._solid_of: list[int | None] = []
        # Matrices at the last frame of the batch before, and at each frame of this batch.
        self._world = np.empty(0, np.float32)
        self._worlds: list[NDArray[np.float32]] = []
        # Surfaces of the objects that change shape, by session uid: at the last frame, and at each
        # frame at which Blender reported a change.
        self._latest: dict[int, Surface] = {}
        self._shapes: list[dict[int, Surface]] = []
        self._keeps_faces: dict[int, bool] = {}
        self._bytes = 0
        # Whether the batch is one frame at which the solids were listed.
        self._is_new = False
        self.steps: list[int] = []
        self.last = -1
        self._reads: dict[tuple[SensorReader, int], Read | None] = {}
        self._edits = 0
        # The sensors whose watched object may be used or not, and at each frame whether it is.
        self._watching: list[Sensor] = []
        self._used: list[list[bool]] = []

    def __len__(self) -> int:
        return len(self._worlds)

    def watch_uses(self, sensors: Iterable[Sensor]) -> None:
        """Read at each frame whether the objects that these sensors watch are in use."""
        self._watching = [s for s in sensors if s.kind.requires(USES) and may_change(s)]

    @property
    def full(self) -> bool:
        """Whether the batch has reached its limit of frames or of memory.

        A frame with a new list is a batch of its own: instances may be gone at the next frame.
        """
        alone = self._is_new or self._single
        return alone or len(self) >= MOST_FRAMES or self._bytes >= MOST_BYTES

    @property
    def edits(self) -> int:
        """The number of possible edits of the scene so far; pure changes of frame do not count."""
        return self.solids.edits + self._edits

    def note_edits(self) -> None:
        """Count a possible edit, because other code could have changed the scene.

        Blender would report this edit only at the next evaluation.
        """
        self._edits += 1

    def read(self, depsgraph: Any, step: int = 0) -> Frames:
        """Return the present frame of an evaluated scene, as a batch of a single frame.

        `step` is the step of the frame.
        """
        if not self.add(depsgraph):
            self.add_first(depsgraph, depsgraph)
        self.read_sensors([step], depsgraph, depsgraph, ())
        return self.finish(depsgraph)

    def add_first(self, depsgraph: Any, watched: Any) -> bool:
        """Copy the first frame of a batch after `add` has returned False.

        Return whether the solids had to be listed anew. `depsgraph` is the depsgraph of the whole
        scene, which must be at this frame. `watched` is the depsgraph from which poses are copied,
        as in `add`.
        """
        self._is_new = not self.solids.is_current(depsgraph)
        if self._is_new:
            self.solids.list_again(depsgraph)
            self._watched = 0
        else:
            self._watch(watched)
            self.add(watched)
        return self._is_new

    def _watch(self, depsgraph: Any) -> None:
        """Copy poses from another depsgraph from now on."""
        solids, objects = self.solids, list(depsgraph.objects)
        uids = [evaluated.original.session_uid for evaluated in objects]
        self._uids = set(uids)
        self._watched, self._listed = depsgraph.as_pointer(), pointers_of(depsgraph)
        self._solid_of = [solids.row_of((uid,)) for uid in uids]
        self._keeps_faces = {}
        # The poses that the solids have so far, which can be those of an earlier frame.
        self._world = self._read_matrices(depsgraph)
        own = {at: row for at, row in enumerate(self._solid_of) if row is not None}
        places = self._world.reshape(-1, 4, 4)
        places[list(own)] = solids.matrix[list(own.values())].transpose(0, 2, 1)

    def _read_matrices(self, depsgraph: Any) -> NDArray[np.float32]:
        world = np.empty(len(self._solid_of) * 16, np.float32)
        depsgraph.objects.foreach_get("matrix_world", world)
        return world

    def add(self, depsgraph: Any) -> bool:
        """Copy the solids at the present frame; return False if the batch must end before it.

        It ends where objects appeared or vanished, or a mesh got other faces. Then call `finish`,
        and `add_first` for this frame.
        """
        solids, shapes = self.solids, {}
        if depsgraph.as_pointer() != self._watched or not solids.is_settled:
            return False
        if not solids.has_objects_of(depsgraph, self._listed):
            return False
        for uid in solids.reshaped:
            geometry = solids.shape_of(uid) if uid in self._uids else None
            if geometry is None:
                continue
            known = self._latest.get(uid, geometry.state)
            if uid not in self._keeps_faces:
                self._keeps_faces[uid] = geometry.keeps_faces
            like = known if self._keeps_faces[uid] else None
            surface = read_surface(geometry.original.evaluated_get(depsgraph), True, like)
            if not surface.has_faces_of(known) and len(self):
                return False
            geometry.deforms = geometry.deforms or uid in solids.bends
            shapes[uid] = surface
        solids.clear_noted()
        world = self._read_matrices(depsgraph)
        self._worlds.append(world)
        self._shapes.append(shapes)
        self._latest |= shapes
        self._bytes += world.nbytes + sum(surface.bytes for surface in shapes.values())
        return True

    def read_sensors(
        self, steps: Sequence[int], depsgraph: Any, watched: Any, readers: Sequence[SensorReader]
    ) -> list[Read | None]:
        """Read sensors at the frame that was copied last, and return what was read.

        Parameters
        ----------
        steps
            The steps between which nothing changes, for which this frame serves.
        depsgraph, watched
            As for `add_first`.
        readers
            The sensors whose parameters or poses can change. Others are read once for the batch.

        Raises
        ------
        AngenError
            If a sensor cannot be read. The frames before are still part of the batch.
        """
        frame = len(self.steps)
        reads = {(one, frame): one.read(depsgraph, self.edits) for one in readers}
        self._reads |= reads
        self._used.append([is_in_use(sensor, watched) for sensor in self._watching])
        self.steps.append(steps[0])
        self.last = steps[-1]
        return list(reads.values())

    def finish(self, depsgraph: Any) -> Frames:
        """Return the copied frames, start a new batch, and set the solids to the last frame.

        `depsgraph` is the depsgraph of the whole scene, which must be at the last frame unless all
        sensors read only what was copied.
        """
        frames = self._copied_solids(depsgraph)
        frames.steps, frames.last, frames.edits = self.steps, self.last, self.edits
        frames.reads, self._reads = self._reads, {}
        used = np.array(self._used, bool).reshape(len(self._used), len(self._watching))
        frames.used = {s.name: used[:, i] for i, s in enumerate(self._watching)}
        self._used = []
        self.steps, self.last = [], -1
        return frames

    def _copied_solids(self, depsgraph: Any) -> Frames:
        solids, count = self.solids, len(self)
        if not count:
            self._is_new = False
            return Frames.unchanged(solids, depsgraph)
        worlds = np.stack([self._world, *self._worlds]).reshape(count + 1, -1, 16)
        changed = (worlds[1:] != worlds[:-1]).any(axis=2)
        moved = np.flatnonzero(changed.any(axis=0)).tolist()
        moves = {row: o for o in moved if (row := self._solid_of[o]) is not None}
        kept, bends = self._changed_surfaces()
        rows = sorted({*moves, *kept})
        solids.set_moving(np.array(rows, np.intp))
        frames = Frames.unchanged(solids, depsgraph, count)
        steps = solids.syncs + 1 + np.arange(count)
        if moves:
            columns, at = [frames.column[row] for row in moves], list(moves.values())
            matrices = matrices_of(worlds[1:, at].reshape(-1, 16))
            frames.matrix[:, columns] = matrices.reshape(count, -1, 4, 4)
            newer = np.where(changed[:, at], steps[:, None], frames.version[:, columns])
            frames.version[:, columns] = newer
        for row, surfaces in kept.items():
            column = frames.column[row]
            newer = np.where(bends[row], steps, 0)
            frames.version[:, column] = np.maximum(newer, frames.version[:, column])
            frames.surfaces[row] = surfaces
        frames.version[:] = np.maximum.accumulate(frames.version, axis=0)
        self._update_bounds(frames, rows)
        self._start_again(frames)
        return frames

    def _start_again(self, frames: Frames) -> None:
        self.solids.syncs += len(frames)
        frames.show(self.solids, -1)
        self._world = self._worlds[-1]
        self._worlds, self._shapes, self._latest, self._bytes = [], [], {}, 0

    def _changed_surfaces(self) -> tuple[dict[int, list[Surface]], dict[int, NDArray[np.bool_]]]:
        """Return the surfaces of solids that changed shape, and masks of the frames with a change.

        Both are by row of the solid in `Solids`, and have one entry for each frame.
        """
        kept: dict[int, list[Surface]] = {}
        bends: dict[int, NDArray[np.bool_]] = {}
        for uid in self._latest:
            geometry = self.solids.shape_of(uid)
            assert geometry is not None
            last, each, other = geometry.state, [], np.zeros(len(self), bool)
            for frame, shapes in enumerate(self._shapes):
                surface = shapes.get(uid, last)
                if surface is not last and not surface.same(last):
                    last, other[frame] = surface, True
                each.append(last)
            if other.any():
                for row in self.solids.rows_of_shape(uid):
                    kept[row], bends[row] = each, other
        return kept, bends

    def _update_bounds(self, frames: Frames, rows: list[int]) -> None:
        """Compute the world bounds of the solids `rows` at all frames."""
        if not rows:
            return
        lo, hi = np.empty((2, len(frames), len(rows), 3))
        for i, row in enumerate(rows):
            shapes: list[Any] = [self.solids.solids[row].geometry]
            shapes = list(frames.surfaces.get(row, shapes))
            lo[:, i], hi[:, i] = [s.lo for s in shapes], [s.hi for s in shapes]
        columns = [frames.column[row] for row in rows]
        matrix = frames.matrix[:, columns]
        bounds = world_bounds(matrix, invertible(matrix), lo, hi)
        frames.lo[:, columns], frames.hi[:, columns] = bounds
