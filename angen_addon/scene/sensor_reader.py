# SPDX-License-Identifier: GPL-3.0-or-later
"""Read sensors at the present frame: their evaluated parameters and poses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...sensor_logic.kind import FORCES, POSES
from ...sensor_logic.logs.error import AngenError, explained
from ...sensor_logic.model import Array, Pose, pose_from_matrix
from ...sensor_logic.parameters import specs
from .animation import is_static
from .instances import shown_in, within
from .sensors import (
    NotPlaced,
    Sensor,
    check_evaluated,
    placed_matrix,
    read_parameters,
    read_pose,
    unit_scale,
)
from .units import gravity_of, kilograms


@dataclass(frozen=True)
class Read:
    """The parameters and the pose of a sensor, as read at one step.

    Attributes
    ----------
    metres
        Length of a Blender unit in m.
    seed
        The seed of the scene's random numbers.
    parameters, pose
        The parameters of the sensor's kind, and the pose in m.
    at_step
        Answers that can only be read while the scene is at this step, by the queried quantity. None
        if the sensor's kind needs no such answers.
    change
        A number that grows whenever the parameters or the pose change.
    """

    metres: float
    seed: int
    parameters: Any
    pose: Pose
    at_step: dict[str, Any] | None
    change: int = 0

    def same(self, other: Read) -> bool:
        """Return whether the values equal the values that were read at another step.

        Return false if either of the two has `at_step`.
        """
        mine = self.metres, self.seed, self.parameters
        same = mine == (other.metres, other.seed, other.parameters)
        return same and self.at_step is other.at_step is None and self.pose.same(other.pose)

    def rays_in_units(
        self, origins: Array, directions: Array, length: Array
    ) -> tuple[Array, Array, Array]:
        """Return rays in Blender units, from origins (n, 3) and lengths (n,) in m."""
        return origins / self.metres, directions, length / self.metres

    def in_metres(self, lengths: Array) -> Array:
        """Return lengths in m, from lengths in Blender units."""
        return lengths if self.metres == 1.0 else lengths * self.metres


class SensorReader:
    """Reads one sensor, and only what can have changed since it was read last."""

    def __init__(self, sensor: Sensor) -> None:
        self.sensor = sensor
        self._read: Read | None = None
        self._edits = self._changes = 0
        self._steady: bool | None = None

    @property
    def steady(self) -> bool:
        """Whether neither the parameters nor the pose of the sensor can change before an edit."""
        if self._steady is None:
            paths = (f"angen_sensor.{self.sensor.kind.attribute}.", "angen_sensor.enabled")
            parts = self.sensor.object, *self.sensor.holders
            self._steady = all(is_static(part, *paths, "hide_viewport") for part in parts)
        return self._steady

    def forget(self) -> None:
        """Read the sensor anew at the next call of `read`."""
        self._read = None

    def read(self, depsgraph: Any, edits: int) -> Read | None:
        """Return the parameters and the pose; None while the sensor is switched off.

        `edits` is the number of edits of the scene so far. Raise AngenError if the sensor cannot be
        read.
        """
        known, scene = self._read, depsgraph.scene
        metres, seed = unit_scale(scene), scene.angen_seed
        if self._edits != edits:
            self._edits, self._steady = edits, None
        elif (
            known is not None
            and (known.metres, known.seed) == (metres, seed)
            and known.at_step is None
            and self.steady
        ):
            return known
        self._read = None
        evaluated = self.sensor.object.evaluated_get(depsgraph)
        settings = self.sensor.settings_in(evaluated)
        if not settings.enabled:
            return None
        check_evaluated(self.sensor, depsgraph)
        parameters = read_parameters(self.sensor, settings)
        pose = read_pose(self.sensor, self.sensor.world_matrix(depsgraph), metres)
        at_step = _read_at_step(self.sensor, evaluated, depsgraph, metres)
        read = Read(metres, seed, parameters, pose, at_step, self._changes)
        if known is None or not known.same(read):
            self._changes += 1
            read = replace(read, change=self._changes)
        self._read = read
        return read


def _read_at_step(
    sensor: Sensor, evaluated: Any, depsgraph: Any, metres: float
) -> dict[str, Any] | None:
    """Return the answers that can only be read while the scene is at this step, by quantity.

    FORCES has the weight of a pad and the objects that it measures. POSES has the poses of the
    objects that parameters name. Return None if the model needs neither quantity. `evaluated` is
    the evaluated object of the sensor.
    """
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
    """Return the pose of the object in each parameter that takes an object, by parameter.

    The pose is None if the parameter is empty. For a sensor in a collection instance, it is the
    pose of the object's copy in the instance, if there is one. Raise AngenError if the pose cannot
    be read.
    """
    pointers = [n for n, s in specs(sensor.kind.parameters).items() if s.pointer == "Object"]
    found: dict[str, Pose | None] = {}
    for name in pointers:
        obj = getattr(settings, name)
        if obj is None:
            found[name] = None
            continue
        holders = sensor.holders
        beside = bool(holders) and obj.original in shown_in(holders[-1].instance_collection)
        with explained(f"'{sensor.name}'", NotPlaced, raised=AngenError):
            matrix = placed_matrix(obj.original, depsgraph, beside)
        matrix = np.array(within(matrix, holders if beside else (), depsgraph))
        try:
            found[name] = pose_from_matrix(matrix, metres)
        except ValueError:
            # An object scaled to zero still has a position.
            found[name] = Pose(matrix[:3, 3] * metres, np.eye(3))
    return found


def _own_weight(evaluated: Any, scene: Any, metres: float) -> Array:
    """Return the weight (3,) in N of a pad's own mass; zero without a mass."""
    mass = evaluated.angen_load.mass
    if mass == 0.0 and evaluated.rigid_body is not None:
        mass = kilograms(evaluated.rigid_body, metres)
    return gravity_of(scene, metres)[0] * mass


def _partners(settings: Any) -> frozenset[int] | None:
    """Return the session uids of the objects that a pad measures; None if it measures all."""
    chosen, group = settings.partner_object, settings.partner_collection
    if chosen is None and group is None:
        return None
    found = {obj.original.session_uid for obj in group.all_objects} if group else set()
    return frozenset(found | ({chosen.original.session_uid} if chosen else set()))
