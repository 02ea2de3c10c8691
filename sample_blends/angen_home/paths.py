# SPDX-License-Identifier: GPL-3.0-or-later
"""The way from here to there: the shortest over the plan's waypoints, straightened and rounded."""

import heapq
from collections.abc import Mapping
from math import hypot, radians

import numpy as np

from . import places, plan
from .checks import along, distance_to_box, solids

BODY = 0.26  # free half width that a walker needs
EASY = 0.36  # what she keeps where she may choose
ROUNDING = 0.55  # of a corner, at the most
LEAF_POINTS = 11

Point = tuple[float, float]
DoorYaws = Mapping[str, float]
_SOLIDS = tuple(solids())


class NoWayError(ValueError):
    """There is no way for a walker; the text says why."""


def leaf_points(name: str, yaw: float) -> list[Point]:
    """Points along a door's leaf that stands at the yaw (degrees)."""
    door = plan.DOORS[name]
    return [
        door.at(k / (LEAF_POINTS - 1) * door.leaf_width, -plan.LEAF_THICKNESS / 2, yaw)
        for k in range(LEAF_POINTS)
    ]


def clearance(p: Point, leaves: list[Point]) -> float:
    """Distance (m) from the point to the next wall, piece of furniture or door leaf."""
    near = min(distance_to_box(p, box) for _, box in _SOLIDS)
    if leaves:
        near = min(near, min(hypot(p[0] - q[0], p[1] - q[1]) for q in leaves))
    return near


def is_free(a: Point, b: Point, radius: float, leaves: list[Point]) -> bool:
    """Whether a walker of that radius can go straight from a to b."""
    return all(clearance(p, leaves) >= radius for p in along(a, b, 0.05))


def _length(a: Point, b: Point) -> float:
    return hypot(b[0] - a[0], b[1] - a[1])


def _neighbours(leaves: list[Point]) -> dict[str, list[str]]:
    graph: dict[str, list[str]] = {name: [] for name in places.WAYPOINTS}
    for a, b in places.WAYS:
        p, q = places.WAYPOINTS[a], places.WAYPOINTS[b]
        if all(min(_length(x, y) for y in leaves) >= BODY - 0.02 for x in along(p, q, 0.05)):
            graph[a].append(b)
            graph[b].append(a)
    return graph


def _entries(p: Point, leaves: list[Point], radius: float) -> list[str]:
    """Waypoints that can be walked to straight from a point."""
    names = [n for n, q in places.WAYPOINTS.items() if _length(p, q) < 3.0]
    return [n for n in names if is_free(p, places.WAYPOINTS[n], radius, leaves)]


def route(start: Point, goal: Point, gate: str, doors: DoorYaws) -> list[Point]:
    """Corner points from start to goal. gate: the waypoint before the goal ("": any)."""
    leaves = [p for name, yaw in doors.items() for p in leaf_points(name, yaw)]
    if is_free(start, goal, BODY, leaves):
        return [start, goal]
    # What stands at a seat or a basin stands nearer to things than it walks.
    reach = min(BODY, clearance(start, leaves) - 0.01, clearance(goal, leaves) - 0.01)
    starts = _entries(start, leaves, reach)
    goals = [gate] if gate else _entries(goal, leaves, reach)
    graph = _neighbours(leaves)
    queue = [(_length(start, places.WAYPOINTS[n]), n, (n,)) for n in starts]
    heapq.heapify(queue)
    seen: set[str] = set()
    while queue:
        cost, name, way = heapq.heappop(queue)
        if name == "":
            return _straightened([start, *(places.WAYPOINTS[n] for n in way), goal], leaves)
        if name in seen:
            continue
        seen.add(name)
        here = places.WAYPOINTS[name]
        if name in goals:
            heapq.heappush(queue, (cost + _length(here, goal), "", way))
        for other in graph[name]:
            if other not in seen:
                step = _length(here, places.WAYPOINTS[other])
                heapq.heappush(queue, (cost + step, other, (*way, other)))
    shut = [name for name, yaw in doors.items() if abs(yaw - plan.DOORS[name].closed_yaw) < 1]
    wide = [
        f"{name} (in front of {plan.DOORS[name].blocks})" if plan.DOORS[name].blocks else name
        for name in doors
        if name not in shut
    ]
    raise NoWayError(
        f"there is no free way; closed doors: {', '.join(shut) or 'none'}; "
        f"doors whose open leaves may be in the way: {', '.join(wide) or 'none'}"
    )


def _straightened(points: list[Point], leaves: list[Point]) -> list[Point]:
    """Without the corners that a walker can cut."""
    out = [points[0]]
    i = 0
    while i < len(points) - 1:
        far = next(
            (j for j in range(len(points) - 1, i + 1, -1)
             if is_free(points[i], points[j], EASY, leaves)),
            i + 1,
        )  # fmt: skip
        if _length(points[far], out[-1]) > 0.02:
            out.append(points[far])
        i = far
    return out


def rounded(points: list[Point], doors: DoorYaws, spacing: float = 0.03) -> np.ndarray:
    """The way as dense points (n, 2), its corners as arcs (quadratic Béziers)."""
    leaves = [p for name, yaw in doors.items() for p in leaf_points(name, yaw)]
    corners = [np.array(p) for p in points]
    out = [corners[0]]
    for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
        into, away = before - corner, after - corner
        trim = min(ROUNDING, 0.48 * np.linalg.norm(into), 0.48 * np.linalg.norm(away))
        while True:
            a = corner + into / np.linalg.norm(into) * trim
            b = corner + away / np.linalg.norm(away) * trim
            t = np.linspace(0, 1, 13)[:, None]
            arc = (1 - t) ** 2 * a + 2 * t * (1 - t) * corner + t**2 * b
            if trim < 0.1 or all(clearance(tuple(p), leaves) >= EASY for p in arc):
                break
            trim *= 0.75
        out.extend(arc)
    out.append(corners[-1])
    line = np.array(out)
    gaps = np.hypot(*np.diff(line, axis=0).T)
    keep = np.concatenate([[True], gaps > 1e-6])
    line, s = line[keep], np.concatenate([[0.0], np.cumsum(gaps)])[keep]
    at = np.linspace(0, s[-1], max(2, int(s[-1] / spacing) + 1))
    return np.stack([np.interp(at, s, line[:, 0]), np.interp(at, s, line[:, 1])], 1)


def door_side(name: str, p: Point) -> float:
    """+1 on the side into which the leaf swings, −1 on the other."""
    door = plan.DOORS[name]
    zero, ahead = door.at(0, 0), door.at(0, 1)
    v = (p[0] - zero[0]) * (ahead[0] - zero[0]) + (p[1] - zero[1]) * (ahead[1] - zero[1])
    return 1.0 if v > -plan.LEAF_THICKNESS / 2 else -1.0


def handle_at(name: str, yaw: float, side: float) -> tuple[float, float, float]:
    """Where a hand holds the door's handle, on the swing side (+1) or the other (−1)."""
    door = plan.DOORS[name]
    off = 0.05 if side > 0 else -plan.LEAF_THICKNESS - 0.05
    return (*door.at(door.leaf_width - 0.11, off, yaw), 1.05)


def door_spot(name: str, side: float, doors: DoorYaws) -> tuple[float, float, float]:
    """Where to stand (x, y, yaw in radians) to move a door: clear of its whole swing, in reach."""
    door = plan.DOORS[name]
    handle = handle_at(name, door.closed_yaw, side)
    others = [p for n, yaw in doors.items() if n != name for p in leaf_points(n, yaw)]
    best: list[tuple[float, Point]] = []
    for u in np.arange(0.2, door.leaf_width + 0.75, 0.05):
        for v in np.arange(0.35, 1.1, 0.05):
            p = door.at(float(u), side * float(v) - (0.0 if side > 0 else 0.06))
            if side > 0 and hypot(u, v) < door.leaf_width + 0.28:
                continue
            away = _length(p, handle[:2])
            cost = abs(away - 0.50) + (0.0 if side > 0 else 0.7 * abs(u - door.leaf_width * 0.62))
            # Elbow room: what is carried should not meet the wall.
            best.append((cost + 2 * max(0.0, 0.42 - clearance(p, others)), p))
    for _, p in sorted(best):
        if clearance(p, others) >= BODY and _entries(p, others, BODY - 0.01):
            look = door.at(door.leaf_width * 0.72, 0.0)
            return (*p, float(np.arctan2(look[1] - p[1], look[0] - p[0])))
    raise NoWayError(f"no room to stand at the door {name!r}")


def leaf_clear(name: str, yaw: float, p: Point) -> float:
    """Distance (m) from a point to the leaf at the yaw (degrees)."""
    return min(_length(p, q) for q in leaf_points(name, yaw)) - plan.LEAF_THICKNESS / 2


def yaw_between(a: Point, b: Point) -> float:
    return float(np.arctan2(b[1] - a[1], b[0] - a[0]))


def place_yaw(place: places.Place) -> float:
    return radians(place.yaw)
