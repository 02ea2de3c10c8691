# SPDX-License-Identifier: GPL-3.0-or-later
"""Change the open home for a run and undo the changes; copy sensors that a run sets differently."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from mathutils import Euler, Matrix, Quaternion, Vector

from ..angen_addon.runtime.time_base import evaluated_depsgraph
from ..angen_addon.scene.animation import is_animated, motion_paths
from ..angen_addon.scene.sensors import (
    Sensor,
    all_sensors,
    check,
    check_names,
    simulated,
    unit_scale,
)
from ..residents.days.rows import Day
from ..sensor_logic.logs.error import AngenError, explained
from ..sensor_logic.recording.tracks import Recording
from .study_file import COMMON, POSE

CHANNELS = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
# Tolerance of positions: single precision at some metres from the origin.
SAME_PLACE = 1e-5


class Changes(ExitStack):
    """Context manager: its methods change the open home, and its exit undoes all changes."""

    def __init__(self) -> None:
        super().__init__()
        # Registered first, so that it is called last.
        self.callback(lambda: bpy.context.view_layer.update())

    def set(self, owner: Any, name: str, value: Any) -> None:
        """Set the attribute `name` of `owner`; the exit restores its present value."""
        before = getattr(owner, name)
        if isinstance(before, (Vector, Euler, Quaternion, Matrix)):
            before = before.copy()
        elif not isinstance(before, (bool, int, float, str, type(None), bpy.types.ID)):
            before = tuple(before)
        self.callback(setattr, owner, name, before)
        setattr(owner, name, value)

    def apply(self, settings: Mapping[str, Mapping[str, Any]]) -> None:
        """Set the parameters of sensors, and move sensors.

        `settings` has values by sensor and parameter. Raise `AngenError` if a sensor cannot be
        changed.
        """
        sensors = {sensor.name: sensor for sensor in all_sensors(bpy.context.view_layer)}
        for name, values in settings.items():
            sensor = sensors[name]
            for parameter, value in values.items():
                if parameter not in POSE:
                    set_parameter(sensor, parameter, value, self.set)
            by = {key: float(values[key]) for key in POSE if values.get(key)}
            if by:
                self._move(sensor, by)
        bpy.context.view_layer.update()

    def _move(self, sensor: Sensor, by: Mapping[str, float]) -> None:
        """Move a sensor along the home's axes (m), and turn it about its own axes (rad)."""
        obj = sensor.object
        if sensor.holders or not obj.is_editable:
            raise AngenError(
                f"'{sensor.name}' is linked or in an instance, so a study cannot move it: make "
                "it local (Object, Relations, Make Local), or move another sensor"
            )
        held = motion_paths(obj)
        if held:
            raise AngenError(
                f"'{sensor.name}' cannot be moved: it is animated or constrained ({held[0]})"
            )
        bpy.context.view_layer.update()
        offset = Vector([by.get(f"move_{axis}", 0.0) for axis in "xyz"])
        turn = Euler([by.get(f"turn_{axis}", 0.0) for axis in "xyz"]).to_matrix().to_4x4()
        metres = unit_scale(bpy.context.scene)
        wanted = Matrix.Translation(offset / metres) @ obj.matrix_world @ turn
        for channel in CHANNELS:
            self.set(obj, channel, getattr(obj, channel))
        obj.matrix_world = wanted
        bpy.context.view_layer.update()
        reached = np.array(sensor.world_matrix(evaluated_depsgraph()))
        if not np.allclose(reached, np.array(wanted), atol=SAME_PLACE, rtol=SAME_PLACE):
            raise AngenError(
                f"'{sensor.name}' cannot be moved: its location or rotation is "
                "locked, constrained or driven"
            )


def set_parameter(
    sensor: Sensor, parameter: str, value: Any, put: Callable[[Any, str, Any], object]
) -> None:
    """Set a parameter of a sensor to another value, by calling `put(owner, name, value)`.

    Do nothing if the parameter has this value. Raise `AngenError` if the parameter is animated,
    linked or out of limits.
    """
    common = parameter in COMMON
    group = sensor.settings if common else sensor.parameters
    path = f"angen_sensor.{parameter}"
    if not common:
        path = f"angen_sensor.{sensor.kind.attribute}.{parameter}"
    if getattr(group, parameter) == value:
        return
    if is_animated(sensor.object, path):
        raise AngenError(
            f"'{sensor.name}': {parameter} is animated or driven: remove the keyframes or driver"
        )
    if not sensor.object.is_editable:
        raise AngenError(f"'{sensor.name}' is linked: make a library override of it in the home")
    with explained(f"'{sensor.name}': {parameter}", TypeError, ValueError, raised=AngenError):
        put(group, parameter, value)


class Variants(ExitStack):
    """Context manager: it makes copies of sensors with other parameters, and removes them on exit.

    With the copies, runs with different parameters share one simulation of the home.
    """

    def __init__(self) -> None:
        super().__init__()
        self._sensors = all_sensors(bpy.context.view_layer)
        self._known: dict[Any, Sensor] = {}

    def sensors_for(self, settings: Mapping[str, Mapping[str, Any]]) -> list[Sensor]:
        """Return the sensors that are enabled in a run; copies, if the run sets their parameters.

        Raise `AngenError` if none is enabled, or if a sensor is not valid.
        """
        found = simulated(self._variant(s, settings.get(s.name, {})) for s in self._sensors)
        if not found:
            raise AngenError("no sensor is switched on")
        for sensor in with_run_names(found):
            check(sensor)
        check_names(with_run_names(found))
        return found

    def _variant(self, sensor: Sensor, values: Mapping[str, Any]) -> Sensor:
        values = {key: value for key, value in values.items() if key not in POSE}
        if not values:
            return sensor
        key = sensor.uid, tuple(sorted(values.items()))
        if key not in self._known:
            number = len(self._known) + 1
            # The copy is in no scene, so the home does not change.
            holder = sensor.object.copy()
            self.callback(bpy.data.objects.remove, holder)
            made = replace(sensor, settings_of=holder, stands_for=sensor.name, variant=number)
            self._known[key] = replace(made, name=f"{sensor.name}\n{number}")
            for parameter, value in values.items():
                set_parameter(made, parameter, value, setattr)
        return self._known[key]


def run_name(sensor: Sensor) -> str:
    """Return a sensor's name in the results of a run; a copy has the copied sensor's name."""
    return sensor.stands_for or sensor.name


def with_run_names(sensors: Iterable[Sensor]) -> list[Sensor]:
    """Return the sensors, named as in the results of a run; see `run_name`."""
    return [replace(sensor, name=run_name(sensor)) for sensor in sensors]


def recording_of_sensors(readings: Recording, sensors: Sequence[Sensor]) -> Recording:
    """Return a recording of only the given sensors, named as in the results of a run."""
    tracks = {}
    for sensor in sensors:
        track = copy.copy(readings.tracks[sensor.name])
        track.sensor = run_name(sensor)
        tracks[track.sensor] = track
    return replace(readings, tracks=tracks)


def day_of_sensors(day: Day, sensors: Sequence[Sensor]) -> Day:
    """Return a day with the events of only the given sensors, named as in the results of a run."""
    names = {sensor.name: run_name(sensor) for sensor in sensors}
    events = [replace(e, sensor=names[e.sensor]) for e in day.events if e.sensor in names]
    events.sort(key=lambda event: (event.time, event.sensor, event.field))
    return replace(day, events=tuple(events))
