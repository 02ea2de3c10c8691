# SPDX-License-Identifier: GPL-3.0-or-later
"""Explain an update in a recording, or the last event before a time."""

from __future__ import annotations

import weakref
from collections.abc import Iterator, Sequence
from typing import Any

from ...sensor_logic.clock import Schedule
from ...sensor_logic.kind import LIGHT
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.recording.events import log_indices
from ...sensor_logic.recording.tracks import Recording
from ..appearance.appearance import appearance_of
from ..appearance.facts import Explanation
from ..appearance.recorded import RecordedSensor
from ..runtime.simulation import Progress, simulate
from ..runtime.time_base import clock_of
from ..scene import outputs
from ..scene.instances import Uid
from ..scene.sensors import Sensor, decimal, simulated


def explain(scene: Any, sensor: Sensor, recording: Recording, index: int) -> Explanation:
    """Explain update `index` of a sensor in a recording.

    If the output is off at that update, the explanation also says what would switch it on.

    Raise `AngenError` if the recording does not tell why the sensor read what it did.
    """
    recorded, appearance = RecordedSensor(scene, sensor, recording), appearance_of(sensor.kind)
    found = appearance.explain(recorded, index)
    return found if recorded.track.active[index] else appearance.lacking(recorded, index, found)


class Memory:
    """Stores the last explanation, for the panels to show.

    It is valid only for the recording from which it was made. Undo, loading a file and edits
    discard that recording.
    """

    def __init__(self) -> None:
        self._of: weakref.ref[Recording] | None = None
        self._uid: Uid = 0
        self._kept: Explanation | None = None

    def keep(self, recording: Recording, uid: Uid, explanation: Explanation) -> None:
        """Store an explanation for a sensor; `uid` is the session uid of the sensor's object."""
        self._of, self._uid, self._kept = weakref.ref(recording), uid, explanation

    def recall(self, recording: Recording, uid: Uid, index: int | None) -> Explanation | None:
        """Return the stored explanation; None if it is not for update `index` of this sensor."""
        kept = self._kept
        if kept is None or self._of is None or self._of() is not recording:
            return None
        return kept if (self._uid, kept.index) == (uid, index) else None

    def clear(self) -> None:
        """Discard the stored explanation."""
        self._of, self._uid, self._kept = None, 0, None


MEMORY = Memory()


class ExplainedTime:
    """Explains a sensor's reading at a time (s), for the command `angen explain`.

    First call `run`, which simulates the necessary frames, `first` to `last`. Then `text` returns
    the explanation.
    """

    def __init__(self, scene: Any, sensors: Sequence[Sensor], sensor: Sensor, time: float) -> None:
        self._scene = scene
        self._sensor = sensor
        self._recording = Recording()
        # Drivers can move objects by the outputs of other sensors, so all are simulated.
        self._sensors = list(sensors) if outputs.are_driven() else [sensor]
        clock = clock_of(scene)
        self._asked = time
        # The log rounds times, so a time copied from the log can be just before its event.
        self._time = time + 1e-6
        steps = self._time * float(clock.steps_per_second)
        step = last = int(steps)
        self.first = scene.frame_start
        schedule = Schedule(clock, decimal(sensor.settings.update_rate))
        if steps - step > 1e-3 and not sensor.kind.requires(LIGHT):
            # A message with a time between two updates belongs to the later update.
            last = max(step, schedule.step(schedule.last_update(step) + 1))
        self.last = clock.frame_and_subframe(last)[0]
        if sensor.kind.requires(LIGHT):
            # Light does not depend on earlier frames, and rendering these would take long.
            earlier = max(schedule.last_update(step) - 1, 0)
            self.first = clock.frame_and_subframe(schedule.step(earlier))[0]

    def run(self) -> Iterator[Progress]:
        """Start the simulation; return the iterator that runs it and yields its progress.

        Raise `AngenError` if the sensor is switched off.
        """
        if not simulated([self._sensor]):
            raise AngenError(
                f"'{self._sensor.name}' is switched off, so it publishes nothing: switch it on "
                "with Enabled"
            )
        return simulate(self._scene, self._sensors, self.first, self.last, self._recording)

    @property
    def updates(self) -> int:
        """The number of simulated updates."""
        return sum(len(track) for track in self._recording.tracks.values())

    def text(self, now: bool = False) -> str:
        """Return the explanation of the last event up to the constructor's `time`.

        Call `run` first. If `now` is True, explain the last update instead, even if it is no event.
        Raise `AngenError` if there is nothing to explain.
        """
        track = self._recording.tracks[self._sensor.name]
        # Whether a reading of light is an event depends on earlier updates, which were not run.
        every = now or self._sensor.kind.requires(LIGHT)
        indices = range(len(track)) if every else log_indices(track).tolist()
        earlier = [i for i in indices if track.times[i] <= self._time]
        if not earlier:
            raise AngenError(
                f"'{self._sensor.name}' has published nothing up to this time: give a later time"
            )
        found = explain(self._scene, self._sensor, self._recording, earlier[-1])
        updates_after = track.times[earlier[-1] + 1 :]
        if every or not any(at <= self._time for at in updates_after):
            return found.as_text()
        asked = f"{self._asked:g} s"
        return found.as_text(
            f"The last event before {asked}; add --now to explain the reading at {asked}"
        )
