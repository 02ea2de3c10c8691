# SPDX-License-Identifier: GPL-3.0-or-later
"""What the ray layer is held to on boxes, in closed form, and the pad beside MuJoCo's."""

from __future__ import annotations

from typing import Any

from .bounds import Bounds
from .peers_report import LIGHT_OURS, RADIANCE

OURS, REFERENCE = "Ängen Sensors", "Blender `scene.ray_cast`"
# Metres: 2.6e-7 and 6.5e-6 measured; Blender's own 1.2e-6 and 2.8e-5.
RMS_M, WORST_M = 5e-7, 1.3e-5
# The closed form itself, by an engine that computes in float64: 1.4e-10 and 1e-8.
MUJOCO_WORST_M = 1e-7
RAYS = 30_000
# Relative error of a box at rest.
TOUCH = 1e-6
# 2.6 % measured with an eighth of the rays.
LIGHT, MOST_RAYS = 0.05, 0.06


def check(data: dict[str, Any], bounds: Bounds) -> None:
    rows = {row["engine"]: row for row in data["rays"]}
    bounds.measured("engines", rows, (OURS, REFERENCE, "mathutils BVHTree"))
    for name, row in rows.items():
        bounds.at_least(f"{name}: rays", row["rays"], RAYS)
        if name == OURS:
            bounds.at_most(f"{name}: range, rms m", row["rms_m"], RMS_M)
            bounds.at_most(f"{name}: range, worst m", row["worst_m"], WORST_M)
            bounds.equal(f"{name}: rays past an edge", row["at_edges"], 0)
            reference = rows[REFERENCE]["rms_m"]
            bounds.at_most(f"{name}: rms m, against scene.ray_cast's", row["rms_m"], reference)
        elif name.startswith("MuJoCo"):
            bounds.at_most(f"{name}: closed form, worst m", row["worst_m"], MUJOCO_WORST_M)
            bounds.equal(f"{name}: rays past an edge", row["at_edges"], 0)
    if data["light"] is not None:
        bounds.at_most("light: difference from Radiance, rms", data["light"]["apart_rms"], LIGHT)
        best = {row["engine"]: row["rms"] for row in data["light"]["rows"]}
        bounds.measured("light: engines", best, (LIGHT_OURS, RADIANCE))
        for name, error in best.items():
            bounds.at_most(f"light: {name}, most rays, rms", error, MOST_RAYS)
    if data["touch"] is not None:
        bounds.at_most("a box on a pad: error", data["touch"]["ours_error"], TOUCH)
        bounds.at_most("a box on a pad: MuJoCo's error", data["touch"]["mujoco_error"], TOUCH)
