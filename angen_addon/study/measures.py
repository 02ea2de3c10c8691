# SPDX-License-Identifier: GPL-3.0-or-later
"""What is measured of a run."""

from __future__ import annotations

import math
import traceback
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.coverage.grid import CoverageMap
from ...sensor_logic.coverage.motions import MOTIONS
from ...sensor_logic.error import AngenError
from ...sensor_logic.kind import LIGHT
from ...sensor_logic.recording.tracks import Recording as Readings
from ...sensor_logic.report.facts import figures, quantity
from ...sensor_logic.study.study import COLUMNS, WITHOUT_DOT
from ..api.recording import Recording
from ..coverage.maps import cover, detectors
from ..runtime.simulation import simulate
from ..runtime.time_base import evaluated_depsgraph
from ..scene.sensors import Sensor
from .changes import Changes
from .tasks import Task

# m: the cells of a coverage map; and the paths of light that stand for the truth.
CELL = 0.25
REFERENCE_PATHS = 16_384


@dataclass
class MeasuredRun:
    """What is measured of a run: `values` by column, and an error for each measure that failed."""

    values: dict[str, Any] = field(default_factory=dict)
    errors: list[str] = field(default_factory=list)

    def add(self, name: str, measure: Callable[[], Mapping[str, Any]]) -> None:
        """Adds the columns of a measure, or its error, beside those of the others."""
        try:
            self.values.update(measure())
        except Exception as error:
            self.errors.append(" ".join(f"{name}{_reason(error)}".split()))

    def add_functions(self, task: Task, recording: Any, truth: Any) -> None:
        """Adds what the user's own functions measure."""
        for label, name, source in task.functions:
            taken = {*self.values, *COLUMNS, *WITHOUT_DOT, *task.versions}
            self.add(label, partial(_of_function, name, source, recording, truth, taken))


def _reason(error: Exception) -> str:
    if isinstance(error, AngenError):
        return f": {error}"
    return f": {type(error).__name__}: {error}"


def measured(
    task: Task,
    recording: Recording,
    readings: Readings,
    sensors: Sequence[Sensor],
) -> MeasuredRun:
    """All that the task asks for."""
    found = MeasuredRun()
    told = {name: figures(track) for name, track in sorted(readings.tracks.items())}

    def events() -> dict[str, Any]:
        total = sum(figure.events for figure in told.values())
        return {"events": total, **{f"events {name}": f.events for name, f in told.items()}}

    def active() -> dict[str, Any]:
        mean = sum(figure.active for figure in told.values()) / len(told)
        return {"active": mean, **{f"active {name}": f.active for name, f in told.items()}}

    known: dict[str, Callable[[], dict[str, Any]]] = {
        "events": events,
        "active": active,
        "coverage": lambda: {"coverage": coverage(sensors)},
        "light_error": lambda: {"light_error": _light_error(task, readings, sensors)},
    }
    for name, measure in known.items():
        if name in task.measure:
            found.add(name, measure)
    found.add_functions(task, recording, None)
    return found


def _of_function(
    name: str, source: str, recording: Any, truth: Any, taken: Collection[str]
) -> dict[str, Any]:
    """What a user's function measures; `taken` are the names of other columns. Raises
    AngenError."""
    try:
        told = _function(name, source)(recording, truth)
    except Exception as error:
        frame = traceback.extract_tb(error.__traceback__)[-1]
        raise AngenError(f"raised {type(error).__name__}: {error} (line {frame.lineno})") from None
    found = _numbers(name, told)
    for key in found:
        if key in taken:
            raise AngenError(f"gives {key!r}, which is another column: name it otherwise")
    return found


def _numbers(name: str, told: Any) -> dict[str, Any]:
    if not isinstance(told, Mapping):
        told = {name: told}
    found = {}
    for key, value in told.items():
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise AngenError(f"gave {value!r} for {key!r}, which is no number") from None
        found[str(key)] = number if math.isfinite(number) else None
    return found


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


def readings_of(sensors: list[Sensor], frames: tuple[int, int] | None) -> Readings:
    """Simulates sensors of the open home."""
    scene = bpy.context.scene
    first, last = frames or (scene.frame_start, scene.frame_end)
    readings = Readings()
    for _ in simulate(scene, sensors, max(first, scene.frame_start), last, readings):
        pass
    return readings
