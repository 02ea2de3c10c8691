# SPDX-License-Identifier: GPL-3.0-or-later
"""Select a sensor, and move the 3D view so that it shows the sensor and what the sensor sees."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import bpy
import numpy as np
from bpy.props import BoolProperty, StringProperty
from bpy.types import Context, Event, Operator
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from ..angen_addon.scene.sensors import Sensor, all_sensors, unit_scale
from ..angen_addon.translations.interface import translated
from ..angen_addon.view.overlay import refresh
from .polls import cancelled, needs

# m: the least radius of the framed sphere.
MIN_RADIUS = 0.6
# The distance of the view, relative to that at which the sphere just fits.
MARGIN = 1.25
# Width of the sensor of Blender's viewport camera.
SENSOR_MM = 36.0


class ANGEN_OT_sensor_show(Operator):
    bl_idname = "angen.sensor_show"
    bl_label = "Show Sensor"
    bl_description = (
        "Select this sensor, and move the view to it and to what it sees. Shift-click: add it to "
        "the selection without moving the view"
    )
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the sensor's object")
    library: StringProperty(
        name="Library", description="File that a linked sensor comes from", options={"HIDDEN"}
    )
    extend: BoolProperty(
        name="Extend", description="Add it to the selection without moving the view", default=False
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(cls, context.mode == "OBJECT", "Switch to Object Mode to select a sensor")

    def invoke(self, context: Context, event: Event) -> set[str]:
        self.extend = event.shift
        return self.execute(context)

    def execute(self, context: Context) -> set[str]:
        sensor = self._find(context)
        if sensor is None:
            return cancelled(self, f"No sensor of this view layer is called '{self.name}'")
        obj = sensor.handle
        hidden = why_hidden(obj, context)
        if hidden:
            self.report({"WARNING"}, translated(f"'{obj.name}': {hidden}"))
            return {"CANCELLED"}
        show(sensor, context, self.extend)
        return {"FINISHED"}

    def _find(self, context: Context) -> Sensor | None:
        sensors = all_sensors(context.view_layer)
        named = [sensor for sensor in sensors if sensor.name == self.name]
        exact = [sensor for sensor in named if sensor.library == self.library]
        return next(iter(exact or named), None)


def show(sensor: Sensor, context: Context, extend: bool = False, stay: bool = False) -> None:
    """Select a sensor and no other object, and move the 3D view to it.

    The sensor must not be hidden. If `extend` is True, add the sensor to the selection, and leave
    the view as it is. If `stay` is True, move the view only if it does not show the sensor.
    """
    select(sensor, context, extend)
    obj = sensor.handle
    if extend or context.area is None or context.area.type != "VIEW_3D":
        return
    if not (stay and is_in_view(obj, context)):
        middle, radius = surroundings(sensor, context)
        frame_sphere(context, middle, radius)


def select(sensor: Sensor, context: Context, extend: bool = False) -> None:
    """Make a sensor active, and select it and no other object. The sensor must not be hidden.

    If `extend` is True, the other objects stay selected.
    """
    obj = sensor.handle
    if not extend:
        for selected in context.selected_objects:
            selected.select_set(False)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    if sensor.holders:
        context.window_manager.angen_instanced = sensor.name


def why_hidden(obj: Any, context: Context) -> str:
    """Return why the user cannot select an object, and how to change that; empty if they can."""
    if obj.hide_select:
        return "it cannot be selected: tick Selectable in its Object tab, Visibility"
    if not obj.visible_get(view_layer=context.view_layer):
        return "it is hidden: show it, or its collection, in the Outliner (eye or monitor icon)"
    return ""


def surroundings(sensor: Sensor, context: Context) -> tuple[Vector, float]:
    """Return centre and radius (Blender units) of a sphere that encloses what a sensor sees.

    That is what the viewport draws of the sensor. If it draws nothing, it is the sensor's range.
    """
    metres = unit_scale(context.scene)
    matrix = sensor.world_matrix(context.evaluated_depsgraph_get())
    drawn = refresh.overlay.seen if refresh.overlay is not None else ()
    seen = next((seen for seen in drawn if seen.uid == sensor.uid), None)
    if seen is not None and seen.rays is not None:
        lines = [part for figure in seen.figures for part in figure.lines.values()]
        points = np.concatenate(
            [np.array([matrix.translation]), *(p.reshape(-1, 3) for p in lines)]
        )
        if len(points) > 1:
            lo, hi = points.min(axis=0), points.max(axis=0)
            radius = max(float(np.linalg.norm(hi - lo)) / 2, MIN_RADIUS / metres)
            return Vector((lo + hi) / 2), radius
    ahead = -Vector(matrix.col[2][:3]).normalized()
    parameters = getattr(sensor.settings, sensor.kind.attribute)
    reach = float(getattr(parameters, "range_max", 0.0)) / metres
    radius = max(reach / 2, MIN_RADIUS / metres)
    return matrix.translation + ahead * (reach / 2), radius


class FreeRegion(NamedTuple):
    """The main region of a 3D view, and the left and right edge (pixels) of its uncovered part."""

    region: Any
    left: int
    right: int


def free_region(area: Any) -> FreeRegion:
    """Return the main region of an area, and the edges of its part that no other region covers."""
    window = next(region for region in area.regions if region.type == "WINDOW")
    left, right = 0, window.width
    for region in area.regions:
        if region.type in {"TOOLS", "UI"} and region.width > 1:
            start = region.x - window.x
            if region.type == "TOOLS" and 0 <= start < window.width:
                left = max(left, start + region.width)
            elif region.type == "UI" and 0 < start < window.width:
                right = min(right, start)
    return FreeRegion(window, left, right) if left < right else FreeRegion(window, 0, window.width)


def is_in_view(obj: Any, context: Context) -> bool:
    """Return whether an object's origin is in the uncovered part of the 3D view."""
    window, left, right = free_region(context.area)
    view = context.space_data.region_3d
    at = location_3d_to_region_2d(window, view, obj.matrix_world.translation)
    return at is not None and left < at.x < right and 0 < at.y < window.height


def frame_sphere(context: Context, middle: Vector, radius: float) -> None:
    """Pan and zoom until a sphere is in the view's uncovered part, as View Selected does."""
    space = context.space_data
    region = context.region_data or space.region_3d
    if region.view_perspective == "CAMERA":
        region.view_perspective = "PERSP"
    window, left, right = free_region(context.area)
    # Tangent of half the angle of view along the longer side; then how much of it nothing covers.
    longer = SENSOR_MM / space.lens
    share = min(right - left, window.height) / max(window.width, window.height)
    region.view_distance = MARGIN * radius / math.sin(math.atan(longer * share))
    pixel = 2 * longer * region.view_distance / max(window.width, window.height)
    aside = ((left + right) - window.width) / 2
    region.view_location = middle - region.view_rotation @ Vector((aside * pixel, 0.0, 0.0))


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_sensor_show,))
