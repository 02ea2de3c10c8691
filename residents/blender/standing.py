# SPDX-License-Identifier: GPL-3.0-or-later
"""Find where a person stands to sit, lie down or use an object, and where hips or hand go.

The search needs the floor on which residents can walk, as a grid of cells.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import compress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...angen_addon.plan.rooms import labels_of, storeys_of
from ...angen_addon.plan.storeys import GRAIN_M, around, grouped
from ...angen_addon.scene.home.evaluated_home import EvaluatedHome
from ...angen_addon.scene.home.floor import (
    MOST_CELLS,
    OVER_M,
    PIT_M,
    RUG_M,
    Grid,
    flood,
    floors,
    free_ways,
    passable,
)
from ...angen_addon.scene.home.rooms import Mask, volumes
from ...angen_addon.scene.rays.solids import Solid
from ...angen_addon.scene.sensors import all_sensors, assigned_room
from ...sensor_logic.logs.error import AngenError, InputError
from ...sensor_logic.model import Array
from ...sensor_logic.progress import Doing, Steps, Work, finished, part_of, saying
from ..acting.path_search import Floor, regions
from ..acting.places import BODY_M, CURTAIN, LAMP, LIE, SIT, STAND, Place, Storey
from .marks import MarkedObject, facing_of, is_living_body
from .settings import residents_in

# m: usual size of a cell, and the largest size, for large homes.
SIZE_M, COARSEST_M = 0.05, 0.1
# m: a mark belongs to parts of the floor that are so near.
NEAR_M = 0.8
# m: residents can walk this far around the marks.
AROUND_M = 2.0
# Heights (m) at which nothing may be in the way from one cell to the next.
FELT_M = (0.3, 1.0, 1.6)
# Rays go down around each mark at these distances (m) to find its floor.
RINGS_M, DEEP_M = (0.5, 1.0, 1.6, 2.2), 4.0
# m: largest height of a mark above its floor.
ABOVE_M = 2.7
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class WalkedStorey:
    """A storey, with the grid of cells on which residents can walk.

    Attributes
    ----------
    storey
        The storey's height, floor and rooms.
    home
        The home without residents, and without the doors that they open.
    part
        The number of each cell's connected part of the floor, shape (nx, ny). It is 0 where a body
        does not fit.
    main
        The number of the part of the floor that is near most marked objects.
    doorways
        Points along shut door leaves, near which nobody stands, shape (k, 2), m.
    """

    storey: Storey
    home: EvaluatedHome
    part: NDArray[np.int64]
    main: int
    doorways: Array = field(default_factory=lambda: np.empty((0, 2)))


def walkable_home(home: EvaluatedHome, leaves: Sequence[Any]) -> EvaluatedHome:
    """Return the home without residents and without the door leaves `leaves`.

    Objects parented to a leaf and walking frames are left out too.
    """
    frames = [r.angen_resident.walking_frame for r in residents_in(home.depsgraph.scene)]
    uids = {obj.session_uid for obj in (*leaves, *frames) if obj is not None}

    def stays(solid: Solid) -> bool:
        return not (uids & solid.owners or is_living_body(solid.original))

    return home.part(stays)


def walkable_storeys(
    home: EvaluatedHome,
    walk: EvaluatedHome,
    marks: Array,
    names: Sequence[str],
    things: NDArray[np.intp],
) -> Work[list[WalkedStorey]]:
    """Find the storeys below marked objects, and return them from the lowest to the highest.

    Yield the progress, 0 to 1.

    Parameters
    ----------
    home
        The whole home.
    walk
        The result of `walkable_home`.
    marks
        A point of each marked object, shape (n, 3), m.
    names
        The names of the marked objects, in the same order.
    things
        The rows of the solids of `walk` that are no floor, shape (k,).

    Raises
    ------
    AngenError
        If there is no floor below the marks, or if the marks are too far apart.
    """
    rows = set(things.tolist())
    heights = _floor_heights(walk.part(lambda solid: solid.row not in rows), marks)
    found: list[WalkedStorey] = []
    for height in heights:
        below = [h for h in heights if h <= height]
        mine = [storey_index(heights, z) == len(below) - 1 for z in marks[:, 2].tolist()]
        grid = _storey_grid(height, marks[mine], list(compress(names, mine)))
        part = len(found) / len(heights), (len(found) + 1) / len(heights)
        found.append((yield from part_of(_walked_storey(home, walk, grid, marks[mine]), *part)))
    return found


def storey_index(heights: Sequence[float], z: float) -> int:
    """Return the index of the storey with the highest floor that is at or below a height (m)."""
    below = [k for k, height in enumerate(heights) if height <= z + PIT_M]
    return below[-1] if below else 0


def _floor_heights(home: EvaluatedHome, marks: Array) -> list[float]:
    """Return the heights of the floors below marked objects, m; raise `InputError` without a floor.

    Rays go down around each object. Its floor is at the height at which most rays end.
    """
    starts = (marks[:, None] + around(RINGS_M) + [0.0, 0.0, 0.2]).reshape(-1, 3)
    ranges = finished(free_ways(home, starts, DOWN, DEEP_M))
    hits = (starts[:, 2] - ranges)[ranges < DEEP_M - 1e-6]
    votes = Counter(np.round(hits / GRAIN_M).astype(int).tolist())
    chosen: Counter[int] = Counter()
    for z in marks[:, 2].tolist():
        low, high = (z - ABOVE_M) / GRAIN_M, (z + RUG_M) / GRAIN_M
        of_mark = [grain for grain in votes if low <= grain <= high]
        if of_mark:
            chosen[max(of_mark, key=lambda grain: (votes[grain], -grain))] += 1
    if not chosen:
        raise InputError("no floor is below the marked places: give the home a floor")
    groups = grouped(sorted(chosen), lambda grain: grain * GRAIN_M)
    most = [max(group, key=lambda grain: (chosen[grain], -grain)) for group in groups]
    # The median of the hits is more exact than the rounded height.
    return [float(np.median(hits[np.abs(hits - grain * GRAIN_M) <= GRAIN_M])) for grain in most]


def _walked_storey(
    home: EvaluatedHome, walk: EvaluatedHome, grid: Grid, marks: Array
) -> Work[WalkedStorey]:
    """Find the free cells and rooms of a storey; yield the progress."""
    # Shares of the time, measured in the sample home.
    over = (yield from saying(Doing(0.0), floors(walk, grid, OVER_M))).reshape(grid.shape)
    level = (over <= RUG_M) & (over >= -PIT_M)
    along = []
    for share, felt in zip(np.linspace(0.1, 0.6, len(FELT_M), False), FELT_M, strict=True):
        along.append((yield from saying(Doing(float(share)), passable(walk, grid, felt, level))))
    ways = (
        np.all([pair[0] for pair in along], axis=0),
        np.all([pair[1] for pair in along], axis=0),
    )
    # Rays inside solids hit nothing: only cells connected with a mark are floor.
    seeds = np.where(level & _near_marks(grid, marks), 1, 0)
    reached = (yield from saying(Doing(0.6), flood(seeds, level, ways))) > 0
    free = reached & ~_beside_thin_obstacles(ways, reached)
    part = regions(Floor(grid.low, grid.size, free), BODY_M)
    # Cells that no body can reach are inside walls.
    free &= (yield from saying(Doing(0.65), flood((part > 0).astype(np.int64), free, ways))) > 0
    floor = Floor(grid.low, grid.size, free)
    number, names, guessed = yield from saying(Doing(0.7), _rooms(home, grid, grid.floor))
    part = regions(floor, BODY_M)
    return WalkedStorey(
        Storey(grid.floor, floor, number, names, guessed),
        walk,
        part,
        _main_part(floor, part, marks),
    )


def _storey_grid(height: float, marks: Array, names: Sequence[str]) -> Grid:
    """Return a grid of cells around the marked objects of a storey.

    Raise `InputError` if these are too far apart.
    """
    low, high = marks[:, :2].min(axis=0) - AROUND_M, marks[:, :2].max(axis=0) + AROUND_M
    size = SIZE_M
    area = float(np.prod(high - low + 2 * size))
    if area / size**2 > MOST_CELLS:
        size = float(np.sqrt(area / MOST_CELLS)) * 1.01
    if size > COARSEST_M:
        off = np.linalg.norm(marks[:, :2] - np.median(marks[:, :2], axis=0), axis=1)
        raise InputError(
            f"'{names[int(np.argmax(off))]}' is marked {off.max():.0f} m from the other "
            "places: mark only what belongs to one home"
        )
    first = np.floor(low / size)
    # An even number of cells, because rooms are found on cells twice as large.
    shape = ((np.ceil(high / size) - first + 1) // 2 * 2).astype(int)
    return Grid(first * size, (int(shape[0]), int(shape[1])), size, height)


def _near_marks(grid: Grid, marks: Array) -> Mask:
    """Return which cells are within AROUND_M of a marked object, shape (nx, ny)."""
    points = grid.at(0.0)[:, :2]
    near = np.zeros(len(points), bool)
    for mark in marks[:, :2]:
        near |= ((points - mark) ** 2).sum(axis=1) <= AROUND_M**2
    return near.reshape(grid.shape)


def _beside_thin_obstacles(ways: tuple[Mask, Mask], reached: Mask) -> Mask:
    """Return which cells are next to an obstacle that is thinner than a cell.

    `ways` are True between neighbouring cells without an obstacle, along x and along y. `reached`
    is True for cells of the floor.
    """
    found = np.zeros_like(reached)
    thin = reached[:-1] & reached[1:] & ~ways[0]
    found[:-1] |= thin
    found[1:] |= thin
    thin = reached[:, :-1] & reached[:, 1:] & ~ways[1]
    found[:, :-1] |= thin
    found[:, 1:] |= thin
    return found


def _rooms(
    home: EvaluatedHome, grid: Grid, height: float
) -> Steps[tuple[NDArray[np.int64], tuple[str, ...], Mask]]:
    """Return the room number of each cell, the rooms' names, and which cells have a guessed room.

    The names come from sensors, and from objects that mark rooms. Both arrays have the shape (nx,
    ny).
    """
    view_layer = home.depsgraph.view_layer
    marked = volumes(home.depsgraph)
    try:
        storeys = storeys_of(home, all_sensors(view_layer), marked)
    except AngenError:
        return np.zeros(grid.shape, np.int64), ("",), np.zeros(grid.shape, bool)
    members = [s for floor, group in storeys if abs(floor - height) < 1.0 for s in group]
    here = [volume for volume in marked if abs(volume.lo[2] - height) < 1.0]
    shape = grid.shape[0] // 2, grid.shape[1] // 2
    coarse = Grid(grid.low, shape, 2 * grid.size, height)
    found = yield from labels_of(home, coarse, members, here)
    guessed = found.guessed.repeat(2, 0).repeat(2, 1)
    return found.number.repeat(2, 0).repeat(2, 1), ("", *found.names), guessed


def _main_part(floor: Floor, part: NDArray[np.int64], marks: Array) -> int:
    """Return the number of the part of the floor that is near most marked objects."""
    votes: Counter[int] = Counter()
    for mark in marks:
        x, y = floor.cell(mark)
        reach = int(NEAR_M / floor.size)
        around = part[max(0, x - reach) : x + reach + 1, max(0, y - reach) : y + reach + 1]
        votes.update(set(np.unique(around).tolist()) - {0})
    sizes = np.bincount(part.ravel())
    return max(votes, key=lambda number: (votes[number], int(sizes[number])), default=0)


# Lengths in m.
# A bed or seat of this width takes two people, each on a side. Assumed.
FOR_TWO_M = 1.2
# The other side of a bed is used if a person can stand so near to it.
OTHER_SIDE_M = 0.5
# A person about to sit stands this far in front of where the hips will be.
BEFORE_SEAT_M = 0.57
# Distance of the hips behind a seat's front, and inside a bed's edge.
ON_SEAT_M, ON_EDGE_M = 0.3, 0.22
# Least and greatest height of seats above the floor.
SEATS_M = (0.15, 1.1)
# Distance of a standing body's middle from an object's front, and from a point such as an empty.
USED_FROM_M, POINT_FROM_M = 0.3, 0.45
# Height of the hands at a higher object.
HAND_M = 1.1
# Greatest height that a person reaches.
REACH_M = 2.2
# A point to stand is searched for within WITHIN_M, and has at least ROOM_M of free room around it.
WITHIN_M, ROOM_M = 1.2, 0.12
# Cost of a point in another part of the floor than most marks.
APART_M = 1.5
# A point nearer than LEAF_M to a shut leaf has this cost, because the leaf would hit the person.
LEAF_M, IN_DOORWAY_M = 0.3, 0.5
# Height at which no wall may be between the person and the object.
SIGHT_M = 1.25
# Number of cells that are tried.
TRIED = 400
# Distance between samples of a seat's or bed's height.
STEP_M = 0.02
# A seat may have a hole: its height is the greatest within this distance of the hips.
AT_HIPS_M = 0.08
# Sight lines end this far before the target, which may be inside another object.
SHORT_M = 0.12


def place_of(
    marked: MarkedObject, ground: WalkedStorey, number: int, target: MarkedObject | None = None
) -> Place:
    """Return the place of a marked object.

    If there is a `target`, such as a lamp's switch, the hand reaches for this object instead.
    """
    mark = marked.obj.angen_place
    look = facing_of(marked.obj, marked.matrix)
    floor = ground.storey.height
    edge: Array | None = None
    sides: tuple[_Side, ...] = ()
    if mark.use == STAND:
        point = marked.middle
        at, target_at = point[:2], np.array([*point[:2], floor])
    elif mark.use == SIT:
        target_at = _hips_on_seat(marked, look, floor)
        at = _before_seat(ground, marked, look, target_at)
        sides = _two_seats(ground, marked, look)
    elif mark.use == LIE:
        target_at = _hips_on_bed(marked, look)
        at, edge, sides = _bedside_points(ground, marked, look, target_at)
    else:
        aimless = mark.use in (LAMP, CURTAIN)
        at, target_at = _point_of_use(ground, target or marked, look, mark.away, aimless)
        away = target_at[:2] - at
        look = away / np.linalg.norm(away) if np.linalg.norm(away) > 1e-6 else look
    yaw = math.atan2(look[1], look[0])
    noted = assigned_room(marked.obj, ground.storey.rooms)
    room = noted or ground.storey.room_at(at)
    guessed = not noted and ground.storey.is_guessed_at(at)
    standing = np.array([*at, floor])
    height = float(target_at[2]) - floor
    place = Place(
        marked.obj.name, mark.use, standing, yaw, target_at, height, room, edge, number, guessed,
        marked.size,
    )  # fmt: skip
    own = (
        replace(
            place,
            at=np.array([*side.at, floor]),
            target=side.target,
            height=float(side.target[2]) - floor,
            edge=side.edge,
            side=count,
        )
        for count, side in enumerate(sides, start=1)
    )
    return replace(place, sides=tuple(own))


class _Side(NamedTuple):
    """A side of a bed or seat for two: points as in `Place`; `at` (2,) is on the floor."""

    at: Array
    target: Array
    edge: Array | None = None


def standing_point(
    ground: WalkedStorey, marked: MarkedObject, ideal: Array, target: Array, ring: float = 0.0
) -> Array:
    """Return the best point (2,) for a person to stand on near `ideal`, m.

    No wall is between the point and `target`. Without such a point, return `ideal`.

    Parameters
    ----------
    ideal
        A point on the floor, shape (2,), m.
    target
        The point that the person uses, shape (3,), m.
    ring
        If it is not 0, the point is near the circle of this radius (m) around `ideal`.
    """
    floor = ground.storey.floor
    cells = np.argwhere(floor.free & (floor.clearance >= ROOM_M))
    points = floor.low + (cells + 0.5) * floor.size
    off = np.linalg.norm(points - ideal, axis=1)
    near = off <= WITHIN_M + ring
    cells, points, off = cells[near], points[near], np.abs(off[near] - ring)
    # If a table is in front of a seat, prefer a point beside the seat.
    far = np.linalg.norm(points - target[:2], axis=1)
    cost = (
        0.5 * off
        + np.maximum(far - BEFORE_SEAT_M, 0.0)
        + np.where(ground.part[tuple(cells.T)] == ground.main, 0.0, APART_M)
    )
    if len(ground.doorways) and len(points):
        gaps = np.linalg.norm(points[:, None] - ground.doorways, axis=2).min(axis=1)
        cost += np.where(gaps < LEAF_M, IN_DOORWAY_M, 0.0)
    order = np.argsort(cost, kind="stable")[:TRIED]
    if not len(order):
        return ideal
    # Within its own cell, the ideal point is as good as the cell's middle.
    exact = floor.cell(ideal)
    seen = _is_in_sight(ground, marked, points[order], target)
    if not seen.any():
        return ideal
    best = order[int(np.argmax(seen))]
    same = tuple(cells[best].tolist()) == exact
    found: Array = ideal if same else points[best]
    return found


def _is_in_sight(ground: WalkedStorey, marked: MarkedObject, points: Array, target: Array) -> Array:
    """Return whether the target is visible from each point (n, 2), shape (n,).

    The marked object itself hides nothing. Rays go at the height SIGHT_M above the floor.
    """
    home = ground.home
    rows = np.setdiff1d(home.rows, marked.rows)
    way = target[:2] - points
    length = np.linalg.norm(way, axis=1)
    far = np.maximum(length - SHORT_M, 1e-3)
    level = np.full(len(points), ground.storey.height + SIGHT_M)
    ways = np.column_stack([way / np.maximum(length, 1e-9)[:, None], np.zeros(len(points))])
    starts = np.column_stack([points, level])
    ranges, _ = home.caster.first_hits(rows, starts / home.metres, ways, far / home.metres)
    seen: Array = ranges * home.metres >= far * (1 - 1e-6)
    return seen


def _before_seat(ground: WalkedStorey, marked: MarkedObject, look: Array, target: Array) -> Array:
    """Return the point (2,) where a person stands before sitting down, m."""
    ideal = target[:2] + look * (marked.obj.angen_place.away or BEFORE_SEAT_M)
    return standing_point(ground, marked, ideal, target)


def _two_seats(ground: WalkedStorey, marked: MarkedObject, look: Array) -> tuple[_Side, ...]:
    """Return both halves of a seat that is wide enough for two; () for any other."""
    if not marked.solid or 2.0 * (wide := marked.box(look)[2]) < FOR_TWO_M:
        return ()
    halves = [_hips_on_seat(marked, look, ground.storey.height, k * wide / 2.0) for k in (1, -1)]
    return tuple(_Side(_before_seat(ground, marked, look, half), half) for half in halves)


def _hips_on_seat(marked: MarkedObject, look: Array, floor: float, aside: float = 0.0) -> Array:
    """Return the point on a seat where the hips rest, shape (3,), m.

    It is `aside` m to the left of the seat's middle, for a person who sits there.
    """
    if not marked.solid:
        return marked.at
    middle, deep, wide = marked.box(look)
    left = np.array([-look[1], look[0]])
    middle = middle + left * aside
    across = left * min(0.1, wide / 2)
    along = np.arange(deep, -deep, -STEP_M)
    lines = [middle + along[:, None] * look + across * k for k in (-1, 0, 1)]
    tops = np.array([marked.heights(line) for line in lines]) - floor
    height = np.where((tops >= SEATS_M[0]) & (tops <= SEATS_M[1]), tops, np.nan)
    known = np.isfinite(height).any(axis=0)
    if not known.any():
        return np.array([*middle, float(marked.points[:, 2].max())])
    front = float(along[np.argmax(known)])
    # On a shallow seat, such as a stool, the hips are in the middle.
    hips = max(front - ON_SEAT_M, (front - deep) / 2.0)
    there = np.abs(along - hips) <= AT_HIPS_M
    top = np.nanmax(height[:, there]) if (known & there).any() else np.nanmax(height)
    return np.array([*(middle + look * hips), floor + float(top)])


def _hips_on_bed(marked: MarkedObject, look: Array) -> Array:
    """Return the point on a bed where the hips of a lying person rest, shape (3,), m."""
    if not marked.solid:
        return marked.at
    middle, deep, wide = marked.box(look)
    across = np.array([-look[1], look[0]])
    s = np.linspace(-0.25, 0.25, 5)
    points = [middle + look * a * deep + across * b * wide for a in s for b in s]
    tops = marked.heights(np.array(points))
    top = float(np.nanmedian(tops)) if np.isfinite(tops).any() else float(marked.middle[2])
    return np.array([*middle, top])


def _bedside_points(
    ground: WalkedStorey, marked: MarkedObject, look: Array, target: Array
) -> tuple[Array, Array, tuple[_Side, ...]]:
    """Return the points where a person stands beside a bed (2,), and sits on its edge (3,), m.

    The third result is the two sides of a bed that is wide enough for two. If nobody can stand on
    the other side, as at a wall, both get in on the same one.
    """
    across = np.array([-look[1], look[0]])
    sides = []
    for side in (across, -across):
        edge = _edge_distance(ground, marked, target, side)
        ideal = target[:2] + side * (edge - ON_EDGE_M + BEFORE_SEAT_M)
        beside = np.array([*(target[:2] + side * edge), target[2]])
        at = standing_point(ground, marked, ideal, beside)
        here = ground.storey.floor.cell(at)
        apart = 0.0 if ground.part[here] == ground.main else APART_M
        free = bool(ground.storey.floor.free[here])
        off = float(np.linalg.norm(at - ideal)) + apart + (0.0 if free else WITHIN_M)
        sitting = target + np.array([*(side * (edge - ON_EDGE_M)), 0.0])
        sides.append((off, at, sitting, side, edge))
    _, at, sitting, _, _ = min(sides, key=lambda found: found[0])
    width = sum(edge for *_, edge in sides)
    if width < FOR_TWO_M:
        return at, sitting, ()
    two = []
    for off, own, seat, side, edge in sides:
        hips = target + np.array([*(side * (edge - width / 4.0)), 0.0])
        two.append(_Side(own, hips, seat) if off < OTHER_SIDE_M else _Side(at, hips, sitting))
    return at, sitting, tuple(two)


def _edge_distance(ground: WalkedStorey, marked: MarkedObject, target: Array, side: Array) -> float:
    """Return the distance from the target to the bed's edge in the direction `side`, m."""
    if marked.solid:
        return float(marked.reach(side)[1] - target[:2] @ side)
    steps = np.arange(0.05, 1.5, STEP_M)
    starts = np.column_stack(
        [target[:2] + steps[:, None] * side, np.full(len(steps), target[2] + 0.15)]
    )
    drops = finished(free_ways(ground.home, starts, np.array([0.0, 0.0, -1.0]), 0.5))
    over = np.flatnonzero(drops > 0.3)
    return float(steps[over[0]]) if len(over) else 0.45


def _point_of_use(
    ground: WalkedStorey, marked: MarkedObject, look: Array, away: float, aimless: bool
) -> tuple[Array, Array]:
    """Return where a person stands (2,) and where the hand goes (3,) to use an object, m.

    If `aimless`, the person can stand on any side of the object.
    """
    floor = ground.storey.height
    if aimless:
        at = standing_point(ground, marked, marked.middle[:2], marked.middle, ring=POINT_FROM_M)
        return at, marked.middle
    if not marked.solid:
        target, front, usual = marked.at, marked.at[:2], POINT_FROM_M
    else:
        middle, deep, _ = marked.box(look)
        front, usual = middle - look * deep, USED_FROM_M
        top = float(marked.points[:, 2].max())
        hand = min(top, floor + HAND_M)
        target = np.array([*(front + look * min(0.15, deep)), hand])
    return standing_point(ground, marked, front - look * (away or usual), target), target
