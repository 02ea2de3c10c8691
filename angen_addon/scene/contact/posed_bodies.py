# SPDX-License-Identifier: GPL-3.0-or-later
"""The surface and centre of mass of animated bodies, and of loose pads, at one frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ....sensor_logic.contact import underside
from ....sensor_logic.contact.world import Support
from ....sensor_logic.model import Array
from ..rays.solids import Solid, Solids
from .contact_bodies import ContactBody
from .parallel_rays import ParallelRays


@dataclass(frozen=True, eq=False)
class PosedPart:
    """A solid of a body: vertices (n, 3) and triangles (m, 3) in its own space, and its matrix;
    `state`: the same object for as long as its surface is the same."""

    state: Any
    vertices: np.typing.NDArray[np.float32]
    corners: np.typing.NDArray[np.int32]
    matrix: Array


class PosedBody:
    """A body as it is at one frame; `lo`, `hi` (3,) are its bounds in metres.

    While it does not move it stays the same object from frame to frame, and keeps the results of
    the search for its supports, each with what it depends on: `supports`; samples of the
    `underside` and the room above each; `down`: the rays from there; `gaps`: how far below each
    solid is, by number. Without them a person who sits still costs as much as one who walks.
    """

    def __init__(
        self, parts: list[PosedPart], closed: bool, metres: float, lo: Array, hi: Array
    ) -> None:
        self.parts = parts
        self.closed = closed
        self.lo, self.hi = lo, hi
        self.supports: tuple[list[Any], list[Support]] | None = None
        self.underside: tuple[list[Any], underside.Samples, Array] | None = None
        self.gaps: dict[int, tuple[tuple[int, float], Array]] = {}
        self.down: tuple[float, ParallelRays] | None = None
        self._metres = metres

    @cached_property
    def triangles(self) -> Array:
        """(n, 3, 3) in metres."""
        found = []
        for part in self.parts:
            world = part.vertices @ part.matrix[:3, :3].T + part.matrix[:3, 3]
            triangles = world[part.corners] * self._metres
            mirrored = np.linalg.det(part.matrix[:3, :3]) < 0.0
            found.append(triangles[:, ::-1] if mirrored else triangles)
        triangles = np.concatenate(found)
        if np.isfinite(triangles.sum()):
            return triangles
        return triangles[np.isfinite(triangles).all(axis=(1, 2))]

    @cached_property
    def centre(self) -> Array:
        """(3,) m: its centre of mass, for an even density."""
        return underside.centre_of_mass(self.triangles, self.closed)


def posed_body(
    depsgraph: Any, body: ContactBody, solids: Solids, metres: float, last: PosedBody | None
) -> PosedBody | None:
    """The body as the solids are now: `last` where nothing changed; None without a surface."""
    now = [value for solid in body.solids for value in surface_state(solid, solids)]
    if last is not None:
        before = [value for part in last.parts for value in (part.state, part.matrix)]
        if unchanged(before, now):
            return last
    rows = [solid.row for solid in body.solids]
    if not rows:
        return None
    lo, hi = solids.lo[rows].min(axis=0) * metres, solids.hi[rows].max(axis=0) * metres
    if not (lo <= hi).all():
        return None
    parts = []
    for solid in body.solids:
        corners = solid.geometry.triangles(depsgraph)
        state, matrix = surface_state(solid, solids)
        parts.append(PosedPart(state, solid.geometry.vertices, corners, matrix))
    return PosedBody(parts, body.is_closed([part.corners for part in parts]), metres, lo, hi)


def surface_state(solid: Solid, solids: Solids) -> list[Any]:
    """A solid's surface and matrix, to be compared by `unchanged`."""
    return [solid.geometry.state, solids.matrix[solid.row].copy()]


def unchanged(one: list[Any], two: list[Any]) -> bool:
    """Whether two lists hold equal arrays, and otherwise the very same objects."""
    return len(one) == len(two) and all(
        a is b or (isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and bool((a == b).all()))
        for a, b in zip(one, two, strict=True)
    )
