# SPDX-License-Identifier: GPL-3.0-or-later
"""What the forces on a pad are worked out from, and what they are: the things of the scene, their
needs and contacts as the island asks for them, and the answer."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from ..model import Array
from .balance import Load
from .covered import Contact

Key = tuple[int, ...]


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
