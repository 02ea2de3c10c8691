# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the frames at which nothing moves that a pad can feel: its forces are the same there.

In a morning of 15 minutes with six pads in the sample home, the pads take 3.3 s instead of 4.8 s
(`python -m benchmarks --apart days.pads "[]"`: `with_s` and `plain_s`, each less `without_s`).
"""

from __future__ import annotations

import numpy as np

from ....sensor_logic.forces.pad_forces import ABOVE, BESIDE
from ....sensor_logic.model import Array
from ..capture import Frames
from ..rays.solids import Solids
from .bodies import MARGIN, ContactBodies, ContactBody, Key
from .supports import DEPTH, THICKEST

# m: an animated body may touch bodies whose bounds are at most this far from its own.
NEARBY = 0.2


def states_near(
    pad: Key, bodies: ContactBodies, solids: Solids, frames: Frames, up: Array, metres: float
) -> list[bytes]:
    """Return a state for each of k stored frames; equal states have the same forces on a pad.

    A state has the versions of the moving solids within a box. The box holds the pad, the bodies
    with a weight beside it and above it, all bodies with a weight in touch with these, and
    everything below. The scene must not have rigid bodies.

    Parameters
    ----------
    pad
        The key of the pad.
    bodies, solids, frames
        The bodies and solids of the scene, and the stored frames.
    up
        The unit vector (3,) upwards.
    metres
        The length of a Blender unit, in m.
    """
    weighing = [body for body in bodies.by_key.values() if body.animated or body.pad]
    wide = (max(body.tolerance for body in weighing) + 2.0 * MARGIN) / metres + 2.0 * MARGIN
    bounds = {body.key: _bounds(body, solids, frames) for body in weighing}
    lo, hi = bounds[pad]
    lo, hi = lo - BESIDE / metres - wide, hi + BESIDE / metres + wide
    above = up * ABOVE / metres
    lo, hi = np.minimum(lo, lo + above), np.maximum(hi, hi + above)
    reach = wide + (NEARBY + THICKEST) / metres
    # Each round can find one more body in touch.
    for _ in weighing:
        before = lo, hi
        for own_lo, own_hi in bounds.values():
            touches = ((own_lo - reach <= hi) & (own_hi + reach >= lo)).all(axis=1, keepdims=True)
            lo = np.where(touches, np.minimum(lo, own_lo - wide), lo)
            hi = np.where(touches, np.maximum(hi, own_hi + wide), hi)
        if np.array_equal(before[0], lo) and np.array_equal(before[1], hi):
            break
    lo, hi = lo - DEPTH / metres - wide, hi + DEPTH / metres + wide
    lo, hi = np.where(up > 0.0, -np.inf, lo), np.where(up < 0.0, np.inf, hi)
    near = ((frames.lo <= hi[:, None]) & (frames.hi >= lo[:, None])).all(axis=2)
    states = np.where(near, frames.version, -1)
    return [state.tobytes() for state in states]


def _bounds(body: ContactBody, solids: Solids, frames: Frames) -> tuple[Array, Array]:
    """Return the bounds lo, hi (k, 3) of a body's solids at each of the frames."""
    count = len(frames)
    lo, hi = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for solid in body.solids:
        column = frames.column.get(solid.row)
        own = solids.lo[solid.row], solids.hi[solid.row]
        if column is not None:
            own = frames.lo[:, column], frames.hi[:, column]
        lo, hi = np.minimum(lo, own[0]), np.maximum(hi, own[1])
    return lo, hi
