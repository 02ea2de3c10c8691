# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing a recording as keyframes of the sensors' `active` and `value`, and removing them.

The keyframes have constant interpolation, since a reading is valid until the next one is published.
Any other interpolation would show values that no sensor measured.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.recording.tracks import Recording, Track
from ..scene.animation import has_curves, remove_curve, time_stretch
from ..scene.outputs import ACTIVE_PATH, VALUE_PATH, output_curves
from ..scene.sensors import Sensor

# Blender's integer for constant interpolation.
CONSTANT = 0
IN_INSTANCE = (
    "it is in a collection instance, and all instances share the keyframes of one object: make "
    "this instance real (Object, Apply, Make Instances Real)"
)


@dataclass
class BakeResult:
    """The result of writing or removing keyframes.

    Attributes
    ----------
    count
        The number of sensors whose keyframes were written or removed.
    notes
        Sentences for the user, on sensors that failed and on actions that were copied.
    """

    count: int = 0
    notes: list[str] = field(default_factory=list)


def bake(sensors: list[Sensor], recording: Recording, scene: Any) -> BakeResult:
    """Replace the keyframes of the sensors' outputs by a keyframe for each change in the recording.

    The keyframes are added to the action of the sensor's object, whose other F-curves do not
    change. An object without an action gets a new one named after the sensor. An action that other
    objects use too is copied first. If the `scene` has time stretching, the times of the keyframes
    are stretched as well.
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
            baked.notes.append(f"'{sensor.name}' got no keyframes: {obstacle}")
        else:
            baked.count += 1
    return baked


def is_baked(sensor: Sensor) -> bool:
    """Return whether the sensor's outputs have keyframes.

    For a sensor in a collection instance, this is false: the keyframes belong to the original
    sensor.
    """
    return not sensor.holders and bool(output_curves(sensor.object))


def unbake(sensors: list[Sensor]) -> BakeResult:
    """Remove the keyframes of the sensors' outputs, and each action that is empty afterwards."""
    baked = BakeResult()
    for sensor in filter(is_baked, sensors):
        animation = sensor.object.animation_data
        action = animation.action
        if action.library is not None:
            where = action.library.filepath
            baked.notes.append(
                f"'{sensor.name}' keeps its keyframes, which are linked from {where}: remove them "
                "in that file"
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
    """Return why an object's outputs cannot get keyframes, and a way out; empty if they can."""
    if obj.library is not None:
        return f"it is linked from {obj.library.filepath}: make it local, or bake it in that file"
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
    """Give the sensor's object an action of its own; if one was copied, return a note, else ""."""
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
    """Return whether keyframes in the action would also animate datablocks other than `obj`.

    From Blender 4.4 on, an action has slots. Keyframes then animate only datablocks with the same
    slot.
    """
    slot = getattr(obj.animation_data, "action_slot", None)
    if hasattr(action, "slots"):
        return slot is not None and any(user != obj for user in slot.users())
    return any(user != obj for user in bpy.data.user_map(subset={action})[action])


def _insert_keys(obj: Any, track: Track, stretch: float) -> str:
    """Replace the keyframes of both outputs; return why that failed, or an empty text.

    `stretch` is the number of frames of the F-curves in one frame of the scene.
    """
    # Blender rounds the stretched time to single precision. A keyframe at the unrounded time could
    # be later, and would then take effect a frame late.
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
            return "Blender allows no keyframes on it: if it is a library override, make it local"
        if found[0].group is not None and found[0].group.mute:
            return f"its group of F-curves '{found[0].group.name}' is muted: unmute it"
        _fill(found[0], frames[changed], values[changed])
    return ""


def _changes(values: Any) -> Any:
    """Return the indices of all finite values that differ from the finite value before, (n,).

    The first finite value counts as a change.
    """
    known = np.flatnonzero(np.isfinite(values))
    differs = np.diff(values[known]) != 0.0
    return known[np.concatenate(([True], differs))] if len(known) else known


def _fill(curve: Any, frames: Any, values: Any) -> None:
    """Replace all keyframes of an F-curve by keyframes at `frames` (n,) with `values` (n,)."""
    curve.mute = False
    points = curve.keyframe_points
    points.clear()
    points.add(len(frames))
    points.foreach_set("co", np.column_stack((frames, values)).astype(np.float32).ravel())
    points.foreach_set("interpolation", np.full(len(frames), CONSTANT, np.int32))
    curve.update()
