# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the error of presence radars by the number of rays, and what a run costs.

A cylinder of the size of a person walks on straight lines before radars that report targets. Their
distances, directions and speeds are compared with those of the cylinder's axis and front. In the
Ängen home, each motion detector becomes a radar. A run is timed beside the bare evaluation of its
frames, in the same process.
"""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.scene.animation import action_curves

from .common import (
    bare_frames,
    enable_only,
    link,
    new_scene,
    open_home,
    rms,
    run,
    sensors_of,
    spread,
)

KIND, PIR = "PRESENCE_RADAR", "PIR"
RADIUS, HEIGHT, SIDES = 0.2, 1.7, 64
# The radar is this high (m) above the floor.
ABOVE = 1.2
FPS, RATE = 24, 12.0
# Rays across and up.
RAYS = ((15, 8), (30, 15), (60, 30), (120, 60))
# Start, end and seconds of each walk, in m: towards the radar, aside, and past it.
WALKS = (
    ((0.0, 5.0), (0.0, 1.5), 3.5),
    ((-1.5, 2.0), (-1.5, 4.5), 2.5),
    ((2.0, 3.0), (0.5, 1.5), 2.0),
)
# At this frame the person of the home walks from the kitchen to the living room.
FIRST = 600


def measure(quick: bool) -> dict[str, Any]:
    return {
        "errors": errors(WALKS[:1] if quick else WALKS),
        "runs": [
            timed(rays, 24 if quick else 240, 1 if quick else 3)
            for rays in (RAYS[1:3] if quick else RAYS)
        ],
    }


def _radar(rays: tuple[int, int], name: str) -> Any:
    """Add a radar that looks along +Y, ABOVE the floor."""
    radar = link(name, None, (0.0, 0.0, ABOVE))
    radar.rotation_euler = math.pi / 2, 0.0, 0.0
    settings = radar.angen_sensor
    settings.kind, settings.update_rate = KIND, RATE
    values = settings.presence_radar
    values.rays_across, values.rays_up = rays
    values.max_targets, values.gate_length, values.hold_time = 3, 0.32, 0.0
    values.moving_thresholds, values.fading = "15", False
    return radar


def _cylinder() -> Any:
    """Add an upright cylinder of skin, whose origin is on the floor."""
    ring = [(RADIUS * math.cos(a), RADIUS * math.sin(a))
            for a in (2.0 * math.pi * i / SIDES for i in range(SIDES))]  # fmt: skip
    points = [(x, y, z) for z in (0.0, HEIGHT) for x, y in ring]
    around = [(i, (i + 1) % SIDES) for i in range(SIDES)]
    faces = [(a, b, SIDES + b, SIDES + a) for a, b in around]
    mesh = bpy.data.meshes.new("cylinder")
    mesh.from_pydata(points, [], [*faces, tuple(range(SIDES)), tuple(range(SIDES, 2 * SIDES))])
    body = link("Walker", mesh)
    body.angen_radar.substance = "BODY"
    return body


def errors(walks: Any) -> list[dict[str, Any]]:
    """Return the errors of all walks for each number of rays."""
    found: dict[tuple[int, int], list[Any]] = {rays: [] for rays in RAYS}
    for start, end, seconds in walks:
        scene = new_scene(FPS, 1 + round(seconds * FPS))
        body = _cylinder()
        for rays in RAYS:
            _radar(rays, f"{rays[0]} × {rays[1]}")
        for frame, place in ((1, start), (scene.frame_end, end)):
            body.location = *place, 0.0
            body.keyframe_insert("location", frame=frame)
        animation = body.animation_data
        for curve in action_curves(animation.action, getattr(animation, "action_slot", None)):
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
        bpy.context.view_layer.update()
        _, recording = run(scene, sensors_of(KIND), 1, scene.frame_end)
        for rays in RAYS:
            track = recording.tracks[f"{rays[0]} × {rays[1]}"]
            found[rays] += _compared(track, np.array(start), np.array(end), seconds)
    rows = []
    for rays, values in found.items():
        distance, angle, speed, is_seen = np.array(values).T
        seen = is_seen == 1.0
        rows.append({
            "name": f"{rays[0]} × {rays[1]}", "rays": rays[0] * rays[1], "updates": len(values),
            "seen": float(seen.mean()),
            "distance_m": rms(distance[seen]), "mean_distance_m": float(distance[seen].mean()),
            "angle_deg": rms(np.degrees(angle[seen])), "speed_share": rms(speed[seen]),
        })  # fmt: skip
    return rows


def _compared(track: Any, start: Any, end: Any, seconds: float) -> list[tuple[float, ...]]:
    """Return the errors at each update but the first, with the number of targets.

    They are those of the distance from the front of the cylinder in m, of the direction in radians,
    and of the radial speed as a share of it.
    """
    velocity, rows = (end - start) / seconds, []
    for i in range(1, len(track)):
        axis = start + velocity * track.times[i]
        away = float(np.linalg.norm(axis))
        radial = float(velocity @ axis) / away
        if track.columns["targets"][i] != 1:
            rows.append((0.0, 0.0, 0.0, 0.0))
            continue
        x, y, speed = (float(track.columns[name][i]) for name in ("x_m", "y_m", "speed_mps"))
        angle = math.atan2(x, y) - math.atan2(*axis)
        rows.append((math.hypot(x, y) - (away - RADIUS), angle, (speed - radial) / radial, 1.0))
    return rows


def timed(rays: tuple[int, int], frames: int, rounds: int) -> dict[str, Any]:
    """Return the time of a run relative to the bare frames, and in ms for each update."""
    scene = open_home()
    for detector in sensors_of(PIR):
        detector.settings.kind = KIND
        values = detector.settings.presence_radar
        values.rays_across, values.rays_up = rays
    enable_only((KIND,))
    bpy.context.view_layer.update()
    sensors = sensors_of(KIND)
    walls, bare, updates = [], [], 0
    for _ in range(rounds):
        wall, recording = run(scene, sensors, FIRST, FIRST + frames - 1)
        updates = sum(len(track) for track in recording.tracks.values())
        due = sorted({int(f) for track in recording.tracks.values() for f in track.frames})
        walls.append(wall)
        bare.append(bare_frames(scene, due))
    return {
        "name": f"{rays[0]} × {rays[1]}", "radars": len(sensors), "updates": updates,
        "ratio": spread([a / b for a, b in zip(walls, bare, strict=True)]),
        "ms_an_update": spread([(a - b) / updates * 1e3 for a, b in zip(walls, bare, strict=True)]),
    }  # fmt: skip
