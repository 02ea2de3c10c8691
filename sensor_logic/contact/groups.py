# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of an island at which its bodies push each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array
from .balance import GROUND, Points
from .covered import Contact, without_covered
from .island import Island, moving_node
from .patches import Patch
from .shapes import Shape
from .world import Key, Node, World

# Areas of contacts count within this ratio of the middle one.
SPREAD = 30.0
# Of a point and of a line, as `contact_patch` gives them.
POINTS_WITHOUT_AREA = (1, 3)
# m, and of a contact's area: so little beside a pad is its rim.
RIM, LEAST_PART = 3e-4, 0.01


@dataclass(frozen=True)
class Group:
    """Contact points of one sort: `b` pushes `a` at places (n, 3) along normals (n, 3). `gaps`
    (n,) in m, beyond collision margins; NaN where the point touches by what was found before.
    `shapes`: of a and of b, where they are known."""

    a: Key
    b: Key
    places: Array
    normals: Array
    friction: float
    areas: Array
    gaps: Array
    shapes: tuple[Shape, ...] = ()


def shape_groups(pad: Key, island: Island, world: World) -> list[Group]:
    """The points where shapes touch, without those hidden behind nearer things."""
    numbers: dict[Key, int] = {}
    contacts = [
        replace(
            contact,
            a=numbers.setdefault(one, len(numbers)),
            b=numbers.setdefault(two, len(numbers)),
        )
        for one, two, contact in island.contacts
    ]
    keys = list(numbers)
    nodes = [world.node(key) for key in keys]
    preferred = [numbers[pad]] if pad in numbers else []
    movable = [moving_node(node, world).weighs for node in nodes]
    kept = without_covered(contacts, movable, preferred)
    if pad in numbers and nodes[numbers[pad]].owner is not None:
        kept = _through_part(kept, numbers, nodes[numbers[pad]])
    groups = []
    for contact in kept:
        one, two = nodes[contact.a], nodes[contact.b]
        patch = contact.patch
        normals = np.broadcast_to(patch.normal, patch.points.shape)
        groups.append(
            Group(
                one.key,
                two.key,
                patch.points,
                normals,
                one.friction * two.friction,
                patch.areas,
                patch.gaps - one.margin - two.margin,
                (contact.shape_a, contact.shape_b),
            )
        )
    return groups


def _through_part(contacts: list[Contact], numbers: dict[Key, int], part: Node) -> list[Contact]:
    """The contacts without those of what a pad is fixed to where the pad comes first."""
    own, whole = numbers[part.key], numbers.get(part.owner or (), -1)
    found = []
    for contact in contacts:
        other = {contact.a, contact.b} - {whole}
        in_front = [
            c.patch
            for c in contacts
            if own in (c.a, c.b) and other == {c.a, c.b} - {own} and len(other) == 1
        ]
        if whole not in (contact.a, contact.b) or not in_front:
            found.append(contact)
            continue
        patch = contact.patch
        across = np.eye(3) - np.outer(patch.normal, patch.normal)
        ahead = np.concatenate([p.points for p in in_front]) @ across
        lo, hi = ahead.min(axis=0) - RIM, ahead.max(axis=0) + RIM
        seen = patch.points @ across
        outside = ((seen < lo) | (seen > hi)).any(axis=1)
        if patch.areas[outside].sum() > LEAST_PART * patch.areas.sum():
            rest = Patch(
                patch.points[outside], patch.normal, patch.gaps[outside], patch.areas[outside]
            )
            found.append(replace(contact, patch=rest))
    return found


def standing_groups(island: Island, world: World) -> list[Group]:
    groups = []
    for key, support in island.supports:
        count = len(support.places)
        groups.append(
            Group(
                key,
                support.node,
                support.places,
                np.broadcast_to(world.up, (count, 3)),
                0.0,
                support.areas,
                np.full(count, np.nan),
            )
        )
    return groups


def points_of(groups: Sequence[Group], order: dict[Key, int], world: World) -> Points:
    """All contact points of the island as arrays; a part's points belong to its owner."""
    counts = [len(group.places) for group in groups]

    def index_of(key: Key) -> int:
        return order.get(world.node(key).owner or key, GROUND)

    return Points(
        np.concatenate([np.empty((0, 3)), *(group.places for group in groups)]),
        np.concatenate([np.empty((0, 3)), *(group.normals for group in groups)]),
        np.repeat(np.array([index_of(group.a) for group in groups], np.intp), counts),
        np.repeat(np.array([index_of(group.b) for group in groups], np.intp), counts),
        np.repeat(np.array([group.friction for group in groups]), counts),
        np.concatenate([np.empty(0), *_stiffnesses(groups)]),
        np.zeros(sum(counts)),
    )


def gaps(groups: Sequence[Group]) -> Array:
    return np.concatenate([np.empty(0), *(group.gaps for group in groups)])


def _stiffnesses(groups: Sequence[Group]) -> list[Array]:
    """In proportion to the areas; lines and points, which have none, are as stiff as the rest."""
    totals = np.array([float(group.areas.sum()) for group in groups])
    # What is stood on was sampled: its areas are known of any number of points.
    flat = np.array([not g.shapes or len(g.areas) not in POINTS_WITHOUT_AREA for g in groups], bool)
    middle = float(np.median(totals[flat])) if flat.any() else 1.0
    kept = np.where(flat, np.clip(totals, middle / SPREAD, middle * SPREAD), middle)
    return [group.areas * (k / t) for group, k, t in zip(groups, kept, totals, strict=True)]


def points_on_pad(pad: Key, groups: Sequence[Group]) -> Array:
    """Mask of the points that are on the pad."""
    counts = [len(group.places) for group in groups]
    return np.repeat(np.array([pad in (group.a, group.b) for group in groups], bool), counts)
