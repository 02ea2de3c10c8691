# SPDX-License-Identifier: GPL-3.0-or-later
"""Convex polygons in a plane, as lists of (x, y): for few points plain Python is faster than
numpy."""

from __future__ import annotations

import math
from collections.abc import Sequence

Point = tuple[float, float]

CORNER_SHARE = 1e-3  # of the area, for each corner, so that an edge can carry a tipping body
MOST_CORNERS = 16


def clipped_by(polygon: Sequence[Point], x: float, y: float, d: float) -> list[Point]:
    """The part with x·px + y·py ≤ d, of a polygon or of a segment's two ends."""
    heights = [x * p[0] + y * p[1] - d for p in polygon]
    if max(heights) <= 0:
        return list(polygon)
    if min(heights) > 0:
        return []
    out: list[Point] = []
    last, high = polygon[-1], heights[-1]
    if len(polygon) == 2:  # one edge, not two
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
    """The intersection of two convex polygons, segments or points, counter-clockwise.

    Points and segments may be `near` apart.
    """
    if len(by) < len(subject) if len(by) < 3 else 3 <= len(subject) < len(by):
        subject, by = by, subject  # the one of fewer sides does the cutting
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
    """Area, centroid (x, y), and the mean of x², xy, y² about the centroid."""
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


def tidied(polygon: Sequence[Point], near: float) -> list[Point]:
    """The polygon without points that lie within `near` of the one before."""
    out: list[Point] = []
    for point in polygon:
        if not out or math.hypot(point[0] - out[-1][0], point[1] - out[-1][1]) > near:
            out.append(point)
    while len(out) > 1 and math.hypot(out[0][0] - out[-1][0], out[0][1] - out[-1][1]) <= near:
        out.pop()
    return out


def longest(polygon: Sequence[Point]) -> tuple[Point, Point]:
    """The two points that are furthest apart."""
    best, ends = -1.0, (polygon[0], polygon[0])
    for i, p in enumerate(polygon):
        for q in polygon[i + 1 :]:
            distance = (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2
            if distance > best * (1 + 1e-9):
                best, ends = distance, (p, q)
    return ends


def fewer(polygon: Sequence[Point], most: int = MOST_CORNERS) -> list[Point]:
    """At most `most` of the corners, without those that cut off the least area."""
    out = list(polygon)
    if len(out) <= most:
        return out
    cuts = [_cut(out, i) for i in range(len(out))]
    while len(out) > most:
        # With equal areas, every other corner of a round outline is removed first.
        least = min(cuts) + 1e-6 * abs(min(cuts))
        i = next(i for i, cut in enumerate(cuts) if cut <= least)
        del out[i], cuts[i]
        for j in (i - 1, i % len(out)):
            cuts[j] = _cut(out, j)
    return out


def _cut(polygon: Sequence[Point], i: int) -> float:
    """Twice the area that removing corner i cuts off."""
    (px, py), (qx, qy), (rx, ry) = polygon[i - 1], polygon[i], polygon[(i + 1) % len(polygon)]
    return (qx - px) * (ry - py) - (qy - py) * (rx - px)


def samples(polygon: Sequence[Point], corners: Sequence[Point]) -> tuple[list[Point], list[float]]:
    """Sample points and areas that integrate every polynomial up to the second degree exactly.

    Four points have nearly all of the area: the centroid plus (±1, ±1) times the square root of the
    covariance. On an axis-aligned rectangle they are the 2×2 Gauss points. They lie inside every
    convex polygon (Kannan, Lovász, Simonovits 1995, theorem 4.1). Each of the `corners`, which come
    last, gets CORNER_SHARE of the area.
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
    """The convex hull, counter-clockwise; two points or one for collinear or equal points."""
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

    loop = tidied(chain(ordered) + chain(ordered[::-1]), near) or ordered[:1]
    if len(loop) < 3:
        return loop
    p, q = longest(loop)
    length = math.hypot(q[0] - p[0], q[1] - p[1])
    return loop if abs(moments(loop)[0]) > near * length else [p, q]
