# SPDX-License-Identifier: GPL-3.0-or-later
"""The outputs `active` and `value` of a sensor, which panels show and drivers read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from ...sensor_logic.recording.tracks import Recording
from ..scene.animation import all_animated, curves
from ..scene.sensors import Sensor

ACTIVE_PATH = "angen_sensor.active"
VALUE_PATH = "angen_sensor.value"


def show(sensor: Sensor, active: bool, value: float) -> bool:
    """Writes the outputs where they differ, so that drivers see them; True if `active` changed.

    Keyed outputs are left alone: their keys say what they are; so are those of sensors in
    collection instances, which have one object between them. In a frame change Blender
    evaluates what is tagged here before it goes on, and tells nobody. A rigid body is never tagged,
    so that its drivers do not follow: Blender would take it for moved and drop the simulation.
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
    """Shows what was recorded at or before `frame`."""
    tracks = {track.uid: track for track in recording.tracks.values()}
    for sensor in sensors:
        track = tracks.get(sensor.uid)
        index = track.at(frame) if track else None
        if track is not None and index is not None:
            show(sensor, bool(track.active[index]), track.value[index])


def output_curves(obj: Any) -> list[Any]:
    """The F-curves that set the outputs."""
    return curves(obj, {ACTIVE_PATH, VALUE_PATH})


def are_driven(*paths: str) -> bool:
    """Whether any driver of the file reads outputs, or what else of sensors begins with these data
    paths."""
    starts = paths or (ACTIVE_PATH, VALUE_PATH)
    return any(target.data_path.startswith(starts) for target in _driver_targets())


def read_by_drivers(sensors: Iterable[Sensor]) -> list[Sensor]:
    """Those of the sensors whose outputs a driver of the file reads: the scene depends on them."""
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
