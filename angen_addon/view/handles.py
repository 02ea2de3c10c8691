# SPDX-License-Identifier: GPL-3.0-or-later
"""The handles that a kind of sensor may have: the place of each, and the value that it changes.

Each kind lists its handles in its `Appearance`. `gizmos.py` draws them and follows the mouse.
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

# Least value (m, rad) of a dragged parameter that must be above 0.
LEAST = 0.001
# rad. Angles snap to multiples of this.
SNAP_ANGLE = math.radians(5)

Point = Sequence[float]


class _Override:
    """Parameters of a sensor, with another value for one of them."""

    def __init__(self, parameters: Any, name: str, value: float) -> None:
        self._parameters, self._name, self._value = parameters, name, value

    def __getattr__(self, name: str) -> Any:
        return self._value if name == self._name else getattr(self._parameters, name)


@dataclass(frozen=True)
class Handle:
    """The handle of one parameter.

    `at` returns the place (3,) of the handle in m, in the sensor's axes, from the parameters.
    """

    parameter: str
    at: Callable[[Any], Point]

    def _spec(self, sensor: Sensor) -> Spec:
        return specs(sensor.kind.parameters)[self.parameter]

    def is_used(self, sensor: Sensor) -> bool:
        """Return whether the sensor's model uses the parameter."""
        return is_chosen(sensor.parameters, self._spec(sensor).used_when)

    def label(self, sensor: Sensor) -> str:
        """Return the label of the parameter."""
        return label_of(self._spec(sensor), sensor.parameters)

    def text(self, sensor: Sensor, lengths: Lengths) -> str:
        """Return the value with its unit."""
        return format_quantity(self.value(sensor), self._spec(sensor).unit, lengths)

    def value(self, sensor: Sensor) -> float:
        """Return the value of the parameter."""
        return float(getattr(sensor.parameters, self.parameter))

    def limits(self, sensor: Sensor) -> tuple[float, float]:
        """Return the least and the greatest value."""
        spec = self._spec(sensor)
        return max(spec.minimum, LEAST if spec.positive else 0.0), spec.maximum

    def point(self, sensor: Sensor, value: float) -> Array:
        """Return the place (3,) in m of the handle for a value, in the sensor's axes."""
        return np.array(self.at(_Override(sensor.parameters, self.parameter, value)), np.float64)

    def set(self, sensor: Sensor, value: float, snap: bool = False) -> None:
        """Set the parameter within its limits, in few digits; with `snap`, in fewer."""
        low, high = self.limits(sensor)
        is_angle = self._spec(sensor).unit == "rad"
        rounded = _rounded_angle(value, snap) if is_angle else _rounded_length(value, snap)
        self.put(sensor, min(max(rounded, low), high))

    def put(self, sensor: Sensor, value: float) -> None:
        """Set the parameter to exactly this value."""
        setattr(sensor.parameters, self.parameter, value)


@dataclass(frozen=True)
class SizeHandle:
    """The handle at an edge of a body, in the middle of its upper side.

    Its value is the distance of the edge from the origin along `axis` (0 or 1), in m. Dragging it
    scales the object.
    """

    axis: int

    def _edge(self, sensor: Sensor) -> Array:
        """Return the place (3,) of the handle in the object's axes, in Blender units."""
        corners = np.array(sensor.object.bound_box, np.float64)
        low, high = corners.min(axis=0), corners.max(axis=0)
        edge: Array = (low + high) / 2.0
        edge[self.axis], edge[2] = high[self.axis], high[2]
        return edge

    def _scale(self, sensor: Sensor) -> Array:
        """Return the metres in a unit of each of the object's axes, shape (3,)."""
        metres = unit_scale(bpy.context.scene)
        return np.array(sensor.object.matrix_world.to_scale(), np.float64) * metres

    def is_used(self, sensor: Sensor) -> bool:
        """Return whether the object has an edge on that side and its scale is not locked."""
        is_free = not sensor.object.lock_scale[self.axis]
        return is_free and bool(self._edge(sensor)[self.axis] > 0.0)

    def label(self, sensor: Sensor) -> str:
        """Return the label of the size."""
        return f"Size {'XY'[self.axis]}"

    def text(self, sensor: Sensor, lengths: Lengths) -> str:
        """Return the size from edge to edge, with its unit."""
        across = float(np.ptp(np.array(sensor.object.bound_box, np.float64)[:, self.axis]))
        return format_quantity(across * self._scale(sensor)[self.axis], "m", lengths)

    def value(self, sensor: Sensor) -> float:
        """Return the distance of the edge from the origin, in m."""
        return float((self._edge(sensor) * self._scale(sensor))[self.axis])

    def limits(self, sensor: Sensor) -> tuple[float, float]:
        """Return the least and the greatest value."""
        return LEAST, math.inf

    def point(self, sensor: Sensor, value: float) -> Array:
        """Return the place (3,) in m of the handle for a value, in the sensor's axes."""
        point: Array = self._edge(sensor) * self._scale(sensor)
        point[self.axis] = value
        return point

    def set(self, sensor: Sensor, value: float, snap: bool = False) -> None:
        """Set the distance in few digits; with `snap`, in fewer."""
        self.put(sensor, max(_rounded_length(value, snap), LEAST))

    def put(self, sensor: Sensor, value: float) -> None:
        """Set the distance to exactly this value."""
        sensor.object.scale[self.axis] *= value / self.value(sensor)
        # Evaluate the world matrix, from which the value is read.
        bpy.context.view_layer.update()


def _rounded_length(metres: float, snap: bool) -> float:
    """Round a length to 4 digits; with `snap`, to a step such as 0.1 m between 1 m and 10 m."""
    if not snap or metres <= 0.0:
        return float(f"{metres:.4g}")
    step = 10.0 ** math.floor(math.log10(metres)) / 10.0
    return float(f"{round(metres / step) * step:.4g}")


def _rounded_angle(radians: float, snap: bool) -> float:
    """Round an angle to a tenth of a degree; with `snap`, to 5°."""
    step = SNAP_ANGLE if snap else math.radians(0.1)
    return round(radians / step) * step


# Handles of parameters that several kinds have.


def ahead(name: str) -> Handle:
    """Return the handle of a distance along the view."""
    return Handle(name, lambda parameters: (0.0, 0.0, -getattr(parameters, name)))


def edge(name: str, aside: tuple[float, float], share: float, reach: str = "range_max") -> Handle:
    """Return the handle of an angle from edge to edge of the field of view.

    Its place is at half of the `reach`. The direction to it is turned from the axis of the view by
    `share` of the angle, towards `aside` (x, y).
    """

    def at(parameters: Any) -> Point:
        angle, away = share * getattr(parameters, name), getattr(parameters, reach) / 2.0
        x, y = (away * math.sin(angle) * part for part in aside)
        return x, y, -away * math.cos(angle)

    return Handle(name, at)
