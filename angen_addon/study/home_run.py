# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in this process's Blender, whose homes stay open from one to the next."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import bpy

from ...sensor_logic.files import OutputError
from ...sensor_logic.log.event_log import events_csv
from ...sensor_logic.recording.tracks import Recording as Readings
from ...sensor_logic.study.digest import digest_of, digest_of_bytes
from ...sensor_logic.study.targets import HomeFacts
from ..api.error import AngenError, raised_as_angen_error
from ..api.opening import opened
from ..api.recording import Recording
from ..output.run_log import about, sensor_facts
from ..runtime.simulation import simulate
from ..scene.sensors import NoSuchSensor, Sensor, SensorError, all_sensors, simulated
from . import days_run, measures
from .changes import Changes
from .tasks import Done, File, Task, found

# The digest of the home that is open now.
_open = ""


def facts(path: Path, home: File, versions: dict[str, str]) -> HomeFacts:
    """What is known of a home, which is opened. Raises AngenError."""
    global _open
    _open = ""
    opened(path)
    _open = home.digest
    sensors = all_sensors(bpy.context.view_layer)
    if not sensors:
        raise AngenError(f"{home.name} has no sensors in its scene")
    kinds = {sensor.name: sensor.kind.identifier for sensor in sensors}
    digest = digest_of({"home": home.digest, "beside": _beside()})
    return HomeFacts(home.name, kinds, digest, versions, bpy.context.scene.frame_start)


def _beside() -> list[str]:
    """Digests of the files that a home is made of besides its own: libraries, images, caches."""
    paths = sorted(Path(path) for path in bpy.utils.blend_paths(absolute=True))
    return [digest_of_bytes(path.read_bytes()) for path in paths if path.is_file()]


def done(task: Task) -> Done:
    """Simulates and measures. Raises AngenError, and what a user's own function raises."""
    global _open
    if _open != task.home.digest:
        _open = ""
        opened(found(task.home))
        _open = task.home.digest
    try:
        with Changes() as changes, raised_as_angen_error(SensorError, NoSuchSensor, OutputError):
            household = days_run.household_of(task)
            changes.set(bpy.context.scene, "angen_seed", task.seed)
            changes.make(task.settings)
            return _measured(task, changes, household)
    except Exception:
        # What was amiss may be amiss in the open home.
        _open = ""
        raise


def _measured(task: Task, changes: Changes, household: days_run.Household | None) -> Done:
    scene = bpy.context.scene
    sensors = all_sensors(bpy.context.view_layer)
    on = simulated(sensors)
    if not on:
        raise AngenError("no sensor is switched on")
    if household is not None:
        return days_run.done(task, household, on)
    begin = time.perf_counter()
    readings = readings_of(on, task.frames)
    seconds = time.perf_counter() - begin
    recording = Recording(readings, {s.name: sensor_facts(s) for s in on}, about(scene))
    values: dict[str, Any] = {"sensors_on": len(on)}
    values |= measures.measured(task, recording, readings, on, changes)
    kept = {f"{task.digest}.csv": events_csv(readings)} if "events" in task.keep else {}
    return Done(task.digest, values, seconds, files=kept)


def readings_of(sensors: list[Sensor], frames: tuple[int, int] | None) -> Readings:
    """Simulates sensors of the open home."""
    scene = bpy.context.scene
    first, last = frames or (scene.frame_start, scene.frame_end)
    readings = Readings()
    for _ in simulate(scene, sensors, max(first, scene.frame_start), last, readings):
        pass
    return readings
