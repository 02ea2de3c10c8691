# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a recording as keyframes onto the sensors' `active` and `value`, and removes them.

Keys have constant interpolation, since a reading holds until the next one is published. A line
between two readings would show values that no sensor measured.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.recording.tracks import Recording, Track
from ..runtime.state import ACTIVE_PATH, VALUE_PATH, output_curves
from ..scene.animation import has_curves, remove_curve, time_stretch
from ..scene.sensors import Sensor

# Blender's integer for constant interpolation.
CONSTANT = 0
IN_INSTANCE = (
    "it is in a collection instance, and all instances share one object's keys: make this one real"
)


@dataclass
class BakeResult:
    """The number of sensors whose keys were written or removed, and `notes` on other sensors."""

    count: int = 0
    notes: list[str] = field(default_factory=list)


def bake(sensors: list[Sensor], recording: Recording, scene: Any) -> BakeResult:
    """Replace the keys of the sensors' outputs by one key for each change in the recording.

    The keys go into the object's action, whose other curves stay as they are, or into a new action
    named after the sensor. An action that other objects use too is copied first. The times of the
    keys follow the time stretching of the `scene`.
    """
    baked = BakeResult()
    for sensor in sensors:
        track = recording.track_of(sensor.uid)
        if track is None or not len(track):
            continue
        obstacle = IN_INSTANCE if sensor.holders else _obstacle(sensor.object)
        if not obstacle:
            note = _ensure_action(sensor)
            obstacle = _insert_keys(sensor.object, track, time_stretch(scene))
            if note and not obstacle:
                baked.notes.append(note)
        if obstacle:
            baked.notes.append(f"'{sensor.name}' was not keyed: {obstacle}")
        else:
            baked.count += 1
    return baked


def is_baked(sensor: Sensor) -> bool:
    """Whether the sensor's outputs have keys.

    The keys of a sensor in a collection instance are those of the original sensor, and do not
    count.
    """
    return not sensor.holders and bool(output_curves(sensor.object))


def unbake(sensors: list[Sensor]) -> BakeResult:
    """Remove the keys of the sensors' outputs, and each action that is then empty."""
    baked = BakeResult()
    for sensor in filter(is_baked, sensors):
        animation = sensor.object.animation_data
        action = animation.action
        if action.library is not None:
            where = action.library.filepath
            baked.notes.append(
                f"'{sensor.name}' keeps its keys, which are linked from {where}: remove them there"
            )
            continue
        for curve in output_curves(sensor.object):
            remove_curve(action, curve)
        baked.count += 1
        if not has_curves(action):
            animation.action = None
            if not action.users:
                bpy.data.actions.remove(action)
    return baked


def _obstacle(obj: Any) -> str:
    """Return why an object's outputs cannot be keyed, and what would help; else ""."""
    if obj.library is not None:
        return f"it is linked from {obj.library.filepath}: make it local, or bake there"
    animation = obj.animation_data
    if animation is not None and animation.use_tweak_mode:
        return "its NLA strip is being tweaked: leave Tweak Mode (Tab in the NLA editor)"
    if (
        animation is not None
        and animation.use_nla
        and any(track.is_solo for track in animation.nla_tracks)
    ):
        return "an NLA track plays alone: end its solo (the star in the NLA editor)"
    drivers = animation.drivers if animation is not None else ()
    if any(curve.data_path in {ACTIVE_PATH, VALUE_PATH} for curve in drivers):
        return "a driver sets its outputs: remove it"
    return ""


def _ensure_action(sensor: Sensor) -> str:
    """Give the object an action that it can change alone; return a note if one was copied."""
    obj = sensor.object
    animation = obj.animation_data or obj.animation_data_create()
    if animation is None:
        return ""
    action = animation.action
    if action is None:
        animation.action = bpy.data.actions.new(f"{sensor.name} readings")
        return ""
    if action.library is None and not _is_shared(action, obj):
        return ""
    slot = getattr(animation, "action_slot", None)
    copy = action.copy()
    animation.action = copy
    if slot is not None:
        animation.action_slot = copy.slots[slot.identifier]
    why = "is linked" if action.library is not None else "has other users"
    return f"'{sensor.name}' now has its own copy, '{copy.name}', of an action that {why}"


def _is_shared(action: Any, obj: Any) -> bool:
    """Whether keys in the action would move other objects than `obj`.

    From Blender 4.4 on, datablocks that share an action may have a slot each, or share one.
    """
    slot = getattr(obj.animation_data, "action_slot", None)
    if hasattr(action, "slots"):
        return slot is not None and any(user != obj for user in slot.users())
    return any(user != obj for user in bpy.data.user_map(subset={action})[action])


def _insert_keys(obj: Any, track: Track, stretch: float) -> str:
    """Replace the keys of both outputs; return why that failed, or an empty text."""
    # Blender rounds each product to single precision; a later key would come a frame late.
    frames = np.asarray(track.frames, np.float32) * np.float32(stretch)
    for path, column in ((ACTIVE_PATH, track.active), (VALUE_PATH, track.value)):
        values = np.array(column, np.float64)
        changed = _changes(values)
        try:
            # This call creates the curve in every version of Blender.
            obj.keyframe_insert(path, frame=float(frames[0]))
        except (RuntimeError, TypeError) as error:
            return " ".join(str(error).split())
        found = [curve for curve in output_curves(obj) if curve.data_path == path]
        if not found:
            return "Blender allows no keys on it: if it is a library override, make it local"
        if found[0].group is not None and found[0].group.mute:
            return f"its group of F-curves '{found[0].group.name}' is muted: unmute it"
        _fill(found[0], frames[changed], values[changed])
    return ""


def _changes(values: Any) -> Any:
    """Return the indices at which a finite value differs from the one before."""
    known = np.flatnonzero(np.isfinite(values))
    differs = np.diff(values[known]) != 0.0
    return known[np.concatenate(([True], differs))] if len(known) else known


def _fill(curve: Any, frames: Any, values: Any) -> None:
    """Replace all keys of a curve by these, with constant interpolation."""
    curve.mute = False
    points = curve.keyframe_points
    points.clear()
    points.add(len(frames))
    points.foreach_set("co", np.column_stack((frames, values)).astype(np.float32).ravel())
    points.foreach_set("interpolation", np.full(len(frames), CONSTANT, np.int32))
    curve.update()
