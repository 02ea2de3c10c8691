# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains an update of a recording, or the last one before a time."""

from __future__ import annotations

import weakref
from collections.abc import Iterator, Sequence
from typing import Any

from ...sensor_logic.clock import Schedule
from ...sensor_logic.error import AngenError
from ...sensor_logic.kind import LIGHT
from ...sensor_logic.log import log_indices
from ...sensor_logic.recording.tracks import Recording
from ..kinds import appearance_of
from ..runtime import state
from ..runtime.simulation import Progress, simulate
from ..runtime.time_base import clock_of
from ..scene.instances import Uid
from ..scene.sensors import Sensor, decimal, simulated
from .facts import Explanation
from .replay import replaying


def explain(scene: Any, sensor: Sensor, recording: Recording, index: int) -> Explanation:
    """Why the sensor's update `index` in the recording is as it is, and what would have to change
    where it is not active.

    `scene` is that of the present context, in the state that was recorded. The frame is put back.
    Raises AngenError.
    """
    with replaying(scene, sensor, recording) as replay:
        appearance = appearance_of(sensor.kind)
        found = appearance.explain(replay, index)
        if replay.track.active[index]:
            return found
        return appearance.lacking(replay, index, found)


# The explanation that panels show: of one sensor, until its recording goes.


class Memory:
    """Keeps the last explanation. It holds for the recording that it was made of, which undo, a
    file load and edits take away."""

    def __init__(self) -> None:
        self._of: weakref.ref[Recording] | None = None
        self._uid: Uid = 0
        self._kept: Explanation | None = None

    def keep(self, recording: Recording, uid: Uid, explanation: Explanation) -> None:
        """`uid`: session uid of the sensor's object."""
        self._of, self._uid, self._kept = weakref.ref(recording), uid, explanation

    def recall(self, recording: Recording, uid: Uid, index: int | None) -> Explanation | None:
        """The last explanation, if it is that of update `index` of this sensor; else None."""
        kept = self._kept
        if kept is None or self._of is None or self._of() is not recording:
            return None
        return kept if (self._uid, kept.index) == (uid, index) else None

    def clear(self) -> None:
        self._of, self._uid, self._kept = None, 0, None


MEMORY = Memory()


# What `angen explain` explains: it simulates up to a moment.


class ExplainedTime:
    """One sensor at a time (s): what has to be simulated first, and the explanation."""

    def __init__(self, scene: Any, sensors: Sequence[Sensor], sensor: Sensor, time: float) -> None:
        self._scene = scene
        self._sensor = sensor
        self._recording = Recording()
        # What drivers make of other sensors belongs to the scene.
        self._sensors = list(sensors) if state.are_driven() else [sensor]
        clock = clock_of(scene)
        # A hair, so that a time as the log writes it is not before its own event.
        self._time = time + 1e-6
        steps = self._time * float(clock.steps_per_second)
        step = last = int(steps)
        self.first = scene.frame_start
        schedule = Schedule(clock, decimal(sensor.settings.update_rate))
        if steps - step > 1e-3 and not sensor.kind.requires(LIGHT):
            # A message that arrives between two updates is read at the later one.
            last = max(step, schedule.step(schedule.last_update(step) + 1))
        self.last = clock.frame_and_subframe(last)[0]
        if sensor.kind.requires(LIGHT):
            # Light does not depend on the frames before, and rendering them all takes long.
            earlier = max(schedule.last_update(step) - 1, 0)
            self.first = clock.frame_and_subframe(schedule.step(earlier))[0]

    def run(self) -> Iterator[Progress]:
        """Simulates. Raises AngenError."""
        if not simulated([self._sensor]):
            raise AngenError(f"'{self._sensor.name}' is switched off: it reports nothing")
        return simulate(self._scene, self._sensors, self.first, self.last, self._recording)

    @property
    def updates(self) -> int:
        """The number of simulated updates."""
        return sum(len(track) for track in self._recording.tracks.values())

    def text(self, now: bool = False) -> str:
        """The explanation of the last event at or before the time, or `now` of the update at it, as
        lines; after `run`. Raises AngenError."""
        track = self._recording.tracks[self._sensor.name]
        # Which readings of light are events is not known without the time before.
        every = now or self._sensor.kind.requires(LIGHT)
        indices = range(len(track)) if every else log_indices(track).tolist()
        told = [i for i in indices if track.times[i] <= self._time]
        if not told:
            raise AngenError(f"'{self._sensor.name}' has reported nothing by then")
        return explain(self._scene, self._sensor, self._recording, told[-1]).as_text()
