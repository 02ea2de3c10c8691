# SPDX-License-Identifier: GPL-3.0-or-later
"""The description of sensors as plain data, which `angen list --json` prints."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from typing import Any

import bpy

from ...sensor_logic.layout.entries import EMPTY_KEYS, MARKS
from ...sensor_logic.parameters import specs
from ..runtime.time_base import evaluated_depsgraph
from ..scene.instances import is_holder, is_sensor
from ..scene.sensors import Sensor, decimal
from . import measured


def describe(sensor: Sensor) -> dict[str, Any]:
    """Return a sensor as an entry of a layout, from which `angen apply` makes the same sensor.

    Lengths are in metres and angles in radians. The entry has

    - the name, kind, room, pose, parent and collection of the sensor,
    - its main reading and the units of its published fields,
    - all its parameters, and the empties and texts that they name, if there are any.
    """
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
        **place_of(sensor),
        "parameters": parameters_of(sensor),
        **_belongings(sensor),
    }


def place_of(sensor: Sensor) -> dict[str, Any]:
    """Return the pose, bounds, parent and collection of a sensor."""
    depsgraph, obj = evaluated_depsgraph(), sensor.object
    location, rotation = measured.place(sensor, depsgraph)
    return {
        "location": location,
        "rotation": rotation,
        "bounds": measured.bounds(sensor, depsgraph),
        "parent": obj.parent.name if obj.parent else None,
        "collection": _collection(obj, depsgraph.scene),
    }


def _belongings(sensor: Sensor) -> dict[str, Any]:
    """Return the empties and texts that a sensor's parameters name, for the keys of a layout."""
    empties, texts = {}, {}
    for block in named_blocks(sensor):
        if isinstance(block, bpy.types.Text):
            texts[block.name] = block.as_string().splitlines()
        else:
            place = place_of(Sensor(block.name, sensor.kind, block))
            empties[block.name] = {key: place[key] for key in EMPTY_KEYS if key in place}
    found = {"empties": empties, "texts": texts}
    return {key: blocks for key, blocks in found.items() if blocks}


def named_blocks(sensor: Sensor) -> list[Any]:
    """Return the texts and plain empties of this file that a sensor's parameters name."""
    group = sensor.parameters
    pointers = [name for name, spec in specs(sensor.kind.parameters).items() if spec.pointer]
    blocks = [block for name in pointers if (block := getattr(group, name)) is not None]
    return [block for block in blocks if not block.library and is_belonging(block)]


def is_belonging(block: Any) -> bool:
    """Return whether a data-block can be described in a layout: a text, or an empty."""
    if isinstance(block, bpy.types.Object):
        return block.type == "EMPTY" and not is_sensor(block) and not is_holder(block)
    return isinstance(block, bpy.types.Text)


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


def layout_text(sensors: Iterable[Sensor], marks: dict[str, Any] | None = None) -> str:
    """Return sensors, and the marks of objects if there are any, as a layout file, in JSON."""
    found: Any = [describe(sensor) for sensor in sensors]
    if marks:
        found = {"sensors": found, MARKS: marks}
    return json.dumps(found, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
