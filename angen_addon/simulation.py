# SPDX-License-Identifier: GPL-3.0-or-later
"""The one generator behind the operator, the command line and the tests.

It advances a frame at a time: evaluate the scene, let the sensors that are due sense, record.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import groupby
from typing import Any

from ..sensor_logic.clock import Clock
from ..sensor_logic.model import Reading
from ..sensor_logic.recording import Recording, Track
from . import handlers, outputs, state
from .sensors import Sensor, SensorError, check, check_names, simulated
from .station import Station, clock_of, evaluated_depsgraph, make_caster

# Modifiers whose result at a frame depends on the frames before it.
SIMULATED_MODIFIERS = {
    "CLOTH",
    "COLLISION",
    "DYNAMIC_PAINT",
    "FLUID",
    "PARTICLE_SYSTEM",
    "SOFT_BODY",
}
# Stands for "evaluate the frame, nobody senses" where a station's index would be.
NO_STATION = -1


@dataclass(frozen=True)
class Progress:
    """How far a run is: seconds of the scene done and in all, and the frame just sensed."""

    seconds_done: float
    seconds_total: float
    frame: float


def simulate(
    scene: Any,
    sensors: Sequence[Sensor],
    frame_start: int,
    frame_end: int,
    recording: Recording,
) -> Iterator[Progress]:
    """Simulates whole frames `frame_start` … `frame_end` into `recording`, yielding progress.

    `scene` is the scene of the present context; of `sensors`, those that can be sense.
    The frame is put back at the end, also after an error or when the generator is closed early;
    what was recorded until then stays. Raises SensorError.
    """
    sensors = simulated(sensors)
    check_names(sensors)
    for sensor in sensors:
        check(sensor)
    clock = clock_of(scene)
    first, last = clock.first_step(frame_start), clock.first_step(frame_end + 1) - 1
    stations = [Station(sensor, clock) for sensor in sensors]
    recording.frame_start, recording.frame_end = frame_start, frame_start - 1
    for sensor in sensors:
        recording.tracks[sensor.name] = Track(sensor.name, sensor.kind.identifier, sensor.uid)
    recording.clock = clock
    return _run(scene, stations, first, last, frame_end, recording)


def _run(
    scene: Any,
    stations: list[Station],
    first: int,
    last: int,
    frame_end: int,
    recording: Recording,
) -> Iterator[Progress]:
    clock = clock_of(scene)
    seconds = clock.step_time(max(last - first, 1))
    frame_before, subframe_before = scene.frame_current, scene.frame_subframe
    handlers.ensure()
    state.CACHE.running = True
    try:
        caster = make_caster(scene)
        with _idle_outputs(stations) as driven:
            for step, due in _agenda(scene, stations, first, last):
                frame, subframe = clock.frame_and_subframe(step)
                scene.frame_set(frame, subframe=subframe)
                if due:
                    depsgraph = evaluated_depsgraph()
                    caster.update(depsgraph)
                    readings = [
                        (station, station.sense(number, step, depsgraph, caster))
                        for number, station in due
                    ]
                    _take(recording, clock, step, readings, driven)
                recording.frame_end = frame
                done = clock.step_time(max(step - first, 0))
                yield Progress(done, seconds, clock.step_frame(step))
        recording.frame_end = frame_end
    except ReferenceError as error:
        raise SensorError(f"something that the run needs was removed during it: {error}") from None
    finally:
        _put_back(scene, frame_before, subframe_before)


def _put_back(scene: Any, frame: int, subframe: float) -> None:
    """The scene as it stood; the frame handler must stay quiet until then."""
    try:
        scene.frame_set(frame, subframe=subframe)
    except ReferenceError:
        # Another file was opened: there is nothing to put back.
        pass
    finally:
        state.CACHE.running = False


def _take(
    recording: Recording,
    clock: Clock,
    step: int,
    readings: list[tuple[Station, Reading | None]],
    driven: bool,
) -> None:
    """Records what was read at a step, and lets drivers see it from the next frame on."""
    for station, reading in readings:
        if reading is None:
            continue
        track = recording.tracks[station.sensor.name]
        track.append(clock.step_frame(step), clock.step_time(step), reading)
        if driven:
            outputs.show(station.sensor, reading.active, reading.value)


@contextmanager
def _idle_outputs(stations: list[Station]) -> Iterator[bool]:
    """Where drivers read the sensors' outputs, these start idle, whatever the playhead showed,
    and are put back at the end. Yields whether drivers read them."""
    if not outputs.are_driven():
        yield False
        return
    sensors = [station.sensor for station in stations]
    before = [(sensor, sensor.settings.active, sensor.settings.value) for sensor in sensors]
    for sensor in sensors:
        outputs.show(sensor, False, 0.0)
    try:
        yield True
    finally:
        with suppress(ReferenceError):
            for sensor, active, value in before:
                outputs.show(sensor, active, value)


def _agenda(
    scene: Any, stations: list[Station], first: int, last: int
) -> Iterator[tuple[int, list[tuple[int, Station]]]]:
    """Each step to evaluate, in order, with the updates due: no other frame is evaluated,
    unless the scene holds what must be stepped through frame by frame from its start."""
    queues = [_queue(order, station, first, last) for order, station in enumerate(stations)]
    starts = frames_to_step_from(scene)
    if starts:
        substeps = clock_of(scene).substeps
        start = (min(starts) - scene.frame_start) * substeps
        queues.append((step, NO_STATION, 0) for step in range(start, last + 1, substeps))
    for step, entries in groupby(heapq.merge(*queues), key=lambda entry: entry[0]):
        yield (
            step,
            [(number, stations[order]) for _, order, number in entries if order != NO_STATION],
        )


def _queue(order: int, station: Station, first: int, last: int) -> Iterator[tuple[int, int, int]]:
    for number, step in station.schedule.updates(first, last):
        yield step, order, number


def frames_to_step_from(scene: Any) -> list[int]:
    """First frames of what in the scene depends, at a frame, on the frames before it."""
    starts = []
    world = scene.rigidbody_world
    if world is not None and world.enabled and not world.point_cache.is_baked:
        starts.append(world.point_cache.frame_start)
    for obj in scene.objects:
        for modifier in obj.modifiers:
            if modifier.type in SIMULATED_MODIFIERS or _has_simulation_zone(modifier):
                holder = getattr(modifier, "particle_system", modifier)
                cache = getattr(holder, "point_cache", None)
                starts.append(cache.frame_start if cache else scene.frame_start)
    return starts


def _has_simulation_zone(modifier: Any) -> bool:
    group = getattr(modifier, "node_group", None)
    return group is not None and _tree_has_zone(group, set())


def _tree_has_zone(tree: Any, seen: set[str]) -> bool:
    if tree.name_full in seen:
        return False
    seen.add(tree.name_full)
    for node in tree.nodes:
        if node.bl_idname == "GeometryNodeSimulationOutput":
            return True
        inner = getattr(node, "node_tree", None)
        if inner is not None and _tree_has_zone(inner, seen):
            return True
    return False
