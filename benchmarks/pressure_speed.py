# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pad costs: milliseconds a frame against the size of its contact island and of the scene.

The time is that of sensing alone, without Blender's own simulation; the error of the same frames
stands beside it.
"""

from __future__ import annotations

import statistics
from typing import Any

from .pressure_scenes import box, floor, follow, new_scene, pad

ISLANDS = (1, 2, 5, 10, 20, 50)
ELSEWHERE = (0, 10, 100, 1000)
G = 9.81
PAD = 0.01
ROW = 5
HALF = (0.1, 0.06, 0.04)


def measure(quick: bool) -> dict[str, Any]:
    frames = 12 if quick else 36
    islands = (10,) if quick else ISLANDS
    crowds = (0, 100) if quick else ELSEWHERE
    return {
        "frames": frames,
        "island": [compare(bodies, 0, frames) for bodies in islands],
        "scene": [compare(1, crowd, frames) for crowd in crowds],
    }


def compare(bodies: int, elsewhere: int, frames: int) -> dict[str, Any]:
    """A wall of boxes on one pad, and others on the floor far from it. The first second is left
    out: shapes are read once."""
    scene = new_scene(last=frames + 6)
    floor(half=(20, 20, 0.5))
    pad("pad", (0.7, 0.1, PAD / 2), (0, 0, PAD / 2))
    for i in range(bodies):
        level, place = divmod(i, ROW)
        # Shifted by level, so that the columns lean on each other.
        aside = (place - (ROW - 1) / 2) * 0.21 + 0.03 * (level % 2)
        if bodies < ROW:
            level, aside = i, 0.0
        box(f"box {i}", HALF, (aside, 0, PAD + HALF[2] * (2 * level + 1)), 1.0)
    for i in range(elsewhere):
        x, y = divmod(i, 32)
        box(f"other {i}", (0.1,) * 3, (2.0 + 0.4 * x, 0.4 * (y - 16), 0.1), 1.0)
    followed = follow(scene)
    track = followed.tracks["pad"]
    exact = bodies * G
    times = sorted(followed.seconds[7:])
    return {
        "bodies": bodies,
        "elsewhere": elsewhere,
        "ms": statistics.median(times) * 1e3,
        "ms_worst": times[-1] * 1e3,
        "start_ms": followed.seconds[0] * 1e3,
        "error": max(
            abs(force / exact - 1.0)
            for force, valid in zip(track.force[6:], track.valid[6:], strict=True)
            if valid
        ),
        "valid": sum(track.valid),
        "updates": len(track.valid) - 1,
    }
