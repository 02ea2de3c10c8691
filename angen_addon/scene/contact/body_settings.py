# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of a body that decide its weight and contacts, read at one frame: all of them can be
animated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

# Friction of objects without a rigid body.
FRICTION = 0.7


@dataclass(frozen=True)
class BodySettings:
    """Masses in kg; `simulated`: the physics engine moves the body."""

    load_mass: float
    simulated: bool = False
    mass: float = 0.0
    friction: float = FRICTION
    linear_damping: float = 0.0
    angular_damping: float = 0.0


def read_settings(evaluated: Any) -> BodySettings:
    """The settings of an object that is evaluated at the frame."""
    load = float(evaluated.angen_load.mass)
    body = evaluated.rigid_body
    if body is None:
        return BodySettings(load)
    return BodySettings(
        load,
        is_simulated(evaluated),
        body.mass,
        body.friction,
        body.linear_damping,
        body.angular_damping,
    )


def is_simulated(obj: Any) -> bool:
    body = obj.rigid_body
    return body is not None and body.enabled and body.type == "ACTIVE" and not body.kinematic
