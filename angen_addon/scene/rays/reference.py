# SPDX-License-Identifier: GPL-3.0-or-later
"""Cast each ray with Blender's `scene.ray_cast`, as a reference for tests of `RayCaster`."""

from __future__ import annotations

from typing import Any

import numpy as np
from mathutils import Vector

from ....sensor_logic.model import Answers, Array, Index
from ..capture import Capture, Frames
from ..instances import Uid
from .caster import Rays
from .solids import Solids

# Blender units. A ray that passes through an object starts again this far behind the hit. The
# distance is larger than the rounding of single precision.
STEP = 1e-6
STEP_ROUNDINGS = 8


class SceneRayCaster:
    """A slow ray caster with the interface of `RayCaster`.

    It casts one ray at a time in world space, in single precision.
    """

    def __init__(self, scene: Any) -> None:
        self.solids = Solids()
        self.capture = Capture(self.solids, single=True)
        self.frames = Frames.unchanged(self.solids)
        self._scene = scene
        self._listing = -1
        self._rows: dict[int, list[int]] = {}

    def update(self, depsgraph: Any) -> None:
        """Read the evaluated scene. Call this after each evaluation, before casting rays."""
        self.show(self.capture.read(depsgraph))

    def show(self, frames: Frames) -> None:
        """Set the frame at which later calls cast rays. It must be the present frame."""
        self.frames = frames
        if self._listing != self.solids.listing:
            self._listing = self.solids.listing
            self._rows = {}
            for row, solid in enumerate(self.solids.solids):
                self._rows.setdefault(solid.key[0], []).append(row)

    def cast(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Array:
        """Return the ranges (n,) of rays at the present frame, as `RayCaster.cast` does."""
        rays = zip(origins, directions, length.tolist(), strict=True)
        return np.array([self._cast_one(sensor, o, d, limit) for o, d, limit in rays])

    def cast_at(self, sensor: Uid, bundle: int, rays: Rays, frames: Index) -> Answers:
        """Return the ranges of rays at the present frame, repeated for each of `frames`."""
        ranges = self.cast(sensor, bundle, *rays)
        return Answers(ranges[None], np.zeros(len(frames), np.intp))

    def _cast_one(self, sensor: Uid, origin: Array, direction: Array, limit: float) -> float:
        start, way = Vector(origin), Vector(direction)
        passed = 0.0
        while passed < limit:
            hit, place, _, _, seen, matrix = self._scene.ray_cast(
                self.frames.depsgraph, start, way, distance=limit - passed
            )
            if not hit:
                return limit
            passed += (place - start).length
            if self._counts(sensor, seen, matrix):
                return min(passed, limit)
            largest = max(1.0, *(abs(c) for c in place))
            step = max(STEP, STEP_ROUNDINGS * float(np.spacing(np.float32(largest))))
            passed += step
            start = place + way * step
        return limit

    def _counts(self, sensor: Uid, seen: Any, matrix: Any) -> bool:
        """Return whether the hit object is a solid that stops the sensor's rays."""
        uid = seen.original.session_uid
        rows = self._rows.get(uid, ())
        solids = self.solids.solids
        if uid not in self.solids.instanced:
            return not all(solids[row].is_passed_by(sensor) for row in rows)
        here = np.array(matrix, np.float64)
        for row in rows:
            if np.allclose(self.solids.matrix[row], here, rtol=1e-6, atol=1e-6):
                return not solids[row].is_passed_by(sensor)
        return False
