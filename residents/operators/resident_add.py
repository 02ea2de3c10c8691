# SPDX-License-Identifier: GPL-3.0-or-later
"""Add a person or a cat that lives in the home (Shift+A, Sensor, Resident)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty
from bpy.types import Context, Menu, Operator

from ...angen_addon.translations.interface import translated
from ...operators.polls import can_add, needs
from ..blender.settings import SORT_ITEMS, add_resident, add_walking_frame, is_resident, stand_up
from ..body.skeleton import Sort


class ANGEN_OT_resident_add(Operator):
    bl_idname = "angen.resident_add"
    bl_label = "Add Resident"
    bl_description = (
        "Add a person or a cat that stands at the 3D cursor: a skinned body that all sensors "
        "notice. A routine says what it does all day"
    )
    bl_options = {"REGISTER", "UNDO"}

    sort: EnumProperty(name="Type", items=SORT_ITEMS)
    walking_frame: BoolProperty(
        name="Walking Frame", description="Give a person a walking frame to push", default=False
    )

    poll = classmethod(can_add)

    def execute(self, context: Context) -> set[str]:
        sort, cursor = Sort(self.sort), context.scene.cursor
        with_frame = self.walking_frame and sort is not Sort.CAT
        yaw = cursor.matrix.to_euler().z
        rig = add_resident(context, sort, cursor.location, yaw, with_frame)
        self.report({"INFO"}, translated(f"Added '{rig.name}' at the 3D cursor"))
        return {"FINISHED"}


class ANGEN_OT_walking_frame_add(Operator):
    bl_idname = "angen.walking_frame_add"
    bl_label = "Add Walking Frame"
    bl_description = "Give the active resident a walking frame to push"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = context.object
        return (
            needs(
                cls,
                is_resident(obj) and obj.angen_resident.sort != Sort.CAT.value,
                "Select a resident that walks on two legs",
            )
            and context.mode == "OBJECT"
        )

    def execute(self, context: Context) -> set[str]:
        frame = add_walking_frame(context.object)
        stand_up(context.object)
        self.report({"INFO"}, translated(f"Added '{frame.name}'"))
        return {"FINISHED"}


class ANGEN_MT_resident_add(Menu):
    bl_idname = "ANGEN_MT_resident_add"
    bl_label = "Resident"

    def draw(self, context: Context) -> None:
        draw_residents(self.layout)


def draw_residents(layout: Any) -> None:
    for identifier, label, _tip, _number in SORT_ITEMS:
        item = layout.operator("angen.resident_add", text=label)
        item.sort, item.walking_frame = identifier, False
        if identifier == Sort.OLDER_ADULT.value:
            item = layout.operator("angen.resident_add", text=f"{label} with Walking Frame")
            item.sort, item.walking_frame = identifier, True


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_resident_add, ANGEN_OT_walking_frame_add, ANGEN_MT_resident_add)
)
