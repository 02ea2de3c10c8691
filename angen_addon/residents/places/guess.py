# SPDX-License-Identifier: GPL-3.0-or-later
"""Guesses the settings of a new mark: which way an object faces, how far a door opens."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.error import AngenError
from ....sensor_logic.model import Array
from ....sensor_logic.residents.places import CURTAIN, DOOR, LIE, SIT
from ...coverage.cells import finished, free_ways
from ...scene.home import EvaluatedHome
from ...scene.placed import NotPlaced
from ...scene.sensors import unit_scale
from .leaves import keyed_angle, keyed_slide, leaf_of
from .looks import FACING, set_look
from .marked_object import MarkedObject

# m: what is less uneven has no back; how far room is looked for; beyond its own box.
UNEVEN_M, FAR_M, BEYOND_M = 0.08, 3.0, 0.01
# m: as much room is enough to stand; what is not higher is looked over.
ENOUGH_M, LOW_M = 1.0, 1.3


def guess(obj: Any, depsgraph: Any) -> None:
    """Fills in the mark of an object."""
    mark = obj.angen_place
    if mark.use in (DOOR, CURTAIN):
        try:
            leaf, _ = leaf_of(obj)
        except AngenError:
            return
        if angle := keyed_angle(leaf):
            mark.angle = angle
        if slide := keyed_slide(leaf):
            mark.slide = slide * unit_scale(depsgraph.scene)
    elif mark.use in FACING:
        home = EvaluatedHome(depsgraph)
        try:
            marked = MarkedObject(home, obj)
        except NotPlaced:
            return
        look = _look(home, marked, mark.use)
        if look is not None:
            set_look(obj, marked.matrix, look)


def _look(home: EvaluatedHome, marked: MarkedObject, use: str) -> Array | None:
    """(2,): where it probably faces; None if no side is more likely than another."""
    axes = np.array(marked.matrix)[:2, :2].T
    sizes = np.linalg.norm(axes, axis=1)
    if sizes.min() < 1e-9:
        axes, sizes = np.eye(2), np.ones(2)
    x, y = axes / sizes[:, None]
    ways = [-y, x, y, -x]
    if not marked.solid:
        return None
    if use == LIE:
        _, deep, wide = marked.box(x)
        ways = [x, -x] if deep > wide else [y, -y]
    tops = [_top_at(marked, way) for way in ways]
    free = [_free(home, marked, way) for way in ways]
    if max(tops) - min(tops) > UNEVEN_M and use in (SIT, LIE):
        high = int(np.argmax(tops))
        return ways[high] if use == LIE else -ways[high]
    # One is where there is room, with a wall opposite; else its front tells.
    room = np.round(np.minimum(free, ENOUGH_M), 1)
    back = room[[2, 3, 0, 1]] if len(ways) == 4 else room[::-1]
    front = ways[int(np.argmax(room - back))]
    return front if use == SIT else -front


def _top_at(marked: MarkedObject, way: Array) -> float:
    """m: how high it is at its end along a way."""
    middle, deep, wide = marked.box(way)
    across = np.array([-way[1], way[0]])
    points = [
        middle + way * (deep - inset * deep) + across * wide * k
        for inset in (0.04, 0.1, 0.16)
        for k in (-0.5, 0.0, 0.5)
    ]
    heights = marked.heights(np.array(points))
    return float(np.nanmax(heights)) if np.isfinite(heights).any() else 0.0


def _free(home: EvaluatedHome, marked: MarkedObject, way: Array) -> float:
    """m: how far there is room beyond its end along a way."""
    middle, deep, wide = marked.box(way)
    across = np.array([-way[1], way[0]])
    rows = set(marked.rows.tolist())
    others = home.part(lambda solid: solid.row not in rows)
    # Over what is low and built into something, such as a sink.
    low, top = float(marked.points[:, 2].min()), float(marked.points[:, 2].max())
    level = top + 0.05 if top - low < LOW_M else (low + top) / 2.0
    edge = middle + way * (deep + BEYOND_M)
    starts = [[*(edge + across * wide * k), level] for k in (-0.6, 0.0, 0.6)]
    ranges = finished(free_ways(others, np.array(starts), np.array([*way, 0.0]), FAR_M))
    return float(np.mean(ranges))
