# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the object that caused an event, and the person who moved the object.

The cause is the object that *Explain* names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ...angen_addon.explain.replay import Recalled, Replay
from ...angen_addon.kinds import appearance_of
from ...angen_addon.runtime import state
from ...angen_addon.runtime.probes import Probes
from ...angen_addon.runtime.sensor_runner import SensorRunner
from ...angen_addon.runtime.trace import NotRecorded
from ...angen_addon.scene.bearers import candidates
from ...angen_addon.scene.sensors import Sensor, unit_scale
from ...sensor_logic.logs.log import Event
from ...sensor_logic.recording.events import NewEvents
from ...sensor_logic.recording.tracks import Recording
from ..acting.timeline import Acted


class Causes:
    """The causes of the events of a day, found while the day is simulated.

    The run calls `note` after each reading of a sensor.

    Parameters
    ----------
    residents
        The object of each person.
    midnight
        The start of the day, in s of the run.
    wanted
        Whether to find causes; if False, they are empty.

    Attributes
    ----------
    events
        The events of the run. `because` is the name of the object that caused the event, and
        `person` is the person who moves this object. Both are empty for events up to midnight.
    """

    def __init__(
        self,
        scene: Any,
        sensors: Sequence[Sensor],
        recording: Recording,
        acted: Acted,
        residents: Mapping[str, Any],
        midnight: float,
        wanted: bool = True,
    ) -> None:
        self._scene = scene
        self._sensors = {sensor.name: sensor for sensor in sensors}
        self._recording = recording
        self.new = NewEvents(recording)
        self._acted = acted
        self._midnight = midnight
        self._persons = {obj.name: person for person, obj in residents.items()}
        frames = {person: obj.angen_resident.walking_frame for person, obj in residents.items()}
        self._persons |= {frame.name: person for person, frame in frames.items() if frame}
        self._probes: Probes | None = None
        self._owners: dict[str, list[str]] = {}
        self._left: list[Event[float]] = []
        self.wanted = wanted
        self.events: list[Event[float]] = []

    def note(self, runner: SensorRunner) -> None:
        """Find the causes of a sensor's new events in the stored rays and hits of its last reading.

        If these lack a cause, `explain_left` finds the cause later.
        """
        because: dict[float, str] = {}
        for event in self.new.take_of(runner.sensor.name):
            if event.time <= self._midnight:
                self.events.append(event)
                continue
            try:
                if event.frame not in because:
                    recalled = Recalled(self._scene, self._recording, runner.trace)
                    because[event.frame] = self._cause_name(recalled, event)
            except NotRecorded:
                self._left.append(event)
            else:
                self._add_event(event, because[event.frame])

    def explain_left(self) -> None:
        """Find the causes that `note` has not found, by simulating these events' frames again.

        Call it while the scene has the keyframes for the time of these events, and no sensor is
        sensing.
        """
        if not self.wanted:
            self.events += (event for name in self._sensors for event in self.new.take_of(name))
            return
        was_running, state.CACHE.running = state.CACHE.running, True
        because: dict[tuple[str, float], str] = {}
        try:
            for event in sorted(self._left):
                key = event.sensor, event.frame
                if key not in because:
                    sensor = self._sensors[event.sensor]
                    replay = Replay(self._scene, sensor, self._recording, self._probes)
                    self._probes = replay.probes
                    because[key] = self._cause_name(replay, event)
                self._add_event(event, because[key])
        finally:
            if self._probes is not None:
                self._probes.close()
            state.CACHE.running = was_running
            self._left = []

    def _cause_name(self, replay: Replay, event: Event[float]) -> str:
        """Return the name of the object that caused an event, or ""."""
        kind, track = replay.sensor.kind, replay.track
        index = track.at(event.frame)
        if index is None or (kind.publishes("motion") and not track.active[index]):
            # The end of a motion has no cause.
            return ""
        return appearance_of(kind).explain(replay, index).cause_name

    def _add_event(self, event: Event[float], because: str) -> None:
        person = self.person_of(because, event.time - self._midnight) if because else ""
        self.events.append(replace(event, person=person, because=because))

    def person_of(self, name: str, time: float) -> str:
        """Return the person who moves an object at a time (s of the day), or "".

        This is the person whose body the object is part of, or who last moved it. Otherwise it is a
        person on top of the object. For example, a person sits on a cushion, which presses on a
        sensor's pad.
        """
        for owner in self._parent_names(name):
            person = self._persons.get(owner) or self._acted.last_mover(owner, time)
            if person:
                return person
        obj = _find_object(name)
        if obj is None or obj.type != "MESH":
            return ""
        corners = np.array([obj.matrix_world @ Vector(corner) for corner in obj.bound_box])
        corners *= unit_scale(self._scene)
        return self._acted.person_on(corners.min(axis=0), corners.max(axis=0), time)

    def _parent_names(self, name: str) -> list[str]:
        """Return the names of an object, its parent, the parent's parent and so on."""
        if name not in self._owners:
            obj = _find_object(name)
            self._owners[name] = [one.name for one in candidates(obj)] if obj is not None else []
        return self._owners[name]


def _find_object(name: str) -> Any:
    """Return the object with a name; an instance is named "OBJECT in INSTANCER"."""
    return bpy.data.objects.get(name) or bpy.data.objects.get(name.rpartition(" in ")[2])
