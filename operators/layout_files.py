# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and write layout files of sensors (File, Import or Export, Sensor Layout)."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy.types import Context, Operator
from bpy_extras.io_utils import ExportHelper, ImportHelper

from ..angen_addon.advice.sensing import open_for_ever
from ..angen_addon.layout.apply import apply_layout
from ..angen_addon.layout.describe import layout_text
from ..angen_addon.layout.marks import marks_of
from ..angen_addon.output.output_files import write
from ..angen_addon.relative_path import RELATIVE_PATH, ChosenFile
from ..angen_addon.scene.sensors import all_sensors
from ..angen_addon.translations.interface import translated, translating
from ..sensor_logic.logs.error import AngenError, InputError
from ..sensor_logic.logs.files import check_folder
from ..sensor_logic.logs.wording import plural
from .polls import cancelled, needs


class ANGEN_OT_import_layout(Operator, ChosenFile, ImportHelper):
    bl_idname = "angen.import_layout"
    bl_label = "Import Sensor Layout"
    bl_description = (
        "Add and change sensors to match a layout file (JSON), such as `angen list --json` "
        "prints. If the file has an error, nothing changes"
    )
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    # Hidden as Blender's own importers have it, because Adjust Last Operation would show it.
    filepath: StringProperty(
        name="File Path", subtype="FILE_PATH", options={"HIDDEN", "SKIP_PRESET", *RELATIVE_PATH}
    )
    remove: BoolProperty(
        name="Remove Others",
        description="Delete sensors that are not in the layout. Objects that are more than a "
        "housing, such as furniture, stay as ordinary objects",
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(cls, context.mode == "OBJECT", "Switch to Object Mode to import sensors")

    def execute(self, context: Context) -> set[str]:
        path = self.path
        try:
            applied = apply_layout(path, self.remove)
        except InputError as error:
            return cancelled(self, error)
        self.report({"INFO"}, translated(f"{path.name}: {applied.text}"))
        sensors = all_sensors(context.view_layer)
        for text in open_for_ever(sensors, context.evaluated_depsgraph_get()):
            self.report({"WARNING"}, translated(text))
        return {"FINISHED"}


class ANGEN_OT_export_layout(Operator, ChosenFile, ExportHelper):
    bl_idname = "angen.export_layout"
    bl_label = "Export Sensor Layout"
    bl_description = (
        "Write all sensors with their places and parameters as a layout file (JSON), which another "
        "home can import"
    )

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    selected_only: BoolProperty(
        name="Selected Sensors", description="Write only the selected sensors"
    )
    marks: BoolProperty(
        name="Marks",
        description="Write what residents do at objects too, such as the doors that they open",
        default=True,
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(cls, bool(all_sensors(context.view_layer)), "The scene has no sensors")

    def execute(self, context: Context) -> set[str]:
        path = self.path
        sensors = all_sensors(context.view_layer)
        if self.selected_only:
            sensors = [sensor for sensor in sensors if sensor.selected]
        if not sensors:
            return cancelled(self, "No sensor is selected: select some, or export all")
        try:
            check_folder(path.parent, "Export")
            marks = marks_of(context.view_layer) if self.marks else None
            write({path: layout_text(sensors, marks)})
        except AngenError as error:
            return cancelled(self, error)
        self.report({"INFO"}, translated(f"{path.name}: {plural(len(sensors), 'sensor')}"))
        return {"FINISHED"}


MENU_TEXT = "Sensor Layout (.json)"


@translating
def draw_in_import_menu(self: Any, context: Context) -> None:
    self.layout.operator(ANGEN_OT_import_layout.bl_idname, text=MENU_TEXT)


@translating
def draw_in_export_menu(self: Any, context: Context) -> None:
    self.layout.operator(ANGEN_OT_export_layout.bl_idname, text=MENU_TEXT)


_register, _unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_import_layout, ANGEN_OT_export_layout)
)


def register() -> None:
    _register()
    bpy.types.TOPBAR_MT_file_import.append(draw_in_import_menu)
    bpy.types.TOPBAR_MT_file_export.append(draw_in_export_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_export.remove(draw_in_export_menu)
    bpy.types.TOPBAR_MT_file_import.remove(draw_in_import_menu)
    _unregister()
