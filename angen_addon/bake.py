# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a recording as keyframes onto the sensors' `active` and `value`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..sensor_logic.recording import Recording, Track
from .outputs import ACTIVE_PATH, VALUE_PATH, output_curves
from .sensors import Sensor


def bake(sensors: list[Sensor], recording: Recording) -> int:
    """Keys every change of the recorded sensors anew; returns how many sensors got keys.

    Linked sensors cannot be keyed and are passed over. Earlier keys of these outputs are
    replaced.
    """
    baked = 0
    for sensor in sensors:
        track = recording.track_of(sensor.uid)
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


def _clear(obj: Any) -> None:
    for curve in output_curves(obj):
        curve.keyframe_points.clear()


def _hold_values(obj: Any) -> None:
    """A reading stands until the next one: constant interpolation."""
    for curve in output_curves(obj):
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT"
        curve.update()
