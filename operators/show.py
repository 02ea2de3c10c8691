# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects a sensor and shows it, with what it sees, in the 3D view."""

from __future__ import annotations

import math
from typing import Any

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy.types import Context, Event, Operator
from mathutils import Vector

from ..angen_addon.sensors import Sensor, all_sensors, unit_scale

# m: the least radius of what is shown around a sensor, so that one sees where it is.
LEAST_RADIUS = 0.6
# Of the view's width, and of its distance, beyond what just fits.
MARGIN = 1.25
SENSOR_MM = 36.0


class ANGEN_OT_sensor_show(Operator):
    bl_idname = "angen.sensor_show"
    bl_label = "Show Sensor"
    bl_description = (
        "Select this sensor and move the view to it and to what it sees. "
        "Shift: add it to the selection and leave the view"
    )
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the sensor's object")
    library: StringProperty(
        name="Library", description="File that a linked sensor comes from", options={"HIDDEN"}
    )
    extend: BoolProperty(
        name="Extend", description="Add it to the selection and leave the view", default=False
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if context.mode != "OBJECT":
            cls.poll_message_set("Switch to Object Mode to select a sensor")
            return False
        return True

    def invoke(self, context: Context, event: Event) -> set[str]:
        self.extend = event.shift
        return self.execute(context)

    def execute(self, context: Context) -> set[str]:
        sensor = self._find(context)
        if sensor is None:
            self.report({"ERROR"}, f"No sensor of this view layer is called '{self.name}'")
            return {"CANCELLED"}
        obj = sensor.object
        hidden = why_hidden(obj, context)
        if hidden:
            self.report({"WARNING"}, f"'{obj.name}' {hidden}")
            return {"CANCELLED"}
        show(sensor, context, self.extend)
        return {"FINISHED"}

    def _find(self, context: Context) -> Sensor | None:
        sensors = all_sensors(context.view_layer)
        named = [sensor for sensor in sensors if sensor.name == self.name]
        exact = [sensor for sensor in named if sensor.library == self.library]
        return next(iter(exact or named), None)


def show(sensor: Sensor, context: Context, extend: bool = False) -> None:
    """Selects a sensor that is not hidden, alone, and moves the view to it; or adds it to the
    selection."""
    obj = sensor.object
    if not extend:
        for selected in context.selected_objects:
            selected.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    if not extend and context.area is not None and context.area.type == "VIEW_3D":
        middle, radius = surroundings(sensor, context)
        frame(context, middle, radius)


def why_hidden(obj: Any, context: Context) -> str:
    """Why it cannot be selected, with the way out; empty where it can."""
    if obj.hide_select:
        return "cannot be selected: tick Selectable in its Object tab, Visibility"
    if not obj.visible_get(view_layer=context.view_layer):
        return "is hidden: show it, or its collection, in the Outliner (eye or monitor icon)"
    return ""


def surroundings(sensor: Sensor, context: Context) -> tuple[Vector, float]:
    """Middle and radius, in Blender units, of what a sensor sees at most."""
    metres = unit_scale(context.scene)
    matrix = sensor.object.matrix_world
    ahead = -Vector(matrix.col[2][:3]).normalized()
    parameters = getattr(sensor.settings, sensor.kind.attribute)
    reach = float(getattr(parameters, "range_max", 0.0)) / metres
    radius = max(reach / 2, LEAST_RADIUS / metres)
    return matrix.translation + ahead * (reach / 2), radius


def frame(context: Context, middle: Vector, radius: float) -> None:
    """Moves the view, as View Selected does, without turning it."""
    space = context.space_data
    region = context.region_data or space.region_3d
    if region.view_perspective == "CAMERA":
        region.view_perspective = "PERSP"
    region.view_location = middle
    half = math.atan(SENSOR_MM / space.lens)
    region.view_distance = MARGIN * radius / math.sin(half)


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_sensor_show,))
