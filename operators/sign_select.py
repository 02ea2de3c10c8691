# SPDX-License-Identifier: GPL-3.0-or-later
"""Select a sensor by a click on its sign, label or housing in a 3D view.

A sign is the symbol that the viewport draws for a sensor. Blender itself would select the object
behind the sign. The keymap items here come before Blender's, and after those of other add-ons. They
pass on every click that is not on a sensor.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Event, Operator
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d

from ..angen_addon.scene.instances import housed_by
from ..angen_addon.scene.sensors import Sensor, all_sensors, sensor_of
from ..angen_addon.view.overlay.hover import sensor_at
from .show import select, why_hidden

# Blender's keymaps in which a click selects an object, with button and event value. Select Box and
# most other tools leave a click to Object Mode. Tweak and the right button select on press.
KEYS = (
    ("Object Mode", "EMPTY", "LEFTMOUSE", "CLICK"),
    ("Object Mode", "EMPTY", "RIGHTMOUSE", "PRESS"),
    ("3D View Tool: Tweak", "VIEW_3D", "LEFTMOUSE", "PRESS"),
    ("3D View Tool: Tweak (fallback)", "VIEW_3D", "LEFTMOUSE", "PRESS"),
)
# The ray passes at most this many objects that the 3D view does not show.
MOST_HIDDEN = 20


class ANGEN_OT_sign_select(Operator):
    bl_idname = "angen.sign_select"
    bl_label = "Select Sensor"
    bl_description = "Select the sensor whose sign, label or housing is clicked"
    bl_options = {"UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        area = context.area
        return context.mode == "OBJECT" and area is not None and area.type == "VIEW_3D"

    def invoke(self, context: Context, event: Event) -> set[str]:
        # In a scene without sensors a click must not cost a search tree of all its triangles.
        if not _is_select_button(context, event) or not all_sensors(context.view_layer):
            return {"PASS_THROUGH"}
        place = event.mouse_region_x, event.mouse_region_y
        sensor = sensor_at(context, place) or sensor_of_housing_at(context, place)
        if sensor is None or why_hidden(sensor.handle, context):
            return {"PASS_THROUGH"}
        obj = sensor.handle
        if event.shift and obj.select_get() and obj == context.view_layer.objects.active:
            obj.select_set(False)
            return {"FINISHED"}
        if not _is_press(event):
            select(sensor, context, extend=event.shift)
            return {"FINISHED"}
        # Several sensors are selected: a drag moves all of them, a click selects only this one.
        self._sensor, self._alone = sensor, not event.shift
        self._begin, self._button = place, event.type
        select(sensor, context, extend=event.shift or obj.select_get())
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: Context, event: Event) -> set[str]:
        """Start to move the sensor if the user drags the mouse before releasing the button."""
        if event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE"}:
            x, y = event.mouse_region_x - self._begin[0], event.mouse_region_y - self._begin[1]
            far = context.preferences.inputs.drag_threshold_mouse
            if max(abs(x), abs(y)) < far * context.preferences.system.ui_scale:
                return {"RUNNING_MODAL"}
            bpy.ops.transform.translate("INVOKE_DEFAULT", release_confirm=True)
            return {"FINISHED"}
        if event.type not in {self._button, "ESC"}:
            return {"RUNNING_MODAL"}
        if self._alone:
            select(self._sensor, context)
        return {"FINISHED"}


def _is_press(event: Event) -> bool:
    return bool(event.value == "PRESS")


def _is_select_button(context: Context, event: Event) -> bool:
    """Return whether the active tool selects objects with the event's mouse button.

    The tool Tweak selects with the left button, whichever button the preferences set.
    """
    configuration = context.window_manager.keyconfigs.active
    chosen = getattr(configuration.preferences, "select_mouse", "LEFT")
    tweaks = event.type == "LEFTMOUSE" and _is_press(event)
    return tweaks or event.type == f"{chosen}MOUSE"


def sensor_of_housing_at(context: Context, place: tuple[float, float]) -> Sensor | None:
    """Return the sensor whose housing is visible at a point of the region, or None.

    `place` is the point in pixels.
    """
    space, view = context.space_data, context.region_data
    depsgraph = context.evaluated_depsgraph_get()
    way = region_2d_to_vector_3d(context.region, view, place)
    start = region_2d_to_origin_3d(context.region, view, place, clamp=space.clip_end)
    # Start at the near clipping plane: Blender draws nothing in front of it.
    start = start + way * (space.clip_start if view.is_perspective else 0.0)
    for _ in range(MOST_HIDDEN):
        hit, at, _normal, _face, obj, _matrix = context.scene.ray_cast(depsgraph, start, way)
        if not hit:
            return None
        if obj.original.visible_in_viewport_get(space):
            owner = housed_by(obj.original)
            return sensor_of(owner) if owner is not None else None
        start = at + way * space.clip_start
    return None


_keys: list[tuple[Any, Any]] = []
_register, _unregister = bpy.utils.register_classes_factory((ANGEN_OT_sign_select,))


def register() -> None:
    _register()
    # Blender without a window has no keymaps.
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:
        return
    for name, space, button, moment in KEYS:
        keymap = configuration.keymaps.new(name, space_type=space)
        for shift in (False, True):
            idname = ANGEN_OT_sign_select.bl_idname
            # Blender merges the items in reverse: the head of this list comes after other add-ons.
            item = keymap.keymap_items.new(idname, button, moment, shift=shift, head=True)
            _keys.append((keymap, item))


def unregister() -> None:
    while _keys:
        keymap, item = _keys.pop()
        keymap.keymap_items.remove(item)
    _unregister()
