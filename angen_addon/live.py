# SPDX-License-Identifier: GPL-3.0-or-later
"""What sensors show at the playhead: the recording, or else what they sense there.

Live sensing samples at the same frames as a run does. Where the updates before the playhead were
not seen, as after a jump, a sensor starts anew: it never compares with a frame long past.
"""

from __future__ import annotations

from typing import Any

from ..sensor_logic.clock import Clock
from ..sensor_logic.model import Reading
from ..sensor_logic.recording import Recording
from .sensors import Sensor, SensorError, all_sensors, check, simulated
from .station import Station, make_caster


class Live:
    """The sensors of one scene following the playhead."""

    def __init__(self, scene: Any) -> None:
        self.scene_uid = scene.session_uid
        self.problems: dict[str, str] = {}
        self.outdated = True
        self._caster = make_caster(scene)
        self._stations: list[Station] = []
        self._last_update: dict[str, int] = {}

    def follow(self, scene: Any, view_layer: Any, depsgraph: Any) -> None:
        """Senses at the present frame and shows it."""
        if self.outdated:
            self._find_sensors(scene, view_layer)
        if not self._stations:
            return
        self._caster.update(depsgraph)
        step = max(scene.frame_current - scene.frame_start, 0)
        for station in self._stations:
            self._follow_one(station, step, depsgraph)

    def _find_sensors(self, scene: Any, view_layer: Any) -> None:
        # A handler cannot evaluate sub-frames: live values look at whole frames.
        clock = Clock(scene.frame_start, scene.render.fps, scene.render.fps_base)
        self.outdated = False
        self.problems.clear()
        self._stations.clear()
        self._last_update.clear()
        for sensor in simulated(all_sensors(view_layer)):
            try:
                check(sensor)
            except SensorError as error:
                self.problems[sensor.name] = str(error)
            else:
                self._stations.append(Station(sensor, clock))

    def _follow_one(self, station: Station, step: int, depsgraph: Any) -> None:
        name = station.sensor.name
        number = station.schedule.last_update(step)
        last = self._last_update.get(name)
        if number == last:
            return
        if last is None or number != last + 1 or station.schedule.step(number) != step:
            station.reset()
        self._last_update[name] = number
        try:
            reading = station.sense(number, step, depsgraph, self._caster)
        except SensorError as error:
            self.problems[name] = str(error)
            self._last_update.pop(name)
            return
        self.problems.pop(name, None)
        show(station.sensor, reading)


def show(sensor: Sensor, reading: Reading) -> None:
    """Writes the outputs that drivers and panels read; only where they change.

    In a frame change Blender evaluates what is tagged here before it goes on, and tells nobody.
    """
    settings = sensor.settings
    moved_on = abs(settings.value - reading.value) > 1e-6 * max(1.0, abs(reading.value))
    if settings.active == reading.active and not moved_on:
        return
    settings.active = reading.active
    settings.value = reading.value
    sensor.object.update_tag(refresh={"OBJECT"})


def show_recorded(recording: Recording, view_layer: Any, frame: float) -> None:
    """Shows what was recorded at or before `frame`."""
    for sensor in all_sensors(view_layer):
        track = recording.tracks.get(sensor.name)
        index = track.at(frame) if track else None
        if track is not None and index is not None:
            show(sensor, Reading(bool(track.active[index]), track.value[index], {}))
