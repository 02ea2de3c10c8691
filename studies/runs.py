# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs in this process's Blender, whose homes stay open from one run to the next, and what is
measured of them: of the home's own animation, or of days that residents live by a routine."""

from __future__ import annotations

import math
import platform
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import date
from functools import cache, partial
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..angen_addon.api.opening import opened
from ..angen_addon.api.recording import Recording
from ..angen_addon.coverage.maps import cover, detectors
from ..angen_addon.output.run_log import about, sensor_facts
from ..angen_addon.runtime.simulation import simulate
from ..angen_addon.runtime.state import are_driven
from ..angen_addon.runtime.time_base import evaluated_depsgraph
from ..angen_addon.scene.animation import may_set
from ..angen_addon.scene.sensors import Sensor, all_sensors
from ..residents.blender.folder import digest_of as digest_of_home
from ..residents.blender.run import Household, Plan, run_days
from ..residents.days.rows import Day, DayRows
from ..residents.days.truth import DAY_S
from ..sensor_logic.coverage.grid import CoverageMap
from ..sensor_logic.coverage.motions import MOTIONS
from ..sensor_logic.error import AngenError
from ..sensor_logic.files import write_files
from ..sensor_logic.kind import LIGHT
from ..sensor_logic.log import events_csv
from ..sensor_logic.recording.tracks import Recording as Readings
from ..sensor_logic.report.facts import figures, quantity
from .changes import Changes, Variants, day_of_run, named, of_run
from .settings import HomeFacts
from .study import COLUMNS, WITHOUT_DOT
from .tasks import (
    Done,
    File,
    Task,
    differences,
    digest_of,
    digest_of_bytes,
    found,
    versions,
)

# m: the cells of a coverage map; and the paths of light that stand for the truth.
CELL = 0.25
REFERENCE_PATHS = 16_384
# The digest of the home that is open now.
_open = ""
# Blender has one scene: a process that has several threads all the same works in turns.
_one_at_a_time = threading.Lock()


def examine(home: File) -> HomeFacts:
    """What is known of a home without simulating it. Raises AngenError."""
    with _one_at_a_time:
        _reopen(home)
        return _facts(home)


def run(group: Sequence[Task]) -> list[Done]:
    """Simulates runs that differ in their sensors alone: the home is lived once for all of them.
    Raises AngenError where this worker has not the study's versions; all else that goes wrong is
    told in what it returns."""
    differ = differences(group[0].versions, versions())
    if differ:
        raise AngenError(f"{platform.node()} is not as the other workers: {differ}")
    with _one_at_a_time:
        return _done(group)


def _reopen(home: File) -> None:
    """Opens a home. Raises AngenError."""
    global _open
    _open = ""
    opened(found(home))
    _open = home.digest


def _facts(home: File) -> HomeFacts:
    """What is known of the open home. Raises AngenError."""
    sensors = all_sensors(bpy.context.view_layer)
    if not sensors:
        raise AngenError(f"{home.name} has no sensors in its scene")
    kinds = {sensor.name: sensor.kind.identifier for sensor in sensors}
    # Libraries, images and caches that the home is made of besides its own file.
    paths = sorted(Path(path) for path in bpy.utils.blend_paths(absolute=True))
    beside = [digest_of_bytes(path.read_bytes()) for path in paths if path.is_file()]
    digest = digest_of({"home": home.digest, "beside": beside})
    begin = bpy.context.scene.frame_start
    return HomeFacts(home.name, kinds, digest, begin, _free(sensors))


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


def _done(group: Sequence[Task]) -> list[Done]:
    """What came of runs that live the home together; if that fails, of each of them alone."""
    global _open
    begin = time.perf_counter()
    try:
        return _lived(group)
    except Exception as error:
        # What was amiss may be amiss in the open home.
        _open = ""
        if len(group) > 1:
            return [one for task in group for one in _done([task])]
        return [_failed(group[0], error, time.perf_counter() - begin)]


def _failed(task: Task, error: Exception, seconds: float = 0.0) -> Done:
    return Done(task.digest, {}, seconds, _line_of(error))


def _line_of(error: Exception) -> str:
    told = str(error) if isinstance(error, AngenError) else f"{type(error).__name__}: {error}"
    return " ".join(told.split())


def _lived(group: Sequence[Task]) -> list[Done]:
    """Raises AngenError where the home cannot be lived."""
    first, failed = group[0], []
    if _open != first.home.digest:
        _reopen(first.home)
    with Changes() as changes:
        household = _household_of(first)
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
            sensors = [*{sensor.name: sensor for _, on in own for sensor in on}.values()]
            begin = time.perf_counter()
            measure: Callable[[Task, Sequence[Sensor]], Measured]
            if household is None:
                measure = partial(_measured_plain, readings_of(sensors, first.frames))
            else:
                measure = partial(_measured_days, _days(first, household, sensors))
            seconds = (time.perf_counter() - begin) / len(own)
            return failed + [_measured(task, on, measure, seconds) for task, on in own]


def _measured(
    task: Task,
    on: Sequence[Sensor],
    measure: Callable[[Task, Sequence[Sensor]], Measured],
    seconds: float,
) -> Done:
    try:
        found = measure(task, on)
    except Exception as error:
        return _failed(task, error, seconds)
    values = {"sensors_on": len(on), **found.values}
    return Done(task.digest, values, seconds, "; ".join(found.errors), found.files)


# The home's own animation.


def readings_of(sensors: list[Sensor], frames: tuple[int, int] | None) -> Readings:
    """Simulates sensors of the open home."""
    scene = bpy.context.scene
    first, last = frames or (scene.frame_start, scene.frame_end)
    readings = Readings()
    for _ in simulate(scene, sensors, max(first, scene.frame_start), last, readings):
        pass
    return readings


def _measured_plain(together: Readings, task: Task, on: Sequence[Sensor]) -> Measured:
    """What is measured of a run, among those that were simulated together."""
    readings, sensors = of_run(together, on), named(on)
    facts = {sensor.name: sensor_facts(sensor) for sensor in sensors}
    recording = Recording(readings, facts, about(bpy.context.scene))
    told = {name: figures(track) for name, track in sorted(readings.tracks.items())}
    events = {name: figure.events for name, figure in told.items()}
    active = {name: figure.active for name, figure in told.items()}
    found = Measured()
    if task.keep:
        found.files[f"{task.digest}.csv"] = events_csv(readings)
    found.add_all(
        task,
        {
            "events": lambda: _of_sensors("events", sum(events.values()), events),
            "active": lambda: _of_sensors("active", _mean(active), active),
            "coverage": lambda: {"coverage": coverage(sensors)},
            "light_error": lambda: {"light_error": _light_error(task, readings, sensors)},
        },
        recording,
        None,
    )
    return found


def _light_error(task: Task, readings: Readings, sensors: Sequence[Sensor]) -> float:
    """Rms difference of what light sensors read to what many paths give, as a share of the mean of
    that."""
    lights = [sensor for sensor in sensors if sensor.kind.requires(LIGHT)]
    if not lights:
        raise AngenError("no light sensor is switched on")
    with Changes() as changes:
        for sensor in lights:
            changes.set(sensor.parameters, "samples", REFERENCE_PATHS)
        bpy.context.view_layer.update()
        reference = readings_of(lights, task.frames)
    errors, scale = [], []
    for name, track in reference.tracks.items():
        (_, truth), (_, read) = quantity(track), quantity(readings.tracks[name])
        errors.append(read - truth)
        scale.append(truth)
    mean = float(np.mean(np.abs(np.concatenate(scale))))
    rms = float(np.sqrt(np.mean(np.square(np.concatenate(errors)))))
    return rms / mean if mean else math.inf


# Days.


def _household_of(task: Task) -> Household | None:
    """Who lives in the open home, as it is before a run changes its sensors, which tell what its
    rooms are called; None for a task without a routine. Raises AngenError."""
    if task.routine is None:
        return None
    sensors = all_sensors(bpy.context.view_layer)
    plan = Plan.read(found(task.routine))
    start = date.fromisoformat(task.start)
    return Household(bpy.context.scene, sensors, plan, start, task.seed)


def _days(task: Task, household: Household, sensors: Sequence[Sensor]) -> list[Day]:
    """The days of a task, sensed by these sensors. Raises AngenError."""
    household.sensors = list(sensors)
    household.causes = bool(task.keep or task.functions)
    kept = _Kept(task, household)
    missing = [number for number in range(task.days) if kept.day(number) is None]
    for number, day in zip(missing, run_days(household, missing), strict=True):
        kept.keep(number, day)
    return [kept.days[number] for number in range(task.days)]


class _Kept:
    """Days that were lived, also in the driver's folder where that is seen from here: a worker that
    is killed loses the day it was at, no more."""

    def __init__(self, task: Task, household: Household) -> None:
        self.days: dict[int, Day] = {}
        facts = digest_of_home(household), task.of_the_home, task.versions, household.causes
        self._digest = digest_of({"day": facts})
        folder = Path(task.days_in)
        self._folder = folder / self._digest if task.days_in and folder.is_dir() else None

    def day(self, number: int) -> Day | None:
        if number not in self.days and self._folder is not None:
            with suppress(OSError, ValueError):
                text = (self._folder / f"{number}.json").read_text(encoding="utf-8")
                found = Day.of_json(text, self._digest)
                if found is not None:
                    self.days[number] = found
        return self.days.get(number)

    def keep(self, number: int, day: Day) -> None:
        self.days[number] = day
        if self._folder is not None:
            # Where it cannot be written, all there is to lose is time.
            with suppress(OSError, AngenError):
                self._folder.mkdir(exist_ok=True)
                write_files({self._folder / f"{number}.json": day.as_json(self._digest)})


def _measured_days(together: Sequence[Day], task: Task, on: Sequence[Sensor]) -> Measured:
    """What is measured of a run, among those that lived these days together."""
    # It loads pandas, some 50 MB of a worker's memory, which other runs do without.
    from . import truth

    rows = DayRows.of([day_of_run(day, on) for day in together])
    sensors = named(on)
    rooms = {sensor.name: sensor.room for sensor in sensors}
    lived = truth.lived(rows, task.days)
    found = Measured()
    if task.keep:
        found.files = {f"{task.digest}/{name}": text for name, text in rows.files().items()}

    def events() -> dict[str, Any]:
        counts = Counter(event.sensor for event in lived.events if event.time_s > 0.0)
        return _of_sensors("events", counts.total(), {name: counts[name] for name in sorted(rooms)})

    def active() -> dict[str, Any]:
        on = truth.when_on(lived)
        seconds = (on["end"] - on["start"]).groupby(on["by"]).sum()
        shares = (seconds.reindex(sorted(rooms), fill_value=0.0) / (lived.days * DAY_S)).to_dict()
        return _of_sensors("active", _mean(shares), shares)

    found.add_all(
        task,
        {
            "events": events,
            "active": active,
            "coverage": lambda: {"coverage": coverage(sensors)},
            "truth": lambda: truth.judged(lived, rooms, task.empty_for),
        },
        lived,
        lived.truth,
    )
    return found


# Measures.


@dataclass
class Measured:
    """What is measured of a run: `values` by column, an error for each measure that failed, and
    the logs that are kept, by name."""

    values: dict[str, Any] = field(default_factory=dict)
    errors: list[str] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)

    def add_all(
        self,
        task: Task,
        known: Mapping[str, Callable[[], Mapping[str, Any]]],
        recording: Any,
        truth: Any,
    ) -> None:
        """Adds what the task asks for: of the `known` measures, and by the user's own functions."""
        for name, measure in known.items():
            if name in task.measure:
                self._add(name, measure)
        for label, name, source in task.functions:
            self._add(label, partial(self._of_function, task, name, source, recording, truth))

    def _add(self, name: str, measure: Callable[[], Mapping[str, Any]]) -> None:
        """Adds the columns of a measure, or its error, beside those of the others."""
        try:
            self.values.update(measure())
        except Exception as error:
            self.errors.append(f"{name}: {_line_of(error)}")

    def _of_function(
        self, task: Task, name: str, source: str, recording: Any, truth: Any
    ) -> dict[str, Any]:
        """What a user's function measures. Raises AngenError."""
        try:
            told = _function(name, source)(recording, truth)
        except Exception as error:
            line = traceback.extract_tb(error.__traceback__)[-1].lineno
            raise AngenError(f"raised {type(error).__name__}: {error} (line {line})") from None
        found = {}
        for key, value in (told if isinstance(told, Mapping) else {name: told}).items():
            if key in {*self.values, *COLUMNS, *WITHOUT_DOT, *task.versions}:
                raise AngenError(f"gives {key!r}, which is another column: name it otherwise")
            try:
                number = float(value)
            except (TypeError, ValueError):
                raise AngenError(f"gave {value!r} for {key!r}, which is no number") from None
            found[str(key)] = number if math.isfinite(number) else None
        return found


def _of_sensors(column: str, whole: float, each: Mapping[str, float]) -> dict[str, Any]:
    return {column: whole, **{f"{column} {name}": value for name, value in each.items()}}


def _mean(values: Mapping[str, float]) -> float:
    return sum(values.values()) / len(values)


# One a source, as long as the process; without it 0.1 ms more a run.
@cache
def _function(name: str, source: str) -> Any:
    space: dict[str, Any] = {"__name__": "angen_study_measure"}
    exec(compile(source, f"{name}.py", "exec"), space)
    return space[name]


def coverage(sensors: Sequence[Sensor]) -> float:
    """The share of the floor that the motion detectors cover, for a walking person."""
    try:
        seen = detectors(sensors)
    except AngenError:
        # None of them is on.
        return 0.0
    motion = next(iter(MOTIONS.values()))
    # Stages, and last the map.
    *_, found = cover(evaluated_depsgraph(), sensors, seen, motion, CELL)
    assert isinstance(found, CoverageMap)
    return found.total().share
