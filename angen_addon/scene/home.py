# SPDX-License-Identifier: GPL-3.0-or-later
"""The solids of a scene at one frame, in metres: their triangles, and rays among them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array
from .instances import Uid
from .rays.caster import RayCaster
from .rays.geometry import triangles_of
from .rays.solids import Solid
from .sensors import unit_scale


@dataclass(frozen=True)
class SolidSurface:
    """A solid's corners (n, 3) in m in the world, and triangles (m, 3) that face outwards."""

    solid: Solid
    points: Array
    triangles: NDArray[np.int32]


class EvaluatedHome:
    """The scene as a depsgraph has it evaluated; `metres` in a unit of Blender. `rows` (k,) are the
    solids that rays of nobody in particular meet: all, if it is not a part."""

    def __init__(self, depsgraph: Any) -> None:
        self.depsgraph = depsgraph
        self.metres = unit_scale(depsgraph.scene)
        self.caster = RayCaster()
        self.caster.update(depsgraph)
        solids = self.caster.solids
        # (n, 3) in m: bounds of all solids.
        self.lo, self.hi = solids.lo * self.metres, solids.hi * self.metres
        self.rows = np.arange(len(solids.solids))

    def part(self, wanted: Callable[[Solid], bool]) -> EvaluatedHome:
        """The same home for rays that meet only the wanted solids."""
        found, solids = copy(self), self.caster.solids.solids
        found.rows = np.array([row for row in self.rows.tolist() if wanted(solids[row])], np.intp)
        return found

    def cast(
        self, sensor: Uid, bundle: int, origins: Array, directions: Array, length: Array
    ) -> Array:
        """Ranges (n,) in m of rays in m, as a sensor of this session uid casts them."""
        return (
            self.caster.cast(
                sensor, bundle, origins / self.metres, directions, length / self.metres
            )
            * self.metres
        )

    def surfaces(self, wanted: NDArray[np.bool_]) -> Iterator[SolidSurface]:
        """The surfaces of those solids that a mask (n,) chooses.

        They are read as Blender lists them: what geometry nodes make lives no longer than that.
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
            # Curves that share their data may have modifiers of their own.
            shape = seen.original.session_uid, seen.data.as_pointer()
            if shape not in shapes:
                shapes[shape] = triangles_of(seen)
            points, triangles = shapes[shape]
            matrix = solids.matrix[solid.row]
            with np.errstate(all="ignore"):
                placed = (points @ matrix[:3, :3].T + matrix[:3, 3]) * self.metres
                mirrored = float(np.linalg.det(matrix[:3, :3])) < 0.0
            yield SolidSurface(solid, placed, triangles[:, ::-1] if mirrored else triangles)
