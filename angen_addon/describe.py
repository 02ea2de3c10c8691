# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor in plain data, for programs."""

from __future__ import annotations

import math
from typing import Any

from ..sensor_logic.parameters import specs
from .sensors import Sensor, decimal, unit_scale
from .station import evaluated_depsgraph


def describe(sensor: Sensor) -> dict[str, Any]:
    """Name, kind, room, what its main reading is and the units of what it publishes, place
    (metres), and all parameters (SI units, radians)."""
    depsgraph = evaluated_depsgraph()
    metres = unit_scale(depsgraph.scene)
    place = sensor.world_matrix(depsgraph)
    return {
        "name": sensor.name,
        "kind": sensor.kind.identifier,
        "room": sensor.room,
        "library": sensor.library,
        "enabled": sensor.settings.enabled,
        "simulated": True,  # Every kind is, but programs may read it.
        "update_rate": decimal(sensor.settings.update_rate),
        "reading": {"field": sensor.reading.name, "unit": sensor.reading.unit},
        "units": {field.name: field.unit for field in sensor.kind.events},
        "location": [_finite(c * metres) for c in place.translation],
        "parameters": parameters_of(sensor),
    }


def parameters_of(sensor: Sensor) -> dict[str, Any]:
    """All parameters of its kind, by name."""
    group = sensor.parameters
    return {name: _plain(getattr(group, name)) for name in specs(sensor.kind.parameters)}


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return _finite(value)
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return value.name


def _finite(value: float) -> float | None:
    """JSON knows no NaN and no infinity."""
    return decimal(value) if math.isfinite(value) else None
