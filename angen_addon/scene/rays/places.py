# SPDX-License-Identifier: GPL-3.0-or-later
"""The places and surfaces of all solids (objects that rays can hit) at single steps.

From the places at several steps, the speeds of surfaces are computed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....sensor_logic.model import Array
from ..capture import Frames
from .caster import RayCaster
from .geometry import Surface


@dataclass(frozen=True, eq=False)
class SolidPlaces:
    """The places of n solids at one step, of which m have moved at least once.

    Places at steps of one batch share all but the last two.

    Attributes
    ----------
    row
        The row of each solid, by its number, in order of the rows.
    still, shapes
        The matrices (n, 4, 4) to the world and the n surfaces, of solids that have never moved.
    column
        The columns of the other solids, by their rows.
    matrix
        The matrices (m, 4, 4) of the other solids.
    surfaces
        The surfaces of those that change shape, by their rows.
    """

    row: dict[int, int]
    still: Array
    shapes: list[Any]
    column: dict[int, int]
    matrix: Array
    surfaces: dict[int, Surface]
    _since: list[tuple[SolidPlaces, frozenset[int]]] = field(default_factory=list)

    def of(self, number: int) -> tuple[Array, Surface] | None:
        """Return the matrix and the surface of a solid, by its number; None if there is none."""
        row = self.row.get(number)
        if row is None:
            return None
        column = self.column.get(row)
        matrix = self.still[row] if column is None else self.matrix[column]
        return matrix, self._shape(row)

    def moved_since(self, earlier: SolidPlaces) -> frozenset[int]:
        """Return the numbers of the solids that moved or changed shape since earlier places.

        A solid that did not exist then has not moved.
        """
        if earlier is self:
            return frozenset()
        # Kept for the other sensors, and for later updates.
        if not self._since or self._since[0][0] is not earlier:
            self._since[:] = [(earlier, frozenset(self._find_moved(earlier)))]
        return self._since[0][1]

    def _find_moved(self, earlier: SolidPlaces) -> Iterator[int]:
        if self.row is not earlier.row:
            # The solids were listed anew.
            for number in self.row.keys() & earlier.row.keys():
                now, then = self.of(number), earlier.of(number)
                assert now is not None and then is not None
                if now[1] is not then[1] or not np.array_equal(now[0], then[0]):
                    yield number
            return
        numbers = list(self.row)
        if self.column is earlier.column:
            differs = (self.matrix != earlier.matrix).any(axis=(1, 2))
            moved = {row for row, column in self.column.items() if differs[column]}
            shapes = set(self.surfaces)
        else:
            differs = (self._matrices() != earlier._matrices()).any(axis=(1, 2))
            moved, shapes = set(np.flatnonzero(differs).tolist()), set(range(len(numbers)))
        moved |= {row for row in shapes if self._shape(row) is not earlier._shape(row)}
        yield from (numbers[row] for row in moved)

    def _matrices(self) -> Array:
        matrices = self.still.copy()
        matrices[list(self.column)] = self.matrix
        return matrices

    def _shape(self, row: int) -> Any:
        return self.surfaces.get(row, self.shapes[row])


class PlaceReader:
    """Reads the places of solids at the frames of a caster, once for all sensors."""

    def __init__(self, caster: RayCaster) -> None:
        self._caster = caster
        self._frames: Frames | None = None
        self._listing = -1
        self._row: dict[int, int] = {}
        self._still, self._shapes = np.empty((0, 4, 4)), list[Any]()
        self._at: dict[int, SolidPlaces] = {}

    def at(self, frame: int) -> SolidPlaces:
        """Return the places at one of the caster's frames, by its index."""
        solids, frames = self._caster.solids, self._caster.frames
        if self._frames is not frames:
            self._frames, self._at = frames, {}
            if self._listing != solids.listing:
                self._listing = solids.listing
                self._row = {solid.number: row for row, solid in enumerate(solids.solids)}
            self._still = solids.matrix.copy()
            self._shapes = [solid.geometry.state for solid in solids.solids]
        if frame not in self._at:
            surfaces = {row: each[frame] for row, each in frames.surfaces.items()}
            still = self._row, self._still, self._shapes
            matrix = frames.matrix[frame].copy()
            self._at[frame] = SolidPlaces(*still, frames.column, matrix, surfaces)
        return self._at[frame]
