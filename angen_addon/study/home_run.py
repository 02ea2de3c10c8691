# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs in this process's Blender, whose homes stay open from one to the next."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import bpy

from ...sensor_logic.error import AngenError
from ...sensor_logic.log import events_csv
from ...sensor_logic.recording.tracks import Recording as Readings
from ...sensor_logic.study.digest import digest_of, digest_of_bytes
from ...sensor_logic.study.targets import HomeFacts
from ..api.opening import opened
from ..api.recording import Recording
from ..output.run_log import about, sensor_facts
from ..runtime.state import are_driven
from ..scene.animation import may_set
from ..scene.sensors import Sensor, all_sensors
from . import days_run, measures
from .changes import Changes
from .tasks import Done, File, Task, found
from .variants import Variants, named, of_run

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
    begin = bpy.context.scene.frame_start
    return HomeFacts(home.name, kinds, digest, versions, begin, _free(sensors))


def _beside() -> list[str]:
    """Digests of the files that a home is made of besides its own: libraries, images, caches."""
    paths = sorted(Path(path) for path in bpy.utils.blend_paths(absolute=True))
    return [digest_of_bytes(path.read_bytes()) for path in paths if path.is_file()]


def _free(sensors: Sequence[Sensor]) -> frozenset[str]:
    """Those that nothing but themselves depends on how they are set: runs that set them otherwise
    can live the home together. Light and forces are found for all that ask at once."""
    if are_driven("angen_sensor."):
        return frozenset()
    return frozenset(
        sensor.name
        for sensor in sensors
        if not (sensor.kind.requires_light or sensor.kind.requires_forces or sensor.holders)
        and not may_set(sensor.object, "angen_sensor.")
    )


def done(group: Sequence[Task]) -> list[Done]:
    """What came of runs that live the home together; if that fails, of each of them alone."""
    global _open
    begin = time.perf_counter()
    try:
        return _lived(group)
    except Exception as error:
        # What was amiss may be amiss in the open home.
        _open = ""
        if len(group) > 1:
            return [one for task in group for one in done([task])]
        return [_failed(group[0], error, time.perf_counter() - begin)]


def _failed(task: Task, error: Exception, seconds: float = 0.0) -> Done:
    told = str(error) if isinstance(error, AngenError) else f"{type(error).__name__}: {error}"
    return Done(task.digest, {}, seconds, " ".join(told.split()))


def _lived(group: Sequence[Task]) -> list[Done]:
    """Raises AngenError where the home cannot be lived."""
    global _open
    first, failed = group[0], []
    if _open != first.home.digest:
        _open = ""
        opened(found(first.home))
        _open = first.home.digest
    with Changes() as changes:
        household = days_run.household_of(first)
        changes.set(bpy.context.scene, "angen_seed", first.seed)
        changes.make(first.of_the_home)
        with Variants() as variants:
            own: list[tuple[Task, list[Sensor]]] = []
            for task in group:
                try:
                    own.append((task, variants.of(task.settings)))
                except AngenError as error:
                    failed.append(_failed(task, error))
            if not own:
                return failed
            sensors = {sensor.name: sensor for _, on in own for sensor in on}
            begin = time.perf_counter()
            measure = _ran(first, [*sensors.values()], household)
            seconds = (time.perf_counter() - begin) / len(own)
            return failed + [_measured(task, on, measure, seconds) for task, on in own]


Measure = Callable[[Task, Sequence[Sensor]], tuple[measures.MeasuredRun, dict[str, str]]]


def _ran(task: Task, sensors: list[Sensor], household: days_run.Household | None) -> Measure:
    """Simulates; returns the function that gives a run's measures, and its logs by name."""
    if household is not None:
        return partial(days_run.measured, days_run.lived(task, household, sensors))
    return partial(_measured_plain, measures.readings_of(sensors, task.frames))


def _measured(task: Task, on: Sequence[Sensor], measure: Measure, seconds: float) -> Done:
    try:
        found, files = measure(task, on)
    except Exception as error:
        return _failed(task, error, seconds)
    values = {"sensors_on": len(on), **found.values}
    kept = files if "events" in task.keep else {}
    return Done(task.digest, values, seconds, "; ".join(found.errors), kept)


def _measured_plain(
    together: Readings, task: Task, on: Sequence[Sensor]
) -> tuple[measures.MeasuredRun, dict[str, str]]:
    """Of a run of the home's own animation, among those that were simulated together."""
    readings, sensors = of_run(together, on), named(on)
    facts = {sensor.name: sensor_facts(sensor) for sensor in sensors}
    recording = Recording(readings, facts, about(bpy.context.scene))
    found = measures.measured(task, recording, readings, sensors)
    return found, {f"{task.digest}.csv": events_csv(readings)} if task.keep else {}
