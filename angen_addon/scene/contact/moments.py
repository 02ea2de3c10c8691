# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the things of a scene are at one frame, in metres."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.contact.world import Standing
from ..rays.solids import Solids
from .carried import Body, carried_body
from .facts import Facts
from .things import MARGIN, Key, Thing, Things

Array = np.typing.NDArray[np.float64]


class Moment:
    """One frame: `poses` (n, 4, 4) and `scales` (n, 3) of the things that collide, world bounds
    `lo`, `hi` (n, 3) of all things, in the order of `row`; animated `bodies` by key, and what they
    are `standing` on, where it was asked for; `gravity` and the direction `up` (3,);
    `facts` of what was near a pad; `cut_off`: why a pad's weight may end before the pad."""

    def __init__(
        self,
        frame: int,
        depsgraph: Any,
        things: Things,
        solids: Solids,
        metres: float,
        before: Moment | None,
    ) -> None:
        self.frame = frame
        self.gravity, self.up = gravity_of(depsgraph.scene, metres)
        known = list(things.by_key.values())
        self.row, self.keys = things.row, things.keys
        matrices = _matrices(depsgraph, known, solids)
        self.poses, self.scales = _rigid(matrices, metres)
        self.lo, self.hi = _bounds(things, self.poses, self.scales, metres)
        self.bodies: dict[Key, Body] = {}
        self.standing: dict[Key, list[Standing]] = {}
        self.facts: dict[Key, Facts] = {}
        self.cut_off: dict[Key, str] = {}
        for row, thing in enumerate(known):
            if not (thing.carried or thing.laid):
                continue
            last = before.bodies.get(thing.key) if before else None
            body = carried_body(depsgraph, thing, solids, metres, last)
            if body is None:
                continue
            self.bodies[thing.key] = body
            reach = thing.tolerance + MARGIN
            self.lo[row] = np.fmin(self.lo[row], body.lo - reach)
            self.hi[row] = np.fmax(self.hi[row], body.hi + reach)

    def overlapping(self, key: Key, widen: float, towards: Array | None = None) -> list[Key]:
        """Things whose bounds come within `widen` of those of `key`, without itself; also of
        these moved by `towards` (3,)."""
        row = self.row[key]
        lo, hi = self.lo[row] - widen, self.hi[row] + widen
        if towards is not None:
            lo, hi = np.minimum(lo, lo + towards), np.maximum(hi, hi + towards)
        found = np.flatnonzero(((self.lo <= hi) & (self.hi >= lo)).all(axis=1))
        return [self.keys[other] for other in found.tolist() if other != row]


def gravity_of(scene: Any, metres: float) -> tuple[Array, Array]:
    """Gravity (3,) in m/s² as the simulation has it, and the upward unit vector (3,)."""
    gravity = np.array(scene.gravity, np.float64) * metres if scene.use_gravity else np.zeros(3)
    if scene.rigidbody_world is not None:
        gravity *= scene.rigidbody_world.effector_weights.gravity
    size = float(np.linalg.norm(gravity))
    return gravity, -gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])


def _matrices(depsgraph: Any, things: list[Thing], solids: Solids) -> Array:
    matrices = np.full((len(things), 4, 4), np.nan)
    for index, thing in enumerate(things):
        if not thing.collides:
            continue
        row = solids.row_of(thing.key)
        if row is not None:
            matrices[index] = solids.matrix[row]
        else:
            # Physics goes on for what the viewport hides.
            matrices[index] = np.array(thing.original.evaluated_get(depsgraph).matrix_world)
    return matrices


def _rigid(matrices: Array, metres: float) -> tuple[Array, Array]:
    """Poses without scale, in metres, and the scales, as Blender takes matrices apart."""
    linear = matrices[:, :3, :3]
    scales = np.linalg.norm(linear, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        mirrored = np.where(np.linalg.det(linear) < 0.0, -1.0, 1.0)
        turns = linear / scales[:, None, :] * mirrored[:, None, None]
    poses = np.zeros_like(matrices)
    poses[:, :3, :3] = turns
    poses[:, :3, 3] = matrices[:, :3, 3] * metres
    poses[:, 3, 3] = 1.0
    return poses, scales


def _bounds(things: Things, poses: Array, scales: Array, metres: float) -> tuple[Array, Array]:
    largest = scales.max(axis=1, initial=0.0)[:, None]
    middle = np.einsum("nij,nj->ni", poses[:, :3, :3], things.middle * scales * metres)
    middle += poses[:, :3, 3]
    half = things.half * np.where(things.even[:, None], largest, scales) * metres + MARGIN * metres
    around = np.einsum("nij,nj->ni", np.abs(poses[:, :3, :3]), half)
    return middle - around, middle + around
