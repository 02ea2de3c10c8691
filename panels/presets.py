# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of presets in the header of a sensor's panel."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Menu

from ..operators.preset import ANGEN_OT_preset_apply, is_applied
from ..sensor_logic.presets import presets_of
from .parameters import sensor_of


class ANGEN_MT_presets(Menu):
    bl_idname = "ANGEN_MT_presets"
    bl_label = "Presets"
    bl_description = "Known parts and settings; the one that the parameters agree with is ticked"

    def draw(self, context: Context) -> None:
        sensor = sensor_of(context.object)
        for preset in presets_of(sensor.kind.identifier) if sensor else ():
            applied = is_applied(context.object, preset)
            item = self.layout.operator(
                ANGEN_OT_preset_apply.bl_idname,
                text=preset.label,
                icon="CHECKMARK" if applied else "BLANK1",
                translate=False,
            )
            item.preset = preset.identifier


def draw_presets(layout: Any, context: Context) -> None:
    """The menu's button, where the active sensor's kind has presets."""
    sensor = sensor_of(context.object)
    if sensor is not None and presets_of(sensor.kind.identifier):
        layout.menu(ANGEN_MT_presets.bl_idname, text="", icon="PRESET")


register, unregister = bpy.utils.register_classes_factory((ANGEN_MT_presets,))
