# SPDX-License-Identifier: GPL-3.0-or-later
"""What a run changes of the open home, all of which is put back, to the last bit, at its end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import bpy
import numpy as np
from mathutils import Euler, Matrix, Quaternion, Vector

from ...sensor_logic.error import AngenError
from ...sensor_logic.study.targets import POSE
from ..runtime.time_base import evaluated_depsgraph
from ..scene.animation import is_animated, motion_paths
from ..scene.sensors import Sensor, all_sensors, unit_scale

CHANNELS = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")
COMMON = ("enabled", "update_rate")
# Single precision at some metres from the origin.
SAME_PLACE = 1e-5


class Changes:
    """As a context; `make` changes, the end puts back."""

    def __init__(self) -> None:
        self._before: list[tuple[Any, str, Any]] = []

    def __enter__(self) -> Changes:
        return self

    def __exit__(self, *_: object) -> None:
        for owner, name, value in reversed(self._before):
            setattr(owner, name, value)
        if self._before:
            bpy.context.view_layer.update()

    def set(self, owner: Any, name: str, value: Any) -> None:
        before = getattr(owner, name)
        if isinstance(before, (Vector, Euler, Quaternion, Matrix)):
            before = before.copy()
        elif not isinstance(before, (bool, int, float, str, type(None), bpy.types.ID)):
            before = tuple(before)
        self._before.append((owner, name, before))
        setattr(owner, name, value)

    def make(self, settings: Mapping[str, Mapping[str, Any]]) -> None:
        """Sets parameters of sensors, and moves them. Raises AngenError."""
        sensors = {sensor.name: sensor for sensor in all_sensors(bpy.context.view_layer)}
        for name, values in settings.items():
            sensor = sensors[name]
            for parameter, value in values.items():
                if parameter not in POSE:
                    set_parameter(sensor, parameter, value, self.set)
            by = {key: float(values[key]) for key in POSE if values.get(key)}
            if by:
                self._move(sensor, by)
        bpy.context.view_layer.update()

    def _move(self, sensor: Sensor, by: Mapping[str, float]) -> None:
        """By metres along the home's axes, and radians about its own."""
        obj = sensor.object
        if sensor.holders or not obj.is_editable:
            raise AngenError(f"'{sensor.name}' is linked or in an instance, and cannot be moved")
        held = motion_paths(obj)
        if held:
            raise AngenError(f"'{sensor.name}' cannot be moved: it is animated or held ({held[0]})")
        bpy.context.view_layer.update()
        offset = Vector([by.get(f"move_{axis}", 0.0) for axis in "xyz"])
        turn = Euler([by.get(f"turn_{axis}", 0.0) for axis in "xyz"]).to_matrix().to_4x4()
        metres = unit_scale(bpy.context.scene)
        wanted = Matrix.Translation(offset / metres) @ obj.matrix_world @ turn
        for channel in CHANNELS:
            self.set(obj, channel, getattr(obj, channel))
        obj.matrix_world = wanted
        bpy.context.view_layer.update()
        reached = np.array(sensor.world_matrix(evaluated_depsgraph()))
        if not np.allclose(reached, np.array(wanted), atol=SAME_PLACE, rtol=SAME_PLACE):
            raise AngenError(f"'{sensor.name}' cannot be moved: something holds it")


def set_parameter(
    sensor: Sensor, parameter: str, value: Any, put: Callable[[Any, str, Any], object]
) -> None:
    """Has `put` set a parameter where the sensor has its settings. Raises AngenError."""
    common = parameter in COMMON
    group = sensor.settings if common else sensor.parameters
    path = f"angen_sensor.{parameter}"
    if not common:
        path = f"angen_sensor.{sensor.kind.attribute}.{parameter}"
    if getattr(group, parameter) == value:
        return
    if is_animated(sensor.object, path):
        raise AngenError(f"'{sensor.name}': {parameter} is animated or driven: clear that")
    if not sensor.object.is_editable:
        raise AngenError(f"'{sensor.name}' is linked: override it in the home, or vary there")
    try:
        put(group, parameter, value)
    except (TypeError, ValueError) as error:
        raise AngenError(f"'{sensor.name}': {parameter}: {error}") from None
