# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of doors: those without a hinge, and those with a switch that never move."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import numpy as np

from ...sensor_logic.model import Array
from ...sensor_logic.wording import named
from ..scene.animation import motion_paths
from ..scene.instances import chain
from .examined import Examined, Found

WORD = re.compile(r"door|tür|tuer|dörr|porte|puerta|deur", re.IGNORECASE)
# Parts and surroundings of doors, whose names hold the word too.
PARTS = (
    "frame", "mat", "handle", "knob", "lock", "bell", "flag", "hinge", "jamb", "lining", "panel",
    "stop", "glass", "outdoor", "indoor",
)  # fmt: skip
PART = re.compile("|".join(PARTS), re.IGNORECASE)
# m: limits of the height, width and thickness of a door's leaf.
HEIGHT, WIDTH, THICK = (1.6, 3.0), (0.4, 1.8), 0.3
# An origin nearer to the middle than this share of the width is not at a hinge.
MIDDLE = 0.3
# m: a switch this near to a leaf watches it.
NEAR = 0.5


def leaves(home: Examined) -> Iterator[tuple[Any, Array, Array]]:
    """The leaves of doors, found by name and size, with their world bounds lo, hi (3,) in m."""
    for obj, matrix in home.seen:
        if obj.type != "MESH" or not WORD.search(obj.name) or PART.search(obj.name):
            continue
        corners = np.array(obj.bound_box, np.float64)
        size = (corners.max(axis=0) - corners.min(axis=0)) * _scale(obj) * home.metres
        thick, wide, high = np.sort(size).tolist()
        if not (HEIGHT[0] <= high <= HEIGHT[1] and WIDTH[0] <= wide <= WIDTH[1] and thick <= THICK):
            continue
        placed = (corners @ matrix[:3, :3].T + matrix[:3, 3]) * home.metres
        yield obj, placed.min(axis=0), placed.max(axis=0)


def without_hinges(home: Examined) -> Iterator[Found]:
    """Reports leaves that turn about their middle, or would."""
    bad = []
    for leaf, *_ in leaves(home):
        moved = [part for part in chain(leaf) if any(motion_paths(part))]
        slides = moved and not any("rotation" in path for path in motion_paths(moved[0]))
        if not slides and _is_middle(leaf, moved[0] if moved else leaf, home):
            bad.append(leaf.name)
    if bad:
        yield (
            f"Doors without a hinge, whose origin is in their middle: {named(sorted(bad))}",
            "Put the 3D cursor on the hinge's edge, then Object, Set Origin, Origin to 3D Cursor; "
            "or Fit Door with Switch, which finds the hinge",
            tuple(sorted(bad)),
        )


def standing_still(home: Examined) -> Iterator[Found]:
    """Reports doors with switches if none of them ever moves, nor is marked for residents."""
    switches = [
        np.array(s.world_matrix(home.depsgraph).translation, np.float64) * home.metres
        for s in home.sensors
        if s.kind.publishes("opening")
    ]
    watched = [
        leaf
        for leaf, lo, hi in leaves(home)
        if any(((at >= lo - NEAR) & (at <= hi + NEAR)).all() for at in switches)
    ]
    parts = [part for leaf in watched for part in chain(leaf)]
    if watched and not any(
        part in home.moved_without_keys or any(motion_paths(part)) for part in parts
    ):
        yield (
            f"No door with a switch is animated: {named(sorted(leaf.name for leaf in watched))}",
            "Key the leaf's rotation about its hinge: shut, open, shut again (I in the 3D view)",
            tuple(sorted(leaf.name for leaf in watched)),
        )


def _is_middle(leaf: Any, pivot: Any, home: Examined) -> bool:
    """Whether a pivot's origin is near the middle of the leaf's width."""
    corners = np.array(leaf.bound_box, np.float64)
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    place = leaf.evaluated_get(home.depsgraph).matrix_world.inverted_safe() @ (
        pivot.evaluated_get(home.depsgraph).matrix_world.translation
    )
    size = (hi - lo) * _scale(leaf)
    wide = int(np.argsort(size)[1])
    off = abs(place[wide] - (lo[wide] + hi[wide]) / 2.0) / max(hi[wide] - lo[wide], 1e-9)
    return bool(off < MIDDLE)


def _scale(obj: Any) -> Array:
    return np.abs(np.array(obj.matrix_world.to_scale(), np.float64))
