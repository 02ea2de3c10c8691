# SPDX-License-Identifier: GPL-3.0-or-later
"""The description of sensors as plain data, which `angen list --json` prints."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any

from ...sensor_logic.parameters import specs
from ..runtime.time_base import evaluated_depsgraph
from ..scene.sensors import Sensor, decimal
from . import measured


def describe(sensor: Sensor) -> dict[str, Any]:
    """Return a sensor as an entry of a layout, from which `angen apply` makes the same sensor.

    Lengths are in metres and angles in radians. The entry has

    - the name, kind, room, pose, parent and collection of the sensor,
    - its main reading and the units of its published fields,
    - all its parameters.
    """
    depsgraph = evaluated_depsgraph()
    obj = sensor.object
    location, rotation = measured.place(sensor, depsgraph)
    return {
        "name": sensor.name,
        "kind": sensor.kind.identifier,
        "room": sensor.room,
        "library": sensor.library,
        "enabled": sensor.settings.enabled,
        "simulated": True,  # True for every kind; programs may rely on the entry.
        "update_rate": decimal(sensor.settings.update_rate),
        "reading": {"field": sensor.reading.name, "unit": sensor.reading.unit},
        "units": {field.name: field.unit for field in sensor.kind.events},
        "location": location,
        "rotation": rotation,
        "bounds": measured.bounds(sensor, depsgraph),
        "parent": obj.parent.name if obj.parent else None,
        "collection": _collection(obj, depsgraph.scene),
        "parameters": parameters_of(sensor),
    }


def _collection(obj: Any, scene: Any) -> str | None:
    """Return the name of the collection that an object is in; None for the root collection."""
    names = [c.name for c in obj.users_collection if c != scene.collection]
    return names[0] if names else None


def parameters_of(sensor: Sensor) -> dict[str, Any]:
    """Return all parameters of the sensor's kind, by name."""
    group = sensor.parameters
    return {
        name: _plain(getattr(group, name), spec.unit)
        for name, spec in specs(sensor.kind.parameters).items()
    }


def _plain(value: Any, unit: str) -> Any:
    if isinstance(value, float):
        # JSON has no NaN and no infinity. Angles keep every bit, other numbers are as typed.
        if not math.isfinite(value):
            return None
        return measured.shortest(value) if unit == "rad" else decimal(value)
    if value is None or isinstance(value, (bool, int, str)):
        return value
    return value.name


def layout_text(sensors: Iterable[Sensor]) -> str:
    """Return sensors as a layout file, in JSON."""
    found = [describe(sensor) for sensor in sensors]
    return json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
