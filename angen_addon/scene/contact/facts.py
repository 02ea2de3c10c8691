# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user set for a body, as it is at one frame: all of it can be animated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

# Friction of what the physics engine does not know.
FRICTION = 0.7


@dataclass(frozen=True)
class Facts:
    """Masses in kg; `simulated`: the engine moves it."""

    load_mass: float
    simulated: bool = False
    mass: float = 0.0
    friction: float = FRICTION
    linear_damping: float = 0.0
    angular_damping: float = 0.0


def facts_of(evaluated: Any) -> Facts:
    """Of an object, evaluated at the frame."""
    load = float(evaluated.angen_load.mass)
    body = evaluated.rigid_body
    if body is None:
        return Facts(load)
    return Facts(
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
