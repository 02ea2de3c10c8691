# SPDX-License-Identifier: GPL-3.0-or-later
"""The handles of the kinds of sensors: the position of each, and the parameter that it changes.

Each kind lists its handles in its `Appearance`. `gizmos.py` draws them and responds to the mouse.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.logs.wording import Lengths
from ...sensor_logic.model import Array
from ...sensor_logic.parameters import Spec, format_quantity, is_chosen, label_of, specs
from ..scene.sensors import Sensor, unit_scale

# Least value (m, rad) of a dragged parameter that must be above 0.
LEAST = 0.001
# rad. Angles snap to multiples of this.
SNAP_ANGLE = math.radians(5)

Point = Sequence[float]


class _Override:
    """The parameters of a sensor with another value for one of them."""

    def __init__(self, parameters: Any, name: str, value: float) -> None:
        self._parameters, self._name, self._value = parameters, name, value

    def __getattr__(self, name: str) -> Any:
        return self._value if name == self._name else getattr(self._parameters, name)


@dataclass(frozen=True)
class Handle:
    """The handle that changes one parameter of a sensor.

    `parameter` is the name of the parameter. The function `at` gets all parameters, and returns the
    position (3,) of the handle in m, in the sensor's axes.
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
        """Return the position (3,) of the handle if the parameter has this value.

        The position is in m, in the sensor's axes.
        """
        return np.array(self.at(_Override(sensor.parameters, self.parameter, value)), np.float64)

    def set(self, sensor: Sensor, value: float, snap: bool = False) -> None:
        """Set the parameter to a rounded value within its limits; `snap` rounds more coarsely."""
        low, high = self.limits(sensor)
        is_angle = self._spec(sensor).unit == "rad"
        rounded = _rounded_angle(value, snap) if is_angle else _rounded_length(value, snap)
        self.put(sensor, min(max(rounded, low), high))

    def put(self, sensor: Sensor, value: float) -> None:
        """Set the parameter to exactly this value."""
        setattr(sensor.parameters, self.parameter, value)


@dataclass(frozen=True)
class SizeHandle:
    """A handle that scales a sensor. It lies in the middle of an edge of the body's upper side.

    Its value is the distance in m from the origin to this edge, along `axis` (0 for X, 1 for Y).
    """

    axis: int

    def _edge(self, sensor: Sensor) -> Array:
        """Return the middle (3,) of the edge in the object's axes, in Blender units."""
        corners = np.array(sensor.object.bound_box, np.float64)
        low, high = corners.min(axis=0), corners.max(axis=0)
        edge: Array = (low + high) / 2.0
        edge[self.axis], edge[2] = high[self.axis], high[2]
        return edge

    def _scale(self, sensor: Sensor) -> Array:
        """Return the length (3,) in m of one unit along each of the object's axes."""
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
        """Return the size of the body from edge to edge, with its unit."""
        across = float(np.ptp(np.array(sensor.object.bound_box, np.float64)[:, self.axis]))
        return format_quantity(across * self._scale(sensor)[self.axis], "m", lengths)

    def value(self, sensor: Sensor) -> float:
        """Return the distance of the edge from the origin, in m."""
        return float((self._edge(sensor) * self._scale(sensor))[self.axis])

    def limits(self, sensor: Sensor) -> tuple[float, float]:
        """Return the least and the greatest value."""
        return LEAST, math.inf

    def point(self, sensor: Sensor, value: float) -> Array:
        """Return the position (3,) of the handle if the edge is at this distance from the origin.

        The position is in m, in the sensor's axes.
        """
        point: Array = self._edge(sensor) * self._scale(sensor)
        point[self.axis] = value
        return point

    def set(self, sensor: Sensor, value: float, snap: bool = False) -> None:
        """Set the distance to a rounded value; round more coarsely if `snap` is True."""
        self.put(sensor, max(_rounded_length(value, snap), LEAST))

    def put(self, sensor: Sensor, value: float) -> None:
        """Set the distance to exactly this value."""
        sensor.object.scale[self.axis] *= value / self.value(sensor)
        # Evaluate the world matrix: the value of this handle is computed from it.
        bpy.context.view_layer.update()


def _rounded_length(metres: float, snap: bool) -> float:
    """Round a length to 4 digits, or if `snap` is True, to a step (0.1 m between 1 m and 10 m)."""
    if not snap or metres <= 0.0:
        return float(f"{metres:.4g}")
    step = 10.0 ** math.floor(math.log10(metres)) / 10.0
    return float(f"{round(metres / step) * step:.4g}")


def _rounded_angle(radians: float, snap: bool) -> float:
    """Round an angle to a tenth of a degree, or to 5° if `snap` is True."""
    step = SNAP_ANGLE if snap else math.radians(0.1)
    return round(radians / step) * step


# Handles of parameters that several kinds have.


def ahead(name: str) -> Handle:
    """Return a handle on the view axis, at the distance that the parameter `name` gives."""
    return Handle(name, lambda parameters: (0.0, 0.0, -getattr(parameters, name)))


def edge(name: str, aside: tuple[float, float], share: float, reach: str = "range_max") -> Handle:
    """Return the handle of an angle from edge to edge of the field of view.

    Parameters
    ----------
    name
        The parameter with the angle.
    aside
        The direction (x, y) from the view axis to the handle.
    share
        The angle between the view axis and the handle, as a fraction of the parameter.
    reach
        The parameter with the range. The handle is at half of this range.
    """

    def at(parameters: Any) -> Point:
        angle, away = share * getattr(parameters, name), getattr(parameters, reach) / 2.0
        x, y = (away * math.sin(angle) * part for part in aside)
        return x, y, -away * math.cos(angle)

    return Handle(name, at)
