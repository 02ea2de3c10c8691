# SPDX-License-Identifier: GPL-3.0-or-later
"""The outputs `active` and `value` of a sensor, which panels show and drivers read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from ...sensor_logic.recording.tracks import Recording
from .animation import all_animated, curves
from .sensors import Sensor

ACTIVE_PATH = "angen_sensor.active"
VALUE_PATH = "angen_sensor.value"


def show(sensor: Sensor, active: bool, value: float) -> bool:
    """Write new outputs to a sensor if they differ; return whether `active` changed.

    Outputs with keyframes are not written. Outputs of a sensor in a collection instance are not
    written either, because all instances share one object.

    The object is tagged, so that Blender evaluates drivers that read the outputs. During a frame
    change, this happens before the change ends, and Blender reports no update. The object of a
    rigid body is not tagged, because Blender would discard the cached simulation. Drivers then do
    not see its new outputs.
    """
    settings = sensor.settings
    changed = settings.active != active
    if not changed and abs(settings.value - value) <= 1e-6 * max(1.0, abs(value)):
        return False
    if sensor.holders or output_curves(sensor.object):
        return False
    settings.active = active
    settings.value = value
    if sensor.object.rigid_body is None:
        sensor.object.update_tag(refresh={"OBJECT"})
    return changed


def show_recorded(recording: Recording, sensors: Iterable[Sensor], frame: float) -> None:
    """Write the last outputs that were recorded at or before `frame` to the sensors."""
    tracks = {track.uid: track for track in recording.tracks.values()}
    for sensor in sensors:
        track = tracks.get(sensor.uid)
        index = track.at(frame) if track else None
        if track is not None and index is not None:
            show(sensor, bool(track.active[index]), track.value[index])


def output_curves(obj: Any) -> list[Any]:
    """Return the F-curves of an object that animate its outputs."""
    return curves(obj, {ACTIVE_PATH, VALUE_PATH})


def are_driven(*paths: str) -> bool:
    """Return whether any driver of the file reads an output of a sensor.

    If `paths` are given, look instead for drivers that read a data path that starts with one of
    `paths`.
    """
    starts = paths or (ACTIVE_PATH, VALUE_PATH)
    return any(target.data_path.startswith(starts) for target in _driver_targets())


def read_by_drivers(sensors: Iterable[Sensor]) -> list[Sensor]:
    """Return the part of the sensors whose outputs any driver of the file reads."""
    read = {
        target.id.session_uid
        for target in _driver_targets()
        if target.id is not None and target.data_path.startswith((ACTIVE_PATH, VALUE_PATH))
    }
    return [s for s in sensors if not s.holders and s.object.session_uid in read]


def _driver_targets() -> Iterator[Any]:
    for animated in all_animated():
        for curve in animated.animation_data.drivers:
            for variable in curve.driver.variables:
                yield from variable.targets
