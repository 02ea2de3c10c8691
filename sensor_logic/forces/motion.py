# SPDX-License-Identifier: GPL-3.0-or-later
"""The forces on a simulated body, from its motion: inverse dynamics (Newton–Euler).

The poses at three frames give the accelerations, and these give the wrench that contacts must
exert. Its force is m(a + c·v − g), its moment I·α + ω×I·ω + c·I·ω. The terms with c = −ln(1 −
damping) are due to the damping of the Bullet engine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arrays import Array

# In m/s. A body whose centre of mass and rim are slower counts as at rest. Its remaining motion is
# jitter of the engine, whose accelerations would give false forces.
REST_SPEED = 0.010
# A body with a soft collision margin, such as an active mesh, jitters more.
MARGIN_REST_SPEED = 0.10


@dataclass(frozen=True)
class RigidMotion:
    """The motion of a rigid body at one frame.

    Attributes
    ----------
    velocity, acceleration
        Velocity and acceleration of the centre of mass, (3,) in m/s and m/s².
    spin, spin_change
        Angular velocity and angular acceleration, (3,) in rad/s and rad/s².
    reach
        The largest distance in m that a point of the body moves in a frame.
    """

    velocity: Array
    acceleration: Array
    spin: Array
    spin_change: Array
    reach: float

    @property
    def moving(self) -> bool:
        """Whether any velocity or acceleration differs from zero."""
        parts = (self.velocity, self.acceleration, self.spin, self.spin_change)
        return any(bool(part.any()) for part in parts)


AT_REST = RigidMotion(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3), 0.0)


def motion(
    before: Array, now: Array, after: Array, dt: float, size: float, rest_speed: float = REST_SPEED
) -> RigidMotion:
    """Return the motion of a body from its poses at three frames.

    Parameters
    ----------
    before, now, after
        The world poses (4, 4) in m at the previous, this and the next frame.
    dt
        The time between two poses in s.
    size
        The largest distance in m of a point of the body from its origin, which is the centre of
        mass.
    rest_speed
        The speed in m/s below which the body counts as at rest.
    """
    if np.array_equal(before, now) and np.array_equal(now, after):
        return AT_REST
    step_in, step_out = now[:3, 3] - before[:3, 3], after[:3, 3] - now[:3, 3]
    turns = [rotation_of(pose) for pose in (before, now, after)]
    spin_in = rotation_vector(turns[1] @ turns[0].T) / dt
    spin_out = rotation_vector(turns[2] @ turns[1].T) / dt
    velocity, spin = (step_in + step_out) / (2 * dt), (spin_in + spin_out) / 2
    reach = max(float(np.abs(step_in).max()), float(np.abs(step_out).max()))
    spinning = size * max(_length(spin_in), _length(spin_out))
    reach += dt * spinning
    fastest = max(max(_length(step_in), _length(step_out)) / dt, spinning)
    if fastest < rest_speed:
        still = np.zeros(3)
        return RigidMotion(still, still, still, still, reach)
    return RigidMotion(
        velocity, (step_out - step_in) / dt**2, spin, (spin_out - spin_in) / dt, reach
    )


def wrench(
    moved: RigidMotion,
    pose: Array,
    mass: float,
    inertia: Array,
    gravity: Array,
    linear_damping: float = 0.0,
    angular_damping: float = 0.0,
) -> Array:
    """Return the wrench (6,) that contacts must exert on a body about its centre of mass.

    Parameters
    ----------
    moved
        The motion of the body.
    pose
        The body's world pose (4, 4).
    mass
        The body's mass in kg.
    inertia
        The principal moments of inertia (3,) in kg·m², about the body's own axes.
    gravity
        The acceleration of gravity (3,) in m/s².
    linear_damping, angular_damping
        The damping of the Bullet engine, 0 to 1.

    Returns
    -------
    The force in N and the moment in N·m.
    """
    if not moved.moving:
        return np.concatenate([-mass * gravity, np.zeros(3)])
    axes = rotation_of(pose)
    tensor = axes @ np.diag(inertia) @ axes.T
    force = mass * (moved.acceleration + _rate(linear_damping) * moved.velocity - gravity)
    momentum = tensor @ moved.spin
    moment = (
        tensor @ moved.spin_change
        + np.cross(moved.spin, momentum)
        + _rate(angular_damping) * momentum
    )
    return np.concatenate([force, moment])


def _rate(damping: float) -> float:
    """Return the damping rate in 1/s: the engine multiplies velocities by (1 − damping)^dt."""
    return -math.log(max(1.0 - damping, 1e-9))


def rotation_of(pose: Array) -> Array:
    """Return the rotation (3, 3) of a pose, without its scale and mirroring."""
    columns = pose[:3, :3]
    lengths = np.sqrt((columns * columns).sum(axis=0))
    turned: Array = columns / np.where(lengths > 0.0, lengths, 1.0)
    (a, b, c), (d, e, f), (g, h, i) = turned.tolist()
    if a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g) < 0.0:
        turned = -turned
    return turned


def _length(vector: Array) -> float:
    """Return the length of a single vector, several times as fast as `np.linalg.norm`."""
    return math.sqrt(float(vector @ vector))


def rotation_vector(rotation: Array) -> Array:
    """Return the vector (3,) of a rotation matrix (3, 3): its axis times its angle in rad.

    It is exact also for tiny angles.
    """
    axis = 0.5 * np.array(
        [
            rotation[2, 1] - rotation[1, 2],
            rotation[0, 2] - rotation[2, 0],
            rotation[1, 0] - rotation[0, 1],
        ]
    )
    sine = _length(axis)
    cosine = (float(np.trace(rotation)) - 1.0) / 2.0
    if sine < 1e-9:
        # This formula finds no axis for a half turn, but frames do not resolve such a fast spin.
        return axis
    turned: Array = axis / sine * math.atan2(sine, cosine)
    return turned
