# SPDX-License-Identifier: GPL-3.0-or-later
"""Input and output of the calculation of forces on a pad.

The input is `World`: the bodies of a scene, their contacts, and the load that the motion of each
body requires. The output is `PadForces`.
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
    """A body or pad that can touch other bodies and pads.

    Attributes
    ----------
    key
        Identifies the node in its `World`.
    name
        The name of the node's object.
    weighs
        The node has a weight of its own: it is simulated, or animated with a mass.
    animated
        Animation moves the node, not physics. What it stands on is found below its own surface.
    friction
        The friction coefficient.
    margin
        The collision margin in m. The physics engine can keep other bodies this far away.
    owner
        The node that this node is a part of, if any.
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
        The centre of mass in the previous, this and the next frame, as rows (3, 3) in m.
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
    """A surface that an animated body stands on and that belongs to no node.

    The weight on it is therefore not transmitted to a pad.

    Attributes
    ----------
    name
        The name of the surface's object.
    number
        The number of its solid.
    places
        The points (k, 3) in m where the body stands on it.
    """

    name: str
    number: int
    places: Array


@dataclass(frozen=True)
class Support:
    """The points at which the node with the key `node` supports an animated body from below.

    Attributes
    ----------
    places
        The points (k, 3) in m.
    areas
        The area (k,) in m² of each point, multiplied by a factor that falls as the gap there grows.
    ground
        The surfaces without a node on which the body also stands.
    """

    node: Key
    places: Array
    areas: Array
    ground: tuple[BareSurface, ...] = ()


class World(Protocol):
    """The scene at one frame, as the calculation reads it; lengths are in m.

    Attributes
    ----------
    up
        The unit vector (3,) upwards.
    gravity
        The acceleration of gravity in m/s².
    """

    up: Array
    gravity: float

    def node(self, key: Key) -> Node:
        """Return the node with this key."""

    def near(self, key: Key) -> Iterable[Key]:
        """Return the keys of the nodes near a node.

        Their bounding boxes overlap that of the node. Each box covers the node's motion in the
        previous, this and the next frame.
        """

    def contacts(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        """Return the contacts between the shapes of the nodes `one` and `two`.

        Parameters
        ----------
        reach
            The largest gap of a contact in m.
        when
            The frame: −1, 0 or 1 for the previous, this or the next one.

        Returns
        -------
        The contacts, in which body a = 0 is `one` and body b = 1 is `two`.
        """

    def supports_of(self, key: Key) -> list[Support]:
        """Return the supports of an animated node."""

    def required_load(self, key: Key) -> RequiredLoad:
        """Return the load that the node's motion requires."""

    def constraints_of(self, key: Key) -> list[Constraint]:
        """Return the rigid-body constraints of a node."""

    def animated_near(self, pad: Key, beside: float, above: float) -> list[Key]:
        """Return the keys of animated nodes near a pad.

        They are at most `beside` m away from the pad's side, or at most `above` m over it.
        """


@dataclass(frozen=True)
class Constraint:
    """A rigid-body constraint between the nodes with the keys `one` and `two`.

    Either can be None: the ground.

    Attributes
    ----------
    place
        The point (3,) in m where the constraint acts.
    forces
        The axes (k, 3) along which it can exert forces.
    moments
        The axes (k, 3) about which it can exert moments.
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

    Attributes
    ----------
    name
        The name of the node's object.
    objects
        The session uids of its objects.
    places
        The contact points (n, 3) in m.
    forces
        The forces (n, 3) in N on the pad at these points.
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
    partners
        The nodes that touch the pad, each with its forces.
    residual
        Of each body in the island, a share of the required load is not explained by contacts. This
        is the largest of these shares.
    problem
        Why the forces are uncertain, or empty.
    usable
        Whether the forces can at least serve as an estimate.
    bodies
        The number of bodies in the island.
    """

    partners: tuple[Partner, ...] = ()
    residual: float = 0.0
    problem: str = ""
    usable: bool = True
    bodies: int = 0
