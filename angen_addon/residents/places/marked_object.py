# SPDX-License-Identifier: GPL-3.0-or-later
"""The size and the surfaces of an object that is marked as a place, with its children."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.model import Array
from ...coverage.cells import finished, free_ways
from ...scene.home import EvaluatedHome
from ...scene.placed import placed_matrix

DOWN = np.array([0.0, 0.0, -1.0])


class MarkedObject:
    """`at` (3,) m is the object's origin; `points` (n, 3) m the corners of its surfaces and those
    of its children: none of an empty. `rows` (k,) are their solids. Raises NotPlaced."""

    def __init__(self, home: EvaluatedHome, obj: Any) -> None:
        self.obj = obj
        self.matrix = placed_matrix(obj, home.depsgraph).copy()
        self.at = np.array(self.matrix.translation) * home.metres
        uid = obj.session_uid
        self.home = home.part(lambda solid: uid in solid.owners)
        self.rows = self.home.rows
        wanted = np.zeros(len(home.caster.solids.solids), bool)
        wanted[self.rows] = True
        parts = [surface.points for surface in home.surfaces(wanted)] if len(self.rows) else []
        points = np.concatenate(parts) if parts else np.empty((0, 3))
        self.points = points[np.isfinite(points).all(axis=1)]

    @property
    def solid(self) -> bool:
        return bool(len(self.points))

    @property
    def middle(self) -> Array:
        """(3,) m: the middle of its bounding box, or its origin if it has no surface."""
        if not self.solid:
            return self.at
        middle: Array = (self.points.min(axis=0) + self.points.max(axis=0)) / 2.0
        return middle

    @property
    def size(self) -> float:
        """The largest side of its bounding box, m."""
        return float(np.ptp(self.points, axis=0).max()) if self.solid else 0.0

    def reach(self, way: Array) -> tuple[float, float]:
        """The least and the greatest distance (m) of its points along a direction (2,) from the
        world's origin."""
        if not self.solid:
            here = float(self.at[:2] @ way)
            return here, here
        along = self.points[:, :2] @ way
        return float(along.min()), float(along.max())

    def box(self, look: Array) -> tuple[Array, float, float]:
        """Its middle on the floor (2,), and how far it goes from there along a look and across
        (half its size), m."""
        across = np.array([-look[1], look[0]])
        near, far = self.reach(look)
        right, left = self.reach(across)
        middle: Array = look * (near + far) / 2.0 + across * (right + left) / 2.0
        return middle, (far - near) / 2.0, (left - right) / 2.0

    def heights(self, points: Array) -> Array:
        """(n,) m in the world: its top at points (n, 2); not a number where it is not."""
        if not self.solid:
            return np.full(len(points), np.nan)
        top, bottom = float(self.points[:, 2].max()) + 0.05, float(self.points[:, 2].min()) - 0.05
        starts = np.column_stack([points, np.full(len(points), top)])
        ranges = finished(free_ways(self.home, starts, DOWN, top - bottom))
        return np.where(ranges < top - bottom - 1e-6, top - ranges, np.nan)
