# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pad can feel at many frames, told by bounds: where nothing of it changes, nothing that
presses on the pad does."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.contact.pad_forces import ABOVE, BESIDE
from ..animation import all_animated, may_set
from ..rays.frames import Frames
from ..rays.solids import Solids
from .standing import DEPTH
from .things import MARGIN, Key, Thing, Things

Array = np.typing.NDArray[np.float64]
# m: an animated body is looked at for what it stands on where bounds come this near.
NEARBY = 0.2
# In data paths: what a weight may depend on beside where things are.
WEIGHT = ("angen_load", "gravity", "rigid_body", "scale_length")


def weights_stay(scene: Any) -> bool:
    """Whether only places and shapes change that pads depend on: neither physics of rigid bodies
    nor keyed masses."""
    return scene.rigidbody_world is None and not any(
        may_set(owner, *WEIGHT) for owner in all_animated()
    )


def states_near(
    pad: Key, things: Things, solids: Solids, frames: Frames, up: Array, metres: float
) -> list[bytes]:
    """At each of the frames (k,) what tells all that a pad can feel from the same elsewhere: what
    moves within a box that holds every weight beside it, above it and in touch with these, and all
    below."""
    weighing = [thing for thing in things.by_key.values() if thing.carried or thing.pad]
    wide = (max(t.tolerance for t in weighing) + 2.0 * MARGIN) / metres + 2.0 * MARGIN
    bounds = {thing.key: _bounds(thing, solids, frames) for thing in weighing}
    lo, hi = (bound.copy() for bound in bounds[pad])
    lo, hi = lo - BESIDE / metres - wide, hi + BESIDE / metres + wide
    above = up * ABOVE / metres
    lo, hi = np.minimum(lo, lo + above), np.maximum(hi, hi + above)
    # Each round one thing more may be in touch.
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


def _bounds(thing: Thing, solids: Solids, frames: Frames) -> tuple[Array, Array]:
    """Of a thing's surfaces (k, 3) at each of the frames."""
    count = len(frames)
    lo, hi = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for solid in thing.surfaces:
        column = frames.column.get(solid.row)
        own = (solids.lo[solid.row], solids.hi[solid.row])
        if column is not None:
            own = frames.lo[:, column], frames.hi[:, column]
        lo, hi = np.minimum(lo, own[0]), np.maximum(hi, own[1])
    return lo, hi
