# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts each solid for a plan: lines where it is cut, or its outline from above."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...sensor_logic.model import Array
from ...sensor_logic.report.facts import PlanShape
from ...sensor_logic.report.sections import Line, cut, from_above
from ..scene.home import EvaluatedHome, SolidSurface

# What is cut and rises this far above the floor (m) is a wall: wardrobes and door leaves do not.
WALL_M = 2.2
# What rises less than this is the floor itself, or a rug; what lies deeper belongs to the storey
# below.
RUG_M, DEPTH_M = 0.06, 0.25


def shapes_at(
    home: EvaluatedHome, floor: float, height: float, area: tuple[Array, Array]
) -> tuple[PlanShape, ...]:
    """The shapes of a storey over an `area` (two corners (2,)), cut at a `height`; all in m."""
    wanted = (home.lo[:, 2] < height) & (home.hi[:, 2] > floor - DEPTH_M)
    wanted &= ((home.lo[:, :2] < area[1]) & (home.hi[:, :2] > area[0])).all(axis=1)
    found: list[PlanShape] = []
    for surface in home.surfaces(wanted):
        found += _shapes(surface, floor, height)
    return tuple(found)


def _shapes(surface: SolidSurface, floor: float, height: float) -> list[PlanShape]:
    points, triangles = surface.points, surface.triangles
    levels = points[triangles, 2] if len(triangles) else np.empty((0, 3))
    below = (levels < height).all(axis=1)
    found = []
    lines = cut(points, triangles, height)
    if lines:
        top = float(np.nanmax(points[:, 2]))
        role = "wall" if top - floor >= WALL_M else "solid"
        if may_move(surface.solid.owner):
            role = "moving"
        found.append(PlanShape(role, tuple(lines), height))
    low = below & (levels.max(axis=1, initial=-np.inf) > floor - DEPTH_M)
    lines = from_above(points, triangles[low])
    if lines:
        top = float(levels[low].max())
        found.append(PlanShape("floor" if top - floor < RUG_M else "low", _closed(lines), top))
    return found


def _closed(lines: list[Line]) -> tuple[Line, ...]:
    """The largest first, so that what is inside another is painted over it."""
    return tuple(sorted(lines, key=lambda line: -line.length))


def may_move(obj: Any) -> bool:
    """Whether something can move the object: its own or a parent's animation, an armature, a
    constraint, the simulation of rigid bodies."""
    seen = set()
    while obj is not None and obj.session_uid not in seen:
        seen.add(obj.session_uid)
        if _is_driven(obj):
            return True
        obj = obj.parent
    return False


def _is_driven(obj: Any) -> bool:
    animation = obj.animation_data
    animated = animation is not None and (
        animation.action is not None or len(animation.nla_tracks) or len(animation.drivers)
    )
    body = obj.rigid_body
    falls = body is not None and body.type == "ACTIVE"
    bent = any(modifier.type == "ARMATURE" for modifier in obj.modifiers)
    return bool(animated or falls or bent or len(obj.constraints))
