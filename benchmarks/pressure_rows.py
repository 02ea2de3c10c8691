# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of the accuracy table: the pads' readings of a scene and their exact forces."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from angen_sensors.sensor_logic.model import NOT_YET

from . import pressure_mujoco
from .pressure_scenes import Followed

G = 9.81
Row = dict[str, Any]


def row(
    group: str,
    scene: str,
    followed: Followed,
    exact: Mapping[str, float],
    first: int | None = None,
    mujoco: bool = False,
) -> Row:
    """The errors of pads with these exact forces in newtons, from frame index `first` on."""
    found: list[float] = []
    errors: list[tuple[float, float]] = []
    for name, force in exact.items():
        track = followed.tracks[name]
        start = len(track.force) // 2 if first is None else first
        valid = [f for f, v in zip(track.force, track.valid, strict=True) if v]
        late = [f for f, v in zip(track.force[start:], track.valid[start:], strict=True) if v]
        found.append(float(np.mean(late)) if late else math.nan)
        worst = max((abs(f - force) for f in late), default=math.nan)
        errors.append((worst / force, worst))
        assert all(math.isfinite(f) for f in valid)
    engine = pressure_mujoco.pad_forces() if mujoco else None
    against = None
    if engine is not None:
        pairs = zip(exact, found, strict=True)
        against = max(abs(value - engine[name]) / exact[name] for name, value in pairs)
    return {
        "group": group,
        "scene": scene,
        "exact": [*exact.values()],
        "measured": found,
        "unit": "N",
        "error": max(error for error, _ in errors),
        "error_newtons": max(newtons for _, newtons in errors),
        "mujoco": against,
        **validity(followed),
    }


def validity(followed: Followed) -> Row:
    """The numbers of valid and of all updates; the first has no frame before it and is never
    valid."""
    tracks = followed.tracks.values()
    return {
        "valid": sum(sum(track.valid) for track in tracks),
        "updates": sum(len(track.valid) - 1 for track in tracks),
        "problems": sorted(set().union(*(t.problems for t in tracks)) - {NOT_YET}),
        "residual": max(
            (r for t in tracks for r, v in zip(t.residual, t.valid, strict=True) if v), default=0.0
        ),
    }


def total(scene: str, followed: Followed, exact: float) -> Row:
    """The error of the sum over all pads."""
    tracks = list(followed.tracks.values())
    half = len(tracks[0].force) // 2
    sums = np.sum([track.force[half:] for track in tracks], axis=0)
    worst = float(np.abs(sums - exact).max())
    return {
        "group": "sitter",
        "scene": scene,
        "exact": [exact],
        "measured": [float(sums.mean())],
        "unit": "N",
        "error": worst / exact,
        "error_newtons": worst,
        "mujoco": None,
        **validity(followed),
    }


def at_rest(followed: Followed, dt: float) -> Any:
    """Mask of the frames before and after which every body, and its rim, is slower than 10 mm/s."""
    count = min(len(track.force) for track in followed.tracks.values())
    still = np.ones(count, bool)
    still[0] = False
    for poses in followed.poses.values():
        points = poses[:, :3, :] @ np.array(
            [[0, 0.1, 0, 0], [0, 0, 0.1, 0], [0, 0, 0, 0.1], [1] * 4]
        )
        speed = np.linalg.norm(np.diff(points, axis=0), axis=1).max(axis=1) / dt
        slow = speed < 0.01
        still[1:] &= slow[: count - 1] & slow[1:count]
    return still
