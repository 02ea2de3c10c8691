# SPDX-License-Identifier: GPL-3.0-or-later
"""Add a timeline marker for each event, and remove the markers again."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np
from bpy.types import Context, Operator

from ..angen_addon.recording.results import RESULTS
from ..angen_addon.scene.sensors import Sensor, all_sensors
from ..angen_addon.translations.interface import translated
from ..angen_addon.view.active import active_sensor
from ..sensor_logic.logs.log import format_value
from ..sensor_logic.logs.wording import plural, split
from ..sensor_logic.recording.events import shown_rows
from ..sensor_logic.recording.tracks import Recording, Track
from .polls import cancelled, needs
from .recording import has_fresh_recording

# Blender draws every marker at every redraw: more of them would slow down the window.
MOST_MARKERS = 5000


def marked(scene: Any) -> set[str]:
    """Return the names of the markers that this extension has added to a scene."""
    return set(scene.angen_timeline.marked.splitlines())


def clear(scene: Any, prefixes: tuple[str, ...] = ("",)) -> int:
    """Remove the event markers whose names begin with one of the prefixes; return their number."""
    names = {name for name in marked(scene) if name.startswith(prefixes)}
    gone = [marker for marker in scene.timeline_markers if marker.name in names]
    for marker in gone:
        scene.timeline_markers.remove(marker)
    scene.angen_timeline.marked = "\n".join(sorted(marked(scene) - names))
    return len(gone)


def prefix(sensor: str) -> str:
    return f"{sensor}: "


def event_name(track: Track, index: int) -> str:
    """Return the text of a marker for the event at update `index` of a track."""
    kind, texts = track.kind, []
    output = next((field.name for field in kind.events if field.type is bool), "")
    for published in kind.events:
        column = track.columns[published.name]
        if index and format_value(column[index]) == format_value(column[index - 1]):
            continue
        value = column[index]
        if published.type is str:
            texts.append(", ".join(split(value)) or "nobody")
        elif published.name == "valid":
            texts.append("reading valid" if value else "reading not valid")
        elif published.name == output:
            texts.append(kind.active_label if value else kind.idle_label)
        elif published.type is bool:
            texts.append(published.name if value else f"not {published.name}")
        elif published.type is int:
            texts.append(f"{value} {published.name.replace('_', ' ')}")
    return ", ".join(texts) or track.reading_at(index).text(track.value[index])


def _selected(context: Context) -> list[Sensor]:
    """Return the selected sensors, or the active one if none is selected."""
    chosen = [s for s in all_sensors(context.view_layer) if s.selected]
    active = active_sensor(context)
    return chosen or ([active] if active else [])


class ANGEN_OT_markers_add(Operator):
    bl_idname = "angen.markers_add"
    bl_label = "Mark Events"
    bl_description = (
        "Add a timeline marker for each event of the selected sensors, replacing earlier ones"
    )
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return has_fresh_recording(cls, context) and needs(
            cls, _selected(context), "Select sensors first"
        )

    def execute(self, context: Context) -> set[str]:
        scene = context.scene
        recording = RESULTS.recording(scene)
        assert recording is not None
        sensors = _selected(context)
        events = list(self._events(recording, sensors, scene.angen_timeline.values))
        if len(events) > MOST_MARKERS:
            return cancelled(
                self,
                f"{len(events)} events are more than {MOST_MARKERS} markers: select fewer sensors",
            )
        clear(scene, tuple(prefix(sensor.name) for sensor in sensors))
        for name, frame in events:
            scene.timeline_markers.new(name, frame=frame)
        names = marked(scene) | {name for name, _ in events}
        scene.angen_timeline.marked = "\n".join(sorted(names))
        if not events:
            self.report(
                {"WARNING"}, translated("The selected sensors have no events in the recording")
            )
            return {"FINISHED"}
        self.report({"INFO"}, translated(f"Added {plural(len(events), 'marker')}"))
        return {"FINISHED"}

    def _events(
        self, recording: Recording, sensors: list[Sensor], with_values: bool
    ) -> Iterator[tuple[str, int]]:
        """Yield the name and the whole frame of each marker to add.

        `with_values` includes events that only publish a measured value, such as a range.
        """
        for sensor in sensors:
            track = recording.track_of(sensor.uid)
            if track is None:
                continue
            # Several fields can change at the same update.
            for index in np.unique(shown_rows(track, with_values)).tolist():
                name = prefix(sensor.name) + event_name(track, index)
                # Blender cuts names at 63 bytes, and `clear` finds markers by name.
                short = name.encode()[:63].decode(errors="ignore")
                yield short, int(track.frames[index])


class ANGEN_OT_markers_clear(Operator):
    bl_idname = "angen.markers_clear"
    bl_label = "Clear Event Markers"
    bl_description = "Remove all timeline markers of sensors' events"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(cls, context.scene.angen_timeline.marked, "There are no event markers")

    def execute(self, context: Context) -> set[str]:
        self.report({"INFO"}, translated(f"Removed {plural(clear(context.scene), 'event marker')}"))
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_markers_add, ANGEN_OT_markers_clear)
)
