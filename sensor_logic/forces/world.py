# SPDX-License-Identifier: GPL-3.0-or-later
"""Input and output of the calculation of forces on a pad: the bodies of the scene with the forces
that their motion requires and their contacts, and the forces on the pad that follow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from ..arrays import Array
from .balance import Load
from .covered import Contact

Key = tuple[int, ...]


@dataclass(frozen=True)
class Node:
    """A body or pad that others can touch. `key` identifies it, `name` is its object's.

    `weighs`: it has a weight of its own (simulated, or animated with a mass). `animated`: keys move
    it, no physics; its contacts are looked for below its own surface. `margin` in metres: the
    physics engine may hold others this far off. `owner`: the node that this one is a part of.
    `objects`: session uids of the objects that it consists of.
    """

    key: Key
    name: str
    weighs: bool
    animated: bool
    friction: float
    margin: float = 0.0
    owner: Key | None = None
    objects: frozenset[int] = frozenset()


@dataclass(frozen=True)
class RequiredLoad:
    """What the contacts of a body must add up to for it to move as it does: `load`, about its
    centre of mass in this frame; `centres` (3, 3) in the frame before, this one and the next, m;
    `mass` in kg; `reach`: how far it moves in a frame, m; `problem`: why this is unknown, or
    empty."""

    load: Load
    centres: Array
    mass: float
    reach: float
    problem: str = ""


@dataclass(frozen=True)
class BareSurface:
    """A surface without a node, which therefore passes no weight on: its object's name, its solid's
    number, and the places (k, 3) in m where a body stands on it."""

    name: str
    number: int
    places: Array


@dataclass(frozen=True)
class Support:
    """Where one `node` supports an animated body from below: places (k, 3) in m, and areas (k,) in
    m² that count less the wider the gap. `ground`: the supporting surfaces without a node."""

    node: Key
    places: Array
    areas: Array
    ground: tuple[BareSurface, ...] = ()


class World(Protocol):
    """The scene at one frame, as the search for a pad's island needs it. Lengths in metres."""

    up: Array
    gravity: float

    def node(self, key: Key) -> Node: ...
    def near(self, key: Key) -> Iterable[Key]:
        """Nodes whose bounds meet those of a node, both swept over the three frames."""

    def contacts(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        """Contacts between two nodes' shapes that are at most `reach` apart, `when` = −1, 0 or 1
        frames from this one; in each, a = 0 is `one` and b = 1 is `two`."""

    def supports_of(self, key: Key) -> list[Support]: ...
    def required_load(self, key: Key) -> RequiredLoad: ...
    def constraints_of(self, key: Key) -> list[Constraint]: ...
    def animated_near(self, pad: Key, beside: float, above: float) -> list[Key]:
        """Animated nodes up to `beside` next to the pad or `above` over it."""


@dataclass(frozen=True)
class Constraint:
    """A rigid-body constraint: `name`, its two nodes (None: the ground), its place (3,) in m, and
    the axes (k, 3) along which it can give forces and about which it can give moments."""

    name: str
    one: Key | None
    two: Key | None
    place: Array
    forces: Array
    moments: Array


@dataclass(frozen=True)
class Partner:
    """A node that touches a pad: its name, session uids of its objects, and of its contact points
    the places (n, 3) in m and the forces on the pad (n, 3) in N."""

    name: str
    objects: frozenset[int]
    places: Array
    forces: Array


@dataclass(frozen=True)
class PadForces:
    """The forces on a pad. `residual`: the greatest share of a body's required load that no contact
    explains; `problem`: why the forces are uncertain, or empty; `usable`: whether they are at least
    an estimate; `bodies`: how many bodies the island has."""

    partners: tuple[Partner, ...] = ()
    residual: float = 0.0
    problem: str = ""
    usable: bool = True
    bodies: int = 0
