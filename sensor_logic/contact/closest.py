# SPDX-License-Identifier: GPL-3.0-or-later
"""Closest points of two convex sets of points: the algorithm of Gilbert, Johnson and Keerthi."""

from __future__ import annotations

import math

from ..arrays import Array

Vector = tuple[float, float, float]

MOST_STEPS = 100


def separation(a: Array, b: Array) -> tuple[float, Vector]:
    """Distance of the hulls of two sets of points (n, 3), and the unit direction from b to a.

    Distance and direction are zero where the hulls meet, to 1e-12 of their extent.
    """
    simplex: list[Vector] = []
    start = a[0] - b[0]
    v: Vector = (float(start[0]), float(start[1]), float(start[2]))
    extent = 1e-12 * (max(map(abs, v)) + float(abs(a - a[0]).max()) + float(abs(b - b[0]).max()))
    square = math.inf
    for _ in range(MOST_STEPS):
        i, j = int((a @ v).argmin()), int((b @ v).argmax())
        difference = a[i] - b[j]
        w: Vector = (float(difference[0]), float(difference[1]), float(difference[2]))
        if square < math.inf and (square - dot(v, w) <= 1e-14 * square or w in simplex):
            break
        closer, nearer = _nearest([*simplex, w])
        length = dot(closer, closer)
        if length <= extent * extent:
            return 0.0, (0.0, 0.0, 0.0)
        if length >= square:
            break
        simplex, v, square = nearer, closer, length
    distance = math.sqrt(square)
    return distance, (v[0] / distance, v[1] / distance, v[2] / distance)


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _along(p: Vector, d: Vector, t: float) -> Vector:
    return (p[0] + d[0] * t, p[1] + d[1] * t, p[2] + d[2] * t)


def _nearest(simplex: list[Vector]) -> tuple[Vector, list[Vector]]:
    """The simplex's point nearest to the origin, and the corners that it is made of."""
    if len(simplex) == 1:
        return simplex[0], simplex
    if len(simplex) == 2:
        return _on_segment(simplex[0], simplex[1])
    if len(simplex) == 3:
        return _on_triangle(simplex[0], simplex[1], simplex[2])
    p, q, r, s = simplex
    inside = True
    best, chosen, least = p, [p], math.inf
    for a, b, c, d in ((p, q, r, s), (p, q, s, r), (p, r, s, q), (q, r, s, p)):
        normal = _cross(_minus(b, a), _minus(c, a))
        here, there = -dot(normal, a), dot(normal, _minus(d, a))
        if here * there > 0:
            continue  # the origin is on the tetrahedron's side of this face
        inside = False
        point, corners = _on_triangle(a, b, c)
        if dot(point, point) < least:
            best, chosen, least = point, corners, dot(point, point)
    return ((0.0, 0.0, 0.0), simplex) if inside else (best, chosen)


def _on_segment(a: Vector, b: Vector) -> tuple[Vector, list[Vector]]:
    d = _minus(b, a)
    t, length = -dot(a, d), dot(d, d)
    if t <= 0:
        return a, [a]
    if t >= length:
        return b, [b]
    return _along(a, d, t / length), [a, b]


def _on_triangle(a: Vector, b: Vector, c: Vector) -> tuple[Vector, list[Vector]]:
    """Its plane's point where that lies inside, else the best of the three edges."""
    ab, ac = _minus(b, a), _minus(c, a)
    normal = _cross(ab, ac)
    square = dot(normal, normal)
    if square > 0:
        v = dot(_cross(ac, a), normal)
        w = dot(_cross(a, ab), normal)
        if v > 0 and w > 0 and v + w < square:
            t = dot(a, normal) / square
            return (normal[0] * t, normal[1] * t, normal[2] * t), [a, b, c]
    edges = (_on_segment(a, b), _on_segment(a, c), _on_segment(b, c))
    return min(edges, key=lambda edge: dot(edge[0], edge[0]))
