# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel rows and explanations of sensors that watch whether an object is in use."""

from __future__ import annotations

from typing import Any

from bpy.types import Context

from ...sensor_logic.logs.wording import quoted
from ...sensor_logic.use import NOTHING_WATCHED
from ..scene.sensors import Sensor
from ..scene.uses import watched_object
from .facts import Explanation, Facts
from .panel_parts import draw_lines
from .reading_text import ReadingText
from .recorded import RecordedSensor


def draw_watched(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Draw what the sensor watches if that is its parent, and warn if it watches nothing.

    `seen` has the texts of the sensor's reading.
    """
    watched = watched_object(sensor)
    if watched is None:
        draw_lines(layout, NOTHING_WATCHED, "ERROR")
    elif watched == sensor.object.parent:
        draw_lines(layout, f"It watches its parent, {quoted(watched.name)}", "INFO")


def explain_use(recorded: RecordedSensor, index: int, does: str, facts: Facts) -> Explanation:
    """Explain update `index` of a sensor by the use of the object that it watches.

    `does` says in a few words what the object does while the output is on, such as "is in use".
    """
    name = recorded.evidence("object", index)
    watched = watched_object(recorded.sensor)
    if name:
        headline = f"{recorded.word(index)}: {quoted(name)} {does}"
    elif watched is None:
        headline = NOTHING_WATCHED
    else:
        headline = f"{recorded.word(index)}: {quoted(watched.name)} neither is in use, nor runs on"
    if index and bool(recorded.track.active[index - 1]) != bool(recorded.track.active[index]):
        facts = [*facts, ("Before", f"{recorded.word(index - 1)}, at {recorded.when(index - 1)}")]
    return recorded.explanation(index, headline, facts)
