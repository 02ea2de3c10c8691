# SPDX-License-Identifier: GPL-3.0-or-later
"""Find where warm bodies rest on other solids: on a seat, a bed or the floor."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ....sensor_logic.model import Array, Index
from ....sensor_logic.warmth_left import CELL, Imprint, Place
from ..bearers import armatures, bearer
from ..rays.caster import NOTHING, RayCaster
from ..rays.solids import Solid, Solids

# m. A body touches a surface that is so far below its underside, or so far above it: people sink
# into cushions, and animations let them.
GAP, SUNK = 0.03, 0.12
# m. Of a body that stands or sits upright, so much above its lowest point is shoes or legs of
# furniture: they leave nothing. Upright is a body that is higher than it is long.
FEET = 0.12
# m. What is larger is no body.
LARGEST = 5.0


def body_of(solid: Solid) -> Any:
    """Return the object of the body that a solid belongs to; None if it belongs to no body.

    A body has a mass in the panel Weight on Sensors, or is bent by an armature.
    """
    bending = armatures(solid.original)
    return bearer(solid.original) or (bending[0] if bending else None)


class Bodies:
    """The warm bodies of a scene, and where they touch other solids.

    Parameters
    ----------
    caster
        The ray caster of the scene.
    warm
        The solids that have a temperature, with the highest temperature of each in K.
    """

    def __init__(self, caster: RayCaster, warm: Mapping[int, float]) -> None:
        self._caster = caster
        # The rows of the solids of each body, and its temperature in K.
        rows: dict[Any, list[int]] = defaultdict(list)
        self._skin: dict[Any, float] = {}
        for solid in caster.solids.solids:
            body = body_of(solid) if solid.number in warm else None
            if body is not None:
                rows[body.session_uid].append(solid.row)
                known = self._skin.get(body.session_uid, 0.0)
                self._skin[body.session_uid] = max(known, warm[solid.number])
        self._rows = {body: np.array(own, np.intp) for body, own in rows.items()}
        # Arrays see through housings: who sits on a pad warms the seat beneath it.
        others = [s.row for s in caster.solids.solids if not s.is_housing]
        every = np.concatenate([np.zeros(0, np.intp), *self._rows.values()])
        self._others = np.setdiff1d(np.array(others, np.intp), every)

    def __bool__(self) -> bool:
        return bool(self._rows)

    def contacts(self, metres: float, cold: Array) -> dict[Place, Imprint]:
        """Return where bodies touch solids, at the frame that the list of solids shows.

        Parameters
        ----------
        metres
            The length of a Blender unit in m.
        cold
            The temperature in K of each solid's surface, by the number of the solid.
        """
        found: dict[Place, list[Imprint]] = defaultdict(list)
        for body, rows in self._rows.items():
            points, hit = self._touched(metres, rows)
            for number in np.unique(hit).tolist():
                place, local = self._in_solid(number, points[hit == number], metres)
                excess = max(self._skin[body] - float(cold[number]), 0.0)
                found[place].append(Imprint(local, np.full(len(local), excess)))
        return {place: _joined(contacts) for place, contacts in found.items()}

    def _touched(self, metres: float, rows: Index) -> tuple[Array, Index]:
        """Return points (k, 3) at which a body touches other solids, and the solids' numbers.

        `rows` are those of the body's solids. Rays from its underside downwards find what it rests
        on.
        """
        solids, depsgraph = self._caster.solids, self._caster.frames.depsgraph
        size = (solids.hi[rows] - solids.lo[rows]).max(axis=0, initial=0.0)
        if not ((size >= 0.0) & (size * metres <= LARGEST)).all():
            return np.zeros((0, 3)), np.zeros(0, np.intp)
        start = np.concatenate([_samples(solids, depsgraph, row, metres) for row in rows.tolist()])
        start = _lowest(start[np.isfinite(start).all(axis=1)], CELL / metres)
        if size[2] > max(size[0], size[1]):
            start = start[start[:, 2] > solids.lo[rows, 2].min() + FEET / metres]
        start[:, 2] += SUNK / metres
        downwards = np.broadcast_to([0.0, 0.0, -1.0], start.shape)
        reach = np.full(len(start), (SUNK + GAP) / metres)
        far, hit = self._caster.first_hits(self._others, start, downwards, reach)
        start[:, 2] -= far
        return start[hit != NOTHING], hit[hit != NOTHING].astype(np.intp)

    def _in_solid(self, number: int, points: Array, metres: float) -> tuple[Place, Array]:
        solids = self._caster.solids
        row = next(solid.row for solid in solids.solids if solid.number == number)
        matrix = solids.matrix[row]
        axis = int(np.argmax(np.abs(matrix[2, :3]) / np.linalg.norm(matrix[:3, :3], axis=0)))
        return (number, axis), in_frame(matrix, solids.inverse[row], axis, points, metres)


def _samples(solids: Solids, depsgraph: Any, row: int, metres: float) -> Array:
    """Return points (k, 3) in the world on the surface of the solid in a `row` of the solids.

    Neighbouring points of a triangle are horizontally at most 0.6 `CELL` apart, where `CELL` is the
    side of a cell of a warm print. `metres` is the length of a Blender unit in m.
    """
    geometry, matrix = solids.solids[row].geometry, solids.matrix[row]
    points = geometry.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    corners = points[geometry.triangles(depsgraph)]
    corners = corners[np.isfinite(corners).all(axis=(1, 2))]
    sides = np.linalg.norm(np.diff(corners[:, [0, 1, 2, 0], :2], axis=1), axis=2)
    parts = np.ceil(sides.max(axis=1, initial=0.0) * metres / (0.6 * CELL)).astype(np.intp)
    found = [points]
    for count in np.unique(parts[parts > 1]).tolist():
        first, second = np.indices((count + 1, count + 1)).reshape(2, -1)
        inside = first + second <= count
        weights = np.stack([first, second, count - first - second])[:, inside] / count
        found.append(np.einsum("wk,twx->tkx", weights, corners[parts == count]).reshape(-1, 3))
    return np.concatenate(found)


def _lowest(points: Array, cell: float) -> Array:
    """Return the middle of each column of side `cell` with points (k, 3), and their lowest z."""
    # The parts of one body can be far apart: columns without points take no memory.
    columns = np.floor(points[:, :2] / cell).astype(np.int64)
    first = columns.min(axis=0, initial=0)
    across, along = (columns - first).T
    width = along.max(initial=0) + 1
    keys, which = np.unique(across * width + along, return_inverse=True)
    lowest = np.full(len(keys), np.inf)
    np.minimum.at(lowest, which, points[:, 2])
    middles = np.stack(np.divmod(keys, width), axis=1) + first + 0.5
    return np.column_stack([middles * cell, lowest])


def in_frame(matrix: Array, inverse: Array, axis: int, points: Array, metres: float) -> Array:
    """Return points (k, 3) of the world in m, along the axes of a solid: `axis` comes last.

    The solid's scale is left in, so that distances are those in the world. `matrix` and `inverse`
    (4, 4) lead from the solid to the world and back.
    """
    local = points @ inverse[:3, :3].T + inverse[:3, 3]
    local *= np.linalg.norm(matrix[:3, :3], axis=0) * metres
    return local[:, [i for i in range(3) if i != axis] + [axis]]


def _joined(contacts: Iterable[Imprint]) -> Imprint:
    return Imprint(*map(np.concatenate, zip(*contacts, strict=True)))
