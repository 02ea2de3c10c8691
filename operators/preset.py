# SPDX-License-Identifier: GPL-3.0-or-later
"""Set the parameters of a sensor to those of a preset."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Operator

from ..angen_addon.authoring.presets import apply, find_preset
from ..angen_addon.scene.instances import is_sensor, stands_for
from ..angen_addon.translations.interface import translated
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.logs.error import AngenError
from .polls import can_change_sensor, cancelled


class ANGEN_OT_preset_apply(Operator):
    bl_idname = "angen.preset_apply"
    bl_label = "Apply Preset"
    bl_description = (
        "Set the parameters of the active sensor to those of a product or a usual setting"
    )
    bl_options = {"REGISTER", "UNDO"}

    preset: StringProperty(name="Preset", description="Identifier of a preset of the kind")

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        """Return the tooltip of a menu item, with the source of its preset."""
        obj = stands_for(context.object)
        if is_sensor(obj):
            for preset in KINDS[obj.angen_sensor.kind].presets:
                if preset.identifier == properties.preset:
                    source = f"{translated('Source')}: {preset.source}"
                    return f"{translated(cls.bl_description)}.\n{source}"
        return translated(cls.bl_description)

    poll = classmethod(can_change_sensor)

    def execute(self, context: Context) -> set[str]:
        obj = stands_for(context.object)
        try:
            preset = find_preset(KINDS[obj.angen_sensor.kind], self.preset)
        except AngenError as error:
            return cancelled(self, error)
        apply(obj, preset)
        self.report({"INFO"}, translated(f"'{obj.name}' is set to: {preset.label}"))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_preset_apply,))
