# SPDX-License-Identifier: GPL-3.0-or-later
"""When rays that move meet triangles: exactly, for rays whose ends go straight.

A ray meets a triangle as long as it passes its three edges on the same side. That side is the sign
of det(W, p, e), with W from the ray's start to its end, p from its start to a corner, and e along
the edge [1]: where the ray's ends go straight, a quadratic in time. Its roots, and the moments at
which an end goes through the triangle's plane, are the only ones at which it can begin or cease to
meet it; between them one look tells.

[1] C. Ericson, Real-Time Collision Detection (2005), 5.3.4: a line against a triangle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Array
from .triangle_tree import Index, TriangleTree

# Share of the time: what is shorter than this is rounding.
NO_TIME = 1e-9


@dataclass(frozen=True)
class Passes:
    """Times during which a ray meets something, (p,) each: which `ray`; from the share `begin` of
    a movement's time, 0 to 1, to its share `end`; how far from the ray's start then, `near` and
    `far`; and the number of what it meets. What is met in between is as far as in between."""

    ray: Index
    begin: Array
    end: Array
    near: Array
    far: Array
    thing: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.ray)

    def __getitem__(self, which: Index) -> Passes:
        """Some of them, in this order."""
        return Passes(
            self.ray[which],
            self.begin[which],
            self.end[which],
            self.near[which],
            self.far[which],
            self.thing[which],
        )


def no_passes() -> Passes:
    none = np.zeros(0)
    return Passes(np.zeros(0, np.intp), none, none, none, none, np.zeros(0, np.int64))


def joined(parts: list[Passes]) -> Passes:
    """All of them as one."""
    if not parts:
        return no_passes()
    return Passes(
        np.concatenate([p.ray for p in parts]),
        np.concatenate([p.begin for p in parts]),
        np.concatenate([p.end for p in parts]),
        np.concatenate([p.near for p in parts]),
        np.concatenate([p.far for p in parts]),
        np.concatenate([p.thing for p in parts]),
    )


def passes(ways: Array, lengths: Array, triangles: TriangleTree, number: int) -> Passes:
    """When rays meet the triangles of the thing `number`.

    `ways` (n + 1, k, 2, 3): both ends of k rays at the bounds of n equal times, between which they
    go straight; `lengths` (k,) what a ray is long, at which unit the passes tell how far.
    """
    pieces = len(ways) - 1
    found, order = [], []
    for piece, ray, triangle in triangles.near(ways[:-1], ways[1:]):
        pair, begin, end, near, far = _meetings(
            ways[piece, ray], ways[piece + 1, ray], triangles.corners[triangle]
        )
        piece, ray, triangle = piece[pair], ray[pair], triangle[pair]
        found.append(
            Passes(
                ray,
                (piece + begin) / pieces,
                (piece + end) / pieces,
                near * lengths[ray],
                far * lengths[ray],
                np.full(len(ray), number, np.int64),
            )
        )
        order.append((piece * ways.shape[1] + ray) * len(triangles.corners) + triangle)
    if not found:
        return no_passes()
    # One after the other as rays and triangles are, however these are found.
    return joined(found)[np.argsort(np.concatenate(order), kind="stable")]


def _meetings(
    before: Array, after: Array, corners: Array
) -> tuple[Index, Array, Array, Array, Array]:
    """Of pairs (q) of a ray, its ends `before` and `after` (q, 2, 3), and a triangle (q, 3, 3):
    the pair (p,), the shares of the time (p,) when it begins and ceases to meet it, and the shares
    of the ray's length (p,) at which it does so then."""
    # Seen from where the ray's start is, numbers are small.
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
    # The ray's length at which it goes through the plane: height / slope, both linear in time.
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
        met = same & (share >= 0.0) & (share <= 1.0) & (np.diff(moments, axis=1) > NO_TIME)
        pair, gap = np.nonzero(met)
        between = share[pair, gap]
        begin, end = moments[pair, gap], moments[pair, gap + 1]
        ends = [
            np.where(np.isfinite(at), np.clip(at, 0.0, 1.0), between)
            for at in (_value(height[pair], t) / _value(slope[pair], t) for t in (begin, end))
        ]
    return pair, begin, end, ends[0], ends[1]


def _value(coefficients: Array, at: Array) -> Array:
    """A polynomial, its coefficients along the last axis from the constant on."""
    value = coefficients[..., -1]
    for power in range(coefficients.shape[-1] - 2, -1, -1):
        value = value * at + coefficients[..., power]
    return np.asarray(value)


def _roots(quadratics: Array) -> tuple[Array, Array]:
    """The two real roots of c0 + c1 t + c2 t², (q, e, 3) → (q, e) twice; what is none is NaN or
    infinite."""
    constant, linear, square = np.moveaxis(quadratics, -1, 0)
    # Never the difference of two numbers that are nearly equal.
    apart = np.sqrt(linear * linear - 4.0 * square * constant)
    half = -(linear + np.where(linear < 0.0, -apart, apart)) / 2.0
    return half / square, constant / half
