# SPDX-License-Identifier: GPL-3.0-or-later
"""Tells by bounds at which frames a pad feels the same: there a run need not solve it again."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.contact.pad_forces import ABOVE, BESIDE
from ..animation import all_animated, may_set
from ..rays.frames import Frames
from ..rays.solids import Solids
from .contact_bodies import MARGIN, ContactBodies, ContactBody, Key
from .supports import DEPTH

Array = np.typing.NDArray[np.float64]
# m: an animated body may touch what its bounds come this near to.
NEARBY = 0.2
# Parts of data paths whose values a weight depends on, beside places and shapes.
WEIGHT = ("angen_load", "gravity", "rigid_body", "scale_length")


def weights_stay(scene: Any) -> bool:
    """Whether forces on pads change with places and shapes alone: the scene has no rigid bodies,
    and nothing animates a mass or gravity."""
    return scene.rigidbody_world is None and not any(
        may_set(owner, *WEIGHT) for owner in all_animated()
    )


def states_near(
    pad: Key, bodies: ContactBodies, solids: Solids, frames: Frames, up: Array, metres: float
) -> list[bytes]:
    """A key for each of the frames (k,): equal where the pad feels the same.

    The key holds the versions of the solids within a box around the pad, all weights beside it,
    above it and in touch with these, and everything below.
    """
    weighing = [body for body in bodies.by_key.values() if body.animated or body.pad]
    wide = (max(t.tolerance for t in weighing) + 2.0 * MARGIN) / metres + 2.0 * MARGIN
    bounds = {body.key: _bounds(body, solids, frames) for body in weighing}
    lo, hi = (bound.copy() for bound in bounds[pad])
    lo, hi = lo - BESIDE / metres - wide, hi + BESIDE / metres + wide
    above = up * ABOVE / metres
    lo, hi = np.minimum(lo, lo + above), np.maximum(hi, hi + above)
    # Each round may find one more body in touch.
    for _ in weighing:
        for own_lo, own_hi in bounds.values():
            reach = wide + NEARBY / metres
            touches = ((own_lo - reach <= hi) & (own_hi + reach >= lo)).all(axis=1, keepdims=True)
            lo = np.where(touches, np.minimum(lo, own_lo - wide), lo)
            hi = np.where(touches, np.maximum(hi, own_hi + wide), hi)
    lo, hi = lo - DEPTH / metres - wide, hi + DEPTH / metres + wide
    lo, hi = np.where(up > 0.0, -np.inf, lo), np.where(up < 0.0, np.inf, hi)
    near = ((frames.lo <= hi[:, None]) & (frames.hi >= lo[:, None])).all(axis=2)
    states = np.where(near, frames.version, -1)
    return [state.tobytes() for state in states]


def _bounds(body: ContactBody, solids: Solids, frames: Frames) -> tuple[Array, Array]:
    """Bounds lo, hi (k, 3) of a body's solids at each of the frames."""
    count = len(frames)
    lo, hi = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for solid in body.solids:
        column = frames.column.get(solid.row)
        own = (solids.lo[solid.row], solids.hi[solid.row])
        if column is not None:
            own = frames.lo[:, column], frames.hi[:, column]
        lo, hi = np.minimum(lo, own[0]), np.maximum(hi, own[1])
    return lo, hi
