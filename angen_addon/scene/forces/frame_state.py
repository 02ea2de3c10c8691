# SPDX-License-Identifier: GPL-3.0-or-later
"""The contact bodies of a scene at one frame, in metres."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.forces.world import Support
from ....sensor_logic.model import Array
from ..rays.solids import Solids
from ..units import gravity_of
from .bodies import MARGIN, BodySettings, ContactBodies, ContactBody, Key
from .posed_bodies import PosedBody, posed_body


class FrameState:
    """The n contact bodies at one frame.

    Attributes
    ----------
    frame
        The number of the frame.
    gravity
        Gravity (3,) in m/s².
    up
        The unit vector (3,) against gravity.
    row
        The index of each body in the arrays, by key.
    keys
        The keys in the order of the arrays.
    poses, scales
        Poses (n, 4, 4) and scales (n, 3); NaN for bodies that do not collide.
    lo, hi
        World bounds (n, 3), in m.
    posed
        The surfaces of animated bodies and loose pads, by key.
    supports, settings
        The supports and settings of the bodies near a pad that publishes at this frame, by key.
    missing_mass
        For each pad that publishes at this frame, by key: why a weight may not reach it, or "".
    """

    def __init__(
        self,
        frame: int,
        depsgraph: Any,
        bodies: ContactBodies,
        solids: Solids,
        metres: float,
        before: FrameState | None,
    ) -> None:
        self.frame = frame
        self.gravity, self.up = gravity_of(depsgraph.scene, metres)
        known = list(bodies.by_key.values())
        self.row, self.keys = bodies.row, bodies.keys
        matrices = _matrices(depsgraph, known, solids)
        self.poses, self.scales = _poses_and_scales(matrices, metres)
        self.lo, self.hi = _bounds(bodies, self.poses, self.scales, metres)
        self.posed: dict[Key, PosedBody] = {}
        self.supports: dict[Key, list[Support]] = {}
        self.settings: dict[Key, BodySettings] = {}
        self.missing_mass: dict[Key, str] = {}
        for row, body in enumerate(known):
            if not (body.animated or body.loose_pad):
                continue
            last = before.posed.get(body.key) if before else None
            posed = posed_body(depsgraph, body, solids, metres, last)
            if posed is None:
                continue
            self.posed[body.key] = posed
            reach = body.tolerance + MARGIN
            self.lo[row] = np.fmin(self.lo[row], posed.lo - reach)
            self.hi[row] = np.fmax(self.hi[row], posed.hi + reach)

    def overlapping(self, key: Key, widen: float, towards: Array | None = None) -> list[Key]:
        """Return the keys of the other bodies whose bounds overlap the bounds of a body.

        Parameters
        ----------
        key
            Key of the body.
        widen
            Distance in m by which the body's bounds are widened first.
        towards
            Vector (3,) in m along which the body's bounds are swept; None not to sweep them.
        """
        row = self.row[key]
        lo, hi = self.lo[row] - widen, self.hi[row] + widen
        if towards is not None:
            lo, hi = np.minimum(lo, lo + towards), np.maximum(hi, hi + towards)
        found = np.flatnonzero(((self.lo <= hi) & (self.hi >= lo)).all(axis=1))
        return [self.keys[other] for other in found.tolist() if other != row]


def _matrices(depsgraph: Any, bodies: list[ContactBody], solids: Solids) -> Array:
    matrices = np.full((len(bodies), 4, 4), np.nan)
    for index, body in enumerate(bodies):
        if not body.collides:
            continue
        row = solids.row_of(body.key)
        if row is not None:
            matrices[index] = solids.matrix[row]
        else:
            # Physics moves objects that are hidden in the viewport too.
            matrices[index] = np.array(body.original.evaluated_get(depsgraph).matrix_world)
    return matrices


def _poses_and_scales(matrices: Array, metres: float) -> tuple[Array, Array]:
    """Return the poses (n, 4, 4) in metres, and the scales (n, 3), of matrices (n, 4, 4).

    Poses are without scale. Matrices are decomposed as Blender does it.
    """
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


def _bounds(
    bodies: ContactBodies, poses: Array, scales: Array, metres: float
) -> tuple[Array, Array]:
    largest = scales.max(axis=1, initial=0.0)[:, None]
    middle = np.einsum("nij,nj->ni", poses[:, :3, :3], bodies.middle * scales * metres)
    middle += poses[:, :3, 3]
    half = (
        bodies.half * np.where(bodies.is_cubic[:, None], largest, scales) * metres + MARGIN * metres
    )
    around = np.einsum("nij,nj->ni", np.abs(poses[:, :3, :3]), half)
    return middle - around, middle + around
