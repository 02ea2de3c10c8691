# SPDX-License-Identifier: GPL-3.0-or-later
"""What all exports of a recording let the user choose: which sensors, and when it begins."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from bpy.props import BoolProperty, StringProperty
from bpy.types import Context

from ..angen_addon.runtime import state
from ..angen_addon.scene.sensors import Sensor, all_sensors
from ..sensor_logic.files import OutputError
from ..sensor_logic.log.event_log import for_spreadsheets
from ..sensor_logic.log.start import parse_start
from ..sensor_logic.recording.tracks import Recording
from .recording import has_fresh_recording


class ExportOptions:
    """A mix-in of export operators, which work where there is a fresh recording."""

    selected_only: BoolProperty(
        name="Selected Sensors", description="Leave out what sensors that are not selected report"
    )
    spreadsheet: BoolProperty(
        name="For Spreadsheets",
        description="Names that a spreadsheet would take for formulas (=A1) get a leading '",
    )
    start: StringProperty(
        name="Start",
        description="Date and time of the scene's first frame, such as 2026-03-01T08:00: what is "
        "written then tells the time of day too. Empty: seconds alone",
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_fresh_recording(cls, context)

    def chosen(self, context: Context) -> tuple[list[Sensor], Recording, datetime | None]:
        """The sensors, what was recorded of them, and what t = 0 stands for. Raises OutputError."""
        recording = state.CACHE.recording(context.scene)
        assert recording is not None
        sensors = all_sensors(context.view_layer)
        if self.selected_only:
            sensors = [sensor for sensor in sensors if sensor.selected]
            names = {track.sensor for s in sensors if (track := recording.track_of(s.uid))}
            if not names:
                raise OutputError("No recorded sensor is selected: select some, or export all")
            recording = recording.only(names)
        return sensors, recording, self._start()

    def shown(self, text: str) -> str:
        """CSV as it is to be written."""
        return for_spreadsheets(text) if self.spreadsheet else text

    def _start(self) -> datetime | None:
        try:
            return parse_start(self.start)
        except ValueError as error:
            raise OutputError(f"Start: {error}") from None


def told(operator: Any, text: str) -> set[str]:
    """Reports what was written, as long as a line is."""
    operator.report({"INFO"}, f"Written: {text}"[:200])
    return {"FINISHED"}
