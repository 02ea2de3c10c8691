# SPDX-License-Identifier: GPL-3.0-or-later
"""The contact forces that keep bodies in balance: an elastic foundation with friction.

Each contact point is a spring that can push and rub, but not pull. Each body takes the small
displacement at which its springs give the wrench that the body needs. If statics alone do not
determine the forces, as on four legs, the stiffnesses of the springs do (Winkler's elastic
foundation).

The displacements λ (six numbers a body) minimise an energy φ, which is convex and once
differentiable:

φ(λ) = Σ ½ |P_C(K½ (Gᵀλ − δ))|² + ½ λᵀ E λ − wᵀλ

- G maps contact forces to wrenches.
- K has the stiffnesses of the springs, and δ their slacks.
- P_C projects on the friction cones C.
- w has the required wrenches.
- E is a diagonal matrix of softnesses, tiny for each component of the balance that must be met.

The gradient of φ is "forces minus wrench". If no forces can meet the balance, E keeps the minimum
finite, and E λ is the part of the wrench that remains. Newton's method with a line search finds the
minimum. If it takes too many steps, an interior-point method does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from ..arrays import Array
from .interior_point import minimise_inside, solve

Mask = npt.NDArray[np.bool_]

GROUND = -1
# The stiffness of tangential springs relative to normal springs. It is small, so that friction
# carries only what normal forces cannot.
TANGENTIAL = 0.01
# E for a balance that must be met, for a body that requires the whole force. It is small compared
# with the required wrench, but large enough that an impossible balance is found in a few steps.
HARD = 1e-6
LEAST_HARD = 1e-12
# A balance with a larger E need not be met.
FREE = 1e-5
AGAIN = 2
# Newton's method zigzags if it needs more steps. A limit of 12 makes tumbling piles 30 % slower.
MAX_STEPS = 50
MAX_HALVINGS = 30
# The tolerance of the minimum of φ, as a share of a body's required wrench.
SETTLED = 1e-7


@dataclass(frozen=True)
class Load:
    """The required wrench (force and moment) of a body.

    Attributes
    ----------
    centre
        The point (3,) in m that the moment is about.
    wrench
        The force in N and the moment in N·m, (6,).
    size
        A length in m. Moments divided by it are compared with forces.
    softness
        A number for each component of the wrench (6,): 0 if the balance of that component must be
        met, else larger. The components are along the rows of `axes`, then about them.
    axes
        The axes of `softness`, as rows (3, 3).
    """

    centre: Array
    wrench: Array
    size: float
    softness: Array = field(default_factory=lambda: np.zeros(6))
    axes: Array = field(default_factory=lambda: np.eye(3))


@dataclass(frozen=True)
class Points:
    """n contact points.

    Attributes
    ----------
    places
        The points (n, 3) in m.
    normals
        Unit normals (n, 3) from body `b` to body `a`.
    a, b
        The indices (n,) of the bodies; GROUND for a body that does not move.
    friction
        The friction coefficients (n,).
    stiffness
        The stiffnesses (n,) of the springs, above 0. Only their ratios matter.
    slack
        The gap (n,) between the bodies at each point, in units of the mean indentation.
    """

    places: Array
    normals: Array
    a: npt.NDArray[np.intp]
    b: npt.NDArray[np.intp]
    friction: Array
    stiffness: Array
    slack: Array


@dataclass(frozen=True)
class Joint:
    """A constraint between bodies `a` and `b`.

    Attributes
    ----------
    a, b
        The indices of the bodies; GROUND for a body that does not move.
    place
        The point (3,) in m where the constraint acts.
    forces
        The axes (k, 3) along which it can exert forces.
    moments
        The axes (m, 3) about which it can exert moments.
    stiffness
        The stiffness of its springs, divided by the total stiffness of the contact points.
    """

    a: int
    b: int
    place: Array
    forces: Array
    moments: Array
    stiffness: float


@dataclass(frozen=True)
class Balance:
    """The result of `balance`.

    Attributes
    ----------
    forces
        The force (n, 3) in N on body `a` at each point.
    depths
        The indentation (n,) at each point, in units of the mean indentation; negative for a gap.
    missing
        The part (bodies, 6) of each body's required wrench that no force provides.
    steps
        The number of steps of the solver.
    settled
        Whether the solver converged.
    """

    forces: Array
    depths: Array
    missing: Array
    steps: int
    settled: bool


class _Arguments:
    """The arguments of `balance` as a key for the cache; equal if all numbers are equal."""

    def __init__(self, loads: Sequence[Load], points: Points, joints: Sequence[Joint]) -> None:
        self.loads, self.points, self.joints = loads, points, joints
        parts = [[*vars(points).values()], *([*vars(part).values()] for part in (*loads, *joints))]
        arrays = [np.asarray(value) for part in parts for value in part]
        # With the shapes, so that different arguments never have the same key.
        self._key = tuple((array.shape, array.tobytes()) for array in arrays)
        self._hash = hash(self._key)

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Arguments) and self._key == other._key


def balance(loads: Sequence[Load], points: Points, joints: Sequence[Joint] = ()) -> Balance:
    """Return the contact forces that keep bodies in balance, in read-only arrays.

    Body i has the required wrench `loads[i]`.
    """
    return _balance(_Arguments(loads, points, joints))


# Keeps 64 islands: without the cache, a body at rest takes 0.6 ms (four legs) or more each frame.
@lru_cache(maxsize=64)
def _balance(arguments: _Arguments) -> Balance:
    loads, points, joints = arguments.loads, arguments.points, arguments.joints
    axes = np.stack([load.axes for load in loads])
    wrench = _in_axes(axes, np.stack([load.wrench for load in loads]))
    sizes = np.array([load.size for load in loads])
    unit = np.ones((len(loads), 6))
    unit[:, 3:] /= sizes[:, None]
    scale = float(np.abs(wrench * unit).sum()) or 1.0
    target = (wrench * unit / scale).ravel()

    count = len(points.places)
    frames = _frames(points.normals)
    mapping = _mapping(loads, points, frames, axes, unit)
    stiffness = points.stiffness / (points.stiffness.sum() or 1.0)
    tied, tied_stiffness = _joint_columns(loads, joints, unit)
    springs = np.concatenate([np.repeat(stiffness, 3), tied_stiffness])
    springs[: 3 * count].reshape(count, 3)[:, 1:] *= TANGENTIAL
    both = np.concatenate([mapping, tied], axis=1)
    root = np.sqrt(springs)
    scaled = both * root
    offset = np.zeros(len(springs))
    offset[0 : 3 * count : 3] = points.slack
    offset *= root
    # In the scaled space, the friction cone is wider by the ratio of the springs.
    opening = points.friction / np.sqrt(TANGENTIAL)
    # The tolerance of a light body depends on its own wrench, not on heavy bodies on top of it.
    share = np.abs(wrench * unit).sum(axis=1) / scale
    hard = np.maximum(HARD * share, LEAST_HARD)
    soft = np.stack([load.softness * s for load, s in zip(loads, share, strict=True)])
    soft = soft + hard[:, None]
    soft = soft.ravel()
    near_enough = np.repeat(SETTLED * share, 6) + 1e-12
    problem = _Problem(scaled, offset, opening, target, count)
    found = _minimise(problem, soft, problem.unconstrained(soft), near_enough)
    steps, settled = found.steps, found.settled
    for _ in range(AGAIN):
        # Add the residual of E to the target (method of multipliers).
        residual = np.where(soft < FREE, soft * found.displacement, 0.0)
        problem = replace(problem, target=target + residual)
        found = _minimise(problem, soft, found.displacement, near_enough)
        steps, settled = steps + found.steps, settled and found.settled
    given = found.given

    local = (given * root * scale)[: 3 * count].reshape(count, 3)
    forces = np.einsum("nij,ni->nj", frames, local)
    depths = found.displacement @ mapping[:, ::3] - points.slack
    for result in (forces, depths):
        result.flags.writeable = False
    missing = (target - scaled @ given).reshape(-1, 6) * scale / unit
    return Balance(forces, depths, _in_axes(axes.transpose(0, 2, 1), missing), steps, settled)


def _in_axes(axes: Array, wrenches: Array) -> Array:
    """Return wrenches (n, 6) in other axes, which are the rows of the matrices `axes` (n, 3, 3)."""
    parts: Array = np.einsum("nij,nkj->nki", axes, wrenches.reshape(-1, 2, 3)).reshape(-1, 6)
    return parts


def _frames(normals: Array) -> Array:
    """Return frames (n, 3, 3), whose rows are the normal of a point and two tangents."""
    helper = np.where(np.abs(normals[:, :1]) < 0.7, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    one = np.cross(normals, helper)
    one /= np.linalg.norm(one, axis=1)[:, None]
    return np.stack([normals, one, np.cross(normals, one)], axis=1)


def _mapping(
    loads: Sequence[Load], points: Points, frames: Array, axes: Array, unit: Array
) -> Array:
    """Return the matrix (6·bodies, 3n) that maps forces at n points to wrenches on the bodies.

    The forces are in the `frames` of the points, the wrenches in the `axes` of the bodies. Wrenches
    are multiplied by `unit` (bodies, 6), so that moments are comparable with forces.
    """
    count = len(points.places)
    mapping = np.zeros((len(loads), 6, count, 3))
    index = np.arange(count)
    for bodies, sign in ((points.a, 1.0), (points.b, -1.0)):
        moved = index[bodies != GROUND]
        if not len(moved):
            continue
        rows = bodies[moved]
        centres = np.stack([load.centre for load in loads])[rows]
        arms = points.places[moved] - centres
        directions = frames[moved]
        moments = np.cross(arms[:, None, :], directions)
        body_axes = axes[rows].transpose(0, 2, 1)
        both = np.concatenate([directions @ body_axes, moments @ body_axes], axis=2) * sign
        mapping[rows, :, moved, :] += both.transpose(0, 2, 1) * unit[rows][:, :, None]
    return mapping.reshape(6 * len(loads), 3 * count)


def _joint_columns(
    loads: Sequence[Load], joints: Sequence[Joint], unit: Array
) -> tuple[Array, Array]:
    """Return the columns that joints add to the matrix of `_mapping`, and their stiffnesses.

    There is a column for each axis of a joint. It has the wrenches on the bodies from a unit force
    along the axis, or from a unit moment about it.
    """
    columns, stiffness = [], []
    for joint in joints:
        for force in joint.forces:
            columns.append(_column(loads, joint, force, None, unit))
        for moment in joint.moments:
            columns.append(_column(loads, joint, None, moment, unit))
        stiffness += [joint.stiffness] * (len(joint.forces) + len(joint.moments))
    if not columns:
        return np.empty((6 * len(loads), 0)), np.empty(0)
    return np.stack(columns, axis=1), np.array(stiffness)


def _column(
    loads: Sequence[Load], joint: Joint, force: Array | None, moment: Array | None, unit: Array
) -> Array:
    column = np.zeros((len(loads), 6))
    # Scaled with the bodies' size, so that its spring is comparable with springs of forces.
    size = min(loads[body].size for body in (joint.a, joint.b) if body != GROUND)
    for body, sign in ((joint.a, 1.0), (joint.b, -1.0)):
        if body == GROUND:
            continue
        if force is not None:
            column[body, :3] += sign * loads[body].axes @ force
            arm = joint.place - loads[body].centre
            column[body, 3:] += sign * loads[body].axes @ np.cross(arm, force)
        if moment is not None:
            column[body, 3:] += sign * loads[body].axes @ moment * size
    return (column * unit).ravel()


@dataclass(frozen=True)
class _State:
    """The energy φ of the module docstring at a displacement, with terms of its derivatives.

    Attributes
    ----------
    value, gradient
        φ, and its gradient (6·bodies,).
    given
        The scaled forces (m,), after the projection on the friction cones.
    sticks, slips
        Masks (n,) of points. A point sticks if its force is inside its friction cone, and slips if
        its force is on the cone's surface.
    size
        The magnitude (n,) of the tangential force, before the projection.
    onto
        The normal component (n,) of the force, after the projection, at points that slip.
    way
        The unit direction (n, 2) of the tangential force.
    """

    value: float
    gradient: Array
    given: Array
    sticks: Mask
    slips: Mask
    size: Array
    onto: Array
    way: Array


@dataclass(frozen=True)
class _Minimum:
    displacement: Array
    given: Array
    steps: int
    settled: bool


@dataclass(frozen=True)
class _Problem:
    """The terms of the energy φ of the module docstring, except ½ λᵀ E λ.

    Attributes
    ----------
    scaled
        The matrix (6·bodies, m) from scaled forces to wrenches. The first 3n columns belong to the
        n points, the others to joints.
    offset
        The offsets (m,) of the springs due to slack.
    opening
        The openings (n,) of the friction cones.
    target
        The required wrenches (6·bodies,).
    count
        The number n of points.
    """

    scaled: Array
    offset: Array
    opening: Array
    target: Array
    count: int

    def unconstrained(self, soft: Array) -> Array:
        """Return the displacement for points that could also pull and would never slip."""
        hessian = self.scaled @ self.scaled.T
        hessian[np.diag_indices_from(hessian)] += soft
        return solve(hessian, self.target + self.scaled @ self.offset)

    def state(self, displacement: Array, soft: Array) -> _State:
        """Return the energy φ, its gradient and the forces at a displacement."""
        wanted = displacement @ self.scaled - self.offset
        given = wanted.copy()
        local = wanted[: 3 * self.count].reshape(self.count, 3)
        press = local[:, 0]
        rub = local[:, 1:]
        size = np.sqrt(np.einsum("ij,ij->i", rub, rub))
        opening = self.opening
        sticks = (press >= 0.0) & (size <= opening * press)
        loose = ~sticks & (opening * size <= -press)
        slips = ~sticks & ~loose
        onto = np.where(slips, (press + opening * size) / (1.0 + opening**2), 0.0)
        way = rub / np.where(size > 0.0, size, 1.0)[:, None]
        forces = given[: 3 * self.count].reshape(self.count, 3)
        forces[loose] = 0.0
        forces[slips, 0] = onto[slips]
        forces[slips, 1:] = (opening * onto)[slips, None] * way[slips]
        gradient = self.scaled @ given + soft * displacement - self.target
        value = 0.5 * float(given @ given) + 0.5 * float(soft @ displacement**2)
        value -= float(self.target @ displacement)
        return _State(value, gradient, given, sticks, slips, size, onto, way)

    def hessian(self, state: _State) -> Array:
        """Return Σ Gᵢ Jᵢ Gᵢᵀ over the points i; J is the derivative of the projection on a cone."""
        jacobian = np.zeros((self.count, 3, 3))
        jacobian[state.sticks] = np.eye(3)
        index = np.flatnonzero(state.slips)
        if len(index):
            mu, way, size = self.opening[index], state.way[index], state.size[index]
            ray = np.concatenate([np.ones((len(index), 1)), mu[:, None] * way], axis=1)
            part: Array = np.einsum("ni,nj->nij", ray, ray) / (1.0 + mu**2)[:, None, None]
            across = np.eye(2) - np.einsum("ni,nj->nij", way, way)
            turning = mu * state.onto[index] / np.where(size > 0.0, size, 1.0)
            part[:, 1:, 1:] += turning[:, None, None] * across
            jacobian[index] = part
        # One matrix product for each direction is several times as fast as a single product.
        tied = self.scaled[:, 3 * self.count :]
        hessian: Array = tied @ tied.T
        pushes = self.scaled[:, : 3 * self.count]
        directions = [np.ascontiguousarray(pushes[:, i::3]) for i in range(3)]
        for j, contacts in enumerate(directions):
            pushed = sum(other * jacobian[:, i, j] for i, other in enumerate(directions))
            hessian += pushed @ contacts.T
        return hessian


def _minimise(problem: _Problem, soft: Array, displacement: Array, near_enough: Array) -> _Minimum:
    """Return the minimum of the energy φ, searched from `displacement`.

    Newton's method mostly takes 1 to 4 steps of 0.15 ms. If it zigzags, the interior-point method
    takes 10 to 60 steps of 0.25 ms.
    """
    found = _newton(problem, soft, displacement, near_enough)
    if found.settled or not problem.count:
        return found
    inside = minimise_inside(problem, soft, displacement, near_enough)
    steps = found.steps + inside.steps
    # The interior-point method leaves all forces inside their cones. Newton's method, started from
    # its result, puts slipping forces on the cones' surfaces, which is more exact.
    found = _newton(problem, soft, inside.displacement, near_enough)
    steps += found.steps
    if found.settled or not inside.closed:
        return replace(found, steps=steps)
    return _Minimum(inside.displacement, inside.given, steps, True)


def _newton(problem: _Problem, soft: Array, displacement: Array, near_enough: Array) -> _Minimum:
    """Search the minimum of the energy φ from `displacement` by Newton's method.

    The search ends if no component of the gradient is larger than the same component of
    `near_enough`.
    """
    state = problem.state(displacement, soft)
    step = 0
    for step in range(MAX_STEPS):
        if (np.abs(state.gradient) <= near_enough).all():
            return _Minimum(displacement, state.given, step, True)
        hessian = problem.hessian(state)
        hessian[np.diag_indices_from(hessian)] += soft
        way = solve(hessian, -state.gradient)
        promised = float(state.gradient @ way)
        if promised >= 0.0:
            break
        length = 1.0
        for _ in range(MAX_HALVINGS):
            tried = problem.state(displacement + length * way, soft)
            if tried.value <= state.value + 1e-4 * length * promised + 1e-16 * abs(state.value):
                break
            length *= 0.5
        else:
            break
        displacement = displacement + length * way
        gained, state = state.value - tried.value, tried
        if gained <= 1e-15 * max(abs(state.value), 1e-30) and length == 1.0:
            return _Minimum(displacement, state.given, step + 1, True)
    settled = bool((np.abs(state.gradient) <= 100.0 * near_enough).all())
    return _Minimum(displacement, state.given, step + 1, settled)
