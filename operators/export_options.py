# SPDX-License-Identifier: GPL-3.0-or-later
"""Options that all exports of a recording share: the sensors, and the date and time of t = 0."""

from __future__ import annotations

from collections.abc import Iterable
from datetime import datetime
from typing import Any

from bpy.props import BoolProperty, StringProperty
from bpy.types import Context

from ..angen_addon.appearance.panel_parts import draw_lines
from ..angen_addon.recording.results import RESULTS
from ..angen_addon.runtime.time_base import start_of
from ..angen_addon.scene.sensors import Sensor, all_sensors
from ..angen_addon.translations.interface import translated
from ..sensor_logic.logs.error import AngenError, InputError, explained
from ..sensor_logic.logs.log import for_spreadsheets, parse_start
from ..sensor_logic.recording.tracks import Recording
from .polls import cancelled
from .recording import has_fresh_recording, is_still_fresh

EXAMPLE = "2026-03-01T08:00"


class ExportOptions:
    """Mix-in of operators that export a recording. Subclasses implement `export`."""

    # What the operator has.
    layout: Any
    report: Any
    # Properties drawn in the file browser, before the scene's Start.
    drawn: tuple[str, ...] = ("selected_only", "spreadsheet")

    selected_only: BoolProperty(
        name="Selected Sensors",
        description="Export only the readings of the selected sensors",
    )
    spreadsheet: BoolProperty(
        name="For Spreadsheets",
        description="Mark the file as UTF-8, so that umlauts are right, and add a leading ' to "
        "names that a spreadsheet would read as formulas (=A1)",
    )
    decimal_comma: BoolProperty(
        name="Decimal Comma",
        description="For a spreadsheet in German, Swedish and other languages that write 0,5: "
        "semicolons separate the cells",
    )
    start: StringProperty(
        name="Start Time",
        description="For scripts: date and time of the first frame, in place of the scene's Start",
        options={"HIDDEN", "SKIP_SAVE"},
    )

    poll = classmethod(has_fresh_recording)

    def draw(self, context: Context) -> None:
        column = self.layout.column()
        column.use_property_split, column.use_property_decorate = True, False
        for name in self.drawn:
            column.prop(self, name)
        if "spreadsheet" in self.drawn and self.spreadsheet:
            column.prop(self, "decimal_comma")
        draw_start(column, context.scene, self.needing())

    def needing(self) -> str:
        """Return the name of the chosen format if that format needs dates, else an empty text."""
        return ""

    def export(self, context: Context) -> str:
        """Write the files, and return their names for the report. Raise `AngenError` on failure."""
        raise NotImplementedError

    def execute(self, context: Context) -> set[str]:
        if not is_still_fresh(self, context):
            return {"CANCELLED"}
        try:
            written = self.export(context)
        except AngenError as error:
            return cancelled(self, error)
        self.report({"INFO"}, translated(f"Written: {written}")[:200])
        return {"FINISHED"}

    def chosen(self, context: Context) -> tuple[list[Sensor], Recording, datetime | None]:
        """Return the chosen sensors, their recording, and the date and time of its start.

        Raise `AngenError` if no recorded sensor is selected, or if a date is required and missing.
        """
        recording = RESULTS.recording(context.scene)
        assert recording is not None
        sensors = all_sensors(context.view_layer)
        if self.selected_only:
            sensors = [sensor for sensor in sensors if sensor.selected]
            names = {track.sensor for s in sensors if (track := recording.track_of(s.uid))}
            if not names:
                raise AngenError("No recorded sensor is selected: select some, or export all")
            recording = recording.only(names)
        return sensors, recording, self._start(context)

    def shown(self, pieces: Iterable[str]) -> Iterable[str]:
        """Return the pieces of a CSV file, for a spreadsheet if the user chose that option."""
        return for_spreadsheets(pieces, self.decimal_comma) if self.spreadsheet else pieces

    def _start(self, context: Context) -> datetime | None:
        """Return the date and time of t = 0, or None if neither operator nor scene sets it.

        Raise `InputError` if the chosen format needs dates and the start is not set.
        """
        if not self.start:
            start = start_of(context.scene)
        else:
            with explained("Start Time", InputError):
                start = parse_start(self.start)
        if start is None and (what := self.needing()):
            raise InputError(
                f"Start Time is empty, and {what} writes dates: set it (here, or in the panel "
                f"Simulation) to the date and time of the first frame, such as {EXAMPLE}"
            )
        return start


def draw_start(layout: Any, scene: Any, needing: str = "") -> None:
    """Draw the scene's start date in a layout, in red and with a line if it is invalid.

    `needing` is the name of a format that needs dates. With it, an empty date is invalid.
    """
    problem = f"{needing} writes dates: set the time of the first frame" if needing else ""
    try:
        problem = "" if start_of(scene) else problem
    except InputError as error:
        problem = str(error)
    row = layout.row()
    row.alert = bool(problem)
    row.prop(scene, "angen_start", placeholder=EXAMPLE if problem else "not set")
    if problem:
        draw_lines(layout, problem, "ERROR")
