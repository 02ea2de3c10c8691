# SPDX-License-Identifier: GPL-3.0-or-later
"""The solids of a scene at one frame, in metres: their triangles, and rays cast at them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Array
from ..instances import Uid
from ..rays.caster import RayCaster
from ..rays.geometry import triangles_of
from ..rays.solids import Solid
from ..sensors import unit_scale


@dataclass(frozen=True)
class SolidSurface:
    """The surface of a solid, in the world.

    Attributes
    ----------
    solid
        The solid: a visible object or instance.
    points
        Points (n, 3), in m.
    triangles
        Point indices (m, 3) of the triangles, which face outwards.
    """

    solid: Solid
    points: Array
    triangles: NDArray[np.int32]


class EvaluatedHome:
    """An evaluated scene in metres, at one frame.

    Attributes
    ----------
    metres
        The length of a Blender unit, in m.
    lo, hi
        World bounds (n, 3) of all n solids, in m.
    rows
        Rows (k,) of the solids that rays without a sensor may hit: all, or fewer in a `part`.
    """

    def __init__(self, depsgraph: Any) -> None:
        self.depsgraph = depsgraph
        self.metres = unit_scale(depsgraph.scene)
        self.caster = RayCaster()
        self.caster.update(depsgraph)
        solids = self.caster.solids

        self.lo, self.hi = solids.lo * self.metres, solids.hi * self.metres
        self.rows = np.arange(len(solids.solids))

    def part(self, wanted: Callable[[Solid], bool]) -> EvaluatedHome:
        """Return a copy in which `rows` has only the solids that the function `wanted` accepts."""
        found, solids = copy(self), self.caster.solids.solids
        found.rows = np.array([row for row in self.rows.tolist() if wanted(solids[row])], np.intp)
        return found

    def cast(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Array:
        """Return the ranges (n,) of a sensor's rays, in m.

        Parameters
        ----------
        sensor
            Session uid of the sensor; rays pass through the solids that belong to it.
        bundle
            Number of the bundle: rays that are cast together. Hits are stored for each bundle.
        origins
            Origins (n, 3), in m.
        directions
            Unit vectors (n, 3).
        length
            Maximum ranges (n,), in m.
        """
        return (
            self.caster.cast(
                sensor, bundle, origins / self.metres, directions, length / self.metres
            )
            * self.metres
        )

    def surfaces(self, wanted: NDArray[np.bool_]) -> Iterator[SolidSurface]:
        """Yield the surfaces of the solids that a mask (n,) selects.

        They are read while Blender lists the instances: afterwards it frees the meshes that
        geometry nodes made.
        """
        solids = self.caster.solids
        by_key = {s.key: s for s in solids.solids if wanted[s.row]}
        shapes: dict[tuple[int, int], tuple[Array, NDArray[np.int32]]] = {}
        for instance in self.depsgraph.object_instances:
            seen = instance.object
            key = (seen.original.session_uid,)
            if instance.is_instance:
                key += (instance.parent.original.session_uid, *instance.persistent_id)
            solid = by_key.pop(key, None)
            if solid is None:
                continue
            # Curves that share their data may have different modifiers.
            shape = seen.original.session_uid, seen.data.as_pointer()
            if shape not in shapes:
                shapes[shape] = triangles_of(seen)
            points, triangles = shapes[shape]
            matrix = solids.matrix[solid.row]
            with np.errstate(all="ignore"):
                placed = (points @ matrix[:3, :3].T + matrix[:3, 3]) * self.metres
                mirrored = float(np.linalg.det(matrix[:3, :3])) < 0.0
            yield SolidSurface(solid, placed, triangles[:, ::-1] if mirrored else triangles)
