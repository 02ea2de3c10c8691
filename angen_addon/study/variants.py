# SPDX-License-Identifier: GPL-3.0-or-later
"""The sensors of runs that live the open home together: one for each of the settings that a sensor
has in some of them."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import bpy

from ...residents.days.rows import Day
from ...sensor_logic.error import AngenError
from ...sensor_logic.recording.tracks import Recording
from ...sensor_logic.study.targets import POSE
from ..scene.sensors import Sensor, all_sensors, check, check_names, simulated
from .changes import set_parameter


class Variants:
    """As a context; its end removes what was made for them."""

    def __init__(self) -> None:
        self._sensors = all_sensors(bpy.context.view_layer)
        self._known: dict[Any, Sensor] = {}

    def __enter__(self) -> Variants:
        return self

    def __exit__(self, *_: object) -> None:
        for sensor in self._known.values():
            bpy.data.objects.remove(sensor.settings_of)

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
