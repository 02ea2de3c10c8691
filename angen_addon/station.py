# SPDX-License-Identifier: GPL-3.0-or-later
"""Where sensor models meet the scene: one station senses for one sensor."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ..sensor_logic.clock import Clock, Schedule
from ..sensor_logic.model import Array, Pose, Reading, Update
from ..sensor_logic.noise import generator
from . import state
from .scene_probe.rays import RayCaster
from .scene_probe.reference_rays import SceneRayCaster
from .sensors import Sensor, check_evaluated, decimal, read_parameters, read_pose, unit_scale

Caster = RayCaster | SceneRayCaster


def clock_of(scene: Any) -> Clock:
    """The scene's time base: t = 0 at its start frame."""
    render = scene.render
    return Clock(scene.frame_start, render.fps, render.fps_base, scene.angen_substeps)


def make_caster(scene: Any) -> Caster:
    """The ray caster that the scene chose, told of every change from now on."""
    caster = SceneRayCaster(scene) if scene.angen_ray_caster == "SCENE" else RayCaster()
    state.CACHE.watch(caster.solids)
    return caster


class Station:
    """A sensor with its schedule and the state of its model."""

    def __init__(self, sensor: Sensor, clock: Clock) -> None:
        self.sensor = sensor
        self.clock = clock
        self.schedule = Schedule(clock, decimal(sensor.settings.update_rate))
        self.reset()

    def reset(self) -> None:
        """Forgets earlier updates, as after a jump of the playhead."""
        assert self.sensor.kind.model is not None
        self._model = self.sensor.kind.model()
        self._pose: tuple[Any, float, Pose] | None = None

    def sense(self, number: int, step: int, depsgraph: Any, caster: Caster) -> Reading | None:
        """Update `number` at the scene's present state; None while the sensor is switched off.

        Raises SensorError.
        """
        scene = depsgraph.scene
        metres = unit_scale(scene)
        evaluated = self.sensor.object.evaluated_get(depsgraph)
        if not evaluated.angen_sensor.enabled:
            self.reset()
            return None
        check_evaluated(self.sensor, evaluated)
        parameters = read_parameters(self.sensor, evaluated.angen_sensor)

        def cast(bundle: int, origins: Array, directions: Array, length: Array) -> Array:
            if metres == 1.0:
                return caster.cast(self.sensor.uid, bundle, origins, directions, length)
            in_units = origins / metres, directions, length / metres
            return caster.cast(self.sensor.uid, bundle, *in_units) * metres

        def noise() -> np.random.Generator:
            return generator(scene.angen_seed, self.sensor.name, number)

        update = Update(
            number,
            self.clock.step_time(step),
            self._pose_now(evaluated, metres),
            cast,
            noise,
        )
        reading: Reading = self._model.update(parameters, update)
        return reading

    def _pose_now(self, evaluated: Any, metres: float) -> Pose:
        """The pose, the same object as long as the sensor stands still."""
        matrix = evaluated.matrix_world
        known = self._pose
        if known is None or known[0] != matrix or known[1] != metres:
            known = (matrix.copy(), metres, read_pose(self.sensor, matrix, metres))
            self._pose = known
        return known[2]


def evaluated_depsgraph() -> bpy.types.Depsgraph:
    """The evaluated scene of the present context, with pending edits applied."""
    return bpy.context.evaluated_depsgraph_get()
