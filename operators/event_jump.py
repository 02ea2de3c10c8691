# SPDX-License-Identifier: GPL-3.0-or-later
"""Move the playhead to the next or previous event of the active sensor."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ..angen_addon.recording.results import RESULTS
from ..angen_addon.runtime.playhead import why_not_recorded
from ..angen_addon.runtime.time_base import moment_text
from ..angen_addon.translations.interface import translated
from ..angen_addon.view.active import active_sensor
from ..sensor_logic.recording.events import event_rows, shown_rows
from ..sensor_logic.recording.tracks import Recording, Track
from .polls import is_idle, needs
from .recording import has_fresh_recording


def recorded_track(context: Context) -> tuple[Recording, Track] | None:
    """Return the recording and its track (the updates) of the active sensor.

    Return None if the recording has no update of the sensor.
    """
    sensor, recording = active_sensor(context), RESULTS.recording(context.scene)
    track = recording.track_of(sensor.uid) if sensor and recording else None
    return (recording, track) if recording and track and len(track) else None


def has_recorded_track(cls: Any, context: Context) -> bool:
    """Poll: whether a recording that matches the scene has updates of the active sensor."""
    sensor = active_sensor(context)
    return (
        is_idle(cls, context)
        and needs(cls, sensor, "Make a sensor the active object: click it")
        and has_fresh_recording(cls, context)
        and sensor is not None
        and needs(cls, recorded_track(context), why_not_recorded(sensor))
    )


class ANGEN_OT_event_jump(Operator):
    bl_idname = "angen.event_jump"
    bl_label = "Jump to Event"
    bl_description = "Move the playhead to the active sensor's next or previous event"
    bl_options = {"REGISTER"}

    direction: EnumProperty(
        name="Direction",
        items=[
            ("NEXT", "Next", "The first event after the playhead", 0),
            ("PREVIOUS", "Previous", "The last event before the playhead", 1),
        ],
    )
    poll = classmethod(has_recorded_track)

    def execute(self, context: Context) -> set[str]:
        found = recorded_track(context)
        assert found is not None
        recording, track = found
        scene = context.scene
        now = scene.frame_current + scene.frame_subframe
        every = [track.frames[i] for i in event_rows(track).tolist()]
        frames = [track.frames[i] for i in shown_rows(track, scene.angen_timeline.values).tolist()]
        # Blender stores subframes in single precision.
        later = [f for f in frames if f > now + 1e-4]
        earlier = [f for f in frames if f < now - 1e-4]
        ahead = later[:1] if self.direction == "NEXT" else earlier[-1:]
        if not ahead:
            name, is_next = f"'{track.sensor}'", self.direction == "NEXT"
            if len(frames) == len(every):
                text = (
                    f"{name} has no event after this frame"
                    if is_next
                    else f"{name} has no event before this frame"
                )
            else:
                text = (
                    f"{name} has no change of state after this frame"
                    if is_next
                    else f"{name} has no change of state before this frame"
                )
            self.report({"INFO"}, translated(text))
            return {"CANCELLED"}
        substeps = recording.clock.substeps if recording.clock else 1
        step = round(ahead[0] * substeps)
        scene.frame_set(step // substeps, subframe=step % substeps / substeps)
        passed = sum(frame <= ahead[0] for frame in every)
        at = moment_text(scene, ahead[0])
        self.report(
            {"INFO"}, translated(f"'{track.sensor}': {passed} of {len(every)} events passed, {at}")
        )
        return {"FINISHED"}


# The keys work in every editor with a timeline. Desktops often take Ctrl+Alt+arrows. In Blender's
# keymaps, only the text and clip editors use Shift+Alt+arrows, and there Blender's keys come first.
KEYS = (("RIGHT_ARROW", "NEXT"), ("LEFT_ARROW", "PREVIOUS"))
_items: list[tuple[Any, Any]] = []


def _register_keys() -> None:
    config = bpy.context.window_manager.keyconfigs.addon
    if config is None:
        return
    keymap = config.keymaps.new(name="Frames", space_type="EMPTY")
    for key, direction in KEYS:
        item = keymap.keymap_items.new(
            ANGEN_OT_event_jump.bl_idname, key, "PRESS", shift=True, alt=True, repeat=True
        )
        item.properties.direction = direction
        _items.append((keymap, item))


def register() -> None:
    bpy.utils.register_class(ANGEN_OT_event_jump)
    _register_keys()


def unregister() -> None:
    while _items:
        keymap, item = _items.pop()
        keymap.keymap_items.remove(item)
    bpy.utils.unregister_class(ANGEN_OT_event_jump)
