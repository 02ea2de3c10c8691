# SPDX-License-Identifier: GPL-3.0-or-later
"""Menu of presets in the header of a sensor's panel: commercial parts, and the user's presets."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Menu

from ..angen_addon.authoring.presets import preset_of, preset_text
from ..angen_addon.scene.instances import stands_for
from ..operators.preset import ANGEN_OT_preset_apply
from ..operators.user_preset import (
    ANGEN_OT_user_preset_apply,
    ANGEN_OT_user_preset_save,
    label_of,
    user_presets,
)
from .parameters import sensor_of


class ANGEN_MT_presets(Menu):
    bl_idname = "ANGEN_MT_presets"
    bl_label = "Presets"
    bl_description = "Products and usual settings. A tick marks the one with the present parameters"

    def draw(self, context: Context) -> None:
        sensor = sensor_of(stands_for(context.object))
        if sensor is None:
            return
        chosen, is_edited = preset_of(sensor.object)
        for preset in sensor.kind.presets:
            text = preset.label
            if is_edited and preset is chosen:
                text = f"{preset.label} (edited)"
            ticked = preset is chosen and not is_edited
            item = self.layout.operator(
                ANGEN_OT_preset_apply.bl_idname,
                text=text,
                icon="CHECKMARK" if ticked else "BLANK1",
            )
            item.preset = preset.identifier
        self.layout.separator()
        _draw_user_presets(self.layout, sensor)


def _draw_user_presets(layout: Any, sensor: Any) -> None:
    for file in user_presets(sensor.kind):
        row = layout.row(align=True)
        item = row.operator(
            ANGEN_OT_user_preset_apply.bl_idname,
            text=label_of(file),
            icon="USER",
            translate=False,
        )
        item.name = label_of(file)
        item = row.operator(ANGEN_OT_user_preset_save.bl_idname, text="", icon="X")
        item.name, item.remove_name = label_of(file), True
    layout.operator_context = "INVOKE_DEFAULT"
    layout.operator(ANGEN_OT_user_preset_save.bl_idname, text="Save as Preset …", icon="ADD")


def draw_choice(layout: Any, sensor: Any) -> None:
    """Draw the button that opens the preset menu, with the current preset as its label."""
    text = preset_text(sensor.object) or "Presets"
    layout.menu(ANGEN_MT_presets.bl_idname, text=text, icon="PRESET")


def draw_presets(layout: Any, context: Context) -> None:
    """Draw the button that opens the preset menu, if the active object is a sensor."""
    if sensor_of(stands_for(context.object)) is not None:
        layout.menu(ANGEN_MT_presets.bl_idname, text="", icon="PRESET")


register, unregister = bpy.utils.register_classes_factory((ANGEN_MT_presets,))
