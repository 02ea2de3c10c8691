# SPDX-License-Identifier: GPL-3.0-or-later
"""Where sensor models meet the scene: one station senses for one sensor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from ..sensor_logic.clock import Clock, Schedule
from ..sensor_logic.model import Array, Emission, PadContact, Pose, Reading, Update
from ..sensor_logic.noise import generator
from .probes import Probes
from .scene_probe.light import LightRequest
from .scene_probe.moments import gravity_of
from .sensors import Sensor, check_evaluated, decimal, read_parameters, read_pose, unit_scale


def clock_of(scene: Any) -> Clock:
    """The scene's time base: t = 0 at its start frame."""
    render = scene.render
    return Clock(scene.frame_start, render.fps, render.fps_base, scene.angen_substeps)


@dataclass(frozen=True)
class Taken:
    """An update of a sensor with all that is known of the scene at its step. Its reading is to be
    asked for once: at once; of a kind that needs the motion, after the next frame; of a light
    sensor, after its `request` was measured."""

    station: Station
    step: int
    parameters: Any
    update: Update
    request: LightRequest | None = None

    def reading(self) -> Reading:
        made: Reading = self.station.model.update(self.parameters, self.update)
        return made


class Station:
    """A sensor with its schedule and the state of its model."""

    def __init__(self, sensor: Sensor, clock: Clock) -> None:
        self.sensor = sensor
        self.clock = clock
        self.schedule = Schedule(clock, decimal(sensor.settings.update_rate))
        self.reset()

    def reset(self) -> None:
        """Forgets earlier updates, as after a jump of the playhead."""
        self.model = self.sensor.kind.model()
        self._pose: tuple[Any, float, Pose] | None = None

    def take(self, number: int, step: int, depsgraph: Any, probes: Probes) -> Taken | None:
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
                return probes.caster.cast(self.sensor.uid, bundle, origins, directions, length)
            in_units = origins / metres, directions, length / metres
            return probes.caster.cast(self.sensor.uid, bundle, *in_units) * metres

        def warmth(bundle: int, origins: Array, directions: Array, length: Array) -> Emission:
            in_units = origins / metres, directions, length / metres
            return probes.warmth.see(depsgraph, self.sensor.uid, bundle, *in_units)

        def noise() -> np.random.Generator:
            return generator(scene.angen_seed, self.sensor.name, number)

        def part() -> np.random.Generator:
            return generator(scene.angen_seed, f"{self.sensor.name}, part", 0)

        weight, chosen = np.zeros(3), None
        if self.sensor.kind.motion:
            weight, chosen = own_weight(evaluated, scene, metres), partners(evaluated)

        def contact() -> PadContact:
            forces = probes.forces(self.sensor.object, self.clock.frame_and_subframe(step)[0])
            return PadContact(forces, weight, chosen)

        update = Update(
            number,
            self.clock.step_time(step),
            self._pose_now(evaluated, metres),
            cast,
            noise,
            part,
            contact,
            lambda: probes.light(self.sensor.name),
            warmth,
        )
        request = None
        if self.sensor.kind.light:
            request = light_request(self.sensor.name, parameters, update.pose, metres)
        return Taken(self, step, parameters, update, request)

    def _pose_now(self, evaluated: Any, metres: float) -> Pose:
        """The pose, the same object as long as the sensor stands still."""
        matrix = evaluated.matrix_world
        known = self._pose
        if known is None or known[0] != matrix or known[1] != metres:
            known = (matrix.copy(), metres, read_pose(self.sensor, matrix, metres))
            self._pose = known
        return known[2]


def light_request(name: str, parameters: Any, pose: Pose, metres: float) -> LightRequest:
    """What a light sensor with these parameters asks of the scene, in Blender units."""
    matrix = np.eye(4)
    matrix[:3, :3] = pose.axes
    matrix[:3, 3] = pose.origin / metres
    return LightRequest(
        name,
        matrix,
        parameters.method,
        parameters.engine,
        parameters.samples,
        parameters.clip_start / metres,
        parameters.clip_end / metres,
        parameters.field_of_view,
        parameters.exposure,
    )


def own_weight(evaluated: Any, scene: Any, metres: float) -> Array:
    """(3,) N: the weight of a pad, where it has a mass."""
    mass = evaluated.angen_load.mass
    if mass == 0.0 and evaluated.rigid_body is not None:
        mass = evaluated.rigid_body.mass
    return gravity_of(scene, metres)[0] * mass


def partners(evaluated: Any) -> frozenset[int] | None:
    """Session uids of the objects that a pad measures alone; None: everything."""
    settings = evaluated.angen_sensor.pressure
    chosen, group = settings.partner_object, settings.partner_collection
    if chosen is None and group is None:
        return None
    found = {obj.original.session_uid for obj in group.all_objects} if group else set()
    return frozenset(found | ({chosen.original.session_uid} if chosen else set()))


def evaluated_depsgraph() -> bpy.types.Depsgraph:
    """The evaluated scene of the present context, with pending edits applied."""
    return bpy.context.evaluated_depsgraph_get()
