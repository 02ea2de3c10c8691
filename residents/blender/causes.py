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

from ...angen_addon.scene.bearers import candidates
from ...angen_addon.scene.sensors import Sensor, unit_scale
from ...sensor_logic.kind import USES
from ...sensor_logic.logs.log import Event
from ...sensor_logic.recording.events import NewEvents
from ...sensor_logic.recording.evidence import cause_of
from ...sensor_logic.recording.tracks import Recording, Track
from ..acting.timeline import Acted


class Causes:
    """The causes of the events of a day, read from the evidence in its recording.

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
        self._names = [sensor.name for sensor in sensors]
        self._recording = recording
        self.new = NewEvents(recording)
        self._acted = acted
        self._midnight = midnight
        self._persons = {obj.name: person for person, obj in residents.items()}
        frames = {person: obj.angen_resident.walking_frame for person, obj in residents.items()}
        self._persons |= {frame.name: person for person, frame in frames.items() if frame}
        self._owners: dict[str, list[str]] = {}
        self.wanted = wanted
        self.events: list[Event[float]] = []

    def add_events(self) -> None:
        """Add the events since the last call, with their causes.

        Call it while the scene has the keyframes for the time of these events.
        """
        for name in self._names:
            events = self.new.take_of(name)
            if not self.wanted:
                self.events += events
                continue
            track = self._recording.tracks[name]
            because: dict[float, str] = {}
            for event in events:
                if event.time <= self._midnight:
                    self.events.append(event)
                    continue
                if event.frame not in because:
                    because[event.frame] = _cause_name(track, event)
                cause = because[event.frame]
                time = event.time - self._midnight
                if track.kind.requires(USES):
                    person = self._acted.last_user(cause, time)
                else:
                    person = self.person_of(cause, time) if cause else ""
                self.events.append(replace(event, person=person, because=cause))

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


def _cause_name(track: Track, event: Event[float]) -> str:
    """Return the name of the object that caused an event, or ""."""
    index = track.at(event.frame)
    objects = cause_of(track, index).objects if index is not None else ()
    return objects[0] if objects else ""


def _find_object(name: str) -> Any:
    """Return the object with a name; an instance is named "OBJECT in INSTANCER"."""
    return bpy.data.objects.get(name) or bpy.data.objects.get(name.rpartition(" in ")[2])
