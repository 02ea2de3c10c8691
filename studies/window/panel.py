# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel Study: writes a study file for `angen study run`, and opens its report (sidebar)."""

from __future__ import annotations

import bpy
from bpy.types import Context, Menu, Panel

from ...angen_addon.appearance.panel_parts import ClosedSidebar, draw_lines
from ...angen_addon.view.active import active_sensor
from ...sensor_logic.logs.wording import plural
from .. import study_file
from .operators import command, vary_of


class ANGEN_MT_study_vary(Menu):
    bl_idname = "ANGEN_MT_study_vary"
    bl_label = "Vary a Parameter"

    def draw(self, context: Context) -> None:
        sensor = active_sensor(context)
        if sensor is None:
            self.layout.label(text="Select a sensor")
            return
        for name in study_file.parameters(sensor.kind):
            label = study_file.label(sensor.kind, name)
            self.layout.operator("angen.study_vary", text=label).parameter = name


class ANGEN_PT_study(ClosedSidebar, Panel):
    bl_label = "Study"
    help_page = "studies"

    def draw(self, context: Context) -> None:
        layout, wanted = self.layout, context.window_manager.angen_study
        layout.operator_context = "INVOKE_DEFAULT"
        layout.menu("ANGEN_MT_study_vary", icon="ADD")
        runs = wanted.seeds
        for index, row in enumerate(wanted.varied):
            box = layout.box().column(align=True)
            head = box.row()
            head.label(text=row.label)
            head.operator("angen.study_leave", text="", icon="X", emboss=False).index = index
            box.label(text=row.sensors, translate=False)
            vary = vary_of(row)
            runs *= len(vary.choices) or row.steps
            if vary.choices:
                box.label(text=row.shown)
            else:
                fields = box.row(align=True)
                fields.prop(row, "first")
                fields.prop(row, "last")
                fields.prop(row, "steps")
        layout.prop(wanted, "seeds")
        layout.operator(
            "angen.study_write", text=f"Write Study of {plural(runs, 'Run')}", icon="FILE_NEW"
        )
        layout.prop(wanted, "file")
        if wanted.file:
            draw_lines(layout, command(wanted.file), "CONSOLE")
        line = layout.row(align=True)
        line.operator("angen.study_command", icon="COPYDOWN")
        line.operator("angen.study_report", icon="URL")
        draw_lines(layout, "Studies run in a terminal, not in Blender", "INFO")


register, unregister = bpy.utils.register_classes_factory((ANGEN_MT_study_vary, ANGEN_PT_study))
