# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains why a sensor reads what it reads: the object, the ray and by how much.

The facts are gathered by going back to the update's frame and the one that it was compared with,
with the same rays, noise and model as in the run. Never in `draw` or in a handler.
"""

from __future__ import annotations

import weakref
from typing import Any

from ...sensor_logic.recording.tracks import Recording
from ..kinds import appearance_of
from ..scene.instances import Uid
from ..scene.sensors import Sensor
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
