# SPDX-License-Identifier: GPL-3.0-or-later
"""The times at which moving rays intersect triangles, and the motion of a body between two poses.

A ray goes from a start to an end. The times are exact if both move in straight lines.

The line of a ray passes each edge of a triangle on one of two sides. The ray can intersect the
triangle only while all three sides are the same. The side is the sign of det(W, p, e): W is the ray
from start to end, p the vector from its start to a corner, and e the edge [1]_. If start and end
move in straight lines, the determinant is a quadratic function of time.

So an intersection can begin or end only at a root of such a function, or when start or end crosses
the triangle's plane. Between two successive of these times, nothing changes: a single test decides
for the whole interval.

References
----------
.. [1] C. Ericson, Real-Time Collision Detection (2005), 5.3.4: a line against a triangle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Array
from .trees import Index, TriangleTree

# As a fraction of the step's time. A shorter interval is a rounding error.
NO_TIME = 1e-9


@dataclass(frozen=True)
class RayCrossings:
    """Intersections (p,) of rays with moving solids during one step.

    Attributes
    ----------
    ray, solid
        The index of the ray and the number of the solid.
    begin, end
        When the intersection begins and ends, as fractions (0 to 1) of the step's time.
    near, far
        The distances of the hit from the ray's start, `near` at `begin` and `far` at `end`. Either
        can be the larger one. Between these times, the distance changes linearly.
    """

    ray: Index
    begin: Array
    end: Array
    near: Array
    far: Array
    solid: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.ray)

    def __getitem__(self, which: Index) -> RayCrossings:
        """Return the crossings with these indices, in this order."""
        return RayCrossings(*(column[which] for column in vars(self).values()))


def no_crossings() -> RayCrossings:
    """Return `RayCrossings` without any crossing."""
    none = np.zeros(0)
    return RayCrossings(np.zeros(0, np.intp), none, none, none, none, np.zeros(0, np.int64))


def joined(parts: list[RayCrossings]) -> RayCrossings:
    """Concatenate several `RayCrossings` to one."""
    if not parts:
        return no_crossings()
    columns = zip(*(vars(part).values() for part in parts), strict=True)
    return RayCrossings(*map(np.concatenate, columns))


def crossings(paths: Array, lengths: Array, triangles: TriangleTree, number: int) -> RayCrossings:
    """Return the intersections of moving rays with the triangles of one solid.

    Parameters
    ----------
    paths
        The ends of k rays at the n + 1 times that separate n equal intervals, (n + 1, k, 2, 3).
        Within an interval, the ends move in straight lines.
    lengths
        The lengths (k,) of the rays, in the unit of `near` and `far`.
    triangles
        The triangles of the solid.
    number
        The number that identifies the solid in the result.
    """
    pieces = len(paths) - 1
    found, order = [], []
    for piece, ray, triangle in triangles.near(paths[:-1], paths[1:]):
        pair, begin, end, near, far = _intersections(
            paths[piece, ray], paths[piece + 1, ray], triangles.corners[triangle]
        )
        piece, ray, triangle = piece[pair], ray[pair], triangle[pair]
        found.append(
            RayCrossings(
                ray,
                (piece + begin) / pieces,
                (piece + end) / pieces,
                near * lengths[ray],
                far * lengths[ray],
                np.full(len(ray), number, np.int64),
            )
        )
        order.append((piece * paths.shape[1] + ray) * len(triangles.corners) + triangle)
    if not found:
        return no_crossings()
    # Sorted, because the order in which the tree finds the crossings can change.
    return joined(found)[np.argsort(np.concatenate(order), kind="stable")]


def _intersections(
    before: Array, after: Array, corners: Array
) -> tuple[Index, Array, Array, Array, Array]:
    """Return the intersections of moving rays with triangles, for q pairs of a ray and a triangle.

    Parameters
    ----------
    before, after
        The ends (q, 2, 3) of the rays at the begin and at the end of a time interval.
    corners
        The triangles (q, 3, 3).

    Returns
    -------
    pair
        The index (p,) of the pair of each intersection.
    begin, end
        When the intersection begins and ends (p,), as fractions of the interval.
    near, far
        The distances (p,) along the ray at `begin` and at `end`, as fractions of the ray's length.
        Either of the two can be the larger one.
    """
    # Relative to the ray's start, so that the numbers are small.
    drift = after[:, 0] - before[:, 0]
    way, turn = before[:, 1] - before[:, 0], after[:, 1] - after[:, 0]
    turn = turn - way
    seen = corners - before[:, :1]
    edges = np.roll(corners, -1, axis=1) - corners
    normal = np.cross(edges[:, 0], edges[:, 1])
    still, going = np.cross(seen, edges), -np.cross(drift[:, None], edges)
    sides = np.stack(
        [
            np.einsum("qc,qec->qe", way, still),
            np.einsum("qc,qec->qe", turn, still) + np.einsum("qc,qec->qe", way, going),
            np.einsum("qc,qec->qe", turn, going),
        ],
        axis=-1,
    )
    # The share of the ray's length at the plane is height / slope, both linear in time.
    height = np.stack(
        [np.einsum("qc,qc->q", normal, seen[:, 0]), -np.einsum("qc,qc->q", normal, drift)], axis=-1
    )
    slope = np.stack(
        [np.einsum("qc,qc->q", normal, way), np.einsum("qc,qc->q", normal, turn)], axis=-1
    )
    beyond = height - slope
    with np.errstate(all="ignore"):
        moments = np.concatenate(
            [
                *_roots(sides),
                -height[:, :1] / height[:, 1:],
                -beyond[:, :1] / beyond[:, 1:],
                np.zeros((len(sides), 1)),
                np.ones((len(sides), 1)),
            ],
            axis=1,
        )
        moments = np.sort(np.clip(np.where(np.isnan(moments), 0.0, moments), 0.0, 1.0), axis=1)
        middle = (moments[:, 1:] + moments[:, :-1]) / 2.0
        side = _value(sides[:, None], middle[:, :, None])
        share = _value(height[:, None], middle) / _value(slope[:, None], middle)
        same = (side >= 0.0).all(axis=2) | (side <= 0.0).all(axis=2)
        is_hit = same & (share >= 0.0) & (share <= 1.0) & (np.diff(moments, axis=1) > NO_TIME)
        pair, gap = np.nonzero(is_hit)
        between = share[pair, gap]
        begin, end = moments[pair, gap], moments[pair, gap + 1]
        ends = [
            np.where(np.isfinite(at), np.clip(at, 0.0, 1.0), between)
            for at in (_value(height[pair], t) / _value(slope[pair], t) for t in (begin, end))
        ]
    return pair, begin, end, ends[0], ends[1]


def _value(coefficients: Array, at: Array) -> Array:
    """Return the values at `at` of polynomials; the last axis has coefficients, constant first."""
    value = coefficients[..., -1]
    for power in range(coefficients.shape[-1] - 2, -1, -1):
        value = value * at + coefficients[..., power]
    return np.asarray(value)


def _roots(quadratics: Array) -> tuple[Array, Array]:
    """Return the two roots of c0 + c1 t + c2 t² for each quadratic function, both (q, e).

    `quadratics` (q, e, 3) has c0, c1 and c2. A root that does not exist is NaN or infinite.
    """
    constant, linear, square = np.moveaxis(quadratics, -1, 0)
    # This form avoids the difference of two nearly equal numbers.
    apart = np.sqrt(linear * linear - 4.0 * square * constant)
    half = -(linear + np.where(linear < 0.0, -apart, apart)) / 2.0
    return half / square, constant / half


# The motion of a body between two known poses.
#
# By Chasles' theorem, a rigid body can move between any two poses by a screw: a rotation about an
# axis and a translation along it. At a constant rate, this is exact for a body that moves in a
# straight line without turning, and for a body that turns about a hinge, whatever its origin. A
# body that changes its size is also stretched at a constant rate (by the polar decomposition).

# Rotations in single precision deviate from rigid ones by less than this.
RIGID = 1e-5
# In rad. A smaller rotation is a rounding error; its centre would be too far away to compute.
SMALLEST_TURN = 1e-7
# In rad. The deviation of a path from a straight line is estimated over arcs of this angle.
ARC = math.pi / 8.0
# The least number of arcs for a stretched body.
FEWEST = 8
# Safety factor, because an arc deviates from a straight line only roughly as a parabola does.
ENOUGH = 0.8
# The most pieces that a path is cut into.
MOST = 10_000


class Movement:
    """The motion of a body between two poses: the matrices `before` and `after`, both (4, 4).

    The matrices are invertible and have the same handedness. For precision, their positions should
    be relative to a point near the body.

    Attributes
    ----------
    angle
        The angle of the rotation from `before` to `after`, 0 to π rad.
    rigid
        Whether the body keeps its size.
    still
        Whether the matrices are equal.
    """

    def __init__(self, before: Array, after: Array) -> None:
        self.before, self.after = before, after
        self.still = bool(np.array_equal(before, after))
        left, sizes, right = np.linalg.svd(after[:3, :3] @ np.linalg.inv(before[:3, :3]))
        turn = left @ right
        self.rigid = bool(np.abs(sizes - 1.0).max() < RIGID)
        # The change of size along the principal directions, as a matrix.
        self._longer = (right.T * (sizes - 1.0)) @ right
        self._axis, angle = _axis_and_angle(turn)
        self.angle = angle if angle > SMALLEST_TURN else 0.0
        if self.angle:
            shift = after[:3, 3] - turn @ before[:3, 3]
            self._glide = self._axis * (self._axis @ shift)
            across = shift - self._glide
            half = 1.0 / math.tan(self.angle / 2.0)
            self._centre = (across + half * np.cross(self._axis, across)) / 2.0

    def at(self, fractions: Array) -> Array:
        """Return the body's matrices (n, 4, 4) at `fractions` (n,) of the motion's time, 0 to 1."""
        between = fractions[:, None, None]
        if not self.angle:
            return np.asarray(self.before + between * (self.after - self.before))
        turns = _turns(self._axis, self.angle * fractions)
        matrices = np.tile(np.eye(4), (len(fractions), 1, 1))
        size = np.eye(3) if self.rigid else np.eye(3) + between * self._longer
        matrices[:, :3, :3] = turns @ size @ self.before[:3, :3]
        matrices[:, :3, 3] = turns @ (self.before[:3, 3] - self._centre) + self._centre
        matrices[:, :3, 3] += fractions[:, None] * self._glide
        return matrices


def _axis_and_angle(turn: Array) -> tuple[Array, float]:
    """Return the axis (3,) and the angle (0 to π rad) of a rotation."""
    odd = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2
    sine, cosine = float(np.linalg.norm(odd)), (float(np.trace(turn)) - 1.0) / 2.0
    angle = math.atan2(sine, cosine)
    if cosine > 0.0:
        return (odd / sine if sine > 0.0 else np.zeros(3)), angle
    # Near a half turn the antisymmetric part vanishes; the symmetric part is
    # cos·I + (1 − cos)·axis axisᵀ.
    even = (turn + turn.T) / 2.0 - cosine * np.eye(3)
    axis = even[:, int(np.argmax(np.diag(even)))]
    axis = axis / np.linalg.norm(axis)
    return (-axis if axis @ odd < 0.0 else axis), angle


def _turns(axis: Array, angles: Array) -> Array:
    """Return rotations (n, 3, 3) about an axis by angles (n,) in rad: Rodrigues' formula."""
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, rest = np.sin(angles)[:, None, None], (1.0 - np.cos(angles))[:, None, None]
    return np.asarray(np.eye(3) + sine * cross + rest * (cross @ cross))


def seen_from(body: Movement, sensor: Movement, fractions: Array, ends: Array) -> Array:
    """Return points that move with a sensor, in the local space of a moving body.

    Parameters
    ----------
    body, sensor
        The motions of both during a step.
    fractions
        The n times, as fractions (0 to 1) of the step's time.
    ends
        The positions (k, 3) of the points in the world at the end of the step.

    Returns
    -------
    The points (n, k, 3).
    """
    carried = sensor.at(fractions) @ np.linalg.inv(sensor.after)
    into = np.linalg.inv(body.at(fractions)) @ carried
    seen = np.einsum("nij,kj->nki", into[:, :3, :3], ends) + into[:, None, :3, 3]
    return np.asarray(seen)


def pieces_needed(body: Movement, sensor: Movement, ends: Array, tolerance: float) -> int:
    """Return the number of equal intervals into which a step is divided to follow moving points.

    The points move with the sensor. Within each interval, their paths as seen from the body are
    nearly straight.

    Parameters
    ----------
    body, sensor
        The motions of both during the step.
    ends
        The positions (k, 3) of the points in the world at the end of the step.
    tolerance
        The largest distance between a path and a straight line, in lengths of the world.
    """
    straight = body.rigid and sensor.rigid and not (body.angle or sensor.angle)
    if straight:
        return 1
    first = max(1 if body.rigid else FEWEST, math.ceil((body.angle + sensor.angle) / ARC))
    seen = seen_from(body, sensor, np.linspace(0.0, 1.0, 2 * first + 1), ends)
    strays = (seen[1::2] - (seen[:-1:2] + seen[2::2]) / 2.0) @ body.after[:3, :3].T
    stray = float(np.linalg.norm(strays, axis=2).max())
    # A short arc deviates most in its middle, by the square of its length.
    return min(MOST, first * max(1, math.ceil(math.sqrt(stray / ENOUGH / tolerance))))
