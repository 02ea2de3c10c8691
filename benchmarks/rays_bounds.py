# SPDX-License-Identifier: GPL-3.0-or-later
"""What the ray layer is held to: the float64 triangle, and `scene.ray_cast` on every update."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds

# Metres. Single precision at 10 m is good for 1e-6; a ray that grazes a face is off by some times
# that. Measured: 5.6e-7 and 8.2e-6.
RMS_M, WORST_M = 8e-7, 1.6e-5
# Against scene.ray_cast, whose own error is 4.5e-5 m: 5.2e-5 measured.
DIFFERENCE_M = 1e-4
RAYS = 5000
# Detectors that are enough for one of them to see the person who walks.
SEE = 7


def check(data: dict[str, Any], bounds: Bounds) -> None:
    accuracy = data["ray_accuracy"]
    bounds.at_least("rays against triangles", accuracy["rays"], RAYS)
    bounds.at_most("range against triangles, rms m", accuracy["fast_rms_m"], RMS_M)
    bounds.at_most("range against triangles, worst m", accuracy["fast_m"], WORST_M)
    bounds.at_most(
        "range against triangles where scene.ray_cast differs, worst m",
        accuracy["apart_fast_m"],
        WORST_M,
    )
    rows = data["ray_layer"]["rows"]
    bounds.measured("fans", {(row["pirs"], row["rays"]) for row in rows}, [(7, 80), (7, 640)])
    for row in rows:
        name = f"{row['scene']}, {row['pirs']} PIRs, {row['rays']} rays, {row['sweep']}"
        bounds.equal(f"{name}: updates that differ", row["updates_that_differ"], 0)
        bounds.at_most(f"{name}: range difference m", row["worst_range_error_m"], DIFFERENCE_M)
        # 10 Hz at 24 frames a second.
        bounds.at_least(f"{name}: updates", row["updates"], row["pirs"] * row["frames"] * 10 // 24)
        if row["pirs"] >= SEE:
            bounds.at_least(f"{name}: updates with movement", row["updates_with_motion"], 1)
