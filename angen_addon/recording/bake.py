# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a recording as keyframes onto the sensors' `active` and `value`, and removes them.

Both are held from key to key (constant interpolation). A reading stands until the next one is
published; a line between two would show values that nobody measured, and show them early.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.recording.tracks import Recording, Track
from ..runtime.outputs import ACTIVE_PATH, VALUE_PATH, output_curves
from ..scene.animation import has_curves, remove_curve
from ..scene.sensors import Sensor

# What Blender calls its keys' kinds, by number.
CONSTANT = 0
IN_INSTANCE = "it is in a collection instance, all of which share one object's keys"


@dataclass
class Baked:
    """Of how many sensors keys were written or removed, and what the user should know of others, a
    line each."""

    count: int = 0
    notes: list[str] = field(default_factory=list)


def bake(sensors: list[Sensor], recording: Recording) -> Baked:
    """Keys every change of the recorded sensors anew, in place of earlier keys of these outputs.

    They go into the object's action where it has one, whose other curves stay as they are; else
    into a new one named after the sensor. An action that other objects play too is copied first.
    """
    baked = Baked()
    for sensor in sensors:
        track = recording.track_of(sensor.uid)
        if track is None or not len(track):
            continue
        obstacle = IN_INSTANCE if sensor.holders else _obstacle(sensor.object)
        if not obstacle:
            note = _own_action(sensor)
            obstacle = _key(sensor.object, track)
            if note and not obstacle:
                baked.notes.append(note)
        if obstacle:
            baked.notes.append(f"'{sensor.name}' was not keyed: {obstacle}")
        else:
            baked.count += 1
    return baked


def is_baked(sensor: Sensor) -> bool:
    """Whether keys say what its outputs are; in an instance they are those of another sensor, its
    original."""
    return not sensor.holders and bool(output_curves(sensor.object))


def unbake(sensors: list[Sensor]) -> Baked:
    """Removes the keys of the sensors' outputs; an action in which nothing else is goes too."""
    baked = Baked()
    for sensor in filter(is_baked, sensors):
        animation = sensor.object.animation_data
        action = animation.action
        if action.library is not None:
            where = action.library.filepath
            baked.notes.append(f"'{sensor.name}' keeps its keys: they are linked from {where}")
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
    """Why the outputs of an object cannot be keyed, and the way out."""
    if obj.library is not None:
        return f"it is linked from {obj.library.filepath}: make it local, or bake there"
    animation = obj.animation_data
    if animation is not None and animation.use_tweak_mode:
        return "its NLA strip is being tweaked: leave Tweak Mode (Tab in the NLA editor)"
    drivers = animation.drivers if animation is not None else ()
    if any(curve.data_path in {ACTIVE_PATH, VALUE_PATH} for curve in drivers):
        return "a driver sets its outputs: remove it"
    return ""


def _own_action(sensor: Sensor) -> str:
    """Sees to an action that only this object plays; returns what the user should know of it."""
    obj = sensor.object
    animation = obj.animation_data or obj.animation_data_create()
    if animation is None:
        return ""
    action = animation.action
    if action is None:
        animation.action = bpy.data.actions.new(f"{sensor.name} readings")
        return ""
    if action.library is None and not _others_play(action, obj):
        return ""
    slot = getattr(animation, "action_slot", None)
    copy = action.copy()
    animation.action = copy
    if slot is not None:
        animation.action_slot = copy.slots[slot.identifier]
    why = "is linked" if action.library is not None else "was shared with others"
    return f"'{sensor.name}' plays its own copy, '{copy.name}', of an action that {why}"


def _others_play(action: Any, obj: Any) -> bool:
    """Whether something but `obj` would get the keys too: from Blender 4.4 on, each datablock has
    its slot in an action, or shares that of another."""
    slot = getattr(obj.animation_data, "action_slot", None)
    if hasattr(action, "slots"):
        return slot is not None and any(user != obj for user in slot.users())
    return any(user != obj for user in bpy.data.user_map(subset={action})[action])


def _key(obj: Any, track: Track) -> str:
    """Replaces the keys of both outputs; returns why it could not."""
    frames = np.asarray(track.frames)
    for path, column in ((ACTIVE_PATH, track.active), (VALUE_PATH, track.value)):
        values = np.array(column, np.float64)
        kept = _changes(values)
        try:
            # Blender makes the curve as it wants it, whatever the version.
            obj.keyframe_insert(path, frame=float(frames[0]))
        except (RuntimeError, TypeError) as error:
            return " ".join(str(error).split())
        found = [curve for curve in output_curves(obj) if curve.data_path == path]
        if not found:
            return "Blender does not let it be animated: is it a library override?"
        _fill(found[0], frames[kept], values[kept])
    return ""


def _changes(values: Any) -> Any:
    """Where a value differs from the one before."""
    known = np.flatnonzero(np.isfinite(values))
    differs = np.diff(values[known]) != 0.0
    return known[np.concatenate(([True], differs))] if len(known) else known


def _fill(curve: Any, frames: Any, values: Any) -> None:
    points = curve.keyframe_points
    points.clear()
    points.add(len(frames))
    points.foreach_set("co", np.column_stack((frames, values)).astype(np.float32).ravel())
    points.foreach_set("interpolation", np.full(len(frames), CONSTANT, np.int32))
    curve.update()
