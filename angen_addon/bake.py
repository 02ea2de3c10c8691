# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a recording as keyframes onto the sensors' `active` and `value`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..sensor_logic.recording import Recording, Track
from .sensors import Sensor

ACTIVE_PATH = "angen_sensor.active"
VALUE_PATH = "angen_sensor.value"


def bake(sensors: list[Sensor], recording: Recording) -> int:
    """Keys every change of the recorded sensors anew; returns how many sensors got keys.

    Linked sensors cannot be keyed and are passed over. Earlier keys of these outputs are
    replaced.
    """
    baked = 0
    for sensor in sensors:
        track = recording.tracks.get(sensor.name)
        if track is None or not len(track) or sensor.object.library:
            continue
        _clear(sensor.object)
        for path, column in ((ACTIVE_PATH, track.active), (VALUE_PATH, track.value)):
            for frame, value in _changes(track, column):
                _key(sensor.object, path, frame, value)
        _hold_values(sensor.object)
        baked += 1
    return baked


def _changes(track: Track, column: Any) -> Iterator[tuple[float, Any]]:
    last = None
    for frame, value in zip(track.frames, column, strict=True):
        if value != last:
            last = value
            yield frame, value


def _key(obj: Any, path: str, frame: float, value: Any) -> None:
    setattr(obj.angen_sensor, path.rpartition(".")[2], value)
    obj.keyframe_insert(path, frame=frame)


def output_curves(obj: Any) -> list[Any]:
    """The F-curves of the outputs; Blender 5 keeps them in layers, strips and channel bags."""
    animation = obj.animation_data
    if animation is None or animation.action is None:
        return []
    action = animation.action
    if hasattr(action, "fcurves"):
        curves = list(action.fcurves)
    else:
        curves = [
            curve
            for layer in action.layers
            for strip in layer.strips
            if (bag := strip.channelbag(animation.action_slot)) is not None
            for curve in bag.fcurves
        ]
    return [curve for curve in curves if curve.data_path in {ACTIVE_PATH, VALUE_PATH}]


def _clear(obj: Any) -> None:
    for curve in output_curves(obj):
        curve.keyframe_points.clear()


def _hold_values(obj: Any) -> None:
    """A reading stands until the next one: constant interpolation."""
    for curve in output_curves(obj):
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT"
        curve.update()
