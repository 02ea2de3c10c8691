# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the plan of a home from its scene: storeys, walls and furniture, what each sensor sees."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from mathutils.geometry import convex_hull_2d

from ..sensor_logic.model import Array
from ..sensor_logic.report.facts import PlanShape, PlanStorey, SensorInPlan
from ..sensor_logic.report.sections import Line, cut, from_above
from .kinds import appearance_of
from .runtime import state
from .runtime.sensor_runner import all_rays
from .runtime.time_base import clock_of, evaluated_depsgraph
from .runtime.trace import SensorRays
from .scene.home import EvaluatedHome, SolidSurface
from .scene.instances import Uid
from .scene.sensors import Sensor

# Which floor each sensor stands over: what most rays straight down around it meet.

# Rays go down around the sensor, at these distances from it (m).
RINGS_M, DIRECTIONS, REACH_M = (0.35, 0.8, 1.4), 8, 12.0
# They start this much above it, for it may lie on the floor; under a ceiling or a rug, at half of
# what is free.
START_M = 0.3
# Floors this far apart (m) are storeys; below it steps of one.
STOREY_M = 1.8
# Heights this close (m) are the same floor.
GRAIN_M = 0.02
BUNDLE_UP, BUNDLE_DOWN = -1, -2

T = TypeVar("T")


@dataclass(frozen=True)
class SensorStorey:
    """A storey: height of its floor in m, and its sensors, by name."""

    floor: float
    sensors: tuple[SensorInPlan, ...]


def levels(home: EvaluatedHome, sensors: Sequence[tuple[Uid, SensorInPlan]]) -> list[SensorStorey]:
    """The storeys, the lowest first, of sensors that come with their session uids; their `height`,
    which is that in the world, becomes that above the floor."""
    found: list[tuple[float, SensorInPlan]] = []
    floors = [_floor_below(home, uid, sensor) for uid, sensor in sensors]
    known = [floor for floor in floors if floor is not None]
    for (_, sensor), floor in zip(sensors, floors, strict=True):
        if floor is None:
            # Nothing is below it: the next floor down that others have, else where it hangs.
            below = [f for f in known if f <= sensor.height]
            floor = max(below, default=sensor.height)
        found.append((floor, sensor))
    found.sort(key=lambda pair: (pair[0], pair[1].name))
    return [_level(group) for group in grouped(found, lambda pair: pair[0])]


def grouped(found: Iterable[T], height: Callable[[T], float]) -> list[list[T]]:
    """Groups what is sorted by its height (m) into storeys."""
    groups: list[list[T]] = []
    for one in found:
        if not groups or height(one) - height(groups[-1][0]) >= STOREY_M:
            groups.append([])
        groups[-1].append(one)
    return groups


def around(rings: Sequence[float]) -> Array:
    """The offsets (n, 3) of rays down: one in the middle, and DIRECTIONS at each distance."""
    turns = [2 * math.pi * k / DIRECTIONS for k in range(DIRECTIONS)]
    ring = [(r * math.cos(t), r * math.sin(t), 0.0) for r in rings for t in turns]
    return np.array([(0.0, 0.0, 0.0), *ring])


def _level(group: list[tuple[float, SensorInPlan]]) -> SensorStorey:
    counted = Counter(round(floor / GRAIN_M) for floor, _ in group)
    # The upper one of two: what lies in a floor has its underside below.
    most = max(counted, key=lambda grain: (counted[grain], grain))
    floor = min(floor for floor, _ in group if round(floor / GRAIN_M) == most)
    members = [replace(sensor, height=sensor.height - floor) for _, sensor in group]
    return SensorStorey(floor, tuple(sorted(members, key=lambda sensor: sensor.name)))


def _floor_below(home: EvaluatedHome, uid: Uid, sensor: SensorInPlan) -> float | None:
    """Height in m of what most rays down meet; the lower of two that as many do."""
    here = np.array([[*sensor.at, sensor.height]])
    up = np.array([[0.0, 0.0, 1.0]])
    free = float(home.cast(uid, BUNDLE_UP, here, up, np.array([2 * START_M]))[0])
    top = sensor.height + free / 2
    origins = np.array([*sensor.at, top]) + around(RINGS_M)
    down = np.broadcast_to(np.array([0.0, 0.0, -1.0]), origins.shape)
    ranges = home.cast(uid, BUNDLE_DOWN, origins, down, np.full(len(origins), REACH_M))
    heights = [top - r for r in ranges.tolist() if r < REACH_M]
    if not heights:
        return None
    counted = Counter(round(height / GRAIN_M) for height in heights)
    most = min(counted, key=lambda grain: (-counted[grain], grain))
    return min(height for height in heights if round(height / GRAIN_M) == most)


# Finds where a sensor stands and what it sees, with the rays that its own model casts.

BUNDLE = 0


def placed(home: EvaluatedHome, sensor: Sensor) -> tuple[Uid, SensorInPlan] | None:
    """The sensor with its session uid, its `height` in the world; None while it is switched off.
    Raises AngenError."""
    sight = all_rays(sensor, clock_of(home.depsgraph.scene), home.depsgraph)
    if sight is None:
        return None
    appearance = appearance_of(sensor.kind)
    rays = appearance.plan_rays(sight, home.metres)
    fans: list[Array] = []
    beams: list[Array] = []
    if len(rays.origins):
        segments = _segments(home, sensor, rays)
        if rays.apart or np.ptp(rays.directions, axis=0).max() < 1e-9:
            beams = [*segments]
        else:
            rows = rays.rows if len(segments) % rays.rows == 0 else 1
            fans = [*segments[:, 1].reshape(rows, -1, 2)]
    pose = sight.pose
    return sensor.uid, SensorInPlan(
        sensor.name,
        pose.origin[:2].copy(),
        -pose.axes[:2, 2],
        float(pose.origin[2]),
        tuple(fans),
        tuple(beams),
        _outline(home, sensor) if appearance.outlined else None,
    )


def _segments(home: EvaluatedHome, sensor: Sensor, rays: SensorRays) -> Array:
    """(n, 2, 2) in m: start and end of each ray as seen from above."""
    ranges = home.caster.cast(sensor.uid, BUNDLE, rays.origins, rays.directions, rays.reach)
    ends = rays.origins + rays.directions * ranges[:, None]
    return np.stack([rays.origins[:, :2], ends[:, :2]], axis=1) * home.metres


def _outline(home: EvaluatedHome, sensor: Sensor) -> Any:
    """(n, 2) in m: the hull, seen from above, of a pad and what belongs to it; None of an empty."""
    own = home.caster.solids.owned_by(sensor.uid)
    points = [surface.points[:, :2] for surface in home.surfaces(own)]
    if not points:
        return None
    flat = np.concatenate(points)
    flat = flat[np.isfinite(flat).all(axis=1)]
    hull = convex_hull_2d([tuple(p) for p in flat.tolist()]) if len(flat) else []
    return flat[hull] if len(hull) > 2 else None


# Cuts each solid for a plan: lines where it is cut, or its outline from above.

# What is cut and rises this far above the floor (m) is a wall: wardrobes and door leaves do not.
WALL_M = 2.2
# What rises less than this is the floor itself, or a rug; what lies deeper belongs to the storey
# below.
RUG_M, DEPTH_M = 0.06, 0.25


def shapes_at(
    home: EvaluatedHome, floor: float, height: float, area: tuple[Array, Array]
) -> tuple[PlanShape, ...]:
    """The shapes of a storey over an `area` (two corners (2,)), cut at a `height`; all in m."""
    wanted = (home.lo[:, 2] < height) & (home.hi[:, 2] > floor - DEPTH_M)
    wanted &= ((home.lo[:, :2] < area[1]) & (home.hi[:, :2] > area[0])).all(axis=1)
    found: list[PlanShape] = []
    for surface in home.surfaces(wanted):
        found += _shapes(surface, floor, height)
    return tuple(found)


def _shapes(surface: SolidSurface, floor: float, height: float) -> list[PlanShape]:
    points, triangles = surface.points, surface.triangles
    levels = points[triangles, 2] if len(triangles) else np.empty((0, 3))
    below = (levels < height).all(axis=1)
    found = []
    lines = cut(points, triangles, height)
    if lines:
        top = float(np.nanmax(points[:, 2]))
        role = "wall" if top - floor >= WALL_M else "solid"
        if may_move(surface.solid.owner):
            role = "moving"
        found.append(PlanShape(role, tuple(lines), height))
    low = below & (levels.max(axis=1, initial=-np.inf) > floor - DEPTH_M)
    lines = from_above(points, triangles[low])
    if lines:
        top = float(levels[low].max())
        found.append(PlanShape("floor" if top - floor < RUG_M else "low", _closed(lines), top))
    return found


def _closed(lines: list[Line]) -> tuple[Line, ...]:
    """The largest first, so that what is inside another is painted over it."""
    return tuple(sorted(lines, key=lambda line: -line.length))


def may_move(obj: Any) -> bool:
    """Whether something can move the object: its own or a parent's animation, an armature, a
    constraint, the simulation of rigid bodies."""
    seen = set()
    while obj is not None and obj.session_uid not in seen:
        seen.add(obj.session_uid)
        if _is_driven(obj):
            return True
        obj = obj.parent
    return False


def _is_driven(obj: Any) -> bool:
    animation = obj.animation_data
    animated = animation is not None and (
        animation.action is not None or len(animation.nla_tracks) or len(animation.drivers)
    )
    body = obj.rigid_body
    falls = body is not None and body.type == "ACTIVE"
    bent = any(modifier.type == "ARMATURE" for modifier in obj.modifiers)
    return bool(animated or falls or bent or len(obj.constraints))


# Where a plan is cut, above its floor (m): above sills and tables, below the heads of openings.
CUT_M = 1.1
# The plan shows what is cut up to this far from where sensors are and see, and this much around.
BEYOND_M, MARGIN_M, LEAST_M = 4.0, 0.3, 2.0


def storeys(scene: Any, sensors: Sequence[Sensor], frame: int) -> tuple[PlanStorey, ...]:
    """The storeys that have sensors, the lowest first, as they are at a whole frame; not to be
    called in a frame handler. Raises AngenError."""
    with at_frame(scene, frame):
        depsgraph = evaluated_depsgraph()
        home = EvaluatedHome(depsgraph)
        seen = [s for s in (placed(home, sensor) for sensor in sensors) if s is not None]
        return tuple(_storey(home, level) for level in levels(home, seen))


@contextmanager
def at_frame(scene: Any, frame: int) -> Iterator[None]:
    """The scene at a whole frame; put back at the end, and no handler of ours shows values."""
    before = scene.frame_current, scene.frame_subframe
    if before == (frame, 0.0):
        yield
        return
    state.CACHE.running = True
    try:
        scene.frame_set(frame)
        yield
    finally:
        scene.frame_set(before[0], subframe=before[1])
        state.CACHE.running = False


def _storey(home: EvaluatedHome, level: SensorStorey) -> PlanStorey:
    own = np.concatenate([_extent(sensor) for sensor in level.sensors])
    low, high = own.min(axis=0), own.max(axis=0)
    cut = level.floor + CUT_M
    shapes = shapes_at(home, level.floor, cut, (low - BEYOND_M, high + BEYOND_M))
    view = _view(low, high, shapes)
    return PlanStorey(level.floor, cut, view, shapes, level.sensors)


def _extent(sensor: SensorInPlan) -> Array:
    """Corners (n, 2) of where a sensor is and what it sees."""
    return np.concatenate([sensor.at[None], *sensor.fans, *sensor.beams])


def _view(low: Array, high: Array, shapes: Sequence[PlanShape]) -> Array:
    """The part of the world to show (2, 2): the sensors and the walls around them."""
    within = low - BEYOND_M, high + BEYOND_M
    for shape in shapes:
        if shape.role in {"wall", "solid"}:
            points = np.concatenate([line.points for line in shape.lines])
            near = points[((points >= within[0]) & (points <= within[1])).all(axis=1)]
            if len(near):
                low, high = np.minimum(low, near.min(axis=0)), np.maximum(high, near.max(axis=0))
    missing = np.maximum(LEAST_M - (high - low), 0.0) / 2
    return np.stack([low - missing - MARGIN_M, high + missing + MARGIN_M])
