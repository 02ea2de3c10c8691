# SPDX-License-Identifier: GPL-3.0-or-later
"""What a story becomes: functions of time for body, doors, lamps and props. No bpy objects.

Times are seconds from the start, yaws of leaves degrees, as in `plan`.
"""

from dataclasses import dataclass, field

import numpy as np
from angen_sensors.sensor_logic.residents.timeline import Gesture, Hold, Swing, Timeline, swung

from . import plan


@dataclass
class Film:
    """Everything that moves: the body, and by name leaves, lamps and props."""

    body: Timeline = field(default_factory=Timeline)
    swings: dict[str, list[Swing]] = field(default_factory=dict)
    lamps: list[tuple[float, str, bool]] = field(default_factory=list)
    props: dict[str, list[Hold]] = field(default_factory=dict)
    tilts: dict[str, list[Gesture]] = field(default_factory=dict)
    marks: list[tuple[float, str]] = field(default_factory=list)

    @property
    def duration(self) -> float:
        return self.body.duration

    def yaw(self, name: str, times: np.ndarray, closed: float) -> np.ndarray:
        """Yaws (n,) of a leaf at times (n,), degrees."""
        return swung(self.swings.get(name, ()), times, closed)

    def door_yaw(self, name: str, times: np.ndarray) -> np.ndarray:
        return self.yaw(f"Door {name}", times, plan.DOORS[name].closed_yaw)
