# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where in a home somebody can move: the cells of its floors that have room."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...sensor_logic.coverage.grid import Cells
from ...sensor_logic.coverage.motions import DIRECTIONS, HEADINGS, Motion
from ...sensor_logic.error import AngenError
from ...sensor_logic.model import Array
from ..plan.fields import placed
from ..plan.storeys import levels
from ..scene.home import EvaluatedHome
from ..scene.sensors import Sensor
from .cells import (
    MOST_CELLS,
    OVER_M,
    PIT_M,
    RUG_M,
    Grid,
    Steps,
    flood,
    floors,
    free_ways,
    passable,
    saying,
)
from .rooms import Labels, Volume, labels_of, volumes

# Rooms reach at most this far (m) from the sensors that tell of them.
BEYOND_M = 10.0
# Heights (m) of a body are this far apart at most, where its surroundings are felt for obstacles.
EVERY_M = 0.4


def cells_of(
    home: EvaluatedHome,
    sensors: Sequence[Sensor],
    motion: Motion,
    size: float,
    rooms: Sequence[str] = (),
) -> Iterator[str | Cells]:
    """Yields what is being done, and last the cells where the body can move; only those of
    `rooms`, if any are named. Raises AngenError."""
    yield "looking for the floor"
    parts = []
    marked = volumes(home)
    for number, (floor, members) in enumerate(storeys_of(home, sensors, marked)):
        grid = _grid(home, floor, members, marked, size)
        labels = yield from saying("looking for rooms", labels_of(home, grid, members, marked))
        found = _storey_cells(home, grid, labels, motion, number)
        parts.append((yield from saying("looking where there is room to move", found)))
    every = _joined(parts, size)
    known = every.rooms
    whole = every.of(rooms) if rooms else every
    for name in rooms:
        if name not in known:
            raise AngenError(
                f"no room '{name}' with free floor was found; there are "
                f"{', '.join(known) or 'none'}. A room is named by the field Room of a sensor in "
                "it, or of a mesh that marks it and is Ignored by sensors"
            )
    if not len(whole):
        raise AngenError(
            "no free floor was found under the sensors: rooms need a floor, and sensors that hang "
            "inside them; or take smaller cells"
        )
    yield whole


def storeys_of(
    home: EvaluatedHome, sensors: Sequence[Sensor], marked: Sequence[Volume]
) -> list[tuple[float, list[Sensor]]]:
    """Heights of floors in m with the sensors over each."""
    inside = [s for s in sensors if s.kind.in_room]
    seen = [p for p in (placed(home, sensor) for sensor in inside) if p is not None]
    by_name = {s.name: s for s in inside}
    found = [
        (level.floor, [by_name[p.name] for p in level.sensors]) for level in levels(home, seen)
    ]
    for volume in marked:
        if not any(abs(volume.lo[2] - floor) < 1.0 for floor, _ in found):
            found.append((float(volume.lo[2]), []))
    if not found:
        raise AngenError(
            "no room is known: put a motion detector or a light sensor into it, or mark it with a "
            "box that is Ignored by sensors and has its Room noted (Physics tab, Sensor)"
        )
    return sorted(found, key=lambda storey: storey[0])


def _grid(
    home: EvaluatedHome,
    floor: float,
    members: Sequence[Sensor],
    marked: Sequence[Volume],
    size: float,
) -> Grid:
    """A grid as large as the home there, but only so far from sensors and marks as they can
    matter."""
    near = [np.array(s.world_matrix(home.depsgraph).translation)[:2] * home.metres for s in members]
    low = np.array([p - BEYOND_M for p in near] + [v.lo[:2] for v in marked]).min(axis=0)
    high = np.array([p + BEYOND_M for p in near] + [v.hi[:2] for v in marked]).max(axis=0)
    there = np.isfinite(home.lo).all(axis=1) & np.isfinite(home.hi).all(axis=1)
    there &= (home.lo[:, 2] < floor + OVER_M) & (home.hi[:, 2] > floor - PIT_M)
    if there.any():
        low = np.maximum(low, home.lo[there, :2].min(axis=0))
        high = np.minimum(high, home.hi[there, :2].max(axis=0))
    first = np.floor(low / size)
    shape = np.maximum(np.ceil(high / size) - first, 1).astype(int)
    if shape.prod() > MOST_CELLS:
        raise AngenError(
            f"cells of {size:g} m make {shape.prod()} of them, more than {MOST_CELLS}: "
            "take larger ones"
        )
    return Grid(first * size, (int(shape[0]), int(shape[1])), size, floor)


def _storey_cells(
    home: EvaluatedHome, grid: Grid, labels: Labels, motion: Motion, number: int
) -> Steps[Cells]:
    """The cells of the rooms where the body can be."""
    top = min(motion.top + 0.02, OVER_M)
    limit = max(motion.bottom, RUG_M)
    in_room = labels.number > 0
    high = yield from floors(home, grid, OVER_M)
    low = yield from floors(home, grid, top)
    open_sky = (high <= limit).reshape(grid.shape) & in_room
    under = (low <= limit).reshape(grid.shape) & in_room
    middle = (max(motion.bottom, RUG_M) + motion.top) / 2.0
    # Under tables a low body gets, into a solid none.
    ways = yield from passable(home, grid, middle)
    reached = (yield from flood(open_sky.astype(np.int64), under | open_sky, ways)) > 0
    cells = np.flatnonzero((reached & under).ravel())
    names = np.array([*labels.names], object)[labels.number.ravel()[cells] - 1]
    at = grid.at(0.0)[cells]
    clearance = yield from _clearance(home, at, motion)
    lengths = motion.lengths(clearance)
    fits = (clearance.min(axis=1, initial=np.inf) >= motion.room) & (lengths > 0.0).any(axis=1)
    return Cells(
        grid.size,
        at[fits],
        tuple(str(name) for name in names[fits]),
        np.full(int(fits.sum()), number),
        lengths[fits],
    )


def _clearance(home: EvaluatedHome, at: Array, motion: Motion) -> Steps[Array]:
    """(n, 8) m: how far it is free around cells, over the height of the body."""
    low, high = max(motion.bottom, RUG_M), motion.top
    heights = np.linspace(low, high, max(2, int(np.ceil((high - low) / EVERY_M)) + 1))
    reach = (motion.step if motion.walks else 0.0) + max(
        motion.radius, motion.length if not motion.walks else motion.length / 2.0
    )
    clearance = np.full((len(at), DIRECTIONS), reach + 1e-6)
    for column, heading in enumerate(HEADINGS.tolist()):
        way = np.array([np.cos(heading), np.sin(heading), 0.0])
        for height in heights.tolist():
            points = at + np.array([0.0, 0.0, height])
            free = yield from free_ways(home, points, way, reach + 1e-6)
            clearance[:, column] = np.minimum(clearance[:, column], free)
    return clearance


def _joined(parts: Sequence[Cells], size: float) -> Cells:
    names: tuple[str, ...] = sum((part.room for part in parts), ())
    if not parts:
        return Cells(size, np.empty((0, 3)), (), np.empty(0, np.intp), np.empty((0, DIRECTIONS)))
    return Cells(
        size,
        np.concatenate([part.at for part in parts]),
        names,
        np.concatenate([part.storey for part in parts]),
        np.concatenate([part.lengths for part in parts]),
    )
