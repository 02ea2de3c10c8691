# SPDX-License-Identifier: GPL-3.0-or-later
"""Convex collision shapes: the Minkowski sum of a polytope and a ball, as in physics engines.

The polytope is called the core. A sphere is a point plus a ball, a capsule is a segment plus a
ball. A hull with a collision margin is a polytope plus a ball whose radius is the margin. A
triangle of a mesh is a flat, two-sided polygon. Lengths are in metres.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..arrays import Array

# Corners, sides and edges of convex solids, from points and loops of points.

Indices = npt.NDArray[np.intp]

COPLANAR = 1e-6  # of the size: faces whose points deviate less from one plane are merged


def cross(a: Array, b: Array) -> Array:
    """Return the cross product of two vectors, ten times as fast as numpy's."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


def perpendiculars(direction: Array) -> tuple[Array, Array]:
    """Return two unit vectors that form a right-handed frame with the unit vector `direction`."""
    x, y, z = direction.tolist()
    # With the sign trick of Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
    sign = math.copysign(1.0, z)
    p = -1.0 / (sign + z)
    q = x * y * p
    first = np.array((1.0 + sign * x * x * p, sign * q, -sign * x))
    return first, np.array((q, sign + y * y * p, -y))


def sides(
    points: Array, planes: list[tuple[float, Array, float]], size: float
) -> list[tuple[int, ...]]:
    """Return the faces of a convex solid as loops of vertex indices.

    Each of the `planes` has the area of a face, its normal and its offset. Coplanar faces become
    one. The largest face comes first, because its plane is the most precise.
    """
    members: list[Indices] = []
    normals: list[Array] = []
    for _, normal, offset in sorted(planes, key=lambda plane: -plane[0]):
        on = np.flatnonzero(points @ normal >= offset - COPLANAR * size)
        if len(on) < 3 or any(len(np.setdiff1d(on, known)) == 0 for known in members):
            continue
        members.append(on)
        normals.append(normal)
    if len(members) < 4:
        raise ValueError("the faces do not close a solid")
    # A corner belongs to at least three sides; other points lie on an edge or inside a side.
    count = np.bincount(np.concatenate(members), minlength=len(points))
    loops = []
    for on, normal in zip(members, normals, strict=True):
        corners = on[count[on] >= 3]
        if len(corners) >= 3:
            loops.append(tuple(corners[around(points[corners], normal)].tolist()))
    return loops


def newell(loop: Array) -> Array:
    """Return the normal of a loop of points; its length is twice the area."""
    local = loop - loop[0]
    total: Array = np.cross(local, np.roll(local, -1, 0)).sum(0)
    return total


def thinnest(points: Array) -> tuple[float, Array]:
    """Return the extent of the points in the direction of least spread, and that direction."""
    local = points - points.mean(0)
    direction: Array = np.linalg.svd(local, full_matrices=True)[2][2]
    return float(np.ptp(local @ direction)), direction


def welded(points: Array, near: float) -> tuple[Array, Indices]:
    """Return the distinct points, and for each of the `points` (n, 3) its index (n,) among them.

    Points within `near` of each other count as one.
    """
    different: list[int] = []
    numbers = np.empty(len(points), np.intp)
    for i, point in enumerate(points):
        distance = np.abs(points[different] - point).max(1)
        same = np.flatnonzero(distance <= near)
        if len(same):
            numbers[i] = same[0]
        else:
            numbers[i] = len(different)
            different.append(i)
    return points[different], numbers


def around(points: Array, normal: Array) -> Indices:
    """Return the indices of a convex polygon's corners, counter-clockwise about `normal`."""
    first, second = perpendiculars(normal)
    local = points - points.mean(0)
    return np.argsort(np.arctan2(local @ second, local @ first), kind="stable")


def outline(points: Array, normal: Array) -> list[int]:
    """Return the indices of the corners of the points' convex hull as seen along `normal`.

    They are in counter-clockwise order. Raise ValueError if the points are on one line.
    """
    first, second = perpendiculars(normal)
    local = points - points.mean(0)
    x, y = (local @ first).tolist(), (local @ second).tolist()
    order = sorted(range(len(x)), key=lambda i: (x[i], y[i]))
    near = 1e-9 * extent(points) ** 2

    def chain(way: Iterable[int]) -> list[int]:
        out: list[int] = []
        for i in way:
            while len(out) > 1:
                a, b = out[-2], out[-1]
                if (x[b] - x[a]) * (y[i] - y[a]) - (y[b] - y[a]) * (x[i] - x[a]) > near:
                    break
                out.pop()
            out.append(i)
        return out[:-1]

    loop = chain(order) + chain(reversed(order))
    if len(loop) < 3:
        raise ValueError("the points lie on one line")
    return loop


def rims_of(faces: tuple[Indices, ...], vertices: int) -> Indices:
    """Return the edges (m, 4) of a solid: first and last vertex, left and right face.

    Raise ValueError if the faces do not close a convex solid.
    """
    if not faces:
        return np.array([(0, 1, -1, -1)] if vertices == 2 else [], np.intp).reshape(-1, 4)
    left: dict[tuple[int, int], int] = {}
    for number, face in enumerate(faces):
        loop = face.tolist()
        for start, end in zip(loop, loop[1:] + loop[:1], strict=True):
            left[start, end] = number
    rows = [(i, j, face, left.get((j, i), -1)) for (i, j), face in left.items() if i < j]
    if 2 * len(rows) != len(left) or any(other < 0 for *_, other in rows):
        raise ValueError("the faces do not close a convex solid")
    return np.array(rows, np.intp)


def unique_directions(spans: Array) -> Array:
    """Return the distinct unit directions of vectors (n, 3).

    Opposite directions count as the same.
    """
    if len(spans) == 0:
        return np.zeros((0, 3))
    spans = spans / np.linalg.norm(spans, axis=1, keepdims=True)
    same = np.abs(spans @ spans.T) > 1 - 1e-12
    first: Array = spans[np.argmax(same, axis=1) == np.arange(len(spans))]
    return first


def extent(points: Array) -> float:
    """Return twice the largest distance of a point from the mean of the points."""
    middle = points.mean(0)
    return 2 * math.sqrt(float(((points - middle) ** 2).sum(1).max()))


# The number of sides of round bodies. `turned` turns an edge between sides to the contact, so that
# rolling and lying bodies are exact. The disc under a standing cylinder is 0.29 % too small.
SIDES = 48
WELD = 1e-7  # of the shape's size: points closer than this are welded


@dataclass(frozen=True, eq=False, slots=True)
class Shape:
    """The Minkowski sum of a convex core and a ball.

    The corners of each face run counter-clockwise as seen from outside.
    """

    vertices: Array  # (n, 3)
    normals: Array  # (f, 3) outward, unit; none for points and segments, two for flat polygons
    offsets: Array  # (f,) n·x ≤ d inside the core
    faces: tuple[Indices, ...]
    edges: Array  # (e, 3) unique directions, unit, up to sign
    rims: Indices  # (m, 4) the core's edges: from and to vertex, the faces left and right of it
    radius: float  # of the ball
    size: float  # twice the largest distance from the mean vertex, with the ball
    lo: Array  # (3,) bounds, with the ball
    hi: Array
    axis: Array | None = None  # (2, 3) of a round body: a point on its axis, the unit direction

    @property
    def flat(self) -> bool:
        """Whether the core is a flat, two-sided polygon."""
        return len(self.faces) == 2

    def placed(self, matrix: npt.ArrayLike) -> Shape:
        """Return the shape in the world, placed by a 4×4 matrix.

        The radius of the ball does not change, even if the matrix scales, shears or mirrors.
        """
        m = np.asarray(matrix, np.float64)
        linear, shift = m[:3, :3], m[:3, 3]
        gram = linear @ linear.T
        rigid = bool(np.abs(gram - _UNIT).max() < 1e-6) and _determinant(linear) > 0
        if not rigid:
            return _transformed(self, linear, shift)
        vertices = self.vertices @ linear.T + shift
        normals = self.normals @ linear.T
        lo, hi = _bounds(vertices, self.radius)
        return Shape(
            vertices,
            normals,
            self.offsets + normals @ shift,
            self.faces,
            self.edges @ linear.T,
            self.rims,
            self.radius,
            self.size,
            lo,
            hi,
            None if self.axis is None else self.axis @ linear.T + np.outer((1.0, 0.0), shift),
        )

    def turned(self, direction: Array) -> Shape:
        """Return a round body rotated about its axis, with an edge of its core facing `direction`.

        `direction` is a unit vector (3,). Return the shape itself if it is not round.
        """
        if self.axis is None:
            return self
        origin, axis = self.axis
        wanted = direction - axis * (direction @ axis)
        arm = self.vertices[0] - origin
        arm = arm - axis * (arm @ axis)
        across = cross(axis, arm)
        away = math.atan2(float(wanted @ across), float(wanted @ arm))
        step = 2 * math.pi / SIDES
        angle = away - step * round(away / step)
        if math.hypot(*wanted.tolist()) < 1e-6 or abs(angle) < 1e-12:
            return self
        matrix = np.eye(4)
        matrix[:3, :3] = rotation_about(axis, angle)
        matrix[:3, 3] = origin - matrix[:3, :3] @ origin
        return self.placed(matrix)


_UNIT = np.eye(3)


def box(half_extents: npt.ArrayLike) -> Shape:
    """Return a box with these half extents."""
    half = _positive(*np.asarray(half_extents, np.float64).reshape(3).tolist())
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    loops = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return _assembled(corners, loops, 0.0)


def sphere(radius: float) -> Shape:
    """Return a sphere."""
    _positive(radius)
    return _assembled(np.zeros((1, 3)), (), radius)


def capsule(radius: float, half_length: float) -> Shape:
    """Return a capsule along z, with round ends beyond ±half_length; length 0 gives a sphere."""
    _positive(radius)
    if half_length == 0:
        return sphere(radius)
    _positive(half_length)
    return _assembled(np.array([(0, 0, -half_length), (0, 0, half_length)]), (), radius)


def cylinder(radius: float, half_height: float) -> Shape:
    """Return a cylinder along z."""
    _positive(radius, half_height)
    n = SIDES
    rim = _circle(radius)
    vertices = np.vstack([rim - (0, 0, half_height), rim + (0, 0, half_height)])
    around = [(i, (i + 1) % n, (i + 1) % n + n, i + n) for i in range(n)]
    loops = [tuple(reversed(range(n))), tuple(range(n, 2 * n)), *around]
    return _assembled(vertices, loops, 0.0, np.array([(0, 0, 0), (0, 0, 1.0)]))


def cone(radius: float, half_height: float) -> Shape:
    """Return a cone along z, with the tip at +half_height and the base at −half_height."""
    _positive(radius, half_height)
    n = SIDES
    vertices = np.vstack([_circle(radius) - (0, 0, half_height), (0, 0, half_height)])
    around = [(i, (i + 1) % n, n) for i in range(n)]
    loops = [tuple(reversed(range(n))), *around]
    return _assembled(vertices, loops, 0.0, np.array([(0, 0, 0), (0, 0, 1.0)]))


def polygon(vertices: npt.ArrayLike, radius: float = 0.0) -> Shape:
    """Return a flat convex polygon, such as a triangle of a mesh.

    Raise ValueError if the polygon has no area or is not flat.
    """
    points = _points(vertices)
    size = extent(points)
    normal = newell(points)
    length = float(np.linalg.norm(normal))
    if length <= 1e-9 * size * size:
        raise ValueError("a polygon needs an area")
    normal = normal / length
    if np.abs((points - points.mean(0)) @ normal).max() > 1e-3 * size:
        raise ValueError("a polygon must be flat")
    loop = outline(points, normal)
    points = points[loop]
    up = tuple(range(len(points)))
    return _assembled(points, (up, up[::-1]), radius)


def polytope(vertices: npt.ArrayLike, faces: Iterable[Sequence[int]], radius: float = 0.0) -> Shape:
    """Return a convex solid with the given faces.

    The faces are triangles or polygons, and can run in either direction. Coplanar faces are merged.
    A solid without thickness becomes a flat polygon. Raise ValueError for a solid without area.
    """
    points = _points(vertices)
    size = extent(points)
    points, names = welded(points, WELD * size)
    middle = points.mean(0)
    thickness, normal = thinnest(points)
    if thickness <= COPLANAR * size:
        return polygon(points[outline(points, normal)], radius)
    planes: list[tuple[float, Array, float]] = []
    for face in faces:
        loop = points[names[np.asarray(face, np.intp)]]
        area = newell(loop)
        length = float(np.linalg.norm(area))
        if length <= 1e-10 * size * size:
            continue  # a degenerate face has no plane
        area = area / length
        if area @ (loop.mean(0) - middle) < 0:
            area = -area
        planes.append((length, area, float((points @ area).max())))
    loops = sides(points, planes, size)
    return _assembled(points, loops, radius)


def _assembled(
    vertices: Array, loops: Sequence[Sequence[int]], radius: float, axis: Array | None = None
) -> Shape:
    if not (math.isfinite(radius) and radius >= 0):
        raise ValueError("the radius must not be negative")
    used = sorted({i for loop in loops for i in loop}) if loops else range(len(vertices))
    renamed = {old: new for new, old in enumerate(used)}
    vertices = np.ascontiguousarray(vertices[list(used)], np.float64)
    faces = tuple(np.array([renamed[i] for i in loop], np.intp) for loop in loops)
    areas = [newell(vertices[face]) for face in faces]
    normals = np.array([area / np.linalg.norm(area) for area in areas]).reshape(-1, 3)
    offsets = (normals @ vertices.T).max(1, initial=-math.inf)
    rims = rims_of(faces, len(vertices))
    span = vertices[rims[:, 1]] - vertices[rims[:, 0]]
    lo, hi = _bounds(vertices, radius)
    size = extent(vertices) + 2 * radius
    edges = unique_directions(span)
    return Shape(vertices, normals, offsets, faces, edges, rims, radius, size, lo, hi, axis)


def _transformed(shape: Shape, linear: Array, shift: Array) -> Shape:
    """Return the shape placed by a matrix that is not a rotation.

    `linear` (3, 3) is the linear part of the matrix, and `shift` (3,) the translation.
    """
    volume = _determinant(linear)
    if not np.isfinite(linear).all() or abs(volume) <= 1e-12 * np.abs(linear).max() ** 3:
        raise ValueError("the matrix flattens the shape")
    vertices = shape.vertices @ linear.T + shift
    faces = shape.faces if volume > 0 else tuple(face[::-1] for face in shape.faces)
    rims = shape.rims if volume > 0 else shape.rims[:, [0, 1, 3, 2]]
    normals = shape.normals @ np.linalg.inv(linear)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    offsets = np.array(
        [normal @ vertices[face[0]] for normal, face in zip(normals, faces, strict=True)]
    )
    span = vertices[rims[:, 1]] - vertices[rims[:, 0]]
    lo, hi = _bounds(vertices, shape.radius)
    size = extent(vertices) + 2 * shape.radius
    axis = None if shape.axis is None else _transformed_axis(shape.axis, linear, shift)
    edges = unique_directions(span)
    return Shape(vertices, normals, offsets, faces, edges, rims, shape.radius, size, lo, hi, axis)


def _transformed_axis(line: Array, linear: Array, shift: Array) -> Array | None:
    """Return the axis of a round body after a transformation; None if circles become ellipses."""
    first, second = perpendiculars(line[1])
    x, y, axis = linear @ first, linear @ second, linear @ line[1]
    axis = axis / np.linalg.norm(axis)
    longest = max(float(x @ x), float(y @ y))
    crooked = max(abs(float(x @ y)), abs(float(x @ x - y @ y)))
    tilt = max(abs(float(axis @ x)), abs(float(axis @ y)))
    if crooked > 1e-6 * longest or tilt > 1e-6 * math.sqrt(longest):
        return None
    return np.array([linear @ line[0] + shift, axis])


def rotation_about(axis: Array, angle: float) -> Array:
    """Return the rotation (3, 3) about a unit axis by an angle in rad: Rodrigues' formula."""
    x, y, z = axis.tolist()
    turn = np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))
    rotation: Array = _UNIT + math.sin(angle) * turn + (1 - math.cos(angle)) * (turn @ turn)
    return rotation


def _circle(radius: float) -> Array:
    angle = 2 * math.pi / SIDES * np.arange(SIDES)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(SIDES)])


def _positive(*lengths: float) -> tuple[float, ...]:
    if not all(math.isfinite(length) and length > 0 for length in lengths):
        raise ValueError("lengths must be above zero")
    return lengths


def _points(vertices: npt.ArrayLike) -> Array:
    points = np.array(vertices, np.float64).reshape(-1, 3)
    if len(points) == 0 or not np.isfinite(points).all():
        raise ValueError("a shape needs finite vertices")
    return points


def _bounds(vertices: Array, radius: float) -> tuple[Array, Array]:
    return vertices.min(0) - radius, vertices.max(0) + radius


def _determinant(m: Array) -> float:
    (a, b, c), (d, e, f), (g, h, i) = m.tolist()
    return float(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))
