# SPDX-License-Identifier: GPL-3.0-or-later
"""Where sensor models meet the scene: one station senses for one sensor."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import bpy
import numpy as np

from ..sensor_logic.clock import Clock, Schedule
from ..sensor_logic.model import Array, Emission, PadContact, Pose, Reading, Update
from ..sensor_logic.noise import generator
from ..sensor_logic.sweep import Passes
from .animation import is_animated, stays
from .probes import Probes
from .scene_probe.light.probe import LightRequest
from .scene_probe.moments import gravity_of
from .scene_probe.sweep import TOLERANCE, Beam, Moment
from .sensors import (
    Sensor,
    check_evaluated,
    decimal,
    names_others,
    read_parameters,
    read_pose,
    unit_scale,
)

# N: the weight of a sensor that feels none.
NOTHING = np.zeros(3)


def clock_of(scene: Any) -> Clock:
    """The scene's time base: t = 0 at its start frame."""
    render = scene.render
    return Clock(scene.frame_start, render.fps, render.fps_base, scene.angen_substeps)


def frames_to_run(scene: Any) -> tuple[int, int]:
    """First and last frame that a user wants to see: the preview range, where one is set."""
    if scene.use_preview_range:
        return scene.frame_preview_start, scene.frame_preview_end
    return scene.frame_start, scene.frame_end


def ends_before_time(scene: Any, first: int, last: int) -> str:
    """What the user is told of frames before the scene's first."""
    return (
        f"frames {first}:{last} end before the scene's start, frame {scene.frame_start}, "
        "where time begins"
    )


@dataclass(frozen=True)
class Read:
    """What was read of a sensor when the probes had `heard` so much, at a unit scale."""

    heard: int
    metres: float
    parameters: Any
    pose: Pose


@dataclass(frozen=True)
class Swept:
    """Where a beam was swept to last: the step, the sensor's pose and where its rays start, both
    of which are the same objects as long as it stands still, its beam, and the solids."""

    step: int
    pose: Pose
    origins: Array
    beam: Beam
    moment: Moment


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
        self.uid = sensor.uid
        self._steady = sensor.kind.light and all(
            stays(part, "angen_sensor.light.") for part in (sensor.object, *sensor.holders)
        )
        self.schedule = Schedule(clock, decimal(sensor.settings.update_rate))
        self._changes: Probes | None = None
        self.reset()

    def heed(self, changes: Probes) -> None:
        """From now on the sensor is read anew only where these heard of a change of it."""
        self._changes = changes

    def reset(self) -> None:
        """Forgets earlier updates, as after a jump of the playhead."""
        self.model = self.sensor.kind.model()
        self._pose: tuple[Any, float, Pose] | None = None
        self._read: Read | None = None
        self._swept: Swept | None = None

    @property
    def watches(self) -> bool:
        """Whether the sensor looks at the steps between its updates too, at some frame at least."""
        attribute = self.sensor.kind.attribute
        group = getattr(self.sensor.settings, attribute)
        return hasattr(group, "swept") and (
            group.swept or is_animated(self.sensor.object, f"angen_sensor.{attribute}.swept")
        )

    def watch(self, step: int, depsgraph: Any, probes: Probes) -> None:
        """Looks at a step between two updates. Raises SensorError."""
        taken = self.take(self.schedule.last_update(step) + 1, step, depsgraph, probes)
        if taken is not None:
            self.model.watch(taken.parameters, taken.update)

    def take(self, number: int, step: int, depsgraph: Any, probes: Probes) -> Taken | None:
        """Update `number` at the scene's present state; None while the sensor is switched off.

        Raises SensorError.
        """
        scene = depsgraph.scene
        metres = unit_scale(scene)
        evaluated = self.sensor.object.evaluated_get(depsgraph)
        read = self._read_now(evaluated, metres, depsgraph)
        if read is None:
            self.reset()
            return None
        parameters, pose = read.parameters, read.pose

        def cast(bundle: int, origins: Array, directions: Array, length: Array) -> Array:
            if metres == 1.0:
                return probes.caster.cast(self.uid, bundle, origins, directions, length)
            in_units = origins / metres, directions, length / metres
            return probes.caster.cast(self.uid, bundle, *in_units) * metres

        def warmth(bundle: int, origins: Array, directions: Array, length: Array) -> Emission:
            in_units = origins / metres, directions, length / metres
            return probes.warmth.see(depsgraph, self.uid, bundle, *in_units)

        def sweep(origins: Array, directions: Array, length: Array) -> Passes | None:
            rays = origins, directions, length
            return self._sweep(step, pose, rays, metres, depsgraph, probes)

        def noise() -> np.random.Generator:
            return generator(scene.angen_seed, self.sensor.name, number)

        def part() -> np.random.Generator:
            return generator(scene.angen_seed, f"{self.sensor.name}, part", 0)

        weight, chosen = NOTHING, None
        if self.sensor.kind.motion:
            weight, chosen = own_weight(evaluated, scene, metres), partners(evaluated)

        def contact() -> PadContact:
            forces = probes.forces(self.uid, self.clock.frame_and_subframe(step)[0])
            return PadContact(forces, weight, chosen)

        update = Update(
            number,
            self.clock.step_time(step),
            pose,
            cast,
            noise,
            part,
            contact,
            lambda: probes.light(self.sensor.name),
            warmth,
            sweep,
        )
        request = None
        if self.sensor.kind.light:
            request = light_request(self.sensor.name, parameters, pose, metres, self._steady)
        return Taken(self, step, parameters, update, request)

    def _sweep(
        self,
        step: int,
        pose: Pose,
        rays: tuple[Array, Array, Array],
        metres: float,
        depsgraph: Any,
        probes: Probes,
    ) -> Passes | None:
        """What went through these rays since the step before; None if nobody looked then."""
        before, (origins, directions, length) = self._swept, rays
        if before is not None and before.pose is pose and before.origins is origins:
            beam = before.beam
        else:
            matrix = matrix_of(pose, metres)
            beam = Beam(matrix, origins / metres, directions, length / metres)
        self._swept = Swept(step, pose, origins, beam, probes.sweeper.moment())
        if before is None or before.step != step - 1:
            return None
        found = probes.sweeper.sweep(
            depsgraph, self.uid, before.moment, before.beam, beam, TOLERANCE / metres
        )
        if metres == 1.0 or not len(found):
            return found
        return replace(found, near=found.near * metres, far=found.far * metres)

    def _read_now(self, evaluated: Any, metres: float, depsgraph: Any) -> Read | None:
        """The parameters and the pose; None while the sensor is switched off. Raises SensorError.

        What Blender has not evaluated anew since need not be read again. Whether it names values
        that are animated or driven differs between versions: these are always read.
        """
        known, changes = self._read, self._changes
        if (
            changes is not None
            and known is not None
            and known.metres == metres
            and changes.untouched(self.uid, known.heard)
        ):
            return known
        self._read = None
        if not evaluated.angen_sensor.enabled:
            return None
        check_evaluated(self.sensor, evaluated)
        parameters = read_parameters(self.sensor, evaluated.angen_sensor)
        heard = changes.heard if changes is not None else 0
        matrix = self.sensor.world_matrix(depsgraph)
        read = Read(heard, metres, parameters, self._pose_now(matrix, metres))
        if self._is_still and not names_others(self.sensor, parameters):
            self._read = read
        return read

    @property
    def _is_still(self) -> bool:
        """Whether Blender names it, or what it stands in, at each change of it."""
        parts = (self.sensor.object, *self.sensor.holders)
        return all(part.animation_data is None for part in parts)

    def _pose_now(self, matrix: Any, metres: float) -> Pose:
        """The pose, the same object as long as the sensor stands still."""
        known = self._pose
        if known is None or known[0] != matrix or known[1] != metres:
            known = (matrix.copy(), metres, read_pose(self.sensor, matrix, metres))
            self._pose = known
        return known[2]


def matrix_of(pose: Pose, metres: float) -> Array:
    """The matrix (4, 4) of a pose, without scale, in Blender units."""
    matrix = np.eye(4)
    matrix[:3, :3] = pose.axes
    matrix[:3, 3] = pose.origin / metres
    return matrix


def light_request(
    name: str, parameters: Any, pose: Pose, metres: float, steady: bool
) -> LightRequest:
    """What a light sensor with these parameters asks of the scene, in Blender units."""
    return LightRequest(
        name,
        matrix_of(pose, metres),
        parameters.method,
        parameters.engine,
        parameters.samples,
        parameters.clip_start / metres,
        parameters.clip_end / metres,
        parameters.field_of_view,
        parameters.exposure,
        steady,
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
