# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the optical switch: one ray or an aperture of several, and fast flags.

The light that passes a straight edge has a closed form. The share of crossings that a switch with
updates T apart detects of a flag of width w at speed v is min(1, w / (v·T)). A swept switch must
detect all of them. The first part uses the product's model with rays in closed form, the others its
simulation of a Blender scene.
"""

from __future__ import annotations

import time
from typing import Any

import bpy
import numpy as np
from angen_sensors.angen_addon.scene.animation import action_curves
from angen_sensors.sensor_logic.kind import RAYS
from angen_sensors.sensor_logic.kinds.optical_switch import OpticalSwitchParameters, SlottedSwitch
from angen_sensors.sensor_logic.model import Pose, Update
from angen_sensors.sensor_logic.recording.tracks import Recording

from .common import link, new_scene, run, sensors_of, spread

Array = np.typing.NDArray[np.float64]
APERTURES = (1, 3, 5, 9, 17, 33)
APERTURE, GAP = 0.5e-3, 3.1e-3
# How far the flag's edge shakes to both sides (m), and the number of updates.
SHAKING, LOOKS = 0.04e-3, 400
SUBSTEPS = (1, 2, 4, 8, 16)
FPS = 24
# Name, width in m and speed in m/s.
FLAGS = (
    ("flag of a door, 10 cm at 1 m/s", 0.1, 1.0),
    ("hand, 8 cm at 5 m/s", 0.08, 5.0),
    ("card, 1 cm at 1 m/s", 0.01, 1.0),
    ("0.5 mm at 1 m/s", 0.0005, 1.0),
)
# Rounds with swept and unswept switches in turn, for their times.
TURNS = 5
POSE = Pose(np.zeros(3), np.eye(3))


def measure(quick: bool) -> dict[str, Any]:
    return {
        "aperture": [_aperture(k, 200 if quick else 2000) for k in APERTURES],
        "aperture_m": APERTURE,
        "shaking_m": SHAKING,
        "looks": LOOKS,
        "flags": [
            _flags(name, width, speed, substeps, 40 if quick else 200)
            for name, width, speed in FLAGS
            for substeps in (SUBSTEPS[::2] if quick else SUBSTEPS)
        ],
        "swept": [
            _swept(name, width, speed, 40 if quick else 200, 2 if quick else TURNS)
            for name, width, speed in FLAGS
        ],
    }


class _Edge:
    """A flag in the gap that covers the aperture up to `at` (m)."""

    def __init__(self) -> None:
        self.at = 0.0

    def cast(self, bundle: int, origins: Array, directions: Array, reach: Array) -> Array:
        return np.where(origins[:, 0] < self.at, GAP / 2, reach)


def _update(number: int, edge: _Edge) -> Update:
    def noise() -> np.random.Generator:
        return np.random.default_rng(number)

    return Update(number, 0.0, POSE, {RAYS: edge.cast}, noise, noise)


def _aperture(rays: int, edges: int) -> dict[str, Any]:
    """Return the worst error of the light with its bound, output changes, and the update's time.

    The changes are those while the flag's edge shakes in the middle of the aperture; the time is in
    µs.
    """
    parameters = OpticalSwitchParameters(
        aperture_rays=rays, aperture=APERTURE, threshold=GAP, range_max=0.01
    )
    chance, edge = np.random.default_rng(1), _Edge()
    worst = 0.0
    offsets = ((np.arange(rays) + 0.5) / rays - 0.5) * APERTURE
    start = POSE.origin + np.outer(offsets, POSE.axes[:, 0])
    reach = np.full(rays, 0.009)
    for at in chance.uniform(-APERTURE / 2, APERTURE / 2, edges).tolist():
        edge.at = at
        light = float(np.mean(edge.cast(0, start, start, reach) >= GAP))
        worst = max(worst, abs(light - (0.5 - at / APERTURE)))
    model, before, changes = SlottedSwitch(), None, 0
    durations = []
    for number in range(LOOKS):
        edge.at = float(chance.uniform(-SHAKING, SHAKING))
        begin = time.perf_counter()
        now = model.update(parameters, _update(number, edge)).active
        durations.append((time.perf_counter() - begin) * 1e6)
        changes += before is not None and now != before
        before = now
    return {
        "rays": rays, "worst_error": worst, "bound": 1.0 / (2 * rays), "changes": changes,
        "us": spread(durations),
    }  # fmt: skip


def _flags(name: str, width: float, speed: float, substeps: int, count: int) -> dict[str, Any]:
    """Let a flag cross `count` switches side by side, each at another time between two updates."""
    scene = _scene_of_switches(width, speed, substeps, count)
    wall, recording = _whole(scene)
    seen = _share_seen(recording)
    exact = min(1.0, width * FPS * substeps / speed)
    return {
        "name": name,
        "width_m": width,
        "speed_m_s": speed,
        "substeps": substeps,
        "switches": count,
        "seen": seen,
        "exact": exact,
        # 95 % of fair runs with so many crossings stay within this.
        "chance": 1.96 * (exact * (1 - exact) / count) ** 0.5,
        "steps": len(next(iter(recording.tracks.values()))),
        "ms_a_step": wall * 1e3 / len(next(iter(recording.tracks.values()))),
    }


def _swept(name: str, width: float, speed: float, count: int, turns: int) -> dict[str, Any]:
    """Let one flag cross `count` swept switches at whole frames.

    Returns the share of crossings detected, the number reported at a wrong update, and the time of
    a run over that of unswept switches. The right update is that of the crossing or the next one.
    """
    scene = _scene_of_switches(width, speed, 1, count)
    switches = [obj for obj in scene.objects if obj.angen_sensor.kind == "OPTICAL_SWITCH"]
    walls: dict[bool, list[float]] = {True: [], False: []}
    recording = Recording()
    for _ in range(turns):
        for swept in (False, True):
            for switch in switches:
                switch.angen_sensor.optical_switch.swept = swept
            wall, recording = _whole(scene)
            walls[swept].append(wall)
    wrong = 0
    for switch in switches:
        times = FPS * np.array([switch.location.x, switch.location.x + width]) / speed
        track = recording.tracks[switch.name]
        closed = [
            round(t * FPS)
            for t, is_open in zip(track.times, track.active, strict=True)
            if not is_open
        ]
        first, last = int(np.ceil(times[0])), int(np.ceil(times[1]))
        # The updates while the flag is in the beam, or else the next one.
        wrong += closed != list(range(first, max(last, first + 1)))
    return {
        "name": name, "width_m": width, "speed_m_s": speed, "switches": count,
        "seen": _share_seen(recording), "wrong": wrong,
        "cost": spread([a / b for a, b in zip(walls[True], walls[False], strict=True)]),
    }  # fmt: skip


def _whole(scene: Any) -> tuple[float, Recording]:
    """Return the seconds of a run, and its recording."""
    return run(scene, sensors_of(), scene.frame_start, scene.frame_end)


def _share_seen(recording: Recording) -> float:
    return sum(0 in track.active for track in recording.tracks.values()) / len(recording.tracks)


def _scene_of_switches(width: float, speed: float, substeps: int, count: int) -> Any:
    scene = new_scene(FPS, 1 + FPS)
    scene.angen_substeps = substeps
    chance = np.random.default_rng(1)
    # Evenly over the path between two updates, with random offsets that no rounding can hit.
    phases = (np.arange(count) + chance.uniform(0, 1, count)) / count
    for i, phase in enumerate(phases.tolist()):
        switch = link(f"switch {i:03d}", None, (speed * (0.5 + phase / FPS), 0.02 * i, 0.0))
        settings = switch.angen_sensor
        settings.kind, settings.update_rate = "OPTICAL_SWITCH", FPS * substeps
    reach = 0.02 * count
    corners = [(-width, -1, -0.02), (0, -1, -0.02), (0, reach, -0.02), (-width, reach, -0.02)]
    mesh = bpy.data.meshes.new("flag")
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    flag = link("flag", mesh)
    for frame, at in ((1, 0.0), (1 + FPS, speed)):
        flag.location.x = at
        flag.keyframe_insert("location", index=0, frame=frame)
    animation = flag.animation_data
    for curve in action_curves(animation.action, getattr(animation, "action_slot", None)):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    bpy.context.view_layer.update()
    return scene
