# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads rigid-body constraints: the forces and moments that they can give between two bodies."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....sensor_logic.contact.world import Constraint, Key

X, Y, Z = 0, 1, 2
# Axes along which each type gives forces, and about which it gives moments, in the space of the
# constraint's object: a hinge turns about its z axis, a slider and a piston run along x.
HELD: dict[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "FIXED": ((X, Y, Z), (X, Y, Z)),
    "POINT": ((X, Y, Z), ()),
    "HINGE": ((X, Y, Z), (X, Y)),
    "SLIDER": ((Y, Z), (X, Y, Z)),
    "PISTON": ((Y, Z), (Y, Z)),
    "GENERIC": ((), ()),
    "GENERIC_SPRING": ((), ()),
    "MOTOR": ((), ()),
}
NAMES = "xyz"


def read_constraint(
    evaluated: Any, known: set[Key], metres: float
) -> tuple[Constraint, bool] | None:
    """The constraint of an object, and whether its two bodies may collide; None where it holds
    nothing. A limit or a spring counts as holding: statics cannot tell its force from a
    contact's."""
    settings = evaluated.rigid_body_constraint
    if not settings.enabled or settings.type not in HELD:
        return None
    if settings.object1 is None or settings.object2 is None:
        return None
    ends = [_key(settings.object1, known), _key(settings.object2, known)]
    forces, states = (set(axes) for axes in HELD[settings.type])
    for axis, name in enumerate(NAMES):
        spring = settings.type == "GENERIC_SPRING"
        if _flag(settings, f"use_limit_lin_{name}") or (
            spring and _flag(settings, f"use_spring_{name}")
        ):
            forces.add(axis)
        if _flag(settings, f"use_limit_ang_{name}") or (
            spring and _flag(settings, f"use_spring_ang_{name}")
        ):
            states.add(axis)
    if settings.type == "MOTOR":
        forces |= {X} if settings.use_motor_lin else set()
        states |= {X} if settings.use_motor_ang else set()
    if None in ends or not (forces or states):
        return None
    matrix = np.array(evaluated.matrix_world, np.float64)
    axes = matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0)
    constraint = Constraint(
        evaluated.original.name,
        ends[0],
        ends[1],
        matrix[:3, 3] * metres,
        axes.T[sorted(forces)],
        axes.T[sorted(states)],
    )
    return constraint, not settings.disable_collisions


# The types that use limits; on others, limits are left-over settings.
LIMITED = {
    "lin": {"GENERIC", "GENERIC_SPRING", "SLIDER", "PISTON"},
    "ang": {"GENERIC", "GENERIC_SPRING", "HINGE", "PISTON"},
}


def _flag(settings: Any, name: str) -> bool:
    if name.startswith("use_limit_") and settings.type not in LIMITED[name[10:13]]:
        return False
    return bool(getattr(settings, name))


def _key(end: Any, known: set[Key]) -> Key | None:
    """The node of a constraint's object; None where it is no rigid body."""
    key = (end.original.session_uid,)
    return key if key in known else None
