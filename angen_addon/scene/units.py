# SPDX-License-Identifier: GPL-3.0-or-later
"""Watts, kilograms and gravity in scenes whose unit is not the metre.

Blender stores the power of a lamp, the mass of a rigid body and gravity as plain numbers. Its
fields show these times a power of the scene's unit scale: a lamp that is stored as 10 W is shown as
1 mW at a scale of 0.01. Scripts and importers write the stored number, users type the shown one.
A number means what is stored, unless only what is shown is usual in a home.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ...sensor_logic.model import Array
from .animation import played_curves
from .sensors import unit_scale

# Squared length and cubed length: the powers of the unit scale by which fields show W and kg.
AREA, VOLUME = 2, 3


class UsualRange(NamedTuple):
    """The least and most of a quantity that are usual in a home, with its power of unit scale."""

    least: float
    most: float
    power: int


# W of light of a lamp. No household lamp emits more, but its electrical power is often greater.
WATTS = UsualRange(0.02, 50.0, AREA)
KILOGRAMS = UsualRange(0.001, 1000.0, VOLUME)
# m/s²: from the Moon's to Jupiter's.
GRAVITY = UsualRange(1.5, 30.0, 1)


def shown_factor(stored: float, usual: UsualRange, metres: float) -> float:
    """Return the factor from a stored number to what it means: 1, or that of Blender's field.

    Parameters
    ----------
    stored
        The number that Blender stores.
    usual
        The quantity.
    metres
        The length of a Blender unit in metres.
    """
    factor = metres**usual.power
    is_usual, shown_is = (usual.least <= v <= usual.most for v in (stored, stored * factor))
    return factor if shown_is and not is_usual else 1.0


def kilograms(rigid_body: Any, metres: float) -> float:
    """Return the mass of a rigid body in kg."""
    return float(rigid_body.mass * shown_factor(rigid_body.mass, KILOGRAMS, metres))


def gravity_factor(gravity: Any, metres: float) -> float:
    """Return the factor from a scene's stored gravity (3,) to m/s²."""
    return shown_factor(float(np.linalg.norm(gravity)), GRAVITY, metres)


def gravity_of(scene: Any, metres: float) -> tuple[Array, Array]:
    """Return gravity (3,) in m/s², and the unit vector against it.

    `metres` is the length of a Blender unit. The field weights of the physics engine count.
    """
    gravity = np.array(scene.gravity, np.float64) * gravity_factor(scene.gravity, metres)
    if not scene.use_gravity:
        gravity = np.zeros(3)
    if scene.rigidbody_world is not None:
        weights = scene.rigidbody_world.effector_weights
        gravity *= weights.gravity * weights.all
    size = float(np.linalg.norm(gravity))
    return gravity, -gravity / size if size > 0.0 else np.array([0.0, 0.0, 1.0])


def watts_factor(lamp: Any, metres: float) -> float:
    """Return the factor from the stored power of a lamp's data to W; for a sun, to W/m².

    It is the same at all frames, unless a driver sets the power.
    """
    return 1.0 if lamp.type == "SUN" else shown_factor(peak_power(lamp), WATTS, metres)


def peak_power(lamp: Any) -> float:
    """Return the greatest stored power of a lamp's data: now or at a keyframe."""
    played = [curve for curve in played_curves(lamp) if curve.data_path == "energy"]
    keyed = [abs(point.co[1]) for curve in played for point in curve.keyframe_points]
    return float(max([abs(lamp.energy), *keyed]))


def light_factor(lamp: Any, scene: Any) -> float:
    """Return the factor by which a render of the scene, in Blender units, has too little light.

    Renders spread the stored power of a lamp's data over areas in square Blender units. Suns, and
    lamps whose power is not normalized by their area, give the same light at any scale.
    """
    metres = unit_scale(scene)
    sized = lamp.size if lamp.type == "AREA" else getattr(lamp, "shadow_soft_size", 0.0)
    if lamp.type == "SUN" or (sized > 0.0 and not getattr(lamp, "normalize", True)):
        return 1.0
    return watts_factor(lamp, metres) / metres**AREA
