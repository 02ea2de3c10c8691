# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a study file, which varies parameters of the selected sensors, and open the study's report.

`angen study run` runs the study outside Blender.
"""

from __future__ import annotations

import math
import os
import shlex
import sys
from pathlib import Path
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Context, Operator, PropertyGroup
from bpy_extras.io_utils import ExportHelper

from ...angen_addon.relative_path import RELATIVE_PATH, ChosenFile, absolute
from ...angen_addon.scene.sensors import Sensor, all_sensors
from ...angen_addon.translations.interface import translated
from ...angen_addon.view.active import active_sensor
from ...operators.polls import cancelled, needs
from ...sensor_logic.kind import Kind
from ...sensor_logic.logs.error import AngenError
from ...sensor_logic.logs.files import write_files
from .. import study_file
from ..study_file import BETWEEN, COMMON, POSE, Vary


class AngenStudyVary(PropertyGroup):
    """One parameter that a study varies, and the sensors that have it.

    Attributes
    ----------
    choices
        The values of an enumeration parameter. The study takes all of them.
    shown
        The same values, as labels for the panel.
    angle
        Whether the parameter is an angle, so that `first` and `last` are in degrees.
    """

    sensors: StringProperty()
    parameter: StringProperty()
    label: StringProperty()
    first: FloatProperty(name="From", description="First value of the parameter", precision=3)
    last: FloatProperty(name="To", description="Last value of the parameter", precision=3)
    steps: IntProperty(name="Steps", description="Number of values", default=3, min=2, soft_max=50)
    whole: BoolProperty()
    angle: BoolProperty()
    choices: StringProperty()
    shown: StringProperty()


class AngenStudy(PropertyGroup):
    """The settings of a study. `file` is the study file that was last written or chosen."""

    varied: CollectionProperty(type=AngenStudyVary)
    seeds: IntProperty(
        name="Seeds",
        description="Number of runs of each combination of values, each with other noise",
        default=1,
        min=1,
    )
    file: StringProperty(
        name="Study", subtype="FILE_PATH", options=RELATIVE_PATH,
        description="Study file; its report is in the folder of the same name beside it",
    )  # fmt: skip


# Functions, not methods: Blender 4.2 never frees a PropertyGroup class and what it refers to.
def fill(row: AngenStudyVary, vary: Vary, kind: Kind) -> None:
    """Copy a `Vary`, which holds a parameter and its values in a study, into a row of the panel."""
    row.name, row.label = vary.key, study_file.label(kind, vary.parameter)
    row.sensors, row.parameter = BETWEEN.join(vary.sensors), vary.parameter
    row.angle, row.whole = vary.angle, vary.whole
    ends = vary.first, vary.last
    row.first, row.last = map(math.degrees, ends) if vary.angle else ends
    row.choices = BETWEEN.join(map(str, vary.choices))
    row.shown = ", ".join(study_file.choice_labels(kind, vary.parameter, vary.choices))


def vary_of(row: AngenStudyVary) -> Vary:
    """Return the `Vary` (a parameter and its values) that a row of the panel describes."""
    choices = [
        {"True": True, "False": False}.get(choice, choice)
        for choice in row.choices.split(BETWEEN)
        if choice
    ]
    ends = row.first, row.last
    first, last = map(math.radians, ends) if row.angle else ends
    names = row.sensors.split(BETWEEN)
    return Vary(names, row.parameter, first, last, row.steps, row.whole, choices, row.angle)


def command(file: str) -> str:
    """Return the shell command that runs a study file; empty if `file` is empty."""
    path = absolute(file)
    study, out = map(quoted, (path, path.with_suffix("")))
    return f"angen study run {study} --out {out}" if file else ""


def quoted(path: Path) -> str:
    """Return a path as one word of a command in the system's shell."""
    # cmd and PowerShell know double quotes, which no file name on Windows contains.
    return f'"{path}"' if sys.platform == "win32" else shlex.quote(str(path))


def varied_sensors(context: Context) -> list[Sensor]:
    """Return the selected sensors that have the active sensor's kind.

    If there are none, return the active sensor alone.
    """
    active = active_sensor(context)
    if active is None:
        return []
    found = [s for s in all_sensors(context.view_layer) if s.selected and s.kind == active.kind]
    return found or [active]


class ANGEN_OT_study_vary(Operator):
    bl_idname = "angen.study_vary"
    bl_label = "Vary"
    bl_description = "Vary this parameter of the selected sensors of this kind in the study"

    parameter: StringProperty(options={"HIDDEN"})

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(cls, active_sensor(context) is not None, "Select a sensor")

    def execute(self, context: Context) -> set[str]:
        sensors = varied_sensors(context)
        kind = sensors[0].kind
        if self.parameter not in study_file.parameters(kind):
            return cancelled(self, f"'{kind.label}' has no parameter '{self.parameter}'")
        names = [sensor.name for sensor in sensors]
        now = _value(sensors[0], self.parameter)
        wished = study_file.proposed(kind.identifier, names, self.parameter, now)
        varied = context.window_manager.angen_study.varied
        row = varied.get(wished.key) or varied.add()
        fill(row, wished, kind)
        return {"FINISHED"}


def _value(sensor: Sensor, parameter: str) -> Any:
    if parameter in POSE:
        return 0.0
    return getattr(sensor.settings if parameter in COMMON else sensor.parameters, parameter)


class ANGEN_OT_study_leave(Operator):
    bl_idname = "angen.study_leave"
    bl_label = "Leave As It Is"
    bl_description = "Remove this parameter from the study"

    index: IntProperty(options={"HIDDEN"})

    def execute(self, context: Context) -> set[str]:
        context.window_manager.angen_study.varied.remove(self.index)
        return {"FINISHED"}


class ANGEN_OT_study_write(Operator, ChosenFile, ExportHelper):
    bl_idname = "angen.study_write"
    bl_label = "Write Study"
    bl_description = (
        "Write the study file for `angen study run`, which simulates this home once for each "
        "combination of values and seed"
    )

    filename_ext = ".toml"
    filter_glob: StringProperty(default="*.toml", options={"HIDDEN"})

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(
            cls, context.window_manager.angen_study.varied, "Add a parameter to vary"
        ) and needs(cls, bpy.data.filepath, "Save the home first: a study names its file")

    def execute(self, context: Context) -> set[str]:
        wanted = context.window_manager.angen_study
        path = self.path
        varied = [vary_of(row) for row in wanted.varied]
        for row in wanted.varied:
            if not row.choices and row.last <= row.first:
                return cancelled(self, f"{row.sensors}, {row.label}: To must be above From")
        try:
            home = Path(os.path.relpath(bpy.data.filepath, path.resolve().parent)).as_posix()
        except ValueError:
            # The home is on another drive, so there is no relative path.
            home = bpy.data.filepath
        try:
            write_files({path: study_file.text(home, wanted.seeds, varied)})
        except AngenError as error:
            return cancelled(self, error)
        wanted.file = str(path)
        unsaved = "; the home has unsaved changes" if bpy.data.is_dirty else ""
        self.report({"INFO"}, translated(f"Written: {path}{unsaved}. Run it in a terminal"))
        return {"FINISHED"}


def _has_study_file(cls: Any, context: Context) -> bool:
    return needs(
        cls, context.window_manager.angen_study.file, "Write a study first, or name the file of one"
    )


class ANGEN_OT_study_command(Operator):
    bl_idname = "angen.study_command"
    bl_label = "Copy Command"
    bl_description = "Copy the command that runs the study, for a terminal"

    poll = classmethod(_has_study_file)

    def execute(self, context: Context) -> set[str]:
        context.window_manager.clipboard = command(context.window_manager.angen_study.file)
        return {"FINISHED"}


class ANGEN_OT_study_report(Operator):
    bl_idname = "angen.study_report"
    bl_label = "Open Report"
    bl_description = "Open the report that `angen study report` wrote in a browser"

    poll = classmethod(_has_study_file)

    def execute(self, context: Context) -> set[str]:
        file = absolute(context.window_manager.angen_study.file)
        report = file.with_suffix("") / "report.html"
        if not report.is_file():
            text = f"There is no report yet: run `angen study report {quoted(report.parent)}`"
            return cancelled(self, text)
        bpy.ops.wm.url_open(url=report.resolve().as_uri())
        return {"FINISHED"}


_register, _unregister = bpy.utils.register_classes_factory(
    (
        AngenStudyVary,
        AngenStudy,
        ANGEN_OT_study_vary,
        ANGEN_OT_study_leave,
        ANGEN_OT_study_write,
        ANGEN_OT_study_command,
        ANGEN_OT_study_report,
    )
)


def register() -> None:
    _register()
    bpy.types.WindowManager.angen_study = PointerProperty(type=AngenStudy)


def unregister() -> None:
    del bpy.types.WindowManager.angen_study
    _unregister()
