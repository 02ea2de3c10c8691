# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sensor reads at the playhead: recorded where there is a recording, else live.

States differ by icon and by word, never by colour alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..angen_addon import outputs, state
from ..angen_addon.sensors import Sensor
from ..angen_addon.units import lengths_of
from ..sensor_logic.quantities import NOTHING

ACTIVE, IDLE, OFF, DOUBTFUL, WRONG = "RADIOBUT_ON", "RADIOBUT_OFF", "X", "QUESTION", "ERROR"
UNKNOWN = "DOT"
# Kinds whose main reading is what they measure; of the others it is the state.
MEASURING = {"LIGHT", "PRESSURE"}


@dataclass(frozen=True)
class Shown:
    """`text` in full, `short` where there is little room, with the `icon` of the state; `problem`:
    why the reading is not valid, or there is none; `fields`: what was published, None where nothing
    is known of it; `recorded`: not live."""

    text: str
    icon: str
    problem: str = ""
    fields: Mapping[str, Any] | None = None
    recorded: bool = False
    brief: str = ""

    @property
    def short(self) -> str:
        return self.brief or self.text


def shown(sensor: Sensor, scene: Any) -> Shown:
    """What the sensor reads, in words, or why nothing."""
    kind, settings = sensor.kind, sensor.settings
    if not settings.enabled:
        return Shown("Off", OFF)
    if state.CACHE.running:
        # What stands is of the frame where the playhead was before the run.
        return Shown("Simulating", UNKNOWN, brief=NOTHING)
    recorded = _recorded(sensor, scene)
    fields, problem = recorded or _live(sensor, scene)
    reading, lengths = sensor.reading, lengths_of(scene)
    value = reading.text(settings.value, lengths)
    if problem:
        icon = WRONG if fields is None else DOUBTFUL
        # What stands is the last known reading, if there was any.
        text = f"Invalid, {value}" if fields and settings.value else "Invalid"
        return Shown(text, icon, problem, fields, recorded is not None, "Invalid")
    if fields is None and not outputs.output_curves(sensor.object):
        return Shown("No reading", UNKNOWN, brief=NOTHING)
    word, icon = (kind.active_label, ACTIVE) if settings.active else (kind.idle_label, IDLE)
    measures = sensor.kind.identifier in MEASURING
    brief = reading.short(settings.value, lengths) if measures else word
    return Shown(f"{word}, {value}", icon, "", fields, recorded is not None, brief)


def _recorded(sensor: Sensor, scene: Any) -> tuple[Mapping[str, Any] | None, str] | None:
    """Fields and problem in the recording; None where it does not cover the playhead."""
    recording = state.CACHE.recording(scene)
    frame = scene.frame_current + scene.frame_subframe
    if recording is None or not recording.covers(frame):
        return None
    track = recording.track_of(sensor.uid)
    index = track.at(frame) if track else None
    if track is None or index is None:
        return None, ""
    fields = {name: column[index] for name, column in track.columns.items()}
    return fields, fields.get("problem", "")


def _live(sensor: Sensor, scene: Any) -> tuple[Mapping[str, Any] | None, str]:
    """Fields and problem of the last live update."""
    live = state.CACHE.live
    if live is None or live.scene_uid != scene.session_uid or not scene.angen_live:
        return None, ""
    problem = live.problems.get(sensor.name, "").removeprefix(f"'{sensor.name}': ")
    return live.readings.get(sensor.name), problem
