# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the recording as CSV files."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Event, Operator
from bpy_extras.io_utils import ExportHelper

from ..angen_addon import state
from ..angen_addon.output_files import write
from ..sensor_logic.event_log import events_csv, samples_csv
from ..sensor_logic.files import OutputError, check_folder, file_names
from .recording import has_fresh_recording, is_still_fresh


class _Export:
    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_fresh_recording(cls, context)

    def _write(self, texts: dict[Path, str], new_folder: Path | None) -> set[str]:
        try:
            write(texts, new_folder)
        except OutputError as error:
            self.report({"ERROR"}, str(error))  # type: ignore[attr-defined]
            return {"CANCELLED"}
        self.report({"INFO"}, f"Written: {', '.join(map(str, texts))}"[:200])  # type: ignore[attr-defined]
        return {"FINISHED"}


class ANGEN_OT_export_events(_Export, Operator, ExportHelper):
    bl_idname = "angen.export_events"
    bl_label = "Export Events"
    bl_description = "Write the event log as CSV: a row for each change of a reading"

    filename_ext = ".csv"
    filter_glob: StringProperty(default="*.csv", options={"HIDDEN"})

    def execute(self, context: Context) -> set[str]:
        if not is_still_fresh(self, context):
            return {"CANCELLED"}
        recording = state.CACHE.recording(context.scene)
        assert recording is not None
        path = Path(bpy.path.abspath(self.filepath))
        try:
            check_folder(path.parent, "Export")
        except OutputError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return self._write({path: events_csv(recording)}, None)


class ANGEN_OT_export_samples(_Export, Operator):
    bl_idname = "angen.export_samples"
    bl_label = "Export Samples"
    bl_description = "Write every update, a CSV file a sensor, into a folder"

    directory: StringProperty(name="Folder", subtype="DIR_PATH")

    def invoke(self, context: Context, event: Event) -> set[str]:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: Context) -> set[str]:
        if not is_still_fresh(self, context):
            return {"CANCELLED"}
        recording = state.CACHE.recording(context.scene)
        assert recording is not None
        if not self.directory:
            self.report({"ERROR"}, "Choose a folder for the samples")
            return {"CANCELLED"}
        folder = Path(bpy.path.abspath(self.directory))
        texts = {
            folder / name: samples_csv(recording.tracks[sensor])
            for sensor, name in file_names(recording.tracks).items()
        }
        return self._write(texts, folder)


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_export_events, ANGEN_OT_export_samples)
)
