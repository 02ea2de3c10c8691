# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor in plain data, for programs."""

from __future__ import annotations

from typing import Any

from ..sensor_logic.parameters import specs
from .sensors import Sensor, decimal


def describe(sensor: Sensor) -> dict[str, Any]:
    """Name, kind, room, place (Blender units) and all parameters (SI units, radians)."""
    group = getattr(sensor.settings, sensor.kind.attribute)
    return {
        "name": sensor.name,
        "kind": sensor.kind.identifier,
        "room": sensor.room,
        "library": sensor.library,
        "enabled": sensor.settings.enabled,
        "simulated": sensor.kind.model is not None,
        "update_rate": decimal(sensor.settings.update_rate),
        "location": [decimal(c) for c in sensor.object.matrix_world.translation],
        "parameters": {
            name: _plain(getattr(group, name)) for name in specs(sensor.kind.parameters)
        },
    }


def _plain(value: Any) -> Any:
    if isinstance(value, float):
        return decimal(value)
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return value.name
