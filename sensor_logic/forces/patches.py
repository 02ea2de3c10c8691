# SPDX-License-Identifier: GPL-3.0-or-later
"""The contact of two convex shapes: points, normal, gaps, and the area that each point represents.

First the direction of the contact is found (directions.py). Then the face, edge or corner of each
shape that faces the other shape is projected along this direction. The intersection of the two
projections is the area of contact. Lengths are in metres. In all functions, `frame` (3, 3) has the
axes of the contact as rows; the last axis is the normal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from .directions import FLAT, Direction, Pair, candidates, has_better_face, side_direction
from .shapes import Shape

# Convex polygons in a plane, as lists of (x, y). For few points, plain Python is faster than numpy.

Point = tuple[float, float]

CORNER_SHARE = 1e-3  # of the area, for each corner, so that an edge can carry a tipping body
MOST_CORNERS = 16


def clipped_by(polygon: Sequence[Point], x: float, y: float, d: float) -> list[Point]:
    """Return the part of a convex polygon or segment in the half-plane x·px + y·py ≤ d."""
    heights = [x * p[0] + y * p[1] - d for p in polygon]
    if max(heights) <= 0:
        return list(polygon)
    if min(heights) > 0:
        return []
    out: list[Point] = []
    last, high = polygon[-1], heights[-1]
    if len(polygon) == 2:  # a segment has one edge, not two
        last, high = polygon[0], heights[0]
    for point, height in zip(polygon, heights, strict=True):
        if (height > 0) != (high > 0):
            t = high / (high - height)
            out.append((last[0] + (point[0] - last[0]) * t, last[1] + (point[1] - last[1]) * t))
        if height <= 0:
            out.append(point)
        last, high = point, height
    return out


def clipped(subject: Sequence[Point], by: Sequence[Point], near: float) -> list[Point]:
    """Return the intersection of two convex polygons, segments or points, counter-clockwise.

    `near` is the largest distance at which points and segments still count as intersecting.
    """
    if len(by) < len(subject) if len(by) < 3 else 3 <= len(subject) < len(by):
        subject, by = by, subject  # cut with the polygon that has fewer sides
    if len(by) >= 3:
        out = list(subject)
        px, py = by[-1]
        for qx, qy in by:
            ex, ey = qx - px, qy - py
            length = math.hypot(ex, ey)
            if length > 0:
                x, y = ey / length, -ex / length
                out = clipped_by(out, x, y, x * px + y * py + near)
                if not out:
                    return out
            px, py = qx, qy
        return out
    if len(by) == 2:
        return _on_segment(subject, by, near)
    gap = math.hypot(subject[0][0] - by[0][0], subject[0][1] - by[0][1])
    return list(subject) if gap <= near else []


def _on_segment(subject: Sequence[Point], by: Sequence[Point], near: float) -> list[Point]:
    (px, py), (qx, qy) = by
    length = math.hypot(qx - px, qy - py)
    x, y = (qx - px) / length, (qy - py) / length
    along = [(p[0] - px) * x + (p[1] - py) * y for p in subject]
    aside = [(p[1] - py) * x - (p[0] - px) * y for p in subject]
    if len(subject) == 1:
        inside = abs(aside[0]) <= near and -near <= along[0] <= length + near
        return list(subject) if inside else []
    slope = abs(aside[1] - aside[0])
    if slope > 1e-3 * math.hypot(along[1] - along[0], slope):  # they cross
        t = aside[0] / (aside[0] - aside[1])
        span = math.hypot(along[1] - along[0], slope)
        s = along[0] + (along[1] - along[0]) * t
        if not (-near <= t * span <= span + near and -near <= s <= length + near):
            return []
        return [(px + x * s, py + y * s)]
    first, last = max(0.0, min(along)), min(length, max(along))
    if first > last + near or abs(aside[0] + aside[1]) / 2 > near + slope:
        return []
    middle = (aside[0] + aside[1]) / 4
    return [(px + x * s - y * middle, py + y * s + x * middle) for s in (first, last)]


def moments(polygon: Sequence[Point]) -> tuple[float, float, float, float, float, float]:
    """Return area, centroid (x, y), and the mean of x², xy and y² relative to the centroid."""
    ox, oy = polygon[0]
    area = sx = sy = sxx = sxy = syy = 0.0
    ax = ay = 0.0
    for px, py in list(polygon[1:]) + [polygon[0]]:
        bx, by = px - ox, py - oy
        cross = ax * by - bx * ay
        area += cross
        sx += cross * (ax + bx)
        sy += cross * (ay + by)
        sxx += cross * (ax * ax + ax * bx + bx * bx)
        syy += cross * (ay * ay + ay * by + by * by)
        sxy += cross * (2 * ax * ay + ax * by + bx * ay + 2 * bx * by)
        ax, ay = bx, by
    if area == 0.0:
        return 0.0, ox, oy, 0.0, 0.0, 0.0
    x, y = sx / (3 * area), sy / (3 * area)
    return (
        area / 2,
        ox + x,
        oy + y,
        sxx / (6 * area) - x * x,
        sxy / (12 * area) - x * y,
        syy / (6 * area) - y * y,
    )


def without_duplicates(polygon: Sequence[Point], near: float) -> list[Point]:
    """Return the polygon without corners that are within `near` of the previous corner."""
    out: list[Point] = []
    for point in polygon:
        if not out or math.hypot(point[0] - out[-1][0], point[1] - out[-1][1]) > near:
            out.append(point)
    while len(out) > 1 and math.hypot(out[0][0] - out[-1][0], out[0][1] - out[-1][1]) <= near:
        out.pop()
    return out


def farthest_pair(polygon: Sequence[Point]) -> tuple[Point, Point]:
    """Return the two points that are farthest apart."""
    best, ends = -1.0, (polygon[0], polygon[0])
    for i, p in enumerate(polygon):
        for q in polygon[i + 1 :]:
            distance = (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2
            if distance > best * (1 + 1e-9):
                best, ends = distance, (p, q)
    return ends


def fewer_corners(polygon: Sequence[Point], most: int = MOST_CORNERS) -> list[Point]:
    """Return the polygon with at most `most` corners.

    The corners whose removal changes the area least are removed first.
    """
    out = list(polygon)
    if len(out) <= most:
        return out
    cuts = [_cut_off(out, i) for i in range(len(out))]
    while len(out) > most:
        # With equal areas, every other corner of a round outline is removed first.
        least = min(cuts) + 1e-6 * abs(min(cuts))
        i = next(i for i, cut in enumerate(cuts) if cut <= least)
        del out[i], cuts[i]
        for j in (i - 1, i % len(out)):
            cuts[j] = _cut_off(out, j)
    return out


def _cut_off(polygon: Sequence[Point], i: int) -> float:
    """Return twice the area that the polygon loses without corner i."""
    (px, py), (qx, qy), (rx, ry) = polygon[i - 1], polygon[i], polygon[(i + 1) % len(polygon)]
    return (qx - px) * (ry - py) - (qy - py) * (rx - px)


def samples(polygon: Sequence[Point], corners: Sequence[Point]) -> tuple[list[Point], list[float]]:
    """Return sample points of a polygon, and their areas.

    They integrate polynomials up to the second degree exactly. Four points have nearly all of the
    area: the centroid plus (±1, ±1) times the square root of the covariance. On an axis-aligned
    rectangle they are the 2×2 Gauss points. They are inside every convex polygon [1]_. The
    `corners` come after them, each with CORNER_SHARE of the area.

    References
    ----------
    .. [1] Kannan, Lovász, Simonovits 1995, theorem 4.1.
    """
    area, x, y, sxx, sxy, syy = moments(polygon)
    share = CORNER_SHARE
    rest = 1 - share * len(corners)
    local = [(p[0] - x, p[1] - y) for p in corners]
    mx = -share * sum(p[0] for p in local) / rest
    my = -share * sum(p[1] for p in local) / rest
    sxx = (sxx - share * sum(p[0] * p[0] for p in local)) / rest - mx * mx
    sxy = (sxy - share * sum(p[0] * p[1] for p in local)) / rest - mx * my
    syy = (syy - share * sum(p[1] * p[1] for p in local)) / rest - my * my
    # Square root of a 2×2 matrix: (S + √det·1) / √(trace + 2√det).
    root = math.sqrt(max(sxx * syy - sxy * sxy, 0.0))
    below = math.sqrt(sxx + syy + 2 * root)
    a, b, c = (sxx + root) / below, sxy / below, (syy + root) / below
    x, y = x + mx, y + my
    points = [(x + i * a + j * b, y + i * b + j * c) for i in (-1, 1) for j in (-1, 1)]
    return [*points, *corners], [rest * area / 4] * 4 + [share * area] * len(corners)


def hull(points: Sequence[Point], near: float) -> list[Point]:
    """Return the convex hull of points, counter-clockwise.

    The hull of collinear points is a segment. The hull of equal points is a single point. Points
    within `near` of each other count as equal.
    """
    ordered = sorted(points)

    def chain(way: Sequence[Point]) -> list[Point]:
        out: list[Point] = []
        for p in way:
            while len(out) > 1:
                (ax, ay), (bx, by) = out[-2], out[-1]
                if (bx - ax) * (p[1] - ay) - (by - ay) * (p[0] - ax) > 0:
                    break
                out.pop()
            out.append(p)
        return out[:-1]

    loop = without_duplicates(chain(ordered) + chain(ordered[::-1]), near) or ordered[:1]
    if len(loop) < 3:
        return loop
    p, q = farthest_pair(loop)
    length = math.hypot(q[0] - p[0], q[1] - p[1])
    return loop if abs(moments(loop)[0]) > near * length else [p, q]


NARROW = 1e-3  # of a shape's size: the width of contact lines and points
DEEP = 0.01  # of the smaller shape's size: beyond this depth all points below the surface touch
TURNS = 4  # iterations that turn the sides of round bodies towards the contact of true circles


@dataclass(frozen=True, eq=False, slots=True)
class Patch:
    """The contact of body a with body b."""

    points: Array  # (k, 3) in the world, midway between the two surfaces
    normal: Array  # (3,) unit, from b to a: the direction of the force on a
    gaps: Array  # (k,) in m, between the surfaces along the normal; negative: they overlap
    # (k,) in m²: the share of the contact's area. Sums weighted with areas integrate second-degree
    # polynomials over a polygon exactly. A line is NARROW times the smaller shape's size wide, a
    # point is a square of that side.
    areas: Array


def contact_patch(a: Shape, b: Shape, tolerance: float) -> Patch | None:
    """Return the contact of two placed shapes; None if they are more than `tolerance` m apart."""
    if (a.lo > b.hi + tolerance).any() or (b.lo > a.hi + tolerance).any():
        return None
    if _sorting_key(a) <= _sorting_key(b):
        return _contact(a, b, tolerance)
    patch = _contact(b, a, tolerance)
    return None if patch is None else Patch(patch.points, -patch.normal, patch.gaps, patch.areas)


def _sorting_key(shape: Shape) -> tuple[float, ...]:
    """Return a sorting key, so that the contact of two shapes does not depend on their order."""
    return (len(shape.vertices), -shape.size, *shape.lo.tolist())


def _contact(a: Shape, b: Shape, tolerance: float) -> Patch | None:
    if a.axis is None and b.axis is None:
        return _find_contact(Pair(a, b, tolerance))
    side = side_direction(a, b)
    if side is not None:
        pair = Pair(a.turned(-side), b.turned(side), tolerance)
        direction = Direction.of(pair, side)
        direction.last = False
        if not has_better_face(pair, direction):
            patch = _contact_along(pair, direction)
            if patch is not None:
                return patch
    # Before they are turned, the sides are less than 0.3 % of the radius inside the circle.
    rough = _find_contact(Pair(a, b, tolerance + 0.003 * max(a.size, b.size)))
    if rough is None:
        return None
    for _ in range(TURNS):
        turned = a.turned(-rough.normal), b.turned(rough.normal)
        if turned == (a, b):
            break
        a, b = turned
        patch = _find_contact(Pair(a, b, tolerance))
        if patch is None:
            break
        moved = float(np.abs(patch.normal - rough.normal).max())
        rough = patch
        if moved < 1e-7:
            break
    near = rough.gaps <= tolerance
    if near.all() or not near.any():
        return rough if near.any() else None
    return Patch(rough.points[near], rough.normal, rough.gaps[near], rough.areas[near])


def _find_contact(pair: Pair) -> Patch | None:
    for direction in candidates(pair):
        patch = _contact_along(pair, direction)
        if patch is not None and patch.gaps.min() <= direction.accept:
            return patch
    return None


class _Surface:
    """A face, edge or corner in the contact's frame: an outline in x and y, and a height along z.

    The height is linear in x and y.
    """

    __slots__ = ("outline", "slope_x", "slope_y", "x", "y", "z")

    def __init__(self, rows: list[list[float]], normal: tuple[float, float, float] | None) -> None:
        self.outline: list[Point] = [(row[0], row[1]) for row in rows]
        self.x, self.y, self.z = rows[0]
        self.slope_x = self.slope_y = 0.0
        if normal is not None:
            self.slope_x, self.slope_y = -normal[0] / normal[2], -normal[1] / normal[2]
        elif len(rows) == 2:
            dx, dy, dz = (q - p for p, q in zip(*rows, strict=True))
            slope = dz / (dx * dx + dy * dy)
            self.slope_x, self.slope_y = dx * slope, dy * slope

    def height(self, x: float, y: float) -> float:
        return self.z + self.slope_x * (x - self.x) + self.slope_y * (y - self.y)


def _contact_along(pair: Pair, direction: Direction) -> Patch | None:
    """Return the contact of two shapes along one direction, or None if there is none.

    If the shapes overlap deeply, and do not touch with a face each, all overlapping points are in
    contact. Otherwise one face, edge or corner of each shape is in contact.
    """
    frame = pair.frame(direction.normal)
    deep = -direction.separation
    if deep > DEEP * pair.scale and pair.penetrating(direction):
        flat = _feature_contact(pair, direction, frame)
        if flat is not None and flat[1] != 1:
            return flat[0]
        lowest = [] if flat is None else ((flat[0].points - pair.origin) @ frame[:2].T).tolist()
        return _overlap_contact(pair, frame, deep, lowest) or (None if flat is None else flat[0])
    flat = _feature_contact(pair, direction, frame)
    return None if flat is None else flat[0]


def _feature_contact(pair: Pair, direction: Direction, frame: Array) -> tuple[Patch, int] | None:
    """Return the contact between the nearest features of two shapes, and the number of faces.

    A feature is a face, edge or corner of a shape. `frame` (3, 3) has the axes of the contact as
    rows: the last one is the normal. The number says how many of the two features are faces; it is
    1 for a contact of one point. Return None if the features do not touch.
    """
    normal = direction.normal
    upper = _feature(pair.a, pair.at_a, -normal, frame, direction.face_a)
    lower = _feature(pair.b, pair.at_b, normal, frame, direction.face_b)
    upper.outline.reverse()  # seen from inside
    near = 1e-9 * pair.scale if direction.separation > 0 else 1e-6 * pair.scale
    outline = clipped(upper.outline, lower.outline, 0.0)
    outline = outline or clipped(upper.outline, lower.outline, near)
    if not outline:
        return (_point_contact(pair, direction, frame, upper, lower), 1) if direction.last else None
    swept = pair.a.radius + pair.b.radius
    gaps = [upper.height(x, y) - lower.height(x, y) - swept for x, y in outline]
    if min(gaps) > pair.tolerance:
        return None
    if max(gaps) > pair.tolerance and len(outline) > 1:
        sx, sy = upper.slope_x - lower.slope_x, upper.slope_y - lower.slope_y
        x, y = outline[0]
        limit = pair.tolerance - gaps[0] + sx * x + sy * y
        outline = clipped_by(outline, sx, sy, limit) or [outline[gaps.index(min(gaps))]]
    points, areas = _sample_outline(outline, pair.scale)
    top = [upper.height(x, y) - pair.a.radius for x, y in points]
    bottom = [lower.height(x, y) + pair.b.radius for x, y in points]
    faces = (len(upper.outline) > 2) + (len(lower.outline) > 2)
    return _patch(pair, frame, points, areas, np.array(top), np.array(bottom)), faces


def _point_contact(
    pair: Pair, direction: Direction, frame: Array, upper: _Surface, lower: _Surface
) -> Patch:
    """Return a contact of one point, for projected outlines that do not intersect.

    The caller has proven that `direction` is the direction of the contact. `frame` is as for
    `_feature_contact`.
    """
    outline = clipped(upper.outline, lower.outline, pair.scale)
    outline = outline or [upper.outline[0], lower.outline[0]]
    x = sum(p[0] for p in outline) / len(outline)
    y = sum(p[1] for p in outline) / len(outline)
    top = float((pair.at_a @ direction.normal).min()) - pair.a.radius
    bottom = top - direction.separation + pair.a.radius + pair.b.radius
    wide = NARROW * pair.scale
    return _patch(pair, frame, [(x, y)], [wide * wide], np.array([top]), np.array([bottom]))


def _overlap_contact(
    pair: Pair, frame: Array, deep: float, lowest: list[list[float]]
) -> Patch | None:
    """Return the contact of two shapes that overlap by `deep` m.

    Of each shape, the part within `deep` of its farthest point is projected. The intersection of
    both projections is the contact. The points `lowest` become sample points if they are in it.
    """
    upper = hull(_cut_slab(pair.at_a, pair.a, frame, -1.0, deep), 1e-9 * pair.scale)
    lower = hull(_cut_slab(pair.at_b, pair.b, frame, 1.0, deep), 1e-9 * pair.scale)
    outline = clipped(upper, lower, 0.0) or clipped(upper, lower, 1e-6 * pair.scale)
    if not outline:
        return None
    weld = 1e-7 * pair.scale
    extra = [(x, y) for x, y in lowest if clipped([(x, y)], outline, weld)]
    points, areas = _sample_outline(outline, pair.scale, extra)
    top = surface(pair.at_a, pair.a, frame, -1.0, points) - pair.a.radius
    bottom = surface(pair.at_b, pair.b, frame, 1.0, points) + pair.b.radius
    near = top - bottom <= pair.tolerance
    if not near.any():
        return None
    points = [point for point, touches in zip(points, near.tolist(), strict=True) if touches]
    areas = [area for area, touches in zip(areas, near.tolist(), strict=True) if touches]
    return _patch(pair, frame, points, areas, top[near], bottom[near])


def _patch(
    pair: Pair, frame: Array, points: list[Point], areas: list[float], top: Array, bottom: Array
) -> Patch:
    local = np.empty((len(points), 3))
    local[:, :2] = points
    local[:, 2] = (top + bottom) / 2
    return Patch(local @ frame + pair.origin, frame[2], top - bottom, np.array(areas))


def _feature(shape: Shape, at: Array, outward: Array, frame: Array, face: int | None) -> _Surface:
    """Return the face, edge or corner of a shape that is farthest in the direction `outward`.

    A face is preferred if its normal has that direction, then an edge that is nearly level. `face`
    is the index of the face if it is already known.
    """
    if len(shape.faces):
        if face is None:
            facing = shape.normals @ outward
            best = int(facing.argmax())
            face = best if facing[best] > FLAT else None
        if face is not None:
            x, y, z = (frame @ shape.normals[face]).tolist()
            return _Surface((at[shape.faces[face]] @ frame.T).tolist(), (x, y, z))
    heights = at @ outward
    top = int(heights.argmax())
    chosen = [top]
    rims = shape.rims
    if len(rims):
        start, end = rims[:, 0], rims[:, 1]
        others = np.where(start == top, end, start)[(start == top) | (end == top)]
        fall = heights[top] - heights[others]
        spans = at[others] - at[top]
        lengths = np.sqrt((spans**2).sum(1))
        slope = fall / lengths
        if shape.axis is not None:  # a circle's chords are not edges
            slope[np.abs(spans @ shape.axis[1]) < 1e-6 * lengths] = 1.0
        least = int(slope.argmin())
        if slope[least] < (1 - FLAT * FLAT) ** 0.5:
            chosen.append(int(others[least]))
    return _Surface((at[chosen] @ frame.T).tolist(), None)


def _cut_slab(at: Array, shape: Shape, frame: Array, sign: float, deep: float) -> list[Point]:
    """Return the projected outline of the part of a shape within `deep` of its farthest corner.

    The outline has the corners in that part, and the points where edges leave it.
    """
    heights = sign * (at @ frame[2])
    level = heights.max() - deep
    flat = at @ frame[:2].T
    inside = heights >= level
    start, end = shape.rims[:, 0], shape.rims[:, 1]
    leaving = inside[start] != inside[end]
    start, end = start[leaving], end[leaving]
    t = ((level - heights[start]) / (heights[end] - heights[start]))[:, None]
    crossing = flat[start] + (flat[end] - flat[start]) * t
    return [(x, y) for x, y in np.vstack([flat[inside], crossing]).tolist()]


def surface(at: Array, shape: Shape, frame: Array, sign: float, points: list[Point]) -> Array:
    """Return the heights (k,) of a shape's surface at `points` of the projection plane.

    `sign` is 1 for the upper side of the shape, −1 for its lower side.
    """
    normals = shape.normals @ frame.T
    if shape.flat:
        facing = np.array([int((sign * normals[:, 2]).argmax())])
    else:
        facing = np.flatnonzero(sign * normals[:, 2] > 1e-3)
    if len(facing) == 0:
        heights = at @ frame[2]
        return np.full(len(points), heights[int((sign * heights).argmax())])
    n = normals[facing]
    corners = at[[shape.faces[face][0] for face in facing]] @ frame.T
    d = (n * corners).sum(1)
    heights = (d - np.array(points) @ n[:, :2].T) / n[:, 2]
    best: Array = sign * (sign * heights).min(1)
    return best


def _sample_outline(
    outline: list[Point], scale: float, extra: Sequence[Point] = ()
) -> tuple[list[Point], list[float]]:
    """Return sample points of a polygon, a segment or a point, and their areas.

    A segment has the points and weights of Simpson's rule. A polygon also has the points `extra`.
    """
    wide = NARROW * scale
    if len(outline) == 1:
        return outline, [wide * wide]
    xs, ys = [x for x, _ in outline], [y for _, y in outline]
    length = max(max(xs) - min(xs), max(ys) - min(ys))
    if length < 1e-4 * scale:
        return [((min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2)], [wide * wide]
    if len(outline) > 2:
        outline = without_duplicates(outline, 1e-6 * length)
        if len(outline) > 2 and moments(outline)[0] > 1e-3 * length * length:
            return samples(outline, [*fewer_corners(outline), *extra])
    (px, py), (qx, qy) = ends = farthest_pair(outline)
    area = ((qx - px) ** 2 + (qy - py) ** 2) ** 0.5 * wide / 6
    return [ends[0], ((px + qx) / 2, (py + qy) / 2), ends[1]], [area, 4 * area, area]
