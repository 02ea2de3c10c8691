# SPDX-License-Identifier: GPL-3.0-or-later
"""Which sensor the user works on: the active object, or one of those that it instances."""

from __future__ import annotations

from typing import Any

from bpy.props import StringProperty
from bpy.types import WindowManager

from ..scene.instances import SensorFinder, is_holder, is_sensor, stands_for
from ..scene.sensors import Sensor, sensor_of


def active_sensor(context: Any) -> Sensor | None:
    """The active object, or the one that it houses, as a sensor; of a collection instance the
    sensor in it that was shown last, else its first."""
    obj = stands_for(context.view_layer.objects.active)
    if obj is None:
        return None
    if is_sensor(obj):
        return sensor_of(obj)
    if not is_holder(obj):
        return None
    inside = [sensor_of(*place) for place in SensorFinder().sensors_in(obj)]
    inside.sort(key=lambda sensor: sensor.name)
    chosen = context.window_manager.angen_instanced
    return next((s for s in inside if s.name == chosen), inside[0] if inside else None)


def register() -> None:
    WindowManager.angen_instanced = StringProperty(
        name="Sensor in an Instance", description="The sensor of a collection instance shown last"
    )


def unregister() -> None:
    del WindowManager.angen_instanced
