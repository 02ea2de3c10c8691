# SPDX-License-Identifier: GPL-3.0-or-later
"""The one generator behind the operator, the command line and the tests.

It advances a frame at a time: evaluate the scene, let the sensors that are due sense, record.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import groupby, islice, pairwise
from typing import Any

import bpy
import numpy as np

from ..sensor_logic.clock import Clock
from ..sensor_logic.recording import Recording, Track
from . import handlers, outputs, state
from .probes import Probes
from .runtime import stillness
from .scene_probe.zones import has_simulation_zone
from .sensors import Sensor, SensorError, check, check_names, report_steps, simulated
from .station import Station, Taken, clock_of, evaluated_depsgraph

# Modifiers whose result at a frame depends on the frames before it.
SIMULATED_MODIFIERS = {
    "CLOTH",
    "COLLISION",
    "DYNAMIC_PAINT",
    "FLUID",
    "PARTICLE_SYSTEM",
    "SOFT_BODY",
}
# Where a station's index and the number of its update would be: nobody senses; the frame is only
# evaluated, is looked at for the motion, is one at which a pad's forces will be asked for, or is
# one between two updates of a sensor that watches.
NO_STATION = -1
ONLY_STEP, LOOK, PAD, WATCH = -1, -2, -3, -4
STOPS_AT_ONCE = 10_000


@dataclass(frozen=True)
class Progress:
    """How far a run is: seconds of the scene done and in all, and the frame just sensed; what is
    being done there, if it takes long. Of the `steps` until there, at which sensors sensed, the
    scene was evaluated at `evaluated`: at the others it was as before."""

    seconds_done: float
    seconds_total: float
    frame: float
    doing: str = ""
    steps: int = 0
    evaluated: int = 0


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
        kind, steps = sensor.kind.identifier, report_steps(sensor)
        track = Track(sensor.name, kind, sensor.uid, steps, clock)
        recording.tracks[sensor.name] = track
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
    probes = Probes(scene)
    state.CACHE.running = True
    try:
        # Other code may change the scene at a frame in ways that Blender tells nobody.
        keep = not handlers.others_follow_frames()
        still = stillness.find(scene, any(s.sensor.kind.light for s in stations), not keep)
        steps = evaluated = 0
        probes.serve(station.sensor for station in stations)
        for station in stations:
            station.heed(probes)
        waiting: list[Taken] = []
        with _idle_outputs(stations) as driven:
            agenda = _agenda(scene, stations, first, last)
            for stop, fresh in _when_fresh(agenda, clock, still):
                if bpy.context.scene.session_uid != scene.session_uid:
                    raise SensorError("the run ended early: another scene is shown now")
                frame, subframe = clock.frame_and_subframe(stop.step)
                done = clock.step_time(min(max(stop.step - first, 0), last - first))
                steps, evaluated = steps + 1, evaluated + fresh
                if fresh:
                    scene.frame_set(frame, subframe=subframe)
                if stop.due or stop.look or stop.watching:
                    depsgraph = evaluated_depsgraph()
                    probes.look(depsgraph, frame if stop.look else None, stop.pads)
                    for station in stop.watching:
                        station.watch(stop.step, depsgraph, probes)
                    ready, waiting = _ready(waiting, stop.step, clock)
                    for number, station in stop.due:
                        taken = station.take(number, stop.step, depsgraph, probes)
                        if taken is not None:
                            (waiting if station.sensor.kind.motion else ready).append(taken)
                    # A picture of the light makes Blender evaluate the scene anew: it comes last.
                    _record(recording, clock, [t for t in ready if t.request is None], driven)
                    lit = [t for t in ready if t.request is not None]
                    if lit:
                        view_layer = bpy.context.view_layer
                        asked = [t.request for t in lit if t.request is not None]
                        for doing in probes.measure(scene, view_layer, depsgraph, asked, keep):
                            at = clock.step_frame(stop.step)
                            yield Progress(done, seconds, at, doing, steps, evaluated)
                        _record(recording, clock, lit, driven)
                recording.frame_end = min(frame, frame_end)
                yield Progress(done, seconds, clock.step_frame(stop.step), "", steps, evaluated)
        recording.frame_end = frame_end
    except ReferenceError as error:
        raise SensorError(f"something that the run needs was removed during it: {error}") from None
    finally:
        probes.close()
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


def _ready(waiting: list[Taken], step: int, clock: Clock) -> tuple[list[Taken], list[Taken]]:
    """Those of the waiting updates whose next frame has come, and the others."""
    frame = clock.frame_and_subframe(step)[0]
    ready = [t for t in waiting if clock.frame_and_subframe(t.step)[0] < frame]
    return ready, [t for t in waiting if t not in ready]


def _record(recording: Recording, clock: Clock, ready: list[Taken], driven: bool) -> None:
    """Records what was read, and lets drivers see it from the next frame on."""
    for taken in ready:
        sensor, reading = taken.station.sensor, taken.reading()
        track = recording.tracks[sensor.name]
        track.append(clock.step_frame(taken.step), clock.step_time(taken.step), reading)
        if driven:
            outputs.show(sensor, reading.active, reading.value)


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


@dataclass
class Stop:
    """A step to evaluate: the updates due, whether the motion there is needed, the pads whose
    forces there will be asked for, and who watches there between two updates."""

    step: int
    due: list[tuple[int, Station]] = field(default_factory=list)
    look: bool = False
    pads: list[Sensor] = field(default_factory=list)
    watching: list[Station] = field(default_factory=list)


def _agenda(scene: Any, stations: list[Station], first: int, last: int) -> Iterator[Stop]:
    """Each step to evaluate, in order: those of the updates, the frames beside where a sensor
    needs the motion, and no other, unless the scene holds what must be stepped through frame by
    frame from its start."""
    substeps = clock_of(scene).substeps
    queues: list[Iterator[tuple[int, int, int]]] = []
    for order, station in enumerate(stations):
        queues.append(_updates(order, station, first, last))
        if station.sensor.kind.motion:
            queues += [_beside(order, station, first, last, offset) for offset in (-1, 0, 1)]
        if station.watches:
            queues.append(_between(order, station, first, last))
    starts = frames_to_step_from(scene)
    if starts:
        start = (min(starts) - scene.frame_start) * substeps
        queues.append((step, NO_STATION, ONLY_STEP) for step in range(start, last + 1, substeps))
    for step, entries in groupby(heapq.merge(*queues), key=lambda entry: entry[0]):
        stop = Stop(step)
        for _, order, number in entries:
            stop.look |= number in (LOOK, PAD)
            if number == PAD:
                stop.pads.append(stations[order].sensor)
            elif number == WATCH:
                stop.watching.append(stations[order])
            elif number >= 0:
                stop.due.append((number, stations[order]))
        yield stop


def _when_fresh(
    stops: Iterator[Stop], clock: Clock, still: stillness.Stillness
) -> Iterator[tuple[Stop, bool]]:
    """Each stop, and whether anything may be otherwise than at the one before."""
    last: list[tuple[int, float]] = []
    while some := list(islice(stops, STOPS_AT_ONCE)):
        frames = last + [clock.frame_and_subframe(stop.step) for stop in some]
        fresh = still.fresh(*np.array(frames).T)[len(last) :]
        last = frames[-1:]
        yield from zip(some, fresh.tolist(), strict=True)


def _updates(order: int, station: Station, first: int, last: int) -> Iterator[tuple[int, int, int]]:
    for number, step in station.schedule.updates(first, last):
        yield step, order, number


def _between(order: int, station: Station, first: int, last: int) -> Iterator[tuple[int, int, int]]:
    """The steps between its updates."""
    for (_, step), (_, after) in pairwise(station.schedule.updates(first, last)):
        for between in range(step + 1, after):
            yield between, order, WATCH


def _beside(
    order: int, station: Station, first: int, last: int, offset: int
) -> Iterator[tuple[int, int, int]]:
    """The whole frames `offset` from those of the updates; time begins at the first."""
    substeps = station.clock.substeps
    for _, step in station.schedule.updates(first, last):
        frame = step // substeps + offset
        if frame >= 0:
            yield frame * substeps, order, LOOK if offset else PAD


def frames_to_step_from(scene: Any) -> list[int]:
    """First frames of what in the scene depends, at a frame, on the frames before it."""
    starts = []
    world = scene.rigidbody_world
    if world is not None and world.enabled and not world.point_cache.is_baked:
        starts.append(world.point_cache.frame_start)
    for obj in scene.objects:
        for modifier in obj.modifiers:
            if modifier.type in SIMULATED_MODIFIERS or has_simulation_zone(modifier):
                holder = getattr(modifier, "particle_system", modifier)
                cache = getattr(holder, "point_cache", None)
                starts.append(cache.frame_start if cache else scene.frame_start)
    return starts
