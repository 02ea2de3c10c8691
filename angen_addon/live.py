# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors that follow the playhead, where there is no recording.

Live sensing samples at the same frames as a run does. Where the updates before the playhead were
not seen, as after a jump, a sensor starts anew: it never compares with a frame long past.
"""

from __future__ import annotations

from typing import Any

from ..sensor_logic.clock import Clock
from . import outputs
from .sensors import SensorError, all_sensors, check, simulated
from .station import Station, make_caster


class Live:
    """The sensors of one scene following the playhead."""

    def __init__(self, scene: Any) -> None:
        self.scene_uid = scene.session_uid
        self.problems: dict[str, str] = {}
        self.outdated = True
        self._caster = make_caster(scene)
        self._clock: Clock
        self._stations: list[Station] = []
        self._last_update: dict[int, int] = {}

    def follow(self, scene: Any, view_layer: Any, depsgraph: Any) -> None:
        """Senses at the present frame and shows it."""
        # A handler cannot evaluate sub-frames: live values look at whole frames.
        clock = Clock(scene.frame_start, scene.render.fps, scene.render.fps_base)
        if self.outdated or clock != self._clock or not self._sensors_are_the_same():
            self._find_sensors(view_layer, clock)
        if not self._stations:
            return
        step = scene.frame_current - scene.frame_start
        if step < 0:
            # Before time begins there is nothing to sense, and nothing to compare with later.
            self._last_update.clear()
            return
        self._caster.update(depsgraph)
        changed = [self._follow_one(station, step, depsgraph) for station in self._stations]
        if any(changed):
            # What drivers make of it now, Blender tells nobody.
            self._caster.solids.forget()

    def _sensors_are_the_same(self) -> bool:
        """Whether every sensor still exists, under its name."""
        try:
            return all(s.sensor.object.name == s.sensor.name for s in self._stations)
        except ReferenceError:
            return False

    def _find_sensors(self, view_layer: Any, clock: Clock) -> None:
        self._clock = clock
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

    def _follow_one(self, station: Station, step: int, depsgraph: Any) -> bool:
        """Whether the sensor's binary output changed."""
        name, uid = station.sensor.name, station.sensor.uid
        number = station.schedule.last_update(step)
        last = self._last_update.get(uid)
        if number == last:
            return False
        if last is None or number != last + 1 or station.schedule.step(number) != step:
            station.reset()
        self._last_update[uid] = number
        try:
            reading = station.sense(number, step, depsgraph, self._caster)
        except SensorError as error:
            self.problems[name] = str(error)
            self._last_update.pop(uid)
            return False
        self.problems.pop(name, None)
        return reading is not None and outputs.show(station.sensor, reading.active, reading.value)
