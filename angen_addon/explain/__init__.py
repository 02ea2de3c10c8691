# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a sensor reads what it reads: the object, the ray and by how much.

The facts are gathered by going back to the update's frame and the one that it was compared with,
with the same rays, noise and model as in the run. Never in `draw` or in a handler.
"""

from __future__ import annotations

from typing import Any

from ...sensor_logic.recording import Recording
from ..sensors import Sensor
from .beam import explain_switch
from .facts import Explanation
from .idle import with_what_is_missing
from .lit import explain_light
from .memory import MEMORY
from .motion import explain_range_scan
from .press import explain_pad
from .replay import Replay, replaying
from .warm import explain_pyroelectric

__all__ = ["MEMORY", "Explanation", "explain"]


def explain_motion(replay: Replay, index: int) -> Explanation:
    """Update `index` of a motion detector of either model. Raises SensorError."""
    if replay.sensor.settings.pir.model == "PYROELECTRIC":
        return explain_pyroelectric(replay, index)
    return explain_range_scan(replay, index)


EXPLAINERS = {
    "PIR": explain_motion,
    "OPTICAL_SWITCH": explain_switch,
    "PRESSURE": explain_pad,
    "LIGHT": explain_light,
}


def explain(scene: Any, sensor: Sensor, recording: Recording, index: int) -> Explanation:
    """Why the sensor's update `index` in the recording is as it is, and what would have to change
    where it is not active.

    `scene` is that of the present context, in the state that was recorded. The frame is put back.
    Raises SensorError.
    """
    with replaying(scene, sensor, recording) as replay:
        found = EXPLAINERS[sensor.kind.identifier](replay, index)
        return with_what_is_missing(replay, index, found)
