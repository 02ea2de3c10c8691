# SPDX-License-Identifier: GPL-3.0-or-later
"""Input and output of the calculation of forces on a pad.

The input are the bodies of the scene, with their contacts and the forces that their motion
requires. The output are the forces on the pad.
"""

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
    """A body or pad that can touch other nodes.

    Attributes
    ----------
    key
        Identifies the node.
    name
        The name of the node's object.
    weighs
        The node has a weight of its own: it is simulated, or animated with a mass.
    animated
        Keys move the node, not physics. Its contacts are found below its own surface.
    friction
        The friction coefficient.
    margin
        The physics engine can keep other bodies this far off, in m.
    owner
        The node that this node is a part of.
    objects
        The session uids of the node's objects.
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
    """The wrench that the contacts of a body must add up to for the body to move as it does.

    Attributes
    ----------
    load
        The wrench about the centre of mass in this frame.
    centres
        The centre of mass (3, 3) in the previous, this and the next frame, in m.
    mass
        The mass in kg.
    reach
        How far the body moves in a frame, in m.
    problem
        Why the load is unknown, or empty.
    """

    load: Load
    centres: Array
    mass: float
    reach: float
    problem: str = ""


@dataclass(frozen=True)
class BareSurface:
    """A surface that belongs to no node and therefore transmits no weight to a pad.

    `name` is its object's name, `number` its solid's number. `places` (k, 3) are the points in m
    where a body stands on it.
    """

    name: str
    number: int
    places: Array


@dataclass(frozen=True)
class Support:
    """The points where one `node` supports an animated body from below.

    Attributes
    ----------
    places
        The points (k, 3) in m.
    areas
        The area (k,) in m² of each point, reduced the wider the gap is.
    ground
        The supporting surfaces without a node.
    """

    node: Key
    places: Array
    areas: Array
    ground: tuple[BareSurface, ...] = ()


class World(Protocol):
    """The scene at one frame, as the search for a pad's island needs it. Lengths are in m."""

    up: Array
    gravity: float

    def node(self, key: Key) -> Node:
        """Return the node with this key."""

    def near(self, key: Key) -> Iterable[Key]:
        """Return the nodes whose bounds overlap a node's bounds, swept over the three frames."""

    def contacts(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        """Return the contacts between two nodes' shapes that are at most `reach` apart.

        `when` is −1, 0 or 1 for the previous, this or the next frame. In each contact, a = 0 is
        `one` and b = 1 is `two`.
        """

    def supports_of(self, key: Key) -> list[Support]:
        """Return the supports of an animated node."""

    def required_load(self, key: Key) -> RequiredLoad:
        """Return the load that the node's motion requires."""

    def constraints_of(self, key: Key) -> list[Constraint]:
        """Return the rigid-body constraints of a node."""

    def animated_near(self, pad: Key, beside: float, above: float) -> list[Key]:
        """Return animated nodes at most `beside` next to the pad or `above` over it."""


@dataclass(frozen=True)
class Constraint:
    """A rigid-body constraint between two nodes, either of which can be None: the ground.

    `place` (3,) is in m. `forces` (k, 3) are the axes along which the constraint can exert forces,
    and `moments` (k, 3) the axes about which it can exert moments.
    """

    name: str
    one: Key | None
    two: Key | None
    place: Array
    forces: Array
    moments: Array


@dataclass(frozen=True)
class Partner:
    """A node that touches a pad.

    `objects` are the session uids of its objects. `places` (n, 3) in m are its contact points, and
    `forces` (n, 3) in N the forces on the pad.
    """

    name: str
    objects: frozenset[int]
    places: Array
    forces: Array


@dataclass(frozen=True)
class PadForces:
    """The forces on a pad.

    Attributes
    ----------
    residual
        The greatest share of any body's required load that no contact explains.
    problem
        Why the forces are uncertain, or empty.
    usable
        Whether the forces are at least an estimate.
    bodies
        The number of bodies in the island.
    """

    partners: tuple[Partner, ...] = ()
    residual: float = 0.0
    problem: str = ""
    usable: bool = True
    bodies: int = 0
