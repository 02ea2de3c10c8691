# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the floor plan of a home from its scene: storeys, walls, furniture and sensors."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from mathutils.geometry import convex_hull_2d

from ...sensor_logic.model import Array
from ...sensor_logic.report.facts import PlanShape, PlanStorey, SensorInPlan
from ...sensor_logic.report.sections import Line, cut, from_above
from ..appearance.appearance import appearance_of
from ..runtime.running import running
from ..runtime.sensor_runner import all_rays
from ..runtime.time_base import clock_of, evaluated_depsgraph
from ..runtime.trace import SensorRays
from ..scene.home.evaluated_home import EvaluatedHome, SolidSurface
from ..scene.instances import Uid
from ..scene.sensors import Sensor

# The floor below each sensor: the height that most rays straight down around the sensor hit.

# Distances (m) of these rays from the sensor.
RINGS_M, DIRECTIONS, REACH_M = (0.35, 0.8, 1.4), 8, 12.0
# The rays start above the sensor, since it may lie on the floor: at most this far, and at most
# half-way to the ceiling.
START_M = 0.3
# Floors that are at least this far apart (m) are different storeys.
STOREY_M = 1.8
# Heights (m) are rounded to this when floors are compared.
GRAIN_M = 0.02
BUNDLE_UP, BUNDLE_DOWN = -1, -2

T = TypeVar("T")


@dataclass(frozen=True)
class SensorStorey:
    """A storey: the height of its floor in m, and its sensors sorted by name."""

    floor: float
    sensors: tuple[SensorInPlan, ...]


def group_by_storey(
    home: EvaluatedHome, sensors: Sequence[tuple[Uid, SensorInPlan]]
) -> list[SensorStorey]:
    """Group sensors into storeys, the lowest first.

    Parameters
    ----------
    home
        The evaluated scene.
    sensors
        Pairs of session uid and sensor. The `height` of a sensor is above the world's origin, in m.

    Returns
    -------
    list of SensorStorey
        The `height` of their sensors is above the floor of the storey.
    """
    found: list[tuple[float, SensorInPlan]] = []
    floors = [_floor_below(home, uid, sensor) for uid, sensor in sensors]
    known = [floor for floor in floors if floor is not None]
    for (_, sensor), floor in zip(sensors, floors, strict=True):
        if floor is None:
            # Nothing is below the sensor: take the nearest floor of other sensors that is lower.
            below = [f for f in known if f <= sensor.height]
            floor = max(below, default=sensor.height)
        found.append((floor, sensor))
    found.sort(key=lambda pair: (pair[0], pair[1].name))
    return [_make_storey(group) for group in grouped(found, lambda pair: pair[0])]


def grouped(found: Iterable[T], height: Callable[[T], float]) -> list[list[T]]:
    """Group items into storeys. The items must be sorted by their `height` (m).

    An item starts a new storey if it is STOREY_M or more above the first item of the last storey.
    """
    groups: list[list[T]] = []
    for one in found:
        if not groups or height(one) - height(groups[-1][0]) >= STOREY_M:
            groups.append([])
        groups[-1].append(one)
    return groups


def around(rings: Sequence[float]) -> Array:
    """Return points (n, 3) in m, relative to an origin, from which to cast rays.

    They are the origin itself, and DIRECTIONS points on a level circle of each radius in `rings`.
    """
    turns = [2 * math.pi * k / DIRECTIONS for k in range(DIRECTIONS)]
    ring = [(r * math.cos(t), r * math.sin(t), 0.0) for r in rings for t in turns]
    return np.array([(0.0, 0.0, 0.0), *ring])


def _make_storey(group: list[tuple[float, SensorInPlan]]) -> SensorStorey:
    """Return a storey with these sensors; each comes with the height (m) of the floor below it."""
    counted = Counter(round(floor / GRAIN_M) for floor, _ in group)
    # Of two equally frequent heights take the upper one: the other is the underside of a thing
    # that is sunk into the floor.
    most = max(counted, key=lambda grain: (counted[grain], grain))
    floor = min(floor for floor, _ in group if round(floor / GRAIN_M) == most)
    members = [replace(sensor, height=sensor.height - floor) for _, sensor in group]
    return SensorStorey(floor, tuple(sorted(members, key=lambda sensor: sensor.name)))


def _floor_below(home: EvaluatedHome, uid: Uid, sensor: SensorInPlan) -> float | None:
    """Return the height (m) of the floor below a sensor, or None if nothing is below.

    The floor is the height that most rays hit; of two equally frequent heights, the lower one.
    """
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


# The place of a sensor in the plan, and what it sees with the rays of its model.

BUNDLE = 0


def sensor_in_plan(home: EvaluatedHome, sensor: Sensor) -> tuple[Uid, SensorInPlan] | None:
    """Return a sensor's session uid, and the sensor as the floor plan shows it.

    The sensor's `height` is above the world's origin. Return None if the sensor is switched off.
    Raise `AngenError` if its parameters are wrong.
    """
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
    """Return start and end of each ray as seen from above, shape (n, 2, 2) in m."""
    ranges = home.caster.cast(sensor.uid, BUNDLE, rays.origins, rays.directions, rays.reach)
    ends = rays.origins + rays.directions * ranges[:, None]
    return np.stack([rays.origins[:, :2], ends[:, :2]], axis=1) * home.metres


def _outline(home: EvaluatedHome, sensor: Sensor) -> Any:
    """Return the convex hull (n, 2) in m of a pad and its parts, as seen from above.

    Return None for an empty, which has no surface.
    """
    rows = home.caster.solids.owned_by(sensor.uid)
    points = [surface.points[:, :2] for surface in home.surfaces(rows)]
    if not points:
        return None
    flat = np.concatenate(points)
    flat = flat[np.isfinite(flat).all(axis=1)]
    hull = convex_hull_2d([tuple(p) for p in flat.tolist()]) if len(flat) else []
    return flat[hull] if len(hull) > 2 else None


# Shapes in the plan: the section of a solid at the cut, or its outline from above.

# m. A solid that the cut goes through is a wall if its top is at least this far above the floor.
# Wardrobes and door leaves are lower.
WALL_M = 2.2
# m. A shape with a top lower than RUG_M above the floor is the floor itself or a rug. A shape that
# is more than DEPTH_M below the floor belongs to the storey below.
RUG_M, DEPTH_M = 0.06, 0.25


def shapes_at(
    home: EvaluatedHome, floor: float, height: float, area: tuple[Array, Array]
) -> tuple[PlanShape, ...]:
    """Return the building and the furniture of a storey as shapes in the floor plan.

    Parameters
    ----------
    home
        The evaluated scene.
    floor, height
        Heights of the floor and of the horizontal cut above the world's origin, in m.
    area
        Two opposite corners (2,) of the area that the plan shows, in m.

    Returns
    -------
    tuple of PlanShape
        Sections of the solids at the cut, and outlines of the solids below it, in m.
    """
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
        found.append(
            PlanShape("floor" if top - floor < RUG_M else "low", _sort_outlines(lines), top)
        )
    return found


def _sort_outlines(lines: list[Line]) -> tuple[Line, ...]:
    """Return outlines sorted by length, the longest first, so that inner ones are painted last."""
    return tuple(sorted(lines, key=lambda line: -line.length))


def may_move(obj: Any) -> bool:
    """Return whether something can move the object or one of its parents.

    That is an animation, an armature, a constraint or the simulation of rigid bodies.
    """
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


# Height of the cut above the floor (m): above sills and tables, below the heads of openings.
CUT_M = 1.1
# The plan shows walls up to BEYOND_M from the sensors and their rays, with a margin around.
BEYOND_M, MARGIN_M, LEAST_M = 4.0, 0.3, 2.0


def storeys(scene: Any, sensors: Sequence[Sensor], frame: int) -> tuple[PlanStorey, ...]:
    """Return the storeys that have sensors, at a whole frame, the lowest first.

    This can change the current frame, so do not call it in a frame handler. Raise `AngenError` if a
    sensor's parameters are wrong.
    """
    with at_frame(scene, frame):
        depsgraph = evaluated_depsgraph()
        home = EvaluatedHome(depsgraph)
        seen = [s for s in (sensor_in_plan(home, sensor) for sensor in sensors) if s is not None]
        return tuple(_storey(home, storey) for storey in group_by_storey(home, seen))


@contextmanager
def at_frame(scene: Any, frame: int) -> Iterator[None]:
    """Context manager: on entry, set the scene to a whole frame; on exit, restore the frame.

    In between, the handlers of this extension do nothing.
    """
    before = scene.frame_current, scene.frame_subframe
    if before == (frame, 0.0):
        yield
        return
    with running():
        try:
            scene.frame_set(frame)
            yield
        finally:
            scene.frame_set(before[0], subframe=before[1])


def _storey(home: EvaluatedHome, storey: SensorStorey) -> PlanStorey:
    points = np.concatenate([_sensor_points(sensor) for sensor in storey.sensors])
    low, high = points.min(axis=0), points.max(axis=0)
    cut = storey.floor + CUT_M
    shapes = shapes_at(home, storey.floor, cut, (low - BEYOND_M, high + BEYOND_M))
    view = _shown_area(low, high, shapes)
    return PlanStorey(storey.floor, cut, view, shapes, storey.sensors)


def _sensor_points(sensor: SensorInPlan) -> Array:
    """Return points (n, 2) in m: the position of a sensor and the ends of its rays."""
    return np.concatenate([sensor.at[None], *sensor.fans, *sensor.beams])


def _shown_area(low: Array, high: Array, shapes: Sequence[PlanShape]) -> Array:
    """Return two opposite corners (2, 2) in m of the area that the plan shows.

    The area encloses the points from `low` to `high`, and the walls around them.
    """
    within = low - BEYOND_M, high + BEYOND_M
    for shape in shapes:
        if shape.role in {"wall", "solid"}:
            points = np.concatenate([line.points for line in shape.lines])
            near = points[((points >= within[0]) & (points <= within[1])).all(axis=1)]
            if len(near):
                low, high = np.minimum(low, near.min(axis=0)), np.maximum(high, near.max(axis=0))
    missing = np.maximum(LEAST_M - (high - low), 0.0) / 2
    return np.stack([low - missing - MARGIN_M, high + missing + MARGIN_M])
