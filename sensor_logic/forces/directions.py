# SPDX-License-Identifier: GPL-3.0-or-later
"""The direction in which two convex shapes push each other.

For separate shapes, it is the direction between their closest points. For shapes with overlapping
cores, it is the direction of the shortest translation that separates the cores. Directions of faces
are preferred to directions of edges. So small errors in the poses do not switch the contact from a
face to an edge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .shapes import SIDES, Shape, perpendiculars

# The closest points of two convex hulls: the algorithm of Gilbert, Johnson and Keerthi.

Vector = tuple[float, float, float]

MOST_STEPS = 100


def separation(a: Array, b: Array) -> tuple[float, Vector]:
    """Return the distance of the convex hulls of two point sets, and the direction from b to a.

    The sets `a` and `b` are (n, 3). The direction is a unit vector. Distance and direction are zero
    if the hulls overlap or nearly touch, to within 1e-12 of their extent.
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
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _along(p: Vector, d: Vector, t: float) -> Vector:
    return (p[0] + d[0] * t, p[1] + d[1] * t, p[2] + d[2] * t)


def _nearest(simplex: list[Vector]) -> tuple[Vector, list[Vector]]:
    """Return the point of the simplex nearest to the origin, and the corners that determine it."""
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
    """Return the triangle's point nearest to the origin, and the corners that determine it."""
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


FLAT = math.cos(math.radians(2))  # a face or edge tilted further touches with an edge or a corner
TOUCHING = 1e-5  # of the smaller shape's size: cores closer than this count as overlapping
SAME = 2e-6  # of that size: depths that differ by less are equal, and the order of faces decides
EDGE_BIAS = 0.005  # of that size: an edge must separate better than a face by this much
PLANE_SHARE = 0.25  # of a body's depth: a body sunk into a polygon by less is on one side of it
MANY = 60_000  # products of edges and corners up to which all pairs of edges are tried


@dataclass(slots=True)
class Direction:
    """A candidate for the direction in which shape b pushes shape a.

    `face_a` or `face_b` is the index of the face whose normal is this direction, if it is a face's.
    """

    normal: Array  # (3,) unit, from b to a
    separation: float  # of the cores along the direction, in m; negative: they overlap
    accept: float  # the largest gap of a contact that confirms this direction
    face_a: int | None = None
    face_b: int | None = None
    last: bool = False  # no other candidate follows

    @staticmethod
    def of(pair: Pair, normal: Array) -> Direction:
        """Return the last candidate of a pair, with this normal."""
        apart = float((pair.at_a @ normal).min() - (pair.at_b @ normal).max())
        return Direction(normal, apart, pair.tolerance, last=True)


class Pair:
    """Two shapes in the world, with coordinates relative to a vertex of the first shape.

    Relative coordinates keep the precision far from the origin of the world.
    """

    __slots__ = ("a", "at_a", "at_b", "b", "origin", "plane", "scale", "swept", "tolerance")

    def __init__(self, a: Shape, b: Shape, tolerance: float) -> None:
        self.a, self.b, self.tolerance = a, b, tolerance
        self.origin = a.vertices[0]
        self.at_a, self.at_b = a.vertices - self.origin, b.vertices - self.origin
        self.scale = min(a.size, b.size)
        self.swept = a.radius + b.radius
        self.plane: Array | None = None  # normal of a flat polygon that the other lies on

    def penetrating(self, direction: Direction) -> bool:
        """Return whether the cores overlap along a direction."""
        return direction.separation < TOUCHING * self.scale

    def frame(self, normal: Array) -> Array:
        """Return axes as rows (3, 3): the last is the normal, the first is aligned with an edge."""
        nx, ny, nz = normal.tolist()
        for shape in (self.a, self.b):
            for x, y, z in shape.edges[:3].tolist():
                along = x * nx + y * ny + z * nz
                if abs(along) < 0.8:
                    x, y, z = x - along * nx, y - along * ny, z - along * nz
                    length = math.sqrt(x * x + y * y + z * z)
                    x, y, z = x / length, y / length, z / length
                    across = (ny * z - nz * y, nz * x - nx * z, nx * y - ny * x)
                    return np.array(((x, y, z), across, (nx, ny, nz)))
        return np.vstack([*perpendiculars(normal), normal])


def candidates(pair: Pair) -> Iterator[Direction]:
    """Yield directions to try for the contact of a pair, the likeliest first.

    Yield none if a direction proves that the gap is above the pair's tolerance.
    """
    a, b, scale = pair.a, pair.b, pair.scale
    limit = pair.tolerance + pair.swept
    face = None
    if len(a.faces) or len(b.faces):
        face = _best_face(pair)
        if face is None or face.separation > limit:
            return
        if face.separation > -EDGE_BIAS * scale:
            yield face
    edge = _best_edge(pair)
    if edge is not None and edge.separation > limit:
        return
    best = max((d.separation for d in (face, edge) if d is not None), default=0.0)
    if best < TOUCHING * scale:
        yield from _overlap_directions(pair, face, edge)
        return
    if edge is not None and edge.separation >= best:
        yield edge
    yield from _gap_direction(pair)


def _overlap_directions(
    pair: Pair, face: Direction | None, edge: Direction | None
) -> Iterator[Direction]:
    """Yield directions for cores that seem to overlap along `face` and `edge`.

    If the cores are separate after all, yield the direction of their closest points.
    """
    apart, normal = separation(pair.at_a, pair.at_b)
    if apart > TOUCHING * pair.scale:
        yield from _gap_direction(pair, (apart, normal))
        return
    known = [d for d in (face, edge) if d is not None]
    if not known:
        yield Direction.of(pair, _any_direction(pair))
        return
    if face is not None and edge is not None:
        bias = EDGE_BIAS * pair.scale + 0.1 * abs(face.separation)
        if edge.separation > face.separation + bias:
            known.reverse()
    for number, direction in enumerate(known):
        direction.accept, direction.last = pair.tolerance, number == len(known) - 1
        if direction.face_a is not None or direction.face_b is not None:
            direction.last = True
        yield direction


def _gap_direction(
    pair: Pair, known: tuple[float, tuple[float, float, float]] | None = None
) -> Iterator[Direction]:
    """Yield the direction between the closest points of two separate cores.

    Yield nothing if the cores overlap or are too far apart. `known` is the result of `separation`
    for these cores, if it is already known.
    """
    apart, toward = known or separation(pair.at_a, pair.at_b)
    if apart <= 0 or apart > pair.tolerance + pair.swept:
        return
    normal = np.array(toward)
    if pair.plane is not None and abs(float(normal @ pair.plane)) < 0.7:
        return  # beside the polygon: its neighbour in the mesh has the contact
    yield Direction(normal, apart, pair.tolerance, last=True)


def _best_face(pair: Pair) -> Direction | None:
    """Return the face normal that separates the shapes farthest, as a `Direction`.

    Among equal faces, it is the first. Return None if no face can touch, as for a body beside a
    flat polygon.
    """
    a, b, scale = pair.a, pair.b, pair.scale
    pair.plane = _flat_normal(pair)
    best: Direction | None = None
    for shape, other, sign in ((a, pair.at_b, -1.0), (b, pair.at_a, 1.0)):
        if not len(shape.faces):
            continue
        offsets = shape.offsets - shape.normals @ pair.origin
        apart = (other @ shape.normals.T).min(0) - offsets
        if pair.plane is not None and not shape.flat:
            apart[np.abs(shape.normals @ pair.plane) < 0.7] = -math.inf
        top = float(apart.max())
        slack = SAME * scale if top < TOUCHING * scale else 0.0
        if best is not None and top <= best.separation + slack:
            continue
        number = int((apart >= top - slack).argmax())
        found = float(apart[number])
        best = Direction(sign * shape.normals[number], found, _accepted_gap(pair, found))
        if shape is a:
            best.face_a = number
        else:
            best.face_b = number
    return best


def _flat_normal(pair: Pair) -> Array | None:
    """Return the normal of a flat shape; None if its plane cuts the other shape or none is flat.

    The flat shape is a polygon of a mesh. A body beside it touches the neighbouring polygon of the
    mesh, not the edge of this one.
    """
    for flat, flat_at, solid, at in (
        (pair.a, pair.at_a, pair.b, pair.at_b),
        (pair.b, pair.at_b, pair.a, pair.at_a),
    ):
        if flat.flat and len(solid.faces) and not solid.flat:
            heights = (at - flat_at[0]) @ flat.normals[0]
            low, high = float(heights.min()), float(heights.max())
            if max(low, -high) > -PLANE_SHARE * (high - low) - 1e-9 * pair.scale:
                normal: Array = flat.normals[0]
                return normal
    return None


def _best_edge(pair: Pair) -> Direction | None:
    """Return the common normal of two edges that separates the shapes farthest, as a `Direction`.

    One edge is of shape a, the other of shape b. Return None if there is no such normal.
    """
    a, b = pair.a, pair.b
    pairs = len(a.edges) * len(b.edges)
    if pairs == 0:
        return None
    if pairs * (len(a.vertices) + len(b.vertices)) > MANY and not (a.flat or b.flat):
        return _best_arc(pair)
    axes = np.cross(a.edges[:, None, :], b.edges[None, :, :]).reshape(-1, 3)
    lengths = np.sqrt((axes * axes).sum(1))
    good = lengths > 1e-4
    if pair.plane is not None:
        good &= np.abs(axes @ pair.plane) >= 0.7 * lengths
    if not good.any():
        return None
    axes = axes[good] / lengths[good, None]
    of_a, of_b = pair.at_a @ axes.T, pair.at_b @ axes.T
    ahead, behind = of_a.min(0) - of_b.max(0), of_b.min(0) - of_a.max(0)
    first, second = int(ahead.argmax()), int(behind.argmax())
    if ahead[first] >= behind[second]:
        return _edge_direction(pair, axes[first], float(ahead[first]))
    return _edge_direction(pair, -axes[second], float(behind[second]))


def _edge_direction(pair: Pair, normal: Array, apart: float) -> Direction:
    return Direction(normal, apart, _accepted_gap(pair, apart))


def _accepted_gap(pair: Pair, apart: float) -> float:
    """Return the largest gap at which a contact along a direction confirms that direction.

    It is the distance `apart` of the cores minus the radii of both shapes, plus a small slack.
    """
    slack = 2 * SAME * pair.scale - 0.1 * apart if apart < TOUCHING * pair.scale else 0.0
    return apart - pair.swept + max(slack, 1e-7 * pair.scale)


def _best_arc(pair: Pair) -> Direction | None:
    """Return the same result as `_best_edge`, faster for shapes with many edges.

    Each edge is an arc on the Gauss sphere, between the normals of its two faces. Only pairs of
    edges whose arcs cross can touch [1]_.

    References
    ----------
    .. [1] D. Gregorius, "The Separating Axis Test between Convex Polyhedra", GDC 2013.
    """
    a, b = pair.a, pair.b
    start_a, start_b = pair.at_a[a.rims[:, 0]], pair.at_b[b.rims[:, 0]]
    edge_a = pair.at_a[a.rims[:, 1]] - start_a
    edge_b = pair.at_b[b.rims[:, 1]] - start_b
    left_a, right_a = a.normals[a.rims[:, 2]], a.normals[a.rims[:, 3]]
    left_b, right_b = -b.normals[b.rims[:, 2]], -b.normals[b.rims[:, 3]]
    cba, dba = edge_a @ left_b.T, edge_a @ right_b.T
    adc, bdc = left_a @ edge_b.T, right_a @ edge_b.T
    i, j = np.nonzero((cba * dba < 0) & (adc * bdc < 0) & (cba * bdc > 0))
    axes = np.cross(edge_a[i], edge_b[j])
    lengths = np.sqrt((axes * axes).sum(1))
    size = np.sqrt((edge_a[i] ** 2).sum(1) * (edge_b[j] ** 2).sum(1))
    good = lengths > 1e-4 * size
    if not good.any():
        return None
    i, j, axes = i[good], j[good], axes[good] / lengths[good, None]
    outward = np.sign((axes * (left_a[i] + right_a[i])).sum(1))
    axes = axes * -outward[:, None]  # now from b to a
    apart = (axes * (start_a[i] - start_b[j])).sum(1)
    best = int(apart.argmax())
    return _edge_direction(pair, axes[best], float(apart[best]))


def _any_direction(pair: Pair) -> Array:
    """Return a direction for points or segments that coincide, the same for the same shapes."""
    spans = [shape.edges[0] for shape in (pair.a, pair.b) if len(shape.edges)]
    if not spans:
        return np.array((0.0, 0.0, 1.0))
    return perpendiculars(spans[0])[0]


def side_direction(a: Shape, b: Shape) -> Array | None:
    """Return the direction from b to a if a cylinder touches the other shape with its round side.

    The direction is computed for the cylinder's axis, as for a capsule. The result is None if a
    cylinder touches with an end, and for cones.
    """
    cores = [_axis_ends(a), _axis_ends(b)]
    if cores[0] is None and cores[1] is None:
        return None
    points = [
        shape.vertices if core is None else core for shape, core in zip((a, b), cores, strict=True)
    ]
    origin = points[0][0]
    apart, toward = separation(points[0] - origin, points[1] - origin)
    if apart <= 1e-9 * min(a.size, b.size):
        return None
    for shape, core in zip((a, b), cores, strict=True):
        if core is not None and shape.axis is not None:
            x, y, z = shape.axis[1].tolist()
            if abs(x * toward[0] + y * toward[1] + z * toward[2]) > 1e-4:
                return None
    return np.array(toward)


def has_better_face(pair: Pair, direction: Direction) -> bool:
    """Return whether a face normal separates the shapes clearly farther than `direction` does."""
    face = _best_face(pair)
    return face is not None and face.separation > direction.separation + 0.003 * pair.scale


def _axis_ends(shape: Shape) -> Array | None:
    if shape.axis is None or len(shape.vertices) != 2 * SIDES:
        return None
    ends: Array = shape.vertices.reshape(2, SIDES, 3).mean(1)
    return ends
