# SPDX-License-Identifier: GPL-3.0-or-later
"""Add and change sensors to match a layout file (File, Import, Sensor Layout)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, StringProperty
from bpy.types import Context, Operator
from bpy_extras.io_utils import ImportHelper

from ..angen_addon.layout.apply import apply_layout
from ..sensor_logic.error import InputError
from .polls import cancelled, needs


class ANGEN_OT_import_layout(Operator, ImportHelper):
    bl_idname = "angen.import_layout"
    bl_label = "Import Sensor Layout"
    bl_description = (
        "Add and change sensors to match a layout file (JSON), such as `angen list --json` "
        "prints. If the file has an error, nothing changes"
    )
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})
    remove: BoolProperty(
        name="Remove Others",
        description="Delete sensors that are not in the layout. Objects that are more than a "
        "housing, such as furniture, stay as ordinary objects",
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(cls, context.mode == "OBJECT", "Switch to Object Mode to import sensors")

    def execute(self, context: Context) -> set[str]:
        path = Path(bpy.path.abspath(self.filepath))
        try:
            applied = apply_layout(path, self.remove)
        except InputError as error:
            return cancelled(self, error)
        self.report({"INFO"}, f"{path.name}: {applied.text}")
        return {"FINISHED"}


def draw_in_import_menu(self: Any, context: Context) -> None:
    self.layout.operator(ANGEN_OT_import_layout.bl_idname, text="Sensor Layout (.json)")


_register, _unregister = bpy.utils.register_classes_factory((ANGEN_OT_import_layout,))


def register() -> None:
    _register()
    bpy.types.TOPBAR_MT_file_import.append(draw_in_import_menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(draw_in_import_menu)
    _unregister()
