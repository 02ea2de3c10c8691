# SPDX-License-Identifier: GPL-3.0-or-later
"""Bundles of rays, what each met when it was last cast, and which of them can now meet another
thing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from . import sections
from .solids import Solids

Array = NDArray[np.float64]


@dataclass
class Rays:
    """A bundle: origins (n, 3), unit directions (n, 3), how far they reach (n,)."""

    origins: Array
    directions: Array
    length: Array

    @cached_property
    def starts(self) -> Array:
        """(3, n): by axis, as numpy is quick with."""
        return np.ascontiguousarray(self.origins.T)

    @cached_property
    def inverse(self) -> Array:
        """(3, n): one over the directions."""
        with np.errstate(divide="ignore"):
            return 1.0 / np.ascontiguousarray(self.directions.T)

    @cached_property
    def plane(self) -> tuple[Array, Array] | None:
        """A point (3,) and the normal (3,) of the plane that all of them lie in, if they do."""
        return sections.plane_of(self.origins, self.directions)

    def are(self, origins: Array, directions: Array, length: Array) -> bool:
        """Whether it is of these arrays themselves."""
        return origins is self.origins and directions is self.directions and length is self.length

    def same(self, other: Rays) -> bool:
        return all(
            a is b or np.array_equal(a, b)
            for a, b in (
                (self.origins, other.origins),
                (self.directions, other.directions),
                (self.length, other.length),
            )
        )

    def box(self, ranges: Array) -> tuple[Array, Array]:
        """Bounds (3,), (3,) of the rays as far as `ranges`."""
        ends = self.origins + self.directions * ranges[:, None]
        both = np.concatenate([self.origins, ends])
        return both.min(axis=0), both.max(axis=0)


@dataclass
class Moving:
    """What a bundle meets among the moving solids `rows`, as they were at their `versions`: by row
    which rays and how far these go; and with the still ones, ranges and numbers (n,), which nobody
    may write to: they are handed out."""

    rows: NDArray[np.intp]
    versions: NDArray[np.int64]
    hits: dict[int, tuple[NDArray[np.intp], Array]]
    ranges: Array
    met: NDArray[np.int64]


@dataclass
class Bundle:
    """What a bundle meets among the still solids: ranges (n,), the numbers of the solids met (n,),
    and the box of the rays up to there. `gone_seen`: how much of `Solids.gone` is dealt with;
    `moving`: what of the moving ones it met last; `place`: in the `Watch`."""

    rays: Rays
    own: frozenset[int]
    ranges: Array
    met: NDArray[np.int64]
    box: tuple[Array, Array]
    gone_seen: int
    place: int
    moving: Moving | None = None


class Watch:
    """Which bundles can meet another thing than when they were last cast: those whose box a solid
    is in that has changed since, or that met such a one. Told for all of them in one go.

    A bundle's place in it is the index of its box `lo`, `hi` (b, 3), of the synchronisation at
    which it was cast, `seen` (b,), and of which moving solids it met, `hit` (b, m).
    """

    def __init__(self, solids: Solids) -> None:
        self._solids = solids
        self._listed = (-1, -1)
        self._looked = -1
        self._rows = np.empty(0, np.intp)
        self._column: dict[int, int] = {}
        self._lo, self._hi = np.empty((0, 3)), np.empty((0, 3))
        self._seen = np.empty(0, np.int64)
        self._hit = np.empty((0, 0), bool)
        self._stale: list[bool] = []

    def add(self) -> int:
        """The place of a new bundle."""
        self._lo = np.concatenate([self._lo, np.full((1, 3), np.inf)])
        self._hi = np.concatenate([self._hi, np.full((1, 3), -np.inf)])
        self._seen = np.append(self._seen, -1)
        self._hit = np.concatenate([self._hit, np.zeros((1, self._hit.shape[1]), bool)])
        self._stale.append(True)
        return len(self._stale) - 1

    def cast(self, bundle: Bundle) -> None:
        """Takes down that a bundle is as the solids are now."""
        self._follow()
        place, moving = bundle.place, bundle.moving
        self._lo[place], self._hi[place] = bundle.box
        self._seen[place] = self._solids.syncs
        self._hit[place] = False
        if moving is not None:
            self._hit[place, [self._column[row] for row in moving.hits]] = True
        self._stale[place] = False

    def is_stale(self, bundle: Bundle) -> bool:
        """Whether the bundle has to be cast again. Of one that was cast with another list of
        moving solids this says nothing."""
        self._follow()
        return self._stale[bundle.place]

    def _follow(self) -> None:
        solids = self._solids
        if self._looked == solids.syncs:
            return
        self._looked = solids.syncs
        listed = solids.listing, len(solids.gone)
        if listed != self._listed:
            self._listed = listed
            self._rows = np.flatnonzero(solids.moving)
            self._column = {row: column for column, row in enumerate(self._rows.tolist())}
            self._hit = np.zeros((len(self._seen), len(self._rows)), bool)
        changed = solids.version[self._rows] > self._seen[:, None]
        lo, hi = solids.lo[self._rows], solids.hi[self._rows]
        inside = np.ones(changed.shape, bool)
        for axis in range(3):
            inside &= lo[:, axis] <= self._hi[:, axis, None]
            inside &= hi[:, axis] >= self._lo[:, axis, None]
        self._stale = (changed & (inside | self._hit)).any(axis=1).tolist()
