# SPDX-License-Identifier: GPL-3.0-or-later
"""The four legs of the sample's table against the exact curves, as the weight moves over it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from .pressure_scenes import follow

SAMPLE = Path(__file__).resolve().parent.parent / "sample_blends" / "pressure.blend"
LEGS = ("front left", "front right", "back left", "back right")
G = 9.81


def measure() -> dict[str, Any]:
    """Time in seconds, and newtons of each leg: measured and exact."""
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLE), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    objects = bpy.data.objects
    watched = [objects[name] for name in ("Table", "Weight", *(f"Leg {leg}" for leg in LEGS))]
    followed = follow(scene, watched)
    poses = {name: pose[:, :3, 3] for name, pose in followed.poses.items()}
    half = objects[f"Leg {LEGS[0]}"].dimensions.x / 2.0
    masses = objects["Table"].rigid_body.mass, objects["Weight"].angen_load.mass
    frames = scene.frame_end - scene.frame_start + 1
    exact = np.array([
        legs_exactly(
            np.array([poses[f"Leg {leg}"][i] for leg in LEGS]),
            half,
            ((masses[0] * G, poses["Table"][i]), (masses[1] * G, poses["Weight"][i])),
        )
        for i in range(frames)
    ])  # fmt: skip
    tracks = {leg: followed.tracks[f"Pad {leg}"] for leg in LEGS}
    measured = np.array([track.force for track in tracks.values()]).T
    known = np.array([track.valid for track in tracks.values()]).all(axis=0)
    off = np.abs(measured - exact)[known]
    return {
        "fps": scene.render.fps,
        "table_kg": masses[0],
        "weight_kg": masses[1],
        "worst_newtons": float(off.max()),
        "worst_share": float((off / exact[known]).max()),
        "valid": int(known.sum()),
        "time_s": [round(i / scene.render.fps, 4) for i in range(frames)],
        "measured": {leg: _rounded(measured[:, i]) for i, leg in enumerate(LEGS)},
        "exact": {leg: _rounded(exact[:, i]) for i, leg in enumerate(LEGS)},
        "known": [int(k) for k in known],
    }


def legs_exactly(places: Any, half: float, loads: Any) -> Any:
    """Forces (n,) in N on square legs of half width `half` m at `places` (n, 3): an elastic
    foundation under one stiff thing that carries `loads`, pairs of newtons and place."""
    rows = np.column_stack([np.ones(len(places)), places[:, :2]])
    inner = len(places) * half**2 / 3.0
    moments = rows.T @ rows + np.diag([0.0, inner, inner])
    push = np.sum([newtons * np.array([1.0, *at[:2]]) for newtons, at in loads], axis=0)
    return rows @ np.linalg.solve(moments, push)


def _rounded(values: Any) -> list[float]:
    return [round(float(value), 4) for value in values]
