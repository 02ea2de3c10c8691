# SPDX-License-Identifier: GPL-3.0-or-later
"""A pad's contact island: every body with a weight that contacts connect with the pad.

The connection can lead through other bodies with a weight, but not through bodies that cannot move.
Forces are computed only within the island, so the cost does not grow with the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import Array
from .balance import GROUND, Points
from .covered import Contact, without_covered
from .patches import Patch
from .shapes import Shape
from .world import Constraint, Key, Node, Support, World

# In m. Bodies nearer than this are tested for contact.
TOLERANCE = 0.002
# In m. The same for gaps beyond a collision margin, because the margin is soft.
MESH_TOLERANCE = 0.008
# The least cosine between a body's required force and the push of a contact that is only within
# `reach`.
ALONG = 0.3


@dataclass
class Island:
    """The bodies of a contact island, and what connects them.

    Attributes
    ----------
    bodies
        The keys of the bodies; a body's index is its position in this list.
    contacts
        The keys of two nodes, and a contact of their shapes.
    supports
        The key of an animated body, and a support of that body.
    constraints
        The rigid-body constraints.
    """

    bodies: list[Key] = field(default_factory=list)
    contacts: list[tuple[Key, Key, Contact]] = field(default_factory=list)
    supports: list[tuple[Key, Support]] = field(default_factory=list)
    constraints: list[Constraint] = field(default_factory=list)


def collect(pad: Key, world: World, reach: dict[Key, float], when: int) -> Island:
    """Follow contacts from the pad through all bodies with a weight, and return the island.

    Parameters
    ----------
    reach
        For the keys of some nodes, the distance in m by which the search for their contacts is
        extended.
    when
        The frame: −1, 0 or 1 for the previous, this or the next one.
    """
    island = Island()
    waiting, seen = [pad], {pad}
    pairs: set[tuple[Key, Key]] = set()
    linked: set[int] = set()

    def visit(key: Key) -> None:
        if key not in seen and world.node(key).weighs:
            seen.add(key)
            waiting.append(key)

    while waiting:
        key = waiting.pop()
        node = world.node(key)
        if node.owner is not None:
            visit(node.owner)
        if node.weighs:
            island.bodies.append(key)
        if node.animated:
            for support in world.supports_of(key):
                island.supports.append((key, support))
                visit(support.node)
        for link in world.constraints_of(key) if node.weighs else []:
            if id(link) not in linked:
                linked.add(id(link))
                island.constraints.append(link)
                for end in (link.one, link.two):
                    if end is not None:
                        visit(end)
        for other in world.near(key):
            neighbour = world.node(other)
            if not any(moving_node(n, world).weighs for n in (node, neighbour)):
                continue
            if neighbour.animated and any(s.node == key for s in world.supports_of(other)):
                visit(other)
            pair = (min(key, other), max(key, other))
            if pair in pairs:
                continue
            pairs.add(pair)
            margin = node.margin + neighbour.margin
            tolerance = TOLERANCE if margin == 0.0 else margin + MESH_TOLERANCE
            wide = reach.get(key, 0.0) + reach.get(other, 0.0)
            contacts = world.contacts(*pair, tolerance + wide, when)
            if wide > 0.0:
                contacts = [
                    contact for contact in contacts if _pushes_as_required(contact, pair, world)
                ]
            island.contacts += [(*pair, contact) for contact in contacts]
            fast = neighbour.weighs and world.required_load(other).reach > TOLERANCE
            if contacts or (fast and not neighbour.animated):
                visit(other)
    return island


def _pushes_as_required(contact: Contact, pair: tuple[Key, Key], world: World) -> bool:
    """Return whether a contact pushes one of its bodies roughly along its required force."""
    for key, sign in zip(pair, (1.0, -1.0), strict=True):
        if world.node(key).weighs:
            force = world.required_load(key).load.wrench[:3]
            along = sign * float(contact.patch.normal @ force)
            if along > ALONG * float(np.linalg.norm(force)):
                return True
    return False


def moving_node(node: Node, world: World) -> Node:
    """Return the body that a pad is a part of; for any other node, the node itself."""
    return node if node.owner is None else world.node(node.owner)


# The points of an island at which its bodies push each other.

# Areas of contacts are limited to within this ratio of the median area.
SPREAD = 30.0
# The number of points that `contact_patch` returns for a point and for a line contact.
POINTS_WITHOUT_AREA = (1, 3)
# In m, and as a share of the contact's area: a contact this near beside a pad is on its rim.
RIM, LEAST_PART = 3e-4, 0.01


@dataclass(frozen=True)
class Group:
    """Contact points at which the body `b` pushes the body `a`; both are keys of a `World`.

    Attributes
    ----------
    places, normals
        The points (n, 3) in m and the unit normals (n, 3).
    areas
        The area (n,) in m² of each point.
    gaps
        The gaps (n,) in m between the collision margins; NaN for points that are known to touch.
    shapes
        The shapes of a and b; empty if they are unknown.
    """

    a: Key
    b: Key
    places: Array
    normals: Array
    friction: float
    areas: Array
    gaps: Array
    shapes: tuple[Shape, ...] = ()


def shape_groups(pad: Key, island: Island, world: World) -> list[Group]:
    """Return the points where shapes touch, except points that a nearer surface covers."""
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
        kept = _without_points_under_pad(kept, numbers, nodes[numbers[pad]])
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


def _without_points_under_pad(
    contacts: list[Contact], numbers: dict[Key, int], part: Node
) -> list[Contact]:
    """Return the contacts without points where a pad covers the body that it is part of.

    `part` is the node of the pad. What lies on the pad is then carried by the pad itself.
    """
    part_number, whole = numbers[part.key], numbers.get(part.owner or (), -1)
    found = []
    for contact in contacts:
        other = {contact.a, contact.b} - {whole}
        in_front = [
            c.patch
            for c in contacts
            if part_number in (c.a, c.b) and other == {c.a, c.b} - {part_number} and len(other) == 1
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
    """Return the contact points of animated bodies with the bodies and pads that support them."""
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
    """Return the contact points of all groups as arrays.

    `order` has the index of each body by its key. A pad that is part of a body has the body's
    index.
    """
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
    """Return the gaps (n,) in m of all points, in the order of `points_of`."""
    return np.concatenate([np.empty(0), *(group.gaps for group in groups)])


def _stiffnesses(groups: Sequence[Group]) -> list[Array]:
    """Return the stiffness of each point of each group, in proportion to the point's area.

    The area of a group is limited to within SPREAD times the median. Line and point contacts have
    no area of their own and count as the median.
    """
    totals = np.array([float(group.areas.sum()) for group in groups])
    # Groups without shapes are samples of an underside: their areas are known.
    flat = np.array([not g.shapes or len(g.areas) not in POINTS_WITHOUT_AREA for g in groups], bool)
    middle = float(np.median(totals[flat])) if flat.any() else 1.0
    kept = np.where(flat, np.clip(totals, middle / SPREAD, middle * SPREAD), middle)
    return [group.areas * (k / t) for group, k, t in zip(groups, kept, totals, strict=True)]


def points_on_pad(pad: Key, groups: Sequence[Group]) -> Array:
    """Return the mask (n,) of the points that are on the pad, in the order of `points_of`."""
    counts = [len(group.places) for group in groups]
    return np.repeat(np.array([pad in (group.a, group.b) for group in groups], bool), counts)
