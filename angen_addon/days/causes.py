# SPDX-License-Identifier: GPL-3.0-or-later
"""Which object made an event, as *Explain* names it, and which person that belongs to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import bpy

from ...sensor_logic.log.event_log import Event, NewEvents
from ...sensor_logic.recording.tracks import Recording
from ...sensor_logic.residents.acted import Acted
from ..advice.weights import chain
from ..kinds import appearance_of
from ..runtime import state
from ..runtime.probes import Probes
from ..scene.sensors import Sensor
from ..view.explain.replay import Replay


class Causes:
    """Of the events of a day's run, asked for while the keys of their time are in the home.
    `residents`: by person, the object that acts."""

    def __init__(
        self,
        scene: Any,
        sensors: Sequence[Sensor],
        recording: Recording,
        acted: Acted,
        residents: Mapping[str, Any],
    ) -> None:
        self._scene = scene
        self._sensors = {sensor.name: sensor for sensor in sensors}
        self._recording = recording
        self._new = NewEvents(recording)
        self._acted = acted
        self._persons = {obj.name: person for person, obj in residents.items()}
        self._probes: Probes | None = None
        self._owners: dict[str, list[str]] = {}
        # By sensor, who made the last event that somebody did.
        self._last: dict[str, str] = {}

    def take(self, since: float, midnight: float) -> list[tuple[Event, str, str]]:
        """The events that came since the last time, each with person and object. Those up to
        `since` s have none; the day begins at `midnight` s of the run."""
        found, was_running = [], state.CACHE.running
        because: dict[tuple[str, float], str] = {}
        state.CACHE.running = True
        try:
            for event in self._new.take():
                if event.time <= since:
                    found.append((event, "", ""))
                    continue
                key = event.sensor, event.frame
                if key not in because:
                    because[key] = self._because(event)
                name = because[key]
                found.append((event, self._person(event, name, event.time - midnight), name))
        finally:
            state.CACHE.running = was_running
        return found

    def _because(self, event: Event) -> str:
        sensor, track = self._sensors[event.sensor], self._recording.tracks[event.sensor]
        index = track.at(event.frame)
        if index is None or (sensor.kind.publishes("motion") and not track.active[index]):
            # That nothing moves any more, nobody does.
            return ""
        replay = Replay(self._scene, sensor, self._recording, self._probes)
        self._probes = replay.probes
        return appearance_of(sensor.kind).explain(replay, index).because

    def _person(self, event: Event, because: str, time: float) -> str:
        """Whose movement the event is of: what ends is of who began it."""
        if because:
            self._last[event.sensor] = self.person_of(because, time)
        return self._last.get(event.sensor, "")

    def person_of(self, name: str, time: float) -> str:
        """Whose body an object is part of, or who moves it at a time; empty where nobody does."""
        for owner in self._chain(name):
            person = self._persons.get(owner) or self._acted.mover(owner, time)
            if person:
                return person
        return ""

    def _chain(self, name: str) -> list[str]:
        """The object itself and what it hangs on, by their names. Instances are told as "thing in
        what brings it forth"."""
        if name not in self._owners:
            obj = bpy.data.objects.get(name) or bpy.data.objects.get(name.rpartition(" in ")[2])
            self._owners[name] = [owner.name for owner in _chain(obj)]
        return self._owners[name]


def _chain(obj: Any) -> Iterable[Any]:
    return chain(obj) if obj is not None else ()
