# SPDX-License-Identifier: GPL-3.0-or-later
"""Add a sensor at the 3D cursor, and draw the menu of sensors (Shift+A, Sensor)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy.types import Context, Menu, Operator

from ..angen_addon.authoring.presets import find_preset, new_sensor
from ..angen_addon.scene.home.rooms import fill_room
from ..angen_addon.translations.interface import translated, translating
from ..sensor_logic.kind import Preset
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.logs.error import AngenError
from .polls import can_add, cancelled

KIND_ITEMS = [(k.identifier, k.label, k.tip, k.icon, k.number) for k in KINDS.values()]


def suggested_presets(self: Any, context: Context, text: str) -> list[tuple[str, str]]:
    """Return identifier and label of the presets that contain the text typed so far."""
    found = [(preset.identifier, preset.label) for preset in KINDS[self.kind].presets]
    return [pair for pair in found if text.lower() in " ".join(pair).lower()]


def preset_property() -> Any:
    return StringProperty(
        name="Preset",
        description="Identifier of a preset of this kind, which also sets the housing. Empty: the "
        "default parameters",
        search=suggested_presets,
        search_options={"SUGGESTION"},
    )


def preset_of(operator: Any) -> Preset | None:
    """Return the preset whose name the operator's property `preset` holds, or None if it is empty.

    Raise `AngenError` if the preset is unknown.
    """
    return find_preset(KINDS[operator.kind], operator.preset) if operator.preset else None


class ANGEN_OT_sensor_add(Operator):
    bl_idname = "angen.sensor_add"
    bl_label = "Add Sensor"
    bl_description = (
        "Add a sensor at the 3D cursor. It looks along its −Z axis with +Y up, as cameras do; "
        "a pressure sensor is a pad that lies there and senses what presses on its +Z side"
    )
    bl_options = {"REGISTER", "UNDO"}

    kind: EnumProperty(name="Kind", items=KIND_ITEMS)
    preset: preset_property()

    poll = classmethod(can_add)

    def execute(self, context: Context) -> set[str]:
        try:
            preset = preset_of(self)
        except AngenError as error:
            return cancelled(self, error)
        sensor = new_sensor(context, self.kind, preset)
        sensor.matrix_world = context.scene.cursor.matrix
        fill_room(context.evaluated_depsgraph_get(), sensor, context.scene.cursor.location)
        text = f"Added '{sensor.name}' at the 3D cursor"
        if preset is not None:
            text = f"Added '{sensor.name}' ({preset.label}) at the 3D cursor"
        self.report({"INFO"}, translated(text))
        return {"FINISHED"}


class ANGEN_MT_sensor_add(Menu):
    bl_idname = "ANGEN_MT_sensor_add"
    bl_label = "Sensor"

    def draw(self, context: Context) -> None:
        layout = self.layout
        _draw_kinds(layout, "angen.sensor_add", "{}")
        layout.separator()
        layout.operator_context = "INVOKE_REGION_WIN"
        _draw_kinds(layout, "angen.sensor_place", "{} on Surface")
        layout.separator()
        layout.operator("angen.door_fit", icon="SNAP_EDGE")
        layout.menu("ANGEN_MT_resident_add", icon="OUTLINER_OB_ARMATURE")


def _draw_kinds(layout: Any, operator: str, text: str) -> None:
    for kind in KINDS.values():
        item = layout.operator(operator, text=text.format(kind.label), icon=kind.icon)
        # The menu gives the preset of a real part; without one, scripts get the defaults.
        item.kind, item.preset = kind.identifier, kind.part


@translating
def draw_in_add_menu(self: Any, context: Context) -> None:
    self.layout.menu(ANGEN_MT_sensor_add.bl_idname, icon="OUTLINER_DATA_LIGHTPROBE")


_register, _unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_sensor_add, ANGEN_MT_sensor_add)
)


def register() -> None:
    _register()
    bpy.types.VIEW3D_MT_add.append(draw_in_add_menu)


def unregister() -> None:
    bpy.types.VIEW3D_MT_add.remove(draw_in_add_menu)
    _unregister()
