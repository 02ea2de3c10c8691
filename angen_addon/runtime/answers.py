# SPDX-License-Identifier: GPL-3.0-or-later
"""What answers the questions of sensor models about the scene, each under its name.

A new physical quantity is one function here, by the name under which kinds say that they need it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...sensor_logic.error import AngenError
from ...sensor_logic.geometry.sweep import RayCrossings
from ...sensor_logic.kind import CROSSINGS, FORCES, LIGHT, POSES, RAYS, REFLECTANCE, WARMTH
from ...sensor_logic.model import Answers, Array, Index, PadContact, Pose, pose_from_matrix
from ...sensor_logic.parameters import specs
from ..scene.contact.frame_state import gravity_of
from ..scene.instances import shown_in, within
from ..scene.light.probe import LightRequest
from ..scene.placed import NotPlaced, placed_matrix
from ..scene.rays.sweep import TOLERANCE, SweptRays
from ..scene.sensors import Sensor
from .trace import Question, Swept


def ranges(
    asked: Question,
    bundle: int,
    origins: Array,
    directions: Array,
    length: Array,
    which: Index | None = None,
) -> Answers:
    """How far rays get."""
    frames = asked.frames if which is None else asked.frames[which]
    metres, cast = asked.read.metres, asked.probes.caster.cast_at
    if metres == 1.0:
        found = cast(asked.sensor.uid, asked.bundle(bundle), origins, directions, length, frames)
    else:
        in_units = origins / metres, directions, length / metres
        found = cast(asked.sensor.uid, asked.bundle(bundle), *in_units, frames)
        found = Answers([ranges * metres for ranges in found.table], found.rows)
    return found


def surfaces(
    name: str,
    asked: Question,
    bundle: int,
    origins: Array,
    directions: Array,
    length: Array,
    which: Index | None = None,
) -> Answers:
    """What the probe called `name` knows of the surfaces that rays meet."""
    frames = asked.frames if which is None else asked.frames[which]
    metres, probe = asked.read.metres, getattr(asked.probes, name)
    known = asked.sensor.uid, asked.bundle(bundle)
    rays = origins / metres, directions, length / metres
    found: Answers = probe.see(asked.depsgraph, *known, *rays, frames)
    return found


def poses(asked: Question, name: str, which: Index | None = None) -> Answers:
    """Where the object is that a parameter names; None where it names none."""
    assert asked.read.beside is not None
    count = len(asked.steps) if which is None else len(which)
    return Answers([asked.read.beside[POSES][name]], np.zeros(count, np.intp))


def crossings(
    asked: Question, origins: Array, directions: Array, length: Array, which: Index | None = None
) -> Answers:
    """What went through rays since the step before."""
    chosen = np.arange(len(asked.steps)) if which is None else which
    rays = origins, directions, length
    found = [_swept_at(asked, asked.steps[i], int(asked.frames[i]), rays) for i in chosen.tolist()]
    return Answers(found, np.arange(len(found)))


def _swept_at(
    asked: Question, step: int, frame: int, rays: tuple[Array, Array, Array]
) -> RayCrossings | None:
    before, (origins, directions, length) = asked.trace.swept, rays
    pose, metres = asked.read.pose, asked.read.metres
    if before is not None and before.pose is pose and before.origins is origins:
        beam = before.beam
    else:
        beam = SweptRays(matrix_of(pose, metres), origins / metres, directions, length / metres)
    sweeper = asked.probes.sweeper
    now = sweeper.solids_at(frame)
    asked.trace.swept = Swept(step, pose, origins, beam, now)
    if before is None or before.step != step - 1:
        return None
    found = sweeper.sweep(
        asked.depsgraph, asked.sensor.uid, before.solids, now, before.beam, beam, TOLERANCE / metres
    )
    if metres == 1.0 or not len(found):
        return found
    return replace(found, near=found.near * metres, far=found.far * metres)


def contact(asked: Question, which: Index | None = None) -> Answers:
    """The forces on a pad, known after the frame that follows."""
    assert asked.read.beside is not None
    weight, chosen = asked.read.beside[FORCES]
    table: list[PadContact] = []
    rows = []
    for step in asked.steps:
        whole = asked.clock.frame_and_subframe(step)[0]
        forces = asked.probes.forces(asked.sensor.uid, whole)
        if not table or table[-1].forces is not forces:
            table.append(PadContact(forces, weight, chosen))
        rows.append(len(table) - 1)
    return Answers(table, np.array(rows, np.intp))


def light(asked: Question, which: Index | None = None) -> Answers:
    """The light on a sensor, once it was measured: the same at all the steps."""
    found = asked.probes.light(asked.sensor.name)
    return Answers([found], np.zeros(len(asked.steps), np.intp))


ANSWERS: dict[str, Callable[..., Answers]] = {
    RAYS: ranges,
    WARMTH: partial(surfaces, WARMTH),
    REFLECTANCE: partial(surfaces, REFLECTANCE),
    CROSSINGS: crossings,
    FORCES: contact,
    LIGHT: light,
    POSES: poses,
}


def beside_of(
    sensor: Sensor, evaluated: Any, depsgraph: Any, metres: float
) -> dict[str, Any] | None:
    """What a sensor's model asks of the scene at this very step."""
    found: dict[str, Any] = {}
    if sensor.kind.requires(FORCES):
        weight = _own_weight(evaluated, depsgraph.scene, metres)
        found[FORCES] = weight, _partners(sensor.parameters_in(evaluated))
    if sensor.kind.requires(POSES):
        found[POSES] = _named_poses(sensor, sensor.parameters_in(evaluated), depsgraph, metres)
    return found or None


def _named_poses(
    sensor: Sensor, settings: Any, depsgraph: Any, metres: float
) -> dict[str, Pose | None]:
    """Where the objects are that parameters point at, by the parameter; None where one points at
    nothing. In an instance those of its collection are where the instance shows them. Raises
    AngenError."""
    pointers = [n for n, s in specs(sensor.kind.parameters).items() if s.pointer == "Object"]
    found: dict[str, Pose | None] = {}
    for name in pointers:
        obj = getattr(settings, name)
        if obj is None:
            found[name] = None
            continue
        holders = sensor.holders
        beside = bool(holders) and obj.original in shown_in(holders[-1].instance_collection)
        try:
            matrix = placed_matrix(obj.original, depsgraph, beside)
        except NotPlaced as error:
            raise AngenError(f"'{sensor.name}': {error}") from None
        matrix = np.array(within(matrix, holders if beside else (), depsgraph))
        try:
            found[name] = pose_from_matrix(matrix, metres)
        except ValueError:
            # Of no size: it has a place nevertheless.
            found[name] = Pose(matrix[:3, 3] * metres, np.eye(3))
    return found


def _own_weight(evaluated: Any, scene: Any, metres: float) -> Array:
    """(3,) N: the weight of a pad, where it has a mass."""
    mass = evaluated.angen_load.mass
    if mass == 0.0 and evaluated.rigid_body is not None:
        mass = evaluated.rigid_body.mass
    return gravity_of(scene, metres)[0] * mass


def _partners(settings: Any) -> frozenset[int] | None:
    """Session uids of the objects that a pad measures alone; None: everything."""
    chosen, group = settings.partner_object, settings.partner_collection
    if chosen is None and group is None:
        return None
    found = {obj.original.session_uid for obj in group.all_objects} if group else set()
    return frozenset(found | ({chosen.original.session_uid} if chosen else set()))


def matrix_of(pose: Pose, metres: float) -> Array:
    """The matrix (4, 4) of a pose, without scale, in Blender units."""
    matrix = np.eye(4)
    matrix[:3, :3] = pose.axes
    matrix[:3, 3] = pose.origin / metres
    return matrix


def light_request(
    sensor: Sensor, parameters: Any, pose: Pose, metres: float, steady: bool
) -> LightRequest:
    """What a light sensor with these parameters asks of the scene, in Blender units."""
    return LightRequest(
        sensor.name,
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
