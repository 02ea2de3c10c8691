# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks that the built home keeps its promises: free ways, free door swings, working switches."""

from collections.abc import Iterator
from itertools import combinations
from math import hypot, radians

import bpy
from mathutils import Vector

from . import places, plan

WALKER_RADIUS = 0.30
# A doorway is narrower than a walker's free way; through it this is enough.
DOORWAY_RADIUS = 0.27
HEAD = 2.0  # obstacles above it do not matter to a walker
Point = tuple[float, float]


def solids() -> Iterator[tuple[str, plan.Box]]:
    """Walls and furniture that stand in a walker's way."""
    for wall in (*plan.OUTER_WALLS, *plan.INNER_WALLS, *plan.BALCONY_WALLS):
        if wall.z0 < HEAD:
            yield "wall", wall
    yield from plan.FURNITURE.items()


def distance_to_box(p: Point, box: plan.Box) -> float:
    """Distance on the floor from a point to a box, m."""
    dx = max(box.x0 - p[0], 0.0, p[0] - box.x1)
    dy = max(box.y0 - p[1], 0.0, p[1] - box.y1)
    return hypot(dx, dy)


def along(a: Point, b: Point, step: float = 0.02) -> Iterator[Point]:
    """Points from a to b, at most `step` m apart."""
    count = max(1, round(hypot(b[0] - a[0], b[1] - a[1]) / step))
    for i in range(count + 1):
        t = i / count
        yield a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])


def way_problems() -> list[str]:
    """Ways that come too near to a wall, to furniture or to a leaf that stands open."""
    problems = []
    for start, end in places.WAYS:
        doorway = start.startswith("door_") or end.startswith("door_")
        radius = DOORWAY_RADIUS if doorway else WALKER_RADIUS
        for name, box in solids():
            near = min(
                distance_to_box(p, box)
                for p in along(places.WAYPOINTS[start], places.WAYPOINTS[end])
            )
            if near < radius - 1e-6:
                problems.append(f"way {start} – {end}: {near:.3f} m from {name}")
        for door in plan.DOORS.values():
            leaf = [door.at(u / 20 * door.leaf_width, 0.0, door.open_yaw) for u in range(21)]
            near = min(
                hypot(p[0] - q[0], p[1] - q[1])
                for p in along(places.WAYPOINTS[start], places.WAYPOINTS[end])
                for q in leaf
            )
            name = f"the open door {door.name}"
            if near < DOORWAY_RADIUS and not (
                (door.name == "entrance" and "hall_workroom" in (start, end))
                or (door.name == "bedroom" and "door_bathroom" in (start, end))
            ):
                problems.append(f"way {start} – {end}: {near:.3f} m from {name}")
    return problems


def swing_problems() -> list[str]:
    """Leaves that cut a wall or furniture anywhere in their swing."""
    problems = []
    for door in plan.DOORS.values():
        width = door.leaf_width - 0.004
        edge = [(u / 40 * width, v) for u in range(1, 41) for v in (0.0, -plan.LEAF_THICKNESS)]
        steps = 72
        for step in range(steps + 1):
            yaw = door.closed_yaw + (door.open_yaw - door.closed_yaw) * step / steps
            for name, box in solids():
                if box.z0 > plan.LEAF_TOP:
                    continue
                near = min(distance_to_box(door.at(u, v, yaw), box) for u, v in edge)
                if near <= 0.0:
                    problems.append(f"door {door.name} at {yaw:.1f}° cuts {name} {box}")
                    break
    return problems


def furniture_problems() -> list[str]:
    """Footprints that overlap each other or a wall."""

    def overlap(a: plan.Box, b: plan.Box) -> bool:
        e = 1e-6
        return (
            a.x0 + e < b.x1 and b.x0 + e < a.x1
            and a.y0 + e < b.y1 and b.y0 + e < a.y1
            and a.z0 + e < b.z1 and b.z0 + e < a.z1
        )  # fmt: skip

    tucked = ("chair", "table", "desk")  # chairs stand under tables
    problems = []
    for (a, box_a), (b, box_b) in combinations(solids(), 2):
        if a == b == "wall" or not overlap(box_a, box_b):
            continue
        if all(any(word in name.lower() for word in tucked) for name in (a, b)):
            continue
        problems.append(f"{a} overlaps {b}")
    return problems


def place_problems() -> list[str]:
    """Places whose waypoint does not exist or is not straight ahead and near."""
    problems = []
    for name, place in places.PLACES.items():
        if place.waypoint not in places.WAYPOINTS:
            problems.append(f"place {name}: no waypoint {place.waypoint!r}")
            continue
        for solid, box in solids():
            near = min(
                distance_to_box(p, box)
                for p in along(places.WAYPOINTS[place.waypoint], (place.x, place.y))
            )
            if near < 0.2:
                problems.append(f"place {name}: {near:.3f} m from {solid}")
    return problems


def plan_problems() -> list[str]:
    """Everything that is wrong with the figures alone."""
    return way_problems() + swing_problems() + furniture_problems() + place_problems()


# --- the built scene -----------------------------------------------------------------------
def _hit(scene: bpy.types.Scene, sensor: bpy.types.Object, reach: float) -> float:
    """Range along a sensor's −Z to the first thing that is not its own, m (inf: nothing)."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    matrix = sensor.evaluated_get(depsgraph).matrix_world
    way = (matrix.to_3x3() @ Vector((0.0, 0.0, -1.0))).normalized()
    start, gone = matrix.translation.copy(), 0.0
    while gone < reach:
        found, place, _, _, obj, _ = scene.ray_cast(depsgraph, start, way, distance=reach - gone)
        if not found:
            return float("inf")
        gone += (place - start).length
        if obj.original.parent is not sensor:
            return gone
        start = place + way * 1e-6
        gone += 1e-6
    return float("inf")


def switch_problems(scene: bpy.types.Scene) -> list[str]:
    """Beams that are not broken by the closed door, or still broken once it has opened."""
    problems = []
    for door in plan.DOORS.values():
        leaf, sensor = (bpy.data.objects[f"{kind} {door.name}"] for kind in ("Door", "Switch"))
        kept = leaf.rotation_euler.z
        way = 1 if door.open_yaw > door.closed_yaw else -1
        for opened in (0.0, 15.0, 45.0, abs(door.open_yaw - door.closed_yaw)):
            leaf.rotation_euler.z = radians(door.closed_yaw + way * opened)
            bpy.context.view_layer.update()
            reading = _hit(scene, sensor, 0.5)
            if (reading >= 0.05) != (opened > 0):
                problems.append(f"switch {door.name}: {reading:.4f} m at {opened:.0f}° open")
        leaf.rotation_euler.z = kept
        bpy.context.view_layer.update()
    return problems


def footprint_problems() -> list[str]:
    """Furniture that reaches out of its footprint, m."""
    problems = []
    for name, box in plan.FURNITURE.items():
        obj = bpy.data.objects.get(name)
        if obj is None:
            continue  # a footprint of several objects
        for part in (part for part in (obj, *obj.children) if part.type == "MESH"):
            points = [part.matrix_world @ v.co for v in part.data.vertices]
            out = max(max(box.x0 - p.x, p.x - box.x1, box.y0 - p.y, p.y - box.y1) for p in points)
            if out > 0.03:
                problems.append(f"{part.name} reaches {out:.3f} m out of the footprint {name}")
    return problems


def scene_problems(scene: bpy.types.Scene) -> list[str]:
    """What is wrong with the built scene."""
    return switch_problems(scene) + footprint_problems()
