# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains why a sensor reads what it reads: the object, the ray and by how much.

The facts are gathered by going back to the update's frame and the one that it was compared with,
with the same rays, noise and model as in the run. Never in `draw` or in a handler.
"""

from __future__ import annotations

from typing import Any

from ...sensor_logic.recording.tracks import Recording
from ..kinds import appearance_of
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
