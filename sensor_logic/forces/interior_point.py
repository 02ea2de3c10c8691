# SPDX-License-Identifier: GPL-3.0-or-later
"""An interior-point method for the least spring energy under friction cones.

It converges in 10 to 60 steps if Newton's method zigzags, as it does near the apex of a friction
cone. There, the curvature of the energy changes by many orders of magnitude from step to step.

The method is Mehrotra's predictor-corrector [1]_ with Nesterov and Todd's scaling for second-order
cones [2]_. It works in the standard cone x₀ ≥ |x₁, x₂|. Let A be diag(1, o, o). A force A x is in a
friction cone of opening o if x is in the standard cone.

References
----------
.. [1] S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optim.
   2 (4), 1992.
.. [2] L. Vandenberghe, "The CVXOPT linear and quadratic cone program solvers", 2010, section 4
   (products of cones) and 5 (scaling).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from ..arrays import Array

MAX_STEPS = 60
# As a share of the step that reaches the surface of a cone.
SHORT_OF_SURFACE = 0.99
# The least product of the eigenvalues of a point's force and gap, as a share of their mean. A step
# that goes below it is shortened, because the next steps would be tiny.
CENTRAL = 0.01
# The duality gap, as a share of the squared forces. The energy is strongly convex, so the error of
# the forces is less than √(2 · gap) of their norm. CLOSED (an error of 1.4e-6) ends the steps. At
# ENOUGH (1.4e-3) the forces count as found, if rounding prevents a smaller gap.
CLOSED, ENOUGH = 1e-12, 1e-6
# The largest difference between the forces and the forces of the displacement, as a share of their
# norm.
EVEN = 1e-5
# The method ends after this many steps without a smaller gap, or at a step shorter than SHORTEST.
PATIENCE = 4
SHORTEST = 1e-8


class FrictionProblem(Protocol):
    """The input of `minimise_inside`: springs, friction cones and required wrenches."""

    @property
    def scaled(self) -> Array:
        """The matrix (6·bodies, m) from scaled forces to wrenches."""

    @property
    def offset(self) -> Array:
        """The offsets (m,) of the springs due to slack."""

    @property
    def opening(self) -> Array:
        """The openings (n,) of the friction cones."""

    @property
    def target(self) -> Array:
        """The required wrenches (6·bodies,)."""

    @property
    def count(self) -> int:
        """The number n of points."""


@dataclass(frozen=True)
class Inside:
    """The result of `minimise_inside`.

    Attributes
    ----------
    displacement
        The displacements (6·bodies,).
    given
        The scaled forces (m,), strictly inside their cones.
    steps
        The number of steps.
    closed
        Whether the method converged, because the duality gap became small enough.
    """

    displacement: Array
    given: Array
    steps: int
    closed: bool


def minimise_inside(
    problem: FrictionProblem, soft: Array, start: Array, near_enough: Array
) -> Inside:
    """Return the forces of least spring energy inside the friction cones, with the displacements.

    Parameters
    ----------
    problem
        The springs, the cones of n points and the required wrenches.
    soft
        The diagonal (6·bodies,) of the matrix E of balance.py, greater than 0.
    start
        The displacement (6·bodies,) to start from. A start near the solution saves few steps.
    near_enough
        The largest error (6·bodies,) of each component at which the wrenches count as balanced.

    Returns
    -------
    The result of the balanced step with the smallest duality gap. If no step was balanced, the
    displacement is from the last step, and the forces are zero.
    """
    count = problem.count
    contacts, ties = problem.scaled[:, : 3 * count], problem.scaled[:, 3 * count :]
    widths = np.ones((count, 3))
    widths[:, 1:] = problem.opening[:, None]
    contacts = contacts * widths.ravel()
    offset, tie_offset = problem.offset[: 3 * count] * widths.ravel(), problem.offset[3 * count :]
    fixed = ties @ ties.T + np.diag(soft)

    moved = start
    # Large compared with the forces of the first displacement: a small start makes the first steps
    # tiny.
    size = max(1.0, np.abs(start).max() * np.abs(contacts).max(), np.abs(offset).max(initial=0.0))
    force, gap = np.zeros((2, count, 3))
    force[:, 0] = gap[:, 0] = size
    best, found = np.inf, Inside(start, np.zeros(len(problem.offset)), 0, False)
    for steps in range(MAX_STEPS):
        tied = moved @ ties - tie_offset
        stretch = (widths**2 * force - gap).ravel() + offset - moved @ contacts
        left = contacts @ force.ravel() + ties @ tied + soft * moved - problem.target
        mean = float((force * gap).sum()) / count
        energy = float(((widths * force) ** 2).sum())
        is_even = np.abs(stretch).max() <= EVEN * energy**0.5
        is_balanced = is_even and (np.abs(left) <= near_enough).all()
        share = count * mean / energy
        if is_balanced and share < best:
            best = share
            given = np.concatenate([(widths * force).ravel(), tied])
            found = Inside(moved, given, steps, share <= ENOUGH)
        if best <= CLOSED or (found.closed and steps >= found.steps + PATIENCE):
            break
        scaling, point, inverse = _scaling(force, gap, widths)
        if not np.isfinite(inverse).all():
            break
        linear = _LinearSystem(contacts, fixed, widths, stretch, left, scaling, inverse)
        _, change, opened = linear.step(-point)
        reach = min(1.0, _length_to_surface(force, change), _length_to_surface(gap, opened))
        scaled_change = np.einsum("nij,nj->ni", scaling, change)
        aim = -_jordan_product(point, point) - _jordan_product(
            scaled_change, -point - scaled_change
        )
        aim[:, 0] += mean * max((1.0 - reach) ** 3, 1e-10)
        move, change, opened = linear.step(_jordan_quotient(aim, point))
        length = min(_length_to_surface(force, change), _length_to_surface(gap, opened))
        length = min(1.0, SHORT_OF_SURFACE * length)
        while length > SHORTEST and not _is_central(force + length * change, gap + length * opened):
            length *= 0.8
        if length <= SHORTEST:
            break
        moved = moved + length * move
        force, gap = force + length * change, gap + length * opened
    return found if np.isfinite(best) else replace(found, displacement=moved)


class _LinearSystem:
    """The conditions of a minimum, linearised at the present forces and gaps."""

    def __init__(
        self,
        contacts: Array,
        fixed: Array,
        widths: Array,
        stretch: Array,
        left: Array,
        scaling: Array,
        inverse: Array,
    ) -> None:
        count = len(widths)
        weighted = np.einsum("ank,nkj->anj", contacts.reshape(-1, count, 3), inverse)
        self._weighted = weighted.reshape(-1, 3 * count)
        self._hessian = self._weighted @ contacts.T + fixed
        self._contacts, self._widths, self._stretch, self._left = contacts, widths, stretch, left
        self._scaling, self._inverse = scaling, inverse

    def step(self, aim: Array) -> tuple[Array, Array, Array]:
        """Return the changes of displacement, forces and gaps in one step.

        The sum of the scaled changes of forces and gaps is `aim` (n, 3).
        """
        turned = np.einsum("nij,nj->ni", self._scaling, aim).ravel()
        move = solve(self._hessian, self._weighted @ (self._stretch - turned) - self._left)
        stretch = self._stretch - move @ self._contacts
        change: Array = np.einsum(
            "nij,nj->ni", self._inverse, (turned - stretch).reshape(aim.shape)
        )
        # From the first condition, because rounding errors of the scaling would add up.
        return move, change, self._widths**2 * change + stretch.reshape(aim.shape)


def solve(hessian: Array, right: Array) -> Array:
    """Solve a linear system, with a step of iterative refinement in case it is ill-conditioned."""
    found = np.linalg.solve(hessian, right)
    refined: Array = found + np.linalg.solve(hessian, right - hessian @ found)
    return refined


def _scaling(force: Array, gap: Array, widths: Array) -> tuple[Array, Array, Array]:
    """Return Nesterov and Todd's scaling of the forces f and the gaps g.

    Returns
    -------
    scaling
        W (n, 3, 3) with W f = W⁻¹ g.
    point
        The scaled point W f (n, 3).
    inverse
        (A² + W²)⁻¹ (n, 3, 3), in closed form, because W² is close to singular near the solution.
    """
    sizes = np.sqrt(_determinant(force)), np.sqrt(_determinant(gap))
    one, two = force / sizes[0][:, None], gap / sizes[1][:, None]
    cosine = np.sqrt((1.0 + np.einsum("ni,ni->n", one, two)) / 2.0)
    middle = two - one
    middle[:, 0] = two[:, 0] + one[:, 0]
    middle /= (2.0 * cosine)[:, None]
    square = sizes[1] / sizes[0]

    main = middle[:, 0]
    side = np.hypot(middle[:, 1], middle[:, 2])
    way = middle[:, 1:] / np.where(side > 0.0, side, 1.0)[:, None]
    along = np.einsum("ni,nj->nij", way, way)
    across = np.eye(2) - along

    def matrix(top: Array, mixed: Array, bottom: Array, rest: Array) -> Array:
        """Return [top, mixed; mixed, bottom] in the plane of the cone's axis and `way`, (n, 3, 3).

        Perpendicular to that plane, the matrix multiplies by `rest`.
        """
        whole = np.empty((len(force), 3, 3))
        whole[:, 0, 0] = top
        whole[:, 0, 1:] = whole[:, 1:, 0] = mixed[:, None] * way
        whole[:, 1:, 1:] = bottom[:, None, None] * along + rest[:, None, None] * across
        return whole

    root = np.sqrt(square)
    scaling = matrix(root * main, root * side, root * main, root)
    wide = widths[:, 1] ** 2
    cosh, sinh = square * (2.0 * main**2 - 1.0), square * 2.0 * main * side
    determinant = wide + cosh * (1.0 + wide) + square**2
    inverse = matrix(
        (wide + cosh) / determinant,
        -sinh / determinant,
        (1.0 + cosh) / determinant,
        1.0 / (wide + square),
    )
    point = np.empty_like(force)
    point[:, 0] = cosine
    point[:, 1:] = (cosine + two[:, 0])[:, None] * one[:, 1:]
    point[:, 1:] += (cosine + one[:, 0])[:, None] * two[:, 1:]
    point[:, 1:] /= (one[:, 0] + two[:, 0] + 2.0 * cosine)[:, None]
    point *= np.sqrt(sizes[0] * sizes[1])[:, None]
    return scaling, point, inverse


# The Jordan algebra of the standard cone: x ∘ y = (x·y, x₀ y₁ + y₀ x₁), det x = x₀² − |x₁|².


def _determinant(points: Array) -> Array:
    side = np.hypot(points[:, 1], points[:, 2])
    found: Array = (points[:, 0] - side) * (points[:, 0] + side)
    return found


def _jordan_product(one: Array, two: Array) -> Array:
    found: Array = one[:, :1] * two + two[:, :1] * one
    found[:, 0] = np.einsum("ni,ni->n", one, two)
    return found


def _jordan_quotient(product: Array, one: Array) -> Array:
    """Return the solution x of one ∘ x = product, where ∘ is the product in the comment above."""
    main = product[:, 0] * one[:, 0] - np.einsum("ni,ni->n", product[:, 1:], one[:, 1:])
    found = np.empty_like(product)
    found[:, 0] = main / _determinant(one)
    found[:, 1:] = (product[:, 1:] - found[:, :1] * one[:, 1:]) / one[:, :1]
    return found


def _length_to_surface(points: Array, change: Array) -> float:
    """Return the largest `length` at which all of `points + length · change` are in the cone."""
    square = change[:, 0] ** 2 - np.einsum("ni,ni->n", change[:, 1:], change[:, 1:])
    half = points[:, 0] * change[:, 0] - np.einsum("ni,ni->n", points[:, 1:], change[:, 1:])
    under = half**2 - square * _determinant(points)
    root = np.sqrt(np.maximum(under, 0.0))
    lengths = np.full(len(points), np.inf)
    nearing = (half < 0.0) & (under >= 0.0)
    lengths[nearing] = _determinant(points)[nearing] / (root - half)[nearing]
    leaving = (half >= 0.0) & (square < 0.0)
    lengths[leaving] = ((half + root)[leaving]) / -square[leaving]
    return float(lengths.min(initial=np.inf))


def _is_central(force: Array, gap: Array) -> bool:
    """Return whether all forces f and gaps g are inside their cones, and not too near the surfaces.

    At each point, √(det f · det g) must be at least CENTRAL times the mean of f · g over all
    points.
    """
    sizes = _determinant(force), _determinant(gap)
    inside = all((side > 0.0).all() for side in (force[:, 0], gap[:, 0], *sizes))
    if not inside:
        return False
    mean = float((force * gap).sum()) / len(force)
    return bool((np.sqrt(sizes[0]) * np.sqrt(sizes[1]) >= CENTRAL * mean).all())
