# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the recording in the format of another tool."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Event, Operator

from ..angen_addon.appearance.panel_parts import draw_lines
from ..angen_addon.output.output_files import Exports, Outputs
from ..angen_addon.output.run_log import log_of_run
from ..angen_addon.relative_path import ChosenFile
from ..angen_addon.translations.interface import translated
from ..sensor_logic.logs.formats import FORMATS
from .export_options import ExportOptions

# A format whose package is missing here is not offered.
ITEMS = [(f.name, f.name, f.tip) for f in FORMATS.values() if f.name != "events" and f.is_installed]


HOME_ASSISTANT = (
    "To have these sensors in Home Assistant: panel Live to MQTT, or the command angen replay "
    "(page Home Assistant of the docs)"
)


class ANGEN_OT_export_format(ExportOptions, Operator, ChosenFile):
    bl_idname = "angen.export_format"
    bl_label = "Export for Other Tools"
    bl_description = (
        "Write the recorded events in the format of another tool: CASAS, Home Assistant, ROS 2 …"
    )

    drawn = ("format", "selected_only")
    format: EnumProperty(name="Format", items=ITEMS)

    def invoke(self, context: Context, event: Event) -> set[str]:
        home = Path(bpy.data.filepath or "home.blend")
        self.filepath = str(home.with_name(f"{home.stem} events"))
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def draw(self, context: Context) -> None:
        super().draw(context)
        if self.format.startswith("home-assistant"):
            draw_lines(self.layout, HOME_ASSISTANT, "INFO")

    def needing(self) -> str:
        return str(self.format)

    def export(self, context: Context) -> str:
        sensors, recording, start = self.chosen(context)
        path = self.path
        # The name of home.v2.blend proposes "home.v2 events", whose end is no suffix.
        if not path.suffix[1:].isalnum():
            path = path.with_name(path.name + FORMATS[self.format].extension)
        exports = Exports([self.format], [path])
        log = log_of_run(recording, context.scene, sensors, start)
        with Outputs() as outputs:
            for text in exports.add_to(outputs, log):
                self.report({"WARNING"}, translated(text))
            outputs.commit()
        return str(path)


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_export_format,))
