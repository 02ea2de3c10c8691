# SPDX-License-Identifier: GPL-3.0-or-later
"""The view of one sensor in a room: how it responds to the motions of a coverage map.

A kind of sensor with a coverage map makes views with `Kind.view`. A view casts its rays once,
through the room without a body. Where they hit the moving body is then computed by formulas.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..model import Array
from .motions import BodyHits, Motion, Start

# The most pairs of a body and a ray in one batch, to bound the memory.
AT_ONCE = 1_500_000


class DetectorView(Protocol):
    """A detector in a room, which gives its response to motions.

    All methods return an array (m,), with a value for each of m motions.
    """

    def strengths(self, motion: Motion, start: Start) -> Array:
        """Return the largest signal (m,) during each motion, divided by the threshold.

        The motion is detected if this value is above 1.
        """
        ...

    def may_notice(self, motion: Motion, start: Start) -> NDArray[np.bool_]:
        """Return whether the detector could possibly detect each motion, (m,).

        This test is much faster than `strengths`, and false only for motions that are not detected.
        """
        ...


def parts_of(rows: NDArray[np.intp], rays: int) -> Iterator[NDArray[np.intp]]:
    """Yield motions `rows` (k,) in parts that need at most AT_ONCE pairs of a body and a ray."""
    at_once = max(1, AT_ONCE // max(1, rays))
    for first in range(0, len(rows), at_once):
        yield rows[first : first + at_once]


def hit_distances(body_hits: BodyHits, range_min: float) -> Array:
    """Return the distance (n,) in m from the origin at which each ray hits the body.

    A ray begins at `range_min`. If that is inside a body, the ray hits the far side of the body.
    The distance is inf if the ray begins behind the body.
    """
    at = np.where(body_hits.enter >= range_min, body_hits.enter, body_hits.leave)
    return np.where(at >= range_min, at, np.inf)
