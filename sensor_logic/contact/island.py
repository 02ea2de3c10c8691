# SPDX-License-Identifier: GPL-3.0-or-later
"""The forces on one pressure pad: the bodies that lean on it, and on each other, in balance.

A pad's contact island is every body with a weight that is reached from the pad through contacts;
what cannot move ends it. Only the island is solved, so its cost does not grow with the scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from ..model import Array
from .balance import GROUND, Balance, Joint, Load, Points, balance
from .covered import ALIGNED, Contact, without_covered
from .patches import Patch
from .settling import Settled, height_between, settled
from .shapes import Shape

Key = tuple[int, ...]

# m: bodies nearer than this are looked at for contact.
TOLERANCE = 0.002
# The same beyond a collision margin, which is soft.
MESH_TOLERANCE = 0.008
# Share of a body's need that may be left unexplained.
RESIDUAL = 0.02
# A body needs at least this share of its weight for its residual to be compared with.
LEAST_NEED = 0.2
# An animated body whose need is below this share of its weight is in free fall.
LEAST_WEIGHT = 0.05
# The same of all that the island's bodies need: what has no weight of its own passes on that.
LEAST_SHARE = 1e-3
# Of a body whose moments are soft, what is left of them counts this much.
BLURRED = 0.1
# m: weight that hovers this near to the side of a pad, or above it, could belong on it.
BESIDE, ABOVE = 0.25, 2.0
# Where joints this much softer and harder share the weight with the pad otherwise, it is unknown.
SOFT_JOINT, HARD_JOINT = 1e-3, 1e3
# Areas of contacts count within this ratio of the middle one.
SPREAD = 30.0
# Least cosine between a far contact's push and what a body needs.
ALONG = 0.3
# Of a point and of a line, as `contact_patch` gives them.
POINTS_WITHOUT_AREA = (1, 3)
# m, and of a contact's area: so little beside a pad is its rim.
RIM, LEAST_PART = 3e-4, 0.01
TINY = 1e-12
SHARE_KNOWN = 0.02


@dataclass(frozen=True)
class Node:
    """A thing in the world that others touch. `key` names it; `name` is what the user calls it.

    `weighs`: it has a weight to pass on (simulated, or animated with a mass). `carried`: an
    animated body, whose contact is looked for below its own surface. `margin` in metres: others
    may be kept this far off by the engine. `owner`: the node that this one is a part of.
    `objects`: session uids of the objects that it is made of.
    """

    key: Key
    name: str
    weighs: bool
    carried: bool
    friction: float
    margin: float = 0.0
    owner: Key | None = None
    objects: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Need:
    """What a body's contacts must give: `load`, with its centre now; its centres (3, 3) in the
    frame before, now and after; its mass in kg; `reach`, how far it moves in a frame in metres;
    and `problem`, why this is not known, or empty."""

    load: Load
    centres: Array
    mass: float
    reach: float
    problem: str = ""


@dataclass(frozen=True)
class Ground:
    """What is stood on but is no node, and so passes nothing on: its name, its number, and places
    (k, 3) in m where it is met."""

    name: str
    number: int
    places: Array


@dataclass(frozen=True)
class Standing:
    """A carried body's contact with what is below it: the support's `node`, places (k, 3), and
    areas (k,) that count less the looser the contact. `ground`: what of it is no node."""

    node: Key
    places: Array
    areas: Array
    ground: tuple[Ground, ...] = ()


class World(Protocol):
    """What the island asks of the scene, at one frame. Lengths in metres."""

    up: Array
    gravity: float

    def node(self, key: Key) -> Node: ...
    def near(self, key: Key) -> Iterable[Key]:
        """Nodes whose bounds meet those of a node, both swept over the three frames."""

    def meeting(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        """Contacts of two nodes' shapes `when` = −1, 0 or 1 frames off; a = 0, b = 1."""

    def standing(self, key: Key) -> list[Standing]: ...
    def need(self, key: Key) -> Need: ...
    def joints(self, key: Key) -> list[Link]: ...
    def hovering(self, pad: Key, beside: float, above: float) -> list[Key]:
        """Carried nodes beside or above the pad."""


@dataclass(frozen=True)
class Link:
    """A constraint of the scene: `name`, the two nodes (None: the ground), and what it can give."""

    name: str
    one: Key | None
    two: Key | None
    place: Array
    forces: Array
    moments: Array


@dataclass(frozen=True)
class Partner:
    """What touches a pad: its name, session uids of its objects, and at each point the place
    (n, 3) in m and the force on the pad (n, 3) in N."""

    name: str
    objects: frozenset[int]
    places: Array
    forces: Array


@dataclass(frozen=True)
class PadForces:
    """What presses on a pad. `residual`: greatest share of a body's need left unexplained;
    `problem`: why the forces are not known for sure, empty where they are; `usable`: whether they
    are an estimate at least; `bodies`: how many are in the island."""

    partners: tuple[Partner, ...] = ()
    residual: float = 0.0
    problem: str = ""
    usable: bool = True
    bodies: int = 0


@dataclass
class _Island:
    """Bodies in order, the contacts of shapes, what carried bodies stand on, and joints."""

    bodies: list[Key] = field(default_factory=list)
    contacts: list[tuple[Key, Key, Contact]] = field(default_factory=list)
    standing: list[tuple[Key, Standing]] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)


@dataclass(frozen=True)
class _Group:
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


@dataclass
class _Attempt:
    """An island as it was found with some reach, and the forces in it."""

    island: _Island
    groups: list[_Group]
    balance: Balance | None
    residuals: dict[Key, float]
    undecided: str = ""
    unresolved: str = ""

    @property
    def worst(self) -> float:
        return max(self.residuals.values(), default=0.0)


def pad_forces(pad: Key, world: World) -> PadForces:
    """The forces on the pad `pad`."""
    problem = _unheld(pad, world)
    if problem:
        return PadForces(problem=problem, usable=False)
    attempt = _attempt(pad, world, {}, 0)
    if attempt.worst > RESIDUAL:
        attempt = _wider(pad, world, attempt)
    return _result(pad, world, attempt)


def _unheld(pad: Key, world: World) -> str:
    """A weight near the pad that nothing holds: it may belong on the pad."""
    for key in world.hovering(pad, BESIDE, ABOVE):
        need = world.need(key)
        heavy = need.load.wrench[:3] @ world.up > LEAST_WEIGHT * need.mass * world.gravity
        if heavy and not world.standing(key):
            return f"nothing holds the weight of '{world.node(key).name}'"
    return ""


def _wider(pad: Key, world: World, attempt: _Attempt) -> _Attempt:
    """Bodies that the contacts do not explain may have touched between two frames: they are
    looked for as far as they moved, now and in the frames beside."""
    best = attempt
    reach = {
        key: 1.2 * world.need(key).reach
        for key, residual in attempt.residuals.items()
        if residual > RESIDUAL
    }
    for when in (0, 1, -1):
        tried = _attempt(pad, world, reach, when)
        if tried.worst < 0.9 * best.worst:
            best = tried
    return best


def _attempt(pad: Key, world: World, reach: dict[Key, float], when: int) -> _Attempt:
    island = _collect(pad, world, reach, when)
    groups = _shape_groups(pad, island, world) + _standing_groups(island, world)
    if not island.bodies:
        return _Attempt(island, groups, None, {})
    order = {key: index for index, key in enumerate(island.bodies)}
    loads = [_load(world.need(key), when) for key in island.bodies]
    joints = [_joint(link, order, 1.0) for link in island.links]
    lying = settled(loads, _points(groups, order, world), _gaps(groups), joints)
    points = lying.points
    found = balance(loads, points, joints)
    whole = sum(float(np.linalg.norm(load.wrench[:3])) for load in loads)
    least = max(LEAST_SHARE * whole, TINY)
    residuals = {
        key: _residual(world, key, found.missing[index], least) for key, index in order.items()
    }
    attempt = _Attempt(island, groups, found, residuals)
    attempt.unresolved = _unresolved(pad, world, attempt, lying)
    if island.links:
        attempt.undecided = _undecided(pad, attempt, loads, points, order)
    return attempt


def _collect(pad: Key, world: World, reach: dict[Key, float], when: int) -> _Island:
    """Follows contacts from the pad through everything that has a weight."""
    island = _Island()
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
        if node.carried:
            for standing in world.standing(key):
                island.standing.append((key, standing))
                visit(standing.node)
        for link in world.joints(key) if node.weighs else []:
            if id(link) not in linked:
                linked.add(id(link))
                island.links.append(link)
                for end in (link.one, link.two):
                    if end is not None:
                        visit(end)
        for other in world.near(key):
            neighbour = world.node(other)
            if not any(_acts(n, world).weighs for n in (node, neighbour)):
                continue
            if neighbour.carried and any(s.node == key for s in world.standing(other)):
                visit(other)
            pair = (min(key, other), max(key, other))
            if pair in pairs:
                continue
            pairs.add(pair)
            margin = node.margin + neighbour.margin
            tolerance = TOLERANCE if margin == 0.0 else margin + MESH_TOLERANCE
            wide = reach.get(key, 0.0) + reach.get(other, 0.0)
            contacts = world.meeting(*pair, tolerance + wide, when)
            if wide > 0.0:
                contacts = [contact for contact in contacts if _helps(contact, pair, world)]
            island.contacts += [(*pair, contact) for contact in contacts]
            fast = neighbour.weighs and world.need(other).reach > TOLERANCE
            if contacts or (fast and not neighbour.carried):
                visit(other)
    return island


def _helps(contact: Contact, pair: tuple[Key, Key], world: World) -> bool:
    """Whether a contact looked for far off pushes one of its bodies the way it must be pushed."""
    for key, sign in zip(pair, (1.0, -1.0), strict=True):
        if world.node(key).weighs:
            force = world.need(key).load.wrench[:3]
            along = sign * float(contact.patch.normal @ force)
            if along > ALONG * float(np.linalg.norm(force)):
                return True
    return False


def _acts(node: Node, world: World) -> Node:
    """A part acts as what it is a part of."""
    return node if node.owner is None else world.node(node.owner)


def _shape_groups(pad: Key, island: _Island, world: World) -> list[_Group]:
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
    movable = [_acts(node, world).weighs for node in nodes]
    kept = without_covered(contacts, movable, preferred)
    if pad in numbers and nodes[numbers[pad]].owner is not None:
        kept = _through_part(kept, numbers, nodes[numbers[pad]])
    groups = []
    for contact in kept:
        one, two = nodes[contact.a], nodes[contact.b]
        patch = contact.patch
        normals = np.broadcast_to(patch.normal, patch.points.shape)
        groups.append(
            _Group(
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


def _standing_groups(island: _Island, world: World) -> list[_Group]:
    groups = []
    for key, standing in island.standing:
        count = len(standing.places)
        groups.append(
            _Group(
                key,
                standing.node,
                standing.places,
                np.broadcast_to(world.up, (count, 3)),
                0.0,
                standing.areas,
                np.full(count, np.nan),
            )
        )
    return groups


def _points(groups: Sequence[_Group], order: dict[Key, int], world: World) -> Points:
    """All points of the island as arrays; a part counts as what it is a part of."""
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


def _gaps(groups: Sequence[_Group]) -> Array:
    return np.concatenate([np.empty(0), *(group.gaps for group in groups)])


def _stiffnesses(groups: Sequence[_Group]) -> list[Array]:
    """In proportion to the areas; lines and points, which have none, are as stiff as the rest."""
    totals = np.array([float(group.areas.sum()) for group in groups])
    # What is stood on was sampled: its areas are known of any number of points.
    flat = np.array([not g.shapes or len(g.areas) not in POINTS_WITHOUT_AREA for g in groups], bool)
    middle = float(np.median(totals[flat])) if flat.any() else 1.0
    kept = np.where(flat, np.clip(totals, middle / SPREAD, middle * SPREAD), middle)
    return [group.areas * (k / t) for group, k, t in zip(groups, kept, totals, strict=True)]


def _load(need: Need, when: int) -> Load:
    return replace(need.load, centre=need.centres[1 + when])


def _residual(world: World, key: Key, missing: Array, least: float) -> float:
    """The share of a body's need, at least `least` newtons, that no contact explains. Of a carried
    body, whose muscles give what its animation wants, only the weight counts."""
    need = world.need(key)
    least = max(LEAST_NEED * need.mass * world.gravity, least)
    force = need.load.wrench[:3]
    if world.node(key).carried:
        return abs(float(missing[:3] @ world.up)) / max(abs(float(force @ world.up)), least)
    moment = float(np.linalg.norm(missing[3:])) / need.load.size
    if need.load.softness[3:].any():
        moment *= BLURRED
    left = float(np.linalg.norm(missing[:3])) + moment
    return left / max(float(np.linalg.norm(force)), least)


def _joint(link: Link, order: dict[Key, int], stiffness: float) -> Joint:
    ends = [GROUND if key is None else order.get(key, GROUND) for key in (link.one, link.two)]
    return Joint(ends[0], ends[1], link.place, link.forces, link.moments, stiffness)


def _undecided(
    pad: Key, attempt: _Attempt, loads: Sequence[Load], points: Points, order: dict[Key, int]
) -> str:
    """Whether it depends on the give of a joint how much the pad carries."""
    on_pad = _on_pad(pad, attempt.groups)
    carried = [
        np.abs(
            balance(
                loads,
                points,
                [_joint(link, order, stiffness) for link in attempt.island.links],
            ).forces[on_pad]
        ).sum()
        for stiffness in (SOFT_JOINT, HARD_JOINT)
    ]
    if abs(carried[0] - carried[1]) <= SHARE_KNOWN * max(carried):
        return ""
    names = ", ".join(f"'{link.name}'" for link in attempt.island.links)
    return f"statics cannot tell how much {names} carries"


def _unresolved(pad: Key, world: World, attempt: _Attempt, found: Settled) -> str:
    """Whether the pad and what does not move beside it share a weight, though one of them is the
    higher, by less than can be told."""
    assert attempt.balance is not None
    sides = []
    start = 0
    for group in attempt.groups:
        part = slice(start, start := start + len(group.places))
        pressed = float(np.linalg.norm(attempt.balance.forces[part], axis=1).sum())
        for body, under, below, sign in (
            (group.a, group.b, group.shapes[1:], 1.0),
            (group.b, group.a, group.shapes[:1], -1.0),
        ):
            if below and _acts(world.node(body), world).weighs:
                sides.append((body, under, below[0], group, sign, part, pressed))
    for body, under, shape, group, sign, part, pressed in sides:
        for same, other, beside, along, turn, _, carried in sides if under == pad else ():
            normal = sign * group.normals[0]
            if same != body or other == pad or world.node(other).weighs:
                continue
            if turn * along.normals[0] @ normal < ALIGNED:
                continue
            step = height_between(shape, beside, group.places, normal)
            shared = min(pressed, carried) > SHARE_KNOWN * max(pressed, carried)
            if shared and found.level[part].max() < step < found.untold[part].max():
                return (
                    f"'{world.node(pad).name}' and '{world.node(other).name}' differ in height by "
                    f"{1000.0 * step:.1g} mm, too little to tell how they share the weight of "
                    f"'{world.node(body).name}': make the pad thicker, or level with it"
                )
    return ""


def _on_pad(pad: Key, groups: Sequence[_Group]) -> Array:
    """Mask of the points that are on the pad."""
    counts = [len(group.places) for group in groups]
    return np.repeat(np.array([pad in (group.a, group.b) for group in groups], bool), counts)


def _result(pad: Key, world: World, attempt: _Attempt) -> PadForces:
    problems = [world.need(key).problem for key in attempt.island.bodies]
    problems = [*problems, attempt.undecided, attempt.unresolved]
    if attempt.balance is None:
        return PadForces()
    found: dict[Key, list[tuple[Array, Array]]] = {}
    start = 0
    for group in attempt.groups:
        forces = attempt.balance.forces[start : start + len(group.places)]
        start += len(group.places)
        if group.a == pad:
            found.setdefault(group.b, []).append((group.places, forces))
        elif group.b == pad:
            found.setdefault(group.a, []).append((group.places, -forces))
    partners = []
    for key, parts in found.items():
        node = world.node(key)
        places, forces = (np.concatenate(side) for side in zip(*parts, strict=True))
        partners.append(Partner(node.name, node.objects, places, forces))
    if attempt.worst > RESIDUAL:
        worst = max(attempt.residuals, key=attempt.residuals.__getitem__)
        problems.append(
            f"the contacts of '{world.node(worst).name}' explain "
            f"{max(0.0, 1.0 - attempt.worst):.0%} of its motion and weight"
        )
    elif not attempt.balance.settled:
        problems.append("the contact forces did not settle")
    problem = next((problem for problem in problems if problem), "")
    bodies = len(attempt.island.bodies)
    return PadForces(tuple(partners), attempt.worst, problem, not problem, bodies)
