# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds where a person stands to sit, lie down or use an object, and where hips or hand go."""

from __future__ import annotations

import math

import numpy as np

from ....sensor_logic.model import Array
from ....sensor_logic.residents.places import CURTAIN, LAMP, LIE, SIT, STAND, Place
from ...coverage.cells import finished, free_ways
from ...scene.rooms import set_room
from .floor import WalkedStorey
from .looks import look_of
from .marked_object import MarkedObject

# m: who stands before a seat has the hips so far before where they will be.
BEFORE_SEAT_M = 0.57
# Hips are so far behind a seat's front, or a bed's edge.
ON_SEAT_M, ON_EDGE_M = 0.3, 0.22
# Heights of seats and beds above the floor.
SEATS_M = (0.15, 1.1)
# Between the body's middle and the front of what is used; to a point, such as an empty.
USED_FROM_M, POINT_FROM_M = 0.3, 0.45
# Hands are at this height at what is higher.
HAND_M = 1.1
# Nobody reaches higher.
REACH_M = 2.2
# A place to stand is looked for within this, and has so much room around it at least.
WITHIN_M, ROOM_M = 1.2, 0.12
# What is not on everybody's way counts as so much farther away.
APART_M = 1.5
# So does what is so near to a shut leaf, which would meet who stands there.
LEAF_M, IN_DOORWAY_M = 0.3, 0.5
# No wall may be between who stands there and the object, at this height above the floor.
SIGHT_M = 1.25
# Cells that are tried.
TRIED = 400
STEP_M = 0.02
# A seat may have a hole: it is as high as it is anywhere so near.
AT_HIPS_M = 0.08
# The target itself may lie in what it is marked on, or in what stands there.
SHORT_M = 0.12


def place_of(
    marked: MarkedObject, ground: WalkedStorey, number: int, target: MarkedObject | None = None
) -> Place:
    """The place of a marked object; `target`: what the hand goes to instead of the object."""
    mark = marked.obj.angen_place
    look = look_of(marked.obj, marked.matrix)
    floor = ground.storey.height
    edge = None
    if mark.use == STAND:
        point = marked.middle
        at, target_at = point[:2], np.array([*point[:2], floor])
    elif mark.use == SIT:
        target_at = _seat(marked, look, floor)
        ideal = target_at[:2] + look * (mark.away or BEFORE_SEAT_M)
        at = stand(ground, marked, ideal, target_at)
    elif mark.use == LIE:
        target_at = _bed(marked, look)
        at, edge = _bedside(ground, marked, look, target_at)
    else:
        aimless = mark.use in (LAMP, CURTAIN)
        at, target_at = _used(ground, target or marked, look, mark.away, aimless)
        away = target_at[:2] - at
        look = away / np.linalg.norm(away) if np.linalg.norm(away) > 1e-6 else look
    yaw = math.atan2(look[1], look[0])
    noted = set_room(marked.obj, ground.storey.rooms)
    room = noted or ground.storey.room_at(at)
    guessed = not noted and ground.storey.is_guessed_at(at)
    standing = np.array([*at, floor])
    height = float(target_at[2]) - floor
    return Place(
        marked.obj.name, mark.use, standing, yaw, target_at, height, room, edge, number, guessed,
        marked.size,
    )  # fmt: skip


def stand(
    ground: WalkedStorey, marked: MarkedObject, ideal: Array, target: Array, ring: float = 0.0
) -> Array:
    """(2,) m: the best place to stand near `ideal` (2,), or at `ring` m from it, with no wall
    between it and `target` (3,); `ideal` itself where there is none."""
    floor = ground.storey.floor
    cells = np.argwhere(floor.free & (floor.clearance >= ROOM_M))
    points = floor.low + (cells + 0.5) * floor.size
    off = np.linalg.norm(points - ideal, axis=1)
    near = off <= WITHIN_M + ring
    cells, points, off = cells[near], points[near], np.abs(off[near] - ring)
    # Beside a seat, where a table is before it.
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
    # The middle of a cell is not better than what lies in it.
    exact = floor.cell(ideal)
    seen = _sees(ground, marked, points[order], target)
    if not seen.any():
        return ideal
    best = order[int(np.argmax(seen))]
    same = tuple(cells[best].tolist()) == exact
    found: Array = ideal if same else points[best]
    return found


def _sees(ground: WalkedStorey, marked: MarkedObject, points: Array, target: Array) -> Array:
    """(n,): whether nothing but the object is between points (n, 2) and a target, at the height of
    a breast."""
    home = ground.home
    rows = np.setdiff1d(home.rows, marked.rows)
    way = target[:2] - points
    length = np.linalg.norm(way, axis=1)
    far = np.maximum(length - SHORT_M, 1e-3)
    level = np.full(len(points), ground.storey.height + SIGHT_M)
    ways = np.column_stack([way / np.maximum(length, 1e-9)[:, None], np.zeros(len(points))])
    starts = np.column_stack([points, level])
    ranges, _ = home.caster.first_met(
        home.depsgraph, rows, starts / home.metres, ways, far / home.metres
    )
    seen: Array = ranges * home.metres >= far * (1 - 1e-6)
    return seen


def _seat(marked: MarkedObject, look: Array, floor: float) -> Array:
    """(3,): what the hips rest on."""
    if not marked.solid:
        return marked.at
    middle, deep, wide = marked.box(look)
    across = np.array([-look[1], look[0]]) * min(0.1, wide / 2)
    along = np.arange(deep, -deep, -STEP_M)
    lines = [middle + along[:, None] * look + across * k for k in (-1, 0, 1)]
    tops = np.array([marked.heights(line) for line in lines]) - floor
    height = np.where((tops >= SEATS_M[0]) & (tops <= SEATS_M[1]), tops, np.nan)
    known = np.isfinite(height).any(axis=0)
    if not known.any():
        return np.array([*middle, float(marked.points[:, 2].max())])
    front = float(along[np.argmax(known)])
    # Of what is shallow, as a stool, the middle.
    hips = max(front - ON_SEAT_M, (front - deep) / 2.0)
    there = np.abs(along - hips) <= AT_HIPS_M
    top = np.nanmax(height[:, there]) if (known & there).any() else np.nanmax(height)
    return np.array([*(middle + look * hips), floor + float(top)])


def _bed(marked: MarkedObject, look: Array) -> Array:
    """(3,): what the hips rest on of who lies."""
    if not marked.solid:
        return marked.at
    middle, deep, wide = marked.box(look)
    across = np.array([-look[1], look[0]])
    s = np.linspace(-0.25, 0.25, 5)
    points = [middle + look * a * deep + across * b * wide for a in s for b in s]
    tops = marked.heights(np.array(points))
    top = float(np.nanmedian(tops)) if np.isfinite(tops).any() else float(marked.middle[2])
    return np.array([*middle, top])


def _bedside(
    ground: WalkedStorey, marked: MarkedObject, look: Array, target: Array
) -> tuple[Array, Array]:
    """The point (2,) where a person stands beside a bed, and the one (3,) where they sit on its
    edge."""
    across = np.array([-look[1], look[0]])
    sides = []
    for side in (across, -across):
        edge = _edge(ground, marked, target, side)
        ideal = target[:2] + side * (edge - ON_EDGE_M + BEFORE_SEAT_M)
        at = stand(ground, marked, ideal, np.array([*(target[:2] + side * edge), target[2]]))
        here = ground.storey.floor.cell(at)
        apart = 0.0 if ground.part[here] == ground.main else APART_M
        free = bool(ground.storey.floor.free[here])
        off = float(np.linalg.norm(at - ideal)) + apart + (0.0 if free else WITHIN_M)
        sides.append((off, at, side * (edge - ON_EDGE_M)))
    _, at, sitting = min(sides, key=lambda found: found[0])
    return at, target + np.array([*sitting, 0.0])


def _edge(ground: WalkedStorey, marked: MarkedObject, target: Array, side: Array) -> float:
    """The distance in m from the target to the bed's edge on one side."""
    if marked.solid:
        return float(marked.reach(side)[1] - target[:2] @ side)
    steps = np.arange(0.05, 1.5, STEP_M)
    starts = np.column_stack(
        [target[:2] + steps[:, None] * side, np.full(len(steps), target[2] + 0.15)]
    )
    drops = finished(free_ways(ground.home, starts, np.array([0.0, 0.0, -1.0]), 0.5))
    over = np.flatnonzero(drops > 0.3)
    return float(steps[over[0]]) if len(over) else 0.45


def _used(
    ground: WalkedStorey, marked: MarkedObject, look: Array, away: float, aimless: bool
) -> tuple[Array, Array]:
    """Where one stands (2,) and where the hand goes (3,); `aimless`: from any side."""
    floor = ground.storey.height
    if aimless:
        at = stand(ground, marked, marked.middle[:2], marked.middle, ring=POINT_FROM_M)
        return at, marked.middle
    if not marked.solid:
        target, front, usual = marked.at, marked.at[:2], POINT_FROM_M
    else:
        middle, deep, _ = marked.box(look)
        front, usual = middle - look * deep, USED_FROM_M
        top = float(marked.points[:, 2].max())
        hand = min(top, floor + HAND_M)
        target = np.array([*(front + look * min(0.15, deep)), hand])
    return stand(ground, marked, front - look * (away or usual), target), target
