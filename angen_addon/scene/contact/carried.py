# SPDX-License-Identifier: GPL-3.0-or-later
"""Animated bodies with a mass: their surface and centre of mass at one frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ....sensor_logic.contact import underside
from ....sensor_logic.contact.world import Standing
from ..rays.solids import Solid, Solids
from .columns import Columns
from .things import Thing

Array = np.typing.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Piece:
    """A part of a body: vertices (n, 3) and triangles (m, 3) in its own space, and its place."""

    state: Any
    vertices: np.typing.NDArray[np.float32]
    corners: np.typing.NDArray[np.int32]
    matrix: Array


class Body:
    """A body as it is at one frame; what costs time is worked out when first asked for.

    `lo`, `hi` (3,) are its bounds in metres; `stood`: what it stood on, and where that was;
    `beneath`: its underside as last looked at, and within which bounds that was; `below`: how far
    below that each solid is, by its number, and of which version of the solid that is true;
    `columns`: the rays that look there, and with which tolerance.
    """

    def __init__(
        self, pieces: list[Piece], closed: bool, metres: float, lo: Array, hi: Array
    ) -> None:
        self.pieces = pieces
        self.closed = closed
        self.lo, self.hi = lo, hi
        self.stood: tuple[list[Any], list[Standing]] | None = None
        self.beneath: tuple[list[Any], underside.Samples, Array] | None = None
        self.below: dict[int, tuple[tuple[int, float], Array]] = {}
        self.columns: tuple[float, Columns] | None = None
        self._metres = metres

    @cached_property
    def triangles(self) -> Array:
        """(n, 3, 3) in metres."""
        found = []
        for piece in self.pieces:
            world = piece.vertices @ piece.matrix[:3, :3].T + piece.matrix[:3, 3]
            triangles = world[piece.corners] * self._metres
            mirrored = np.linalg.det(piece.matrix[:3, :3]) < 0.0
            found.append(triangles[:, ::-1] if mirrored else triangles)
        triangles = np.concatenate(found)
        if np.isfinite(triangles.sum()):
            return triangles
        return triangles[np.isfinite(triangles).all(axis=(1, 2))]

    @cached_property
    def centre(self) -> Array:
        """(3,) its centre of mass, were it of one material."""
        return underside.centre_of_mass(self.triangles, self.closed)


def carried_body(
    depsgraph: Any, thing: Thing, solids: Solids, metres: float, last: Body | None
) -> Body | None:
    """The body of a thing as the solids are now: `last`, where nothing changed; None without a
    surface."""
    now = [part for solid in thing.surfaces for part in parts_of(solid, solids)]
    if last is not None:
        before = [part for piece in last.pieces for part in (piece.state, piece.matrix)]
        if same_parts(before, now):
            return last
    rows = [solid.row for solid in thing.surfaces]
    if not rows:
        return None
    lo, hi = solids.lo[rows].min(axis=0) * metres, solids.hi[rows].max(axis=0) * metres
    if not (lo <= hi).all():
        return None
    pieces = []
    for solid in thing.surfaces:
        corners = solid.geometry.triangles(depsgraph)
        state, matrix = parts_of(solid, solids)
        pieces.append(Piece(state, solid.geometry.vertices, corners, matrix))
    return Body(pieces, thing.is_closed([piece.corners for piece in pieces]), metres, lo, hi)


def parts_of(solid: Solid, solids: Solids) -> list[Any]:
    """What tells whether a solid is where and as it was: its surface and its place."""
    return [solid.geometry.state, solids.matrix[solid.row].copy()]


def same_parts(one: list[Any], two: list[Any]) -> bool:
    return len(one) == len(two) and all(
        a is b or (isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and bool((a == b).all()))
        for a, b in zip(one, two, strict=True)
    )
