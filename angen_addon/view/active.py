# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the sensor that panels and handles show: the active object, or one in an active instance."""

from __future__ import annotations

from typing import Any

from bpy.props import StringProperty
from bpy.types import WindowManager

from ..scene.instances import SensorFinder, is_holder, is_sensor, stands_for
from ..scene.sensors import Sensor, sensor_of
from ..translations.dictionary import CONTEXT


def active_sensor(context: Any) -> Sensor | None:
    """Return the active sensor; None if the active object is not and has no sensor.

    For a housing, return the sensor that it belongs to. For a collection instance, return the
    sensor inside that was shown last, or else the first one by name.
    """
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
        translation_context=CONTEXT,
        name="Sensor in an Instance",
        description="The sensor of a collection instance shown last",
    )


def unregister() -> None:
    del WindowManager.angen_instanced
