# SPDX-License-Identifier: GPL-3.0-or-later
"""Remove contacts that carry no load, because a nearer surface lies in between.

A box on a thin pad is also near the floor below the pad. So is a box that sank into its pad. In
both cases only the pad carries the box. Without this rule the pad would read half of the weight,
and the floor would carry the other half.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arrays import Array
from . import patches
from .directions import FLAT
from .patches import Patch, Point, surface
from .shapes import Shape, perpendiculars

Flags = NDArray[np.bool_]

NEARER = 3e-4  # in m: contacts whose depths differ by less are equally deep
ALIGNED = 0.9  # cosine of the angle up to which two contacts push in the same direction
SLIVER = 1e-4  # of a patch's area: smaller pieces of it are dropped
MOST_SIDES = 8  # a nearer face with more sides is replaced by a quadrangle of the same area


@dataclass(frozen=True, eq=False, slots=True)
class Contact:
    """The contact of bodies `a` and `b`: their indices, its patch, and both shapes in the world."""

    a: int
    b: int
    patch: Patch
    shape_a: Shape
    shape_b: Shape


@dataclass(frozen=True, eq=False, slots=True)
class _Side:
    """A contact as seen from one of its two bodies.

    Attributes
    ----------
    number
        The index of the contact.
    other
        The index of the other body.
    nearest, furthest
        The least and the greatest gap of the contact in m.
    """

    number: int
    other: int
    patch: Patch
    normal: Array  # (3,) the direction of the force on the body
    shape: Shape  # of the other body
    nearest: float  # the least gap, in m
    furthest: float


def without_covered(
    contacts: Sequence[Contact],
    movable: Sequence[bool],
    preferred: Collection[int] = (),
) -> list[Contact]:
    """Return the contacts without the parts that a nearer contact of the same body covers.

    A contact covers another one if its gap is smaller by more than NEARER.

    Parameters
    ----------
    movable
        Whether each body can move. Only contacts of such bodies are covered, because only they need
        support.
    preferred
        The indices of bodies, such as a pressure pad, whose contacts also cover equally deep
        contacts with other bodies.
    """
    sides: dict[int, list[_Side]] = {}
    for number, contact in enumerate(contacts):
        patch = contact.patch
        gaps = float(patch.gaps.min()), float(patch.gaps.max())
        for body, other, normal, shape in (
            (contact.a, contact.b, patch.normal, contact.shape_b),
            (contact.b, contact.a, -patch.normal, contact.shape_a),
        ):
            if movable[body]:
                side = _Side(number, other, patch, normal, shape, *gaps)
                sides.setdefault(body, []).append(side)
    left: dict[int, Patch | None] = {}
    for of_body in sides.values():
        for back in of_body:
            fronts = [
                (front, ahead)
                for front in of_body
                if front.other != back.other
                for ahead in (_required_lead(front.other, back.other, preferred),)
                if _may_cover(front, back, ahead)
            ]
            if fronts:
                rest = left.get(back.number, back.patch)
                if rest is not None:
                    left[back.number] = _uncovered(rest, back, fronts)
    found = []
    for number, contact in enumerate(contacts):
        if number not in left:
            found.append(contact)
        elif (rest := left[number]) is not None:
            found.append(replace(contact, patch=rest))
    return found


def _required_lead(front: int, back: int, preferred: Collection[int]) -> float:
    """Return by how many metres the body `front` must be nearer than `back` to cover it.

    The result is negative if `front` also covers `back` when both are equally near.
    """
    return -NEARER if front in preferred and back not in preferred else NEARER


def _may_cover(front: _Side, back: _Side, ahead: float) -> bool:
    if front.nearest >= back.furthest - ahead or float(front.normal @ back.normal) < ALIGNED:
        return False
    points, reach = back.patch.points, max(abs(back.nearest), abs(back.furthest)) + NEARER
    low, high = points.min(0) - reach, points.max(0) + reach
    return bool((front.shape.lo <= high).all() and (front.shape.hi >= low).all())


def _uncovered(patch: Patch, back: _Side, fronts: Sequence[tuple[_Side, float]]) -> Patch | None:
    view = _ProjectedPatch(patch, back.normal)
    if view.pieces:
        for front, ahead in fronts:
            shadow = view.shadow(front, ahead)
            if shadow is None:
                break
            view.cut(shadow)
        else:
            return view.patch()
    hidden = np.any([view.hidden(front, ahead) for front, ahead in fronts], axis=0)
    if not hidden.any():
        return patch
    if hidden.all():
        return None
    keep = ~hidden
    return Patch(patch.points[keep], patch.normal, patch.gaps[keep], patch.areas[keep])


class _ProjectedPatch:
    """A contact patch projected along its normal; heights are along that normal."""

    def __init__(self, patch: Patch, normal: Array) -> None:
        self.whole = patch
        self.origin = patch.points[0]
        self.frame = np.vstack([*perpendiculars(normal), normal])
        local = (patch.points - self.origin) @ self.frame.T
        self.flat: list[Point] = [(x, y) for x, y in local[:, :2].tolist()]
        self.heights = local[:, 2] - patch.gaps / 2  # of the other body's surface
        self.changed = False
        # The gap and the middle as planes: constant, slope along x, slope along y.
        columns = np.column_stack([np.ones(len(local)), local[:, :2]])
        wanted = np.column_stack([patch.gaps, local[:, 2]])
        self.planes = np.linalg.lstsq(columns, wanted, rcond=1e-9)[0]
        outline = patches.hull(self.flat, 1e-9)
        curved = np.abs(columns @ self.planes - wanted).max() > 1e-6
        self.pieces: list[list[Point]] = [] if curved else [outline]
        self.corners = outline
        self.extent = _extent(outline)

    def shadow(self, front: _Side, ahead: float) -> list[Point] | None:
        """Return the outline of the area in which the nearest face of `front` covers the patch.

        The outline is a convex polygon, empty if it covers nothing. Return None if the shape of
        `front` has no flat face towards the body. `ahead` is the result of `_required_lead`.
        """
        shape = front.shape
        facing = shape.normals @ self.frame[2]
        if len(facing) == 0 or facing.max() < FLAT:
            return None
        face = int(facing.argmax())
        rows = (shape.vertices[shape.faces[face]] - self.origin) @ self.frame.T
        nx, ny, nz = (self.frame @ shape.normals[face]).tolist()
        x, y, z = rows[0].tolist()
        z += shape.radius
        outline = [(px, py) for px, py in rows[:, :2].tolist()]
        if len(outline) > MOST_SIDES:
            outline = _quadrangle(outline)
        # Above the back surface, of height z₀ + a·x + b·y, and not far above the body's surface.
        (gap, gap_x, gap_y), (middle, middle_x, middle_y) = self.planes.T.tolist()
        sx, sy = -nx / nz, -ny / nz
        z -= sx * x + sy * y
        over = z - (middle - gap / 2), sx - middle_x + gap_x / 2, sy - middle_y + gap_y / 2
        deep = z - (middle + gap / 2), sx - middle_x - gap_x / 2, sy - middle_y - gap_y / 2
        outline = patches.clipped_by(outline, -over[1], -over[2], over[0] - ahead)
        if outline:
            limit = NEARER - front.nearest - deep[0]
            outline = patches.clipped_by(outline, deep[1], deep[2], limit)
        return outline

    def cut(self, shadow: list[Point]) -> None:
        """Remove the polygon `shadow` from the pieces of the patch."""
        if len(shadow) < 3:
            return
        pieces: list[list[Point]] = []
        for piece in self.pieces:
            near = 1e-9 * (1 + max(abs(c) for p in piece for c in p))
            if len(patches.clipped(piece, shadow, -near)) == 0:
                pieces.append(piece)
                continue
            self.changed = True
            pieces += _outside(piece, shadow)
        self.pieces = [p for p in pieces if _extent(p) > SLIVER * self.extent]

    def patch(self) -> Patch | None:
        """Return what remains of the patch, with new sample points; None if nothing remains."""
        if not self.changed:
            return self.whole
        total = float(self.whole.areas.sum())
        points: list[Point] = []
        areas: list[float] = []
        for piece in self.pieces:
            share = total * _extent(piece) / self.extent
            if len(piece) == 1:
                places, weights = list(piece), [1.0]
            elif len(piece) == 2:
                (px, py), (qx, qy) = piece
                places = [piece[0], ((px + qx) / 2, (py + qy) / 2), piece[1]]
                weights = [1 / 6, 4 / 6, 1 / 6]
            else:
                places, weights = patches.samples(piece, [p for p in piece if p in self.corners])
            scale = share / sum(weights)
            points += places
            areas += [weight * scale for weight in weights]
        if not points:
            return None
        flat = np.array(points)
        values = np.column_stack([np.ones(len(flat)), flat]) @ self.planes
        local = np.column_stack([flat, values[:, 1]])
        gaps = np.ascontiguousarray(values[:, 0])
        return Patch(local @ self.frame + self.origin, self.whole.normal, gaps, np.array(areas))

    def hidden(self, front: _Side, ahead: float) -> Flags:
        """Return the mask (n,) of the patch's points that the shape of `front` covers.

        The shape must be nearer by `ahead` m, the result of `_required_lead`.
        """
        shape = front.shape
        if not len(shape.faces):
            return np.zeros(len(self.flat), np.bool_)
        at = shape.vertices - self.origin
        top = surface(at, shape, self.frame, 1.0, self.flat)
        bottom = surface(at, shape, self.frame, -1.0, self.flat)
        inside = _inside(at @ self.frame[:2].T, self.flat) if shape.flat else top >= bottom
        top = top + shape.radius
        body = self.heights + self.whole.gaps
        out: Flags = inside & (top > self.heights + ahead) & (top < body - front.nearest + NEARER)
        return out


def _outside(piece: list[Point], shadow: list[Point]) -> list[list[Point]]:
    """Return the convex pieces of a polygon, segment or point that are outside `shadow`."""
    pieces = []
    rest = piece
    px, py = shadow[-1]
    for qx, qy in shadow:
        length = math.hypot(qx - px, qy - py)
        if length > 0:
            x, y = (qy - py) / length, -(qx - px) / length
            d = x * px + y * py
            pieces.append(patches.clipped_by(rest, -x, -y, -d))
            rest = patches.clipped_by(rest, x, y, d)
            if not rest:
                break
        px, py = qx, qy
    least = 3 if len(piece) >= 3 else len(piece)
    return [p for p in pieces if len(p) >= least]


def _extent(outline: Sequence[Point]) -> float:
    """Return the area of a polygon, the length of a segment, or 1 for a point."""
    if len(outline) >= 3:
        return patches.moments(outline)[0]
    if len(outline) == 2:
        return math.hypot(outline[1][0] - outline[0][0], outline[1][1] - outline[0][1])
    return float(len(outline))


def _quadrangle(outline: Sequence[Point]) -> list[Point]:
    """Return a quadrangle with the area and the centroid of a round outline."""
    area, x, y = patches.moments(outline)[:3]
    corners = patches.fewer_corners(outline, 4)
    less, mx, my = patches.moments(corners)[:3]
    grown = math.sqrt(area / less)
    return [(x + (px - mx) * grown, y + (py - my) * grown) for px, py in corners]


def _inside(corners: Array, points: list[Point]) -> Flags:
    outline = patches.hull([(x, y) for x, y in corners.tolist()], 1e-9)
    return np.array([bool(patches.clipped([point], outline, 1e-9)) for point in points])
