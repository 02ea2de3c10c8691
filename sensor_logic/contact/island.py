# SPDX-License-Identifier: GPL-3.0-or-later
"""A pad's contact island: every body with a weight that contacts connect with the pad. What cannot
move ends it. Only the island is solved, so its cost does not grow with the scene."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .covered import Contact
from .world import Constraint, Key, Node, Support, World

# m: bodies nearer than this are tested for contact.
TOLERANCE = 0.002
# m: the same beyond a collision margin, which is soft.
MESH_TOLERANCE = 0.008
# Least cosine between the push of a contact found within `reach` and the force a body requires.
ALONG = 0.3


@dataclass
class Island:
    """Bodies in order, contacts between shapes, supports of animated bodies, constraints."""

    bodies: list[Key] = field(default_factory=list)
    contacts: list[tuple[Key, Key, Contact]] = field(default_factory=list)
    supports: list[tuple[Key, Support]] = field(default_factory=list)
    constraints: list[Constraint] = field(default_factory=list)


def collect(pad: Key, world: World, reach: dict[Key, float], when: int) -> Island:
    """Follows contacts from the pad through everything that has a weight."""
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
                contacts = [contact for contact in contacts if _helps(contact, pair, world)]
            island.contacts += [(*pair, contact) for contact in contacts]
            fast = neighbour.weighs and world.required_load(other).reach > TOLERANCE
            if contacts or (fast and not neighbour.animated):
                visit(other)
    return island


def _helps(contact: Contact, pair: tuple[Key, Key], world: World) -> bool:
    """Whether a contact pushes one of its bodies the way the body's required force points."""
    for key, sign in zip(pair, (1.0, -1.0), strict=True):
        if world.node(key).weighs:
            force = world.required_load(key).load.wrench[:3]
            along = sign * float(contact.patch.normal @ force)
            if along > ALONG * float(np.linalg.norm(force)):
                return True
    return False


def moving_node(node: Node, world: World) -> Node:
    """The node whose motion this node shares: its owner, or itself without one."""
    return node if node.owner is None else world.node(node.owner)
