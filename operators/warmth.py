# SPDX-License-Identifier: GPL-3.0-or-later
"""Set typical temperatures of objects, and write a detector's lens as a text."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ..angen_addon.advice.warmth import USUAL, warm
from ..angen_addon.scene.instances import stands_for
from ..angen_addon.translations.interface import translated
from ..sensor_logic.kinds.pir.lenses import LENSES, write_table
from .polls import can_change_sensor, cancelled, needs

ITEMS = [(u.identifier, u.label, u.tip) for u in USUAL.values()]


class ANGEN_OT_warmth_set(Operator):
    bl_idname = "angen.warmth_set"
    bl_label = "Set Usual Temperature"
    bl_description = "Give the selected objects and their children a usual temperature"
    bl_options = {"REGISTER", "UNDO"}

    sort: EnumProperty(name="Type", items=ITEMS)

    @classmethod
    def description(cls, context: Context, properties: Any) -> str:
        tip = translated(USUAL[properties.sort].tip)
        return f"{translated(cls.bl_description)}.\n{tip}"

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(
            cls, context.selected_objects or context.object is not None, "Select the warm objects"
        )

    def execute(self, context: Context) -> set[str]:
        chosen = context.selected_objects or [context.object]
        usual = USUAL[self.sort]
        surfaces, parts = [], []
        for obj in chosen:
            some, found = warm(obj, usual, context.view_layer)
            surfaces += [surface for surface in some if surface not in surfaces]
            parts += [material for material in found if material not in parts]
        if not surfaces:
            return cancelled(
                self,
                "None of the selected objects has a surface that can get a temperature: "
                "select meshes that are not linked",
            )
        names = ", ".join(sorted(f"'{surface.name}'" for surface in surfaces)[:4])
        names += " …" if len(surfaces) > 4 else ""
        text = f"{usual.celsius:g} °C: {names}"
        if usual.insulation:
            text = f"{usual.celsius:g} °C under {usual.insulation:g} clo: {names}"
        if usual.identifier == "PERSON":
            others = ", ".join(
                sorted(f"'{m.name}' {m.angen_warmth.insulation:.1f} clo" for m in parts)
            )
            text += (
                f". {others}"
                if others
                else ". No material has a name like skin: if one is bare skin, set its "
                "temperature in the Material tab"
            )
        self.report({"INFO"}, translated(text))
        return {"FINISHED"}


class ANGEN_OT_lens_table(Operator):
    bl_idname = "angen.lens_table"
    bl_label = "Lens as Text"
    bl_description = (
        "Write the zones of the active detector's lens into a text for the Text Editor, and let "
        "the detector use it"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = stands_for(context.object)
        return needs(
            cls, obj is not None and obj.angen_sensor.kind == "PIR", "Select a motion detector"
        ) and can_change_sensor(cls, context)

    def execute(self, context: Context) -> set[str]:
        obj = stands_for(context.object)
        pir = obj.angen_sensor.pir
        text = bpy.data.texts.new(f"Lens of {obj.name}")
        text.write(write_table(LENSES[pir.lens].zones))
        pir.lens_table = text
        self.report(
            {"INFO"},
            translated(f"The lens is in the text '{text.name}': degrees, a row for each zone"),
        )
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_warmth_set, ANGEN_OT_lens_table)
)
