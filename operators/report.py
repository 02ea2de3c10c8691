# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the report on a recording as a page, or as a picture."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Operator
from bpy_extras.io_utils import ExportHelper

from ..angen_addon.output.output_files import write
from ..angen_addon.output.report import check_name, report_text
from ..angen_addon.relative_path import ChosenFile
from ..angen_addon.translations.interface import translating
from ..sensor_logic.logs.files import check_folder
from .export_options import ExportOptions


class ANGEN_OT_export_report(ExportOptions, Operator, ChosenFile, ExportHelper):
    bl_idname = "angen.export_report"
    bl_label = "Export Report"
    bl_description = (
        "Write timeline, floor plan and figures of the recording: .html to read and print, "
        ".svg for the pictures alone"
    )

    drawn = ("selected_only",)
    # Empty, so that the file browser accepts both .html and .svg.
    filename_ext = ".html"
    check_extension = None
    filter_glob: StringProperty(default="*.html;*.svg", options={"HIDDEN"})

    def export(self, context: Context) -> str:
        path = self.path
        check_name(path, "Export")
        check_folder(path.parent, "Export")
        sensors, recording, start = self.chosen(context)
        write({path: report_text(path, context.scene, sensors, recording, start)})
        return str(path)


class ANGEN_MT_export(bpy.types.Menu):
    bl_idname = "ANGEN_MT_export"
    bl_label = "Sensors"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        layout.operator("angen.export_report", text="Report (.html, .svg)")
        layout.operator("angen.export_events", text="Events (.csv)")
        layout.operator("angen.export_samples", text="Samples (.csv)")
        layout.operator("angen.export_format", text="For Other Tools (CASAS, Home Assistant …)")


@translating
def draw_menu(self: bpy.types.Menu, context: Context) -> None:
    self.layout.menu(ANGEN_MT_export.bl_idname)


_register, _unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_export_report, ANGEN_MT_export)
)


def register() -> None:
    _register()
    bpy.types.TOPBAR_MT_file_export.append(draw_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_export.remove(draw_menu)
    _unregister()
