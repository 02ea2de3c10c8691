# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the recording as CSV files."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Event, Operator
from bpy_extras.io_utils import ExportHelper

from ..angen_addon.output.output_files import write
from ..angen_addon.relative_path import RELATIVE_PATH, ChosenFile, absolute
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.logs.files import check_folder, file_names
from ..sensor_logic.recording.events import events_csv, samples_csv
from .export_options import ExportOptions


class ANGEN_OT_export_events(ExportOptions, Operator, ChosenFile, ExportHelper):
    bl_idname = "angen.export_events"
    bl_label = "Export Events"
    bl_description = "Write the event log as CSV: a row for each change of a reading"

    filename_ext = ".csv"
    filter_glob: StringProperty(default="*.csv", options={"HIDDEN"})

    def export(self, context: Context) -> str:
        path = self.path
        _, recording, start = self.chosen(context)
        check_folder(path.parent, "Export")
        write({path: self.shown([events_csv(recording, start)])})
        return str(path)


class ANGEN_OT_export_samples(ExportOptions, Operator):
    bl_idname = "angen.export_samples"
    bl_label = "Export Samples"
    bl_description = "Write all updates, one CSV file for each sensor, into a new folder"

    drawn = ("folder", *ExportOptions.drawn)
    directory: StringProperty(name="Folder", subtype="DIR_PATH", options=RELATIVE_PATH)
    folder: StringProperty(
        name="New Folder",
        description="Name of a new folder in the chosen one, with a number if the name exists. "
        "Empty: write the files into the chosen folder",
    )

    def invoke(self, context: Context, event: Event) -> set[str]:
        stem = Path(bpy.data.filepath).stem
        self.folder = f"{stem} samples".strip()
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def export(self, context: Context) -> str:
        _, recording, start = self.chosen(context)
        if not self.directory:
            raise AngenError("Choose a folder for the samples")
        folder = self._make_folder(absolute(self.directory))
        texts = {
            folder / name: self.shown(samples_csv(recording.tracks[sensor], start))
            for sensor, name in file_names(recording.tracks).items()
        }
        write(texts, folder)
        return f"{len(texts)} files in {folder}"

    def _make_folder(self, chosen: Path) -> Path:
        """Return `chosen`, or a new folder inside it if the user has typed a name for one."""
        check_folder(chosen if self.folder or chosen.exists() else chosen.parent, "Export")
        if not self.folder:
            return chosen
        if Path(self.folder).name != self.folder or self.folder == "..":
            raise AngenError(f"New Folder: '{self.folder}' is not the name of a folder")
        made, number = chosen / self.folder, 1
        while made.exists():
            number += 1
            made = chosen / f"{self.folder} {number}"
        return made


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_export_events, ANGEN_OT_export_samples)
)
