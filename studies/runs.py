# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulate and measure runs in this process's Blender.

A home stays open from one run to the next. A run simulates the home's own animation, or days on
which residents follow a routine.
"""

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

from ..angen_addon.api.opening import open_home_file
from ..angen_addon.api.recording import Recording
from ..angen_addon.coverage.maps import cover, detectors
from ..angen_addon.output.run_log import about, sensor_facts
from ..angen_addon.runtime.simulation import simulate
from ..angen_addon.runtime.time_base import evaluated_depsgraph
from ..angen_addon.scene.animation import may_set
from ..angen_addon.scene.outputs import are_driven
from ..angen_addon.scene.sensors import Sensor, all_sensors
from ..residents.blender.folder import digest_of as digest_of_home
from ..residents.blender.run import HouseholdDays, Plan, run_days
from ..residents.days.rows import Day, DayRows
from ..residents.days.truth import DAY_S
from ..sensor_logic.coverage.motions import MOTIONS
from ..sensor_logic.kind import LIGHT
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.logs.files import read_text, write_files
from ..sensor_logic.progress import finished
from ..sensor_logic.recording.events import events_csv
from ..sensor_logic.recording.tracks import Recording as Readings
from ..sensor_logic.report.facts import figures, quantity
from .changes import Changes, Variants, day_of_sensors, recording_of_sensors, with_run_names
from .settings import StudiedHome
from .study import COLUMNS, WITHOUT_DOT
from .tasks import (
    File,
    RunResult,
    Task,
    differences,
    digest_of,
    digest_of_bytes,
    local_path,
    versions,
)

# Cells of a coverage map, m, and number of light paths of the reference for light errors.
CELL = 0.25
REFERENCE_PATHS = 16_384
# The digest of the open home.
_open = ""
# Blender has one open file: threads of a process must take turns.
_one_at_a_time = threading.Lock()


def examine(home: File) -> StudiedHome:
    """Open a home, and return data about it for a study.

    Raise `AngenError` if the home has no sensors.
    """
    with _one_at_a_time:
        _reopen(home)
        return _facts(home)


def run(group: Sequence[Task]) -> list[RunResult]:
    """Simulate runs together and return their results.

    The runs may only differ in their sensors, so that they can share one simulation. Raise
    `AngenError` if this worker has other software versions than the study. All other errors are in
    the results.
    """
    differ = differences(group[0].versions, versions())
    if differ:
        raise AngenError(f"{platform.node()} has other versions than the other workers: {differ}")
    with _one_at_a_time:
        return _run_group(group)


def _reopen(home: File) -> None:
    """Open the file of a home, even if it is open already; raise `AngenError` if that fails."""
    global _open
    _open = ""
    open_home_file(local_path(home))
    _open = home.digest


def _facts(home: File) -> StudiedHome:
    """Return data about the open home for a study; raise `AngenError` if it has no sensors."""
    sensors = all_sensors(bpy.context.view_layer)
    if not sensors:
        raise AngenError(f"{home.name} has no sensors in its scene")
    kinds = {sensor.name: sensor.kind.identifier for sensor in sensors}
    # Libraries, images and caches that the home links.
    paths = sorted(Path(path) for path in bpy.utils.blend_paths(absolute=True))
    beside = [digest_of_bytes(path.read_bytes()) for path in paths if path.is_file()]
    digest = digest_of({"home": home.digest, "beside": beside})
    begin = bpy.context.scene.frame_start
    return StudiedHome(home.name, kinds, digest, begin, _independent_sensors(sensors))


def _independent_sensors(sensors: Sequence[Sensor]) -> frozenset[str]:
    """Return the names of the sensors whose parameters affect the readings of no other sensor."""
    if are_driven("angen_sensor."):
        return frozenset()
    return frozenset(
        sensor.name
        for sensor in sensors
        # Light and forces are computed for all sensors at once.
        if not (sensor.kind.requires_light or sensor.kind.requires_forces or sensor.holders)
        and not may_set(sensor.object, "angen_sensor.")
    )


def _run_group(group: Sequence[Task]) -> list[RunResult]:
    """Return the results of runs in one simulation; if this fails, simulate each run alone."""
    global _open
    begin = time.perf_counter()
    try:
        return _simulate_together(group)
    except Exception as error:
        # The open home can be the reason, so open it again.
        _open = ""
        if len(group) > 1:
            return [one for task in group for one in _run_group([task])]
        return [_failed_run(group[0], error, time.perf_counter() - begin)]


def _failed_run(task: Task, error: Exception, seconds: float = 0.0) -> RunResult:
    return RunResult(task.digest, {}, seconds, _one_line(error))


def _one_line(error: Exception) -> str:
    text = str(error) if isinstance(error, AngenError) else f"{type(error).__name__}: {error}"
    return " ".join(text.split())


def _simulate_together(group: Sequence[Task]) -> list[RunResult]:
    """Return the results of runs that share one simulation."""
    first, failed = group[0], []
    if _open != first.home.digest:
        _reopen(first.home)
    with Changes() as changes:
        household = _make_household(first)
        changes.set(bpy.context.scene, "angen_seed", first.seed)
        changes.apply(first.shared_settings)
        with Variants() as variants:
            own: list[tuple[Task, list[Sensor]]] = []
            for task in group:
                try:
                    own.append((task, variants.sensors_for(task.settings)))
                except AngenError as error:
                    failed.append(_failed_run(task, error))
            if not own:
                return failed
            sensors = [*{sensor.name: sensor for _, on in own for sensor in on}.values()]
            begin = time.perf_counter()
            measure: Callable[[Task, Sequence[Sensor]], Measurements]
            if household is None:
                measure = partial(_measure_recording, simulate_frames(sensors, first.frames))
            else:
                measure = partial(_measure_days, _days(first, household, sensors))
            seconds = (time.perf_counter() - begin) / len(own)
            return failed + [_measure(task, on, measure, seconds) for task, on in own]


def _measure(
    task: Task,
    enabled: Sequence[Sensor],
    measure: Callable[[Task, Sequence[Sensor]], Measurements],
    seconds: float,
) -> RunResult:
    """Return the result of a run: what `measure` returns for its enabled sensors."""
    try:
        found = measure(task, enabled)
    except Exception as error:
        return _failed_run(task, error, seconds)
    values = {"sensors_on": len(enabled), **found.values}
    return RunResult(task.digest, values, seconds, "; ".join(found.errors), found.files)


# The home's own animation.


def simulate_frames(sensors: list[Sensor], frames: tuple[int, int] | None) -> Readings:
    """Simulate sensors of the open home, and return their recording.

    `frames` are the first and last frame, or None for the scene's range.
    """
    scene = bpy.context.scene
    first, last = frames or (scene.frame_start, scene.frame_end)
    readings = Readings()
    for _ in simulate(scene, sensors, max(first, scene.frame_start), last, readings):
        pass
    return readings


def _measure_recording(shared: Readings, task: Task, enabled: Sequence[Sensor]) -> Measurements:
    """Measure one run from `shared`, the recording of all runs that are simulated together."""
    readings, sensors = recording_of_sensors(shared, enabled), with_run_names(enabled)
    facts = {sensor.name: sensor_facts(sensor) for sensor in sensors}
    recording = Recording(readings, facts, about(bpy.context.scene))
    shown = {name: figures(track) for name, track in sorted(readings.tracks.items())}
    events = {name: figure.events for name, figure in shown.items()}
    active = {name: f.active for name, f in shown.items() if f.active is not None}
    found = Measurements()
    if task.keep:
        found.files[f"{task.digest}.csv"] = events_csv(readings)
    found.add_all(
        task,
        {
            "events": lambda: _columns("events", sum(events.values()), events),
            "active": lambda: _columns("active", _mean(active), active),
            "coverage": lambda: {"coverage": coverage(sensors)},
            "light_error": lambda: {"light_error": _light_error(task, readings, sensors)},
        },
        recording,
        None,
    )
    return found


def _light_error(task: Task, readings: Readings, sensors: Sequence[Sensor]) -> float:
    """Return the relative rms error of light sensors against a simulation with many light paths."""
    lights = [sensor for sensor in sensors if sensor.kind.requires(LIGHT)]
    if not lights:
        raise AngenError("no light sensor is switched on")
    with Changes() as changes:
        for sensor in lights:
            changes.set(sensor.parameters, "samples", REFERENCE_PATHS)
        bpy.context.view_layer.update()
        reference = simulate_frames(lights, task.frames)
    errors, scale = [], []
    for name, track in reference.tracks.items():
        (_, truth), (_, read) = quantity(track), quantity(readings.tracks[name])
        errors.append(read - truth)
        scale.append(truth)
    mean = float(np.mean(np.abs(np.concatenate(scale))))
    rms = float(np.sqrt(np.mean(np.square(np.concatenate(errors)))))
    return rms / mean if mean else math.inf


# Days.


def _make_household(task: Task) -> HouseholdDays | None:
    """Return the residents of the open home, or None for a task without a routine.

    Call it before a run changes the sensors, because they name the rooms.
    """
    if task.routine is None:
        return None
    sensors = all_sensors(bpy.context.view_layer)
    # Errors are stored in the results, which contain no path of a machine.
    plan = Plan.from_text(read_text(local_path(task.routine)), task.routine.name)
    start = date.fromisoformat(task.start)
    return HouseholdDays(bpy.context.scene, sensors, plan, start, task.seed)


def _days(task: Task, household: HouseholdDays, sensors: Sequence[Sensor]) -> list[Day]:
    """Return the days of a task, with the events of `sensors`."""
    household.sensors = list(sensors)
    household.causes = bool(task.keep or task.functions)
    kept = _DayCache(task, household)
    missing = [number for number in range(task.days) if kept.day(number) is None]
    for number, day in zip(missing, run_days(household, missing), strict=True):
        kept.keep(number, day)
    return [kept.days[number] for number in range(task.days)]


class _DayCache:
    """Simulated days of a task, in memory and, if it can be reached, in the driver's folder."""

    def __init__(self, task: Task, household: HouseholdDays) -> None:
        self.days: dict[int, Day] = {}
        facts = digest_of_home(household), task.shared_settings, task.versions, household.causes
        self._digest = digest_of({"day": facts})
        # With the folder, a killed worker loses only the day that it was simulating.
        folder = Path(task.days_in)
        self._folder = folder / self._digest if task.days_in and folder.is_dir() else None

    def day(self, number: int) -> Day | None:
        """Return the day with this number from memory or the folder, or None."""
        if number not in self.days and self._folder is not None:
            with suppress(OSError, ValueError):
                text = (self._folder / f"{number}.json").read_text(encoding="utf-8")
                found = Day.of_json(text, self._digest)
                if found is not None:
                    self.days[number] = found
        return self.days.get(number)

    def keep(self, number: int, day: Day) -> None:
        """Store a day in memory and in the folder."""
        self.days[number] = day
        if self._folder is not None:
            # A day that cannot be written only costs time.
            with suppress(OSError, AngenError):
                self._folder.mkdir(exist_ok=True)
                write_files({self._folder / f"{number}.json": day.as_json(self._digest)})


def _measure_days(shared: Sequence[Day], task: Task, enabled: Sequence[Sensor]) -> Measurements:
    """Measure one run from `shared`, the days of all runs that are simulated together."""
    # Imported here because pandas takes some 50 MB of a worker's memory.
    from . import truth

    rows = DayRows.joined([day_of_sensors(day, enabled) for day in shared])
    sensors = with_run_names(enabled)
    rooms = {sensor.name: sensor.room for sensor in sensors}
    days = truth.days_from_rows(rows, task.days)
    found = Measurements()
    if task.keep:
        found.files = {f"{task.digest}/{name}": text for name, text in rows.files().items()}

    def events() -> dict[str, Any]:
        counts = Counter(event.sensor for event in days.events if event.time_s > 0.0)
        return _columns("events", counts.total(), {name: counts[name] for name in sorted(rooms)})

    def active() -> dict[str, Any]:
        on = truth.on_spans(days)
        seconds = (on["end"] - on["start"]).groupby(on["by"]).sum()
        shares = (seconds.reindex(sorted(rooms), fill_value=0.0) / (days.days * DAY_S)).to_dict()
        return _columns("active", _mean(shares), shares)

    found.add_all(
        task,
        {
            "events": events,
            "active": active,
            "coverage": lambda: {"coverage": coverage(sensors)},
            "truth": lambda: truth.scores(days, rooms, task.empty_for),
        },
        days,
        days.truth,
    )
    return found


# Measures.


@dataclass
class Measurements:
    """What was measured in a run.

    Attributes
    ----------
    values : dict
        The value of each column of the results.
    errors : list of str
        A text for each measure that failed.
    files : dict of str to str
        The text of each log to store, by file name.
    """

    values: dict[str, Any] = field(default_factory=dict)
    errors: list[str] = field(default_factory=list)
    files: dict[str, str] = field(default_factory=dict)

    def add_all(
        self,
        task: Task,
        built_in: Mapping[str, Callable[[], Mapping[str, Any]]],
        recording: Any,
        truth: Any,
    ) -> None:
        """Add the measures that a task asks for.

        Parameters
        ----------
        task : Task
            The run.
        built_in : mapping of str to callable
            The built-in measures by name; each returns the values of its columns.
        recording, truth
            The arguments of the user's own functions.
        """
        for name, measure in built_in.items():
            if name in task.measure:
                self._add(name, measure)
        for label, name, source in task.functions:
            self._add(label, partial(self._call_function, task, name, source, recording, truth))

    def _add(self, name: str, measure: Callable[[], Mapping[str, Any]]) -> None:
        """Add the columns that `measure` returns, or the text of its error."""
        try:
            self.values.update(measure())
        except Exception as error:
            self.errors.append(f"{name}: {_one_line(error)}")

    def _call_function(
        self, task: Task, name: str, source: str, recording: Any, truth: Any
    ) -> dict[str, Any]:
        """Return the numbers that a user's function returns, by column."""
        try:
            answer = _function(name, source)(recording, truth)
        except Exception as error:
            line = traceback.extract_tb(error.__traceback__)[-1].lineno
            raise AngenError(f"raised {type(error).__name__}: {error} (line {line})") from None
        found = {}
        for key, value in (answer if isinstance(answer, Mapping) else {name: answer}).items():
            if key in {*self.values, *COLUMNS, *WITHOUT_DOT, *task.versions}:
                raise AngenError(
                    f"returns {key!r}, which is the name of another column: choose another name"
                )
            try:
                number = float(value)
            except (TypeError, ValueError):
                raise AngenError(f"returned {value!r} for {key!r}, which is not a number") from None
            found[str(key)] = number if math.isfinite(number) else None
        return found


def _columns(column: str, whole: float, each: Mapping[str, float]) -> dict[str, Any]:
    """Return a column with the value of all sensors together, and one column for each sensor."""
    return {column: whole, **{f"{column} {name}": value for name, value in each.items()}}


def _mean(values: Mapping[str, float]) -> float:
    return sum(values.values()) / len(values) if values else math.nan


# Cached for the process: without the cache each run takes 0.1 ms more.
@cache
def _function(name: str, source: str) -> Any:
    """Return the function `name` that a user's source text defines."""
    space: dict[str, Any] = {"__name__": "angen_study_measure"}
    exec(compile(source, f"{name}.py", "exec"), space)
    return space[name]


def coverage(sensors: Sequence[Sensor]) -> float:
    """Return the fraction of the floor on which motion detectors notice a walking person.

    It is 0 if no motion detector is enabled.
    """
    try:
        seen = detectors(sensors)
    except AngenError:
        # No motion detector is enabled.
        return 0.0
    motion = next(iter(MOTIONS.values()))
    found = finished(cover(evaluated_depsgraph(), sensors, seen, motion, CELL))
    return found.total().share
