# SPDX-License-Identifier: GPL-3.0-or-later
"""Replace an instance of a linked collection by library overrides of its objects.

The sensors in it can then have their own settings, keyframes and drivers.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Operator
from mathutils import Matrix

from ..angen_addon.scene.instances import is_sensor
from ..angen_addon.translations.interface import translated
from ..angen_addon.view.active import active_sensor
from .polls import cancelled, needs


def why_not(sensor: Any) -> str:
    """Return why the instance that contains a sensor cannot be overridden; empty if it can be."""
    if sensor is None or not sensor.holders:
        return "Select a collection instance with sensors in it"
    holder = sensor.handle
    if not holder.is_editable:
        return "The instance itself is linked: make it local first"
    if holder.instance_collection.library is None:
        return "Its collection is in this file: edit the collection itself"
    return ""


class ANGEN_OT_instance_override(Operator):
    bl_idname = "angen.instance_override"
    bl_label = "Override Linked Home"
    bl_description = (
        "Replace this instance of a linked collection by library overrides, which can be "
        "edited and move with the instance"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        reason = why_not(active_sensor(context))
        return needs(cls, not reason, reason)

    def execute(self, context: Context) -> set[str]:
        sensor = active_sensor(context)
        assert sensor is not None
        holder = sensor.handle
        made = holder.instance_collection.override_hierarchy_create(
            context.scene, context.view_layer, reference=holder, do_fully_editable=True
        )
        if made is None:
            return cancelled(self, f"Blender could not override the collection of '{holder.name}'")
        holder.instance_type = "NONE"
        # Overrides are placed as in the library: parenting moves them to where the instance was.
        for obj in made.all_objects:
            if obj.parent is None:
                obj.parent = holder
                obj.matrix_parent_inverse = Matrix.Translation(-made.instance_offset)
        sensors = [obj for obj in made.all_objects if is_sensor(obj)]
        if sensors:
            context.view_layer.objects.active = sensors[0]
        names = ", ".join(obj.name for obj in sensors)
        self.report(
            {"INFO"}, translated(f"'{holder.name}' is overridden, with the sensors {names}")[:200]
        )
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_instance_override,))
