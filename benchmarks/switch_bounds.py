# SPDX-License-Identifier: GPL-3.0-or-later
"""What the optical switch is held to: closed forms of the light past an edge, and of the share of
flags that a look falls on; a swept switch misses none."""

from __future__ import annotations

import math
from typing import Any

from .bounds import Bounds

ROUNDING = 1e-9
# Of its bound, the least that the worst error over random edges comes to: else none were tried.
TRIED = 0.9
# An edge that shakes in the middle of the slit toggles one ray in some hundred looks; a hysteresis
# of a few rays swallows it.
TOGGLES, STEADY, STEADY_RAYS = 100, 1, 9
# Standard deviations of the share of moments, spread evenly, that a look falls on.
SIGMAS = 3.0


def check(data: dict[str, Any], bounds: Bounds) -> None:
    aperture = {row["rays"]: row for row in data["aperture"]}
    bounds.measured("apertures", aperture, (1, STEADY_RAYS))
    for rays, row in aperture.items():
        exact = 1.0 / (2 * rays)
        name = f"aperture of {rays} rays"
        bounds.within(
            f"{name}: error of the light", row["worst_error"], TRIED * exact, exact + ROUNDING
        )
        if rays == 1:
            bounds.at_least(f"{name}: changes of a shaking edge", row["changes"], TOGGLES)
        if rays >= STEADY_RAYS:
            bounds.at_most(f"{name}: changes of a shaking edge", row["changes"], STEADY)
    bounds.at_least("flags", len(data["flags"]), 12)
    for row in data["flags"]:
        share, count = row["exact"], row["switches"]
        # Binomial, or less where the moments lie evenly: half a moment at each end of each look.
        variance = min(share * (1.0 - share) * count, row["substeps"] / 2)
        off = SIGMAS * math.sqrt(variance) / count + ROUNDING
        name = f"{row['name']}, {row['substeps']} substeps: share seen"
        bounds.within(name, row["seen"], share - off, share + off)
    bounds.at_least("flags of swept switches", len(data["swept"]), 4)
    for row in data["swept"]:
        bounds.equal(f"{row['name']}, swept: share seen", row["seen"], 1.0)
        bounds.equal(f"{row['name']}, swept: said at another update", row["wrong"], 0)
