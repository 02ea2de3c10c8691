# SPDX-License-Identifier: GPL-3.0-or-later
"""What runs change of the open home, all of which is put back, to the last bit, at their end: the
home itself, and its sensors, of which each run has variants of its own."""

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
from ..sensor_logic.error import AngenError, explained
from ..sensor_logic.recording.tracks import Recording
from ..sensor_logic.study_file import COMMON, POSE

CHANNELS = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
# Single precision at some metres from the origin.
SAME_PLACE = 1e-5


class Changes(ExitStack):
    """As a context; `make` changes, the end puts back."""

    def __init__(self) -> None:
        super().__init__()
        # Called last: what is entered first leaves last.
        self.callback(lambda: bpy.context.view_layer.update())

    def set(self, owner: Any, name: str, value: Any) -> None:
        before = getattr(owner, name)
        if isinstance(before, (Vector, Euler, Quaternion, Matrix)):
            before = before.copy()
        elif not isinstance(before, (bool, int, float, str, type(None), bpy.types.ID)):
            before = tuple(before)
        self.callback(setattr, owner, name, before)
        setattr(owner, name, value)

    def make(self, settings: Mapping[str, Mapping[str, Any]]) -> None:
        """Sets parameters of sensors, and moves them. Raises AngenError."""
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
        """By metres along the home's axes, and radians about its own."""
        obj = sensor.object
        if sensor.holders or not obj.is_editable:
            raise AngenError(f"'{sensor.name}' is linked or in an instance, and cannot be moved")
        held = motion_paths(obj)
        if held:
            raise AngenError(f"'{sensor.name}' cannot be moved: it is animated or held ({held[0]})")
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
            raise AngenError(f"'{sensor.name}' cannot be moved: something holds it")


def set_parameter(
    sensor: Sensor, parameter: str, value: Any, put: Callable[[Any, str, Any], object]
) -> None:
    """Has `put` set a parameter where the sensor has its settings. Raises AngenError."""
    common = parameter in COMMON
    group = sensor.settings if common else sensor.parameters
    path = f"angen_sensor.{parameter}"
    if not common:
        path = f"angen_sensor.{sensor.kind.attribute}.{parameter}"
    if getattr(group, parameter) == value:
        return
    if is_animated(sensor.object, path):
        raise AngenError(f"'{sensor.name}': {parameter} is animated or driven: clear that")
    if not sensor.object.is_editable:
        raise AngenError(f"'{sensor.name}' is linked: override it in the home, or vary there")
    with explained(f"'{sensor.name}': {parameter}", TypeError, ValueError, raised=AngenError):
        put(group, parameter, value)


class Variants(ExitStack):
    """The sensors of runs that live the open home together: one for each of the settings that a
    sensor has in some of them. As a context; its end removes what was made for them."""

    def __init__(self) -> None:
        super().__init__()
        self._sensors = all_sensors(bpy.context.view_layer)
        self._known: dict[Any, Sensor] = {}

    def of(self, settings: Mapping[str, Mapping[str, Any]]) -> list[Sensor]:
        """The sensors that are on with the settings of a run. Raises AngenError."""
        found = simulated(self._variant(s, settings.get(s.name, {})) for s in self._sensors)
        if not found:
            raise AngenError("no sensor is switched on")
        for sensor in named(found):
            check(sensor)
        check_names(named(found))
        return found

    def _variant(self, sensor: Sensor, values: Mapping[str, Any]) -> Sensor:
        values = {key: value for key, value in values.items() if key not in POSE}
        if not values:
            return sensor
        key = sensor.uid, tuple(sorted(values.items()))
        if key not in self._known:
            number = len(self._known) + 1
            # In no scene: nothing of the home changes by it.
            holder = sensor.object.copy()
            self.callback(bpy.data.objects.remove, holder)
            made = replace(sensor, settings_of=holder, stands_for=sensor.name, variant=number)
            self._known[key] = replace(made, name=f"{sensor.name}\n{number}")
            for parameter, value in values.items():
                set_parameter(made, parameter, value, setattr)
        return self._known[key]


def name_of(sensor: Sensor) -> str:
    """What it is called in its run."""
    return sensor.stands_for or sensor.name


def named(sensors: Iterable[Sensor]) -> list[Sensor]:
    """As they are called in their run."""
    return [replace(sensor, name=name_of(sensor)) for sensor in sensors]


def of_run(readings: Recording, sensors: Sequence[Sensor]) -> Recording:
    """What these of the sensors that were simulated read, as if they had been alone."""
    tracks = {}
    for sensor in sensors:
        track = copy.copy(readings.tracks[sensor.name])
        track.sensor = name_of(sensor)
        tracks[track.sensor] = track
    return replace(readings, tracks=tracks)


def day_of_run(day: Day, sensors: Sequence[Sensor]) -> Day:
    """A day as these of the sensors that were simulated told it, as if they had been alone."""
    names = {sensor.name: name_of(sensor) for sensor in sensors}
    events = [replace(e, sensor=names[e.sensor]) for e in day.events if e.sensor in names]
    events.sort(key=lambda event: (event.time, event.sensor, event.field))
    return replace(day, events=tuple(events))
