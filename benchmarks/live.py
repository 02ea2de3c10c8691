# SPDX-License-Identifier: GPL-3.0-or-later
"""Playback of the sample home with live readings and without, without a window; and whether what is
read live is what a run records."""

from __future__ import annotations

import time
from typing import Any

import bpy
from angen_sensors.angen_addon.runtime import state
from angen_sensors.angen_addon.runtime.simulation import simulate
from angen_sensors.angen_addon.scene.sensors import all_sensors
from angen_sensors.sensor_logic.recording.tracks import Recording

from .common import open_home, spread
from .progress import progress

# The kinds of sensors that are on.
CASES = (
    ("7 PIRs", ("PIR",)),
    ("7 PIRs and 7 switches", ("PIR", "OPTICAL_SWITCH")),
    ("and the pad", ("PIR", "OPTICAL_SWITCH", "PRESSURE")),
)
# Frames that are played: she goes from the kitchen to the sofa. Sensors look at all anew in the
# first of them.
FIRST, LAST, AHEAD = 900, 1100, 5
ROUNDS, GLANCE = 12, 2


def measure(quick: bool) -> dict[str, Any]:
    rows = []
    for number, (name, kinds) in enumerate(CASES):
        progress("live", number, len(CASES), name)
        rows.append({"name": name, **_case(kinds, GLANCE if quick else ROUNDS)})
    return {"frames": LAST - FIRST, "cases": rows}


def _case(kinds: tuple[str, ...], rounds: int) -> dict[str, Any]:
    scene = open_home()
    for sensor in all_sensors(bpy.context.view_layer):
        sensor.settings.enabled = sensor.kind.identifier in kinds
    state.CACHE.clear()
    bpy.context.view_layer.update()
    plain, live = [], []
    for _ in range(rounds):
        plain.append(_played(scene, False))
        live.append(_played(scene, True))
    sensors = [s for s in all_sensors(bpy.context.view_layer) if s.settings.enabled]
    return {
        "sensors": len(sensors),
        "plain_ms": spread(plain),
        "live_ms": spread(live),
        "cost_ms": spread([a - b for a, b in zip(live, plain, strict=True)]),
        **_compared(scene, sensors),
    }


def _played(scene: Any, live: bool) -> float:
    """Milliseconds of processor time a frame."""
    scene.angen_live = live
    begin = 0.0
    for frame in range(FIRST - AHEAD, LAST):
        if frame == FIRST:
            begin = time.process_time()
        scene.frame_set(frame)
    return (time.process_time() - begin) / (LAST - FIRST) * 1000


def _compared(scene: Any, sensors: list[Any]) -> dict[str, int]:
    """Readings that live sensing gave as a run from the first frame on records them."""
    recording = Recording()
    for _ in simulate(scene, sensors, scene.frame_start, LAST, recording):
        pass
    expected = {
        (name, float(frame)): (bool(active), float(value))
        for name, track in recording.tracks.items()
        for frame, active, value in zip(track.frames, track.active, track.value, strict=True)
    }
    scene.angen_live = True
    found = {}
    for frame in range(scene.frame_start, LAST):
        scene.frame_set(frame)
        for name, published in state.CACHE.live.readings.items():
            reading = published.reading
            found[name, float(published.frame)] = reading.active, reading.value
    same = sum(expected[key] == reading for key, reading in found.items())
    return {"read": len(found), "same": same, "active": sum(one[0] for one in found.values())}
