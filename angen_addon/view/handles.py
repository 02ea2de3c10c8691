# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a sensor can be dragged in 3D views: where each handle is, and what it changes.

Each kind names its handles in its `Appearance`; gizmos.py draws them and follows the mouse.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.model import Array
from ...sensor_logic.parameters import Spec, format_quantity, is_chosen, label_of, specs
from ...sensor_logic.wording import Lengths
from ..scene.sensors import Sensor, unit_scale

# The least that a length or an angle that must be above 0 is dragged to: m, rad.
LEAST = 0.001
# rad: angles snap to this.
SNAP_ANGLE = math.radians(5)

Point = Sequence[float]


class _With:
    """Parameters of a sensor, of which one has another value."""

    def __init__(self, parameters: Any, name: str, value: float) -> None:
        self._parameters, self._name, self._value = parameters, name, value

    def __getattr__(self, name: str) -> Any:
        return self._value if name == self._name else getattr(self._parameters, name)


@dataclass(frozen=True)
class Handle:
    """The handle of one parameter. `at`: from the parameters to its point (3,) in m, in the
    sensor's axes."""

    parameter: str
    at: Callable[[Any], Point]

    def _spec(self, sensor: Sensor) -> Spec:
        return specs(sensor.kind.parameters)[self.parameter]

    def is_used(self, sensor: Sensor) -> bool:
        """Whether the sensor's model uses the parameter."""
        return is_chosen(sensor.parameters, self._spec(sensor).used_when)

    def label(self, sensor: Sensor) -> str:
        return label_of(self._spec(sensor), sensor.parameters)

    def text(self, sensor: Sensor, lengths: Lengths) -> str:
        """Its value, with its unit."""
        return format_quantity(self.value(sensor), self._spec(sensor).unit, lengths)

    def value(self, sensor: Sensor) -> float:
        return float(getattr(sensor.parameters, self.parameter))

    def limits(self, sensor: Sensor) -> tuple[float, float]:
        spec = self._spec(sensor)
        return max(spec.minimum, LEAST if spec.positive else 0.0), spec.maximum

    def point(self, sensor: Sensor, value: float) -> Array:
        """Where it is in the sensor's axes (m) if the parameter has this value."""
        return np.array(self.at(_With(sensor.parameters, self.parameter, value)), np.float64)

    def set(self, sensor: Sensor, value: float, snap: bool = False) -> None:
        """Gives the parameter this value within its limits, in few digits; `snap`: in fewer."""
        low, high = self.limits(sensor)
        is_angle = self._spec(sensor).unit == "rad"
        rounded = _rounded_angle(value, snap) if is_angle else _rounded_length(value, snap)
        self.put(sensor, min(max(rounded, low), high))

    def put(self, sensor: Sensor, value: float) -> None:
        """Gives the parameter exactly this value."""
        setattr(sensor.parameters, self.parameter, value)


@dataclass(frozen=True)
class SizeHandle:
    """The handle at the edge of a body along its axis 0 or 1, in the middle of its upper side. Its
    value is how far the edge is from the origin, in m; it scales the object."""

    axis: int

    def _edge(self, sensor: Sensor) -> Array:
        """(3,) in the object's own axes, in Blender units."""
        corners = np.array(sensor.object.bound_box, np.float64)
        low, high = corners.min(axis=0), corners.max(axis=0)
        edge: Array = (low + high) / 2.0
        edge[self.axis], edge[2] = high[self.axis], high[2]
        return edge

    def _scale(self, sensor: Sensor) -> Array:
        """(3,) m a unit of the object's own axes."""
        metres = unit_scale(bpy.context.scene)
        return np.array(sensor.object.matrix_world.to_scale(), np.float64) * metres

    def is_used(self, sensor: Sensor) -> bool:
        """Whether the object has an edge on that side, and users may scale it."""
        is_free = not sensor.object.lock_scale[self.axis]
        return is_free and bool(self._edge(sensor)[self.axis] > 0.0)

    def label(self, sensor: Sensor) -> str:
        return f"Size {'XY'[self.axis]}"

    def text(self, sensor: Sensor, lengths: Lengths) -> str:
        """Its size from edge to edge."""
        across = float(np.ptp(np.array(sensor.object.bound_box, np.float64)[:, self.axis]))
        return format_quantity(across * self._scale(sensor)[self.axis], "m", lengths)

    def value(self, sensor: Sensor) -> float:
        return float((self._edge(sensor) * self._scale(sensor))[self.axis])

    def limits(self, sensor: Sensor) -> tuple[float, float]:
        return LEAST, math.inf

    def point(self, sensor: Sensor, value: float) -> Array:
        point: Array = self._edge(sensor) * self._scale(sensor)
        point[self.axis] = value
        return point

    def set(self, sensor: Sensor, value: float, snap: bool = False) -> None:
        self.put(sensor, max(_rounded_length(value, snap), LEAST))

    def put(self, sensor: Sensor, value: float) -> None:
        sensor.object.scale[self.axis] *= value / self.value(sensor)
        # The world matrix, by which the value is told, follows.
        bpy.context.view_layer.update()


def _rounded_length(metres: float, snap: bool) -> float:
    """To four digits; `snap`: to a tenth of the first one's place, such as 0.1 m up to 10 m."""
    if not snap or metres <= 0.0:
        return float(f"{metres:.4g}")
    step = 10.0 ** math.floor(math.log10(metres)) / 10.0
    return float(f"{round(metres / step) * step:.4g}")


def _rounded_angle(radians: float, snap: bool) -> float:
    """To a tenth of a degree; `snap`: to 5°."""
    step = SNAP_ANGLE if snap else math.radians(0.1)
    return round(radians / step) * step


# Where the handles of usual parameters are, which several kinds have.


def ahead(name: str) -> Handle:
    """Of a distance along the view."""
    return Handle(name, lambda parameters: (0.0, 0.0, -getattr(parameters, name)))


def edge(name: str, aside: tuple[float, float], share: float, reach: str = "range_max") -> Handle:
    """Of an angle from edge to edge of what it sees: at half of its reach, in the direction that is
    turned from the view's axis by this share of the angle, towards `aside` (x, y)."""

    def at(parameters: Any) -> Point:
        angle, away = share * getattr(parameters, name), getattr(parameters, reach) / 2.0
        x, y = (away * math.sin(angle) * part for part in aside)
        return x, y, -away * math.cos(angle)

    return Handle(name, at)
