# SPDX-License-Identifier: GPL-3.0-or-later
"""Input and output of the calculation of forces on a pad.

The input is `World`: the bodies of a scene, their contacts, and the contact force that each body
needs for its motion. The output is `PadForces`.
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
    """A body or a pad, as a node in the graph of bodies that touch each other.

    Attributes
    ----------
    key
        A tuple of numbers that identifies the node in its `World`.
    name
        The name of the node's object.
    weighs
        Whether the node has a mass: it is simulated, or animated with a mass.
    animated
        Whether animation moves the node, not physics. Its supports are searched below its surface.
    friction
        The friction coefficient.
    margin
        The collision margin in m: the physics engine can keep other bodies this far away.
    owner
        The key of the node that this node is a part of; None if it is not a part.
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
    """The force and moment that the contacts of a body must exert, given the body's motion.

    Attributes
    ----------
    load
        The required wrench (force and moment) about the centre of mass in this frame.
    centres
        The centre of mass in the previous, this and the next frame, as rows (3, 3) in m.
    mass
        The mass in kg.
    reach
        The largest distance in m that a point of the body moves in a frame.
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
    """A surface that an animated body stands on, but that is not a `Node`.

    It does not transmit the body's weight to a pad.

    Attributes
    ----------
    name
        The name of the surface's object.
    number
        The number of the visible object or instance (`Solid.number`).
    places
        The points (k, 3) in m where the body stands on it.
    share
        The share of the body's whole support that it is, by area as in `Support`.
    """

    name: str
    number: int
    places: Array
    share: float = 1.0


@dataclass(frozen=True)
class Support:
    """The points at which a body or pad supports an animated body from below.

    Attributes
    ----------
    node
        The key of the supporting body or pad.
    places
        The points (k, 3) in m.
    areas
        The area (k,) in m² of each point, multiplied by a factor that falls as the gap there grows.
    ground
        The surfaces on which the animated body also stands, but that are not nodes.
    """

    node: Key
    places: Array
    areas: Array
    ground: tuple[BareSurface, ...] = ()


class World(Protocol):
    """The scene at one frame, as input of `pad_forces`; lengths are in m.

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
        """Return the body or pad with this key."""

    def near(self, key: Key) -> Iterable[Key]:
        """Return the keys of the bodies and pads whose bounding boxes overlap the box of `key`.

        Each box covers the motion in the previous, this and the next frame.
        """

    def contacts(self, one: Key, two: Key, reach: float, when: int) -> list[Contact]:
        """Return the contacts between the shapes of two bodies or pads, given by their keys.

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
        """Return the supports of an animated body, one for each body or pad that it stands on."""

    def required_load(self, key: Key) -> RequiredLoad:
        """Return the load that contacts must exert on a body for it to move as it does."""

    def constraints_of(self, key: Key) -> list[Constraint]:
        """Return the rigid-body constraints of a body."""

    def animated_near(self, pad: Key, beside: float, above: float) -> list[Key]:
        """Return the keys of animated bodies near a pad.

        They are at most `beside` m away from the pad's side, or at most `above` m over it.
        """


@dataclass(frozen=True)
class Constraint:
    """A rigid-body constraint between two bodies.

    Attributes
    ----------
    one, two
        The keys of the bodies; None for a fixed point of the world.
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
    """A body that touches a pad, with its forces on the pad.

    Attributes
    ----------
    name
        The name of the body's object.
    objects
        The session uids of the body's objects.
    places
        The contact points (n, 3) in m.
    forces
        The forces (n, 3) in N on the pad at these points.
    area
        The contact area in m² at the points that carry a force; 0 if it is unknown.
    """

    name: str
    objects: frozenset[int]
    places: Array
    forces: Array
    area: float = 0.0


@dataclass(frozen=True)
class PadForces:
    """The forces on a pad.

    Attributes
    ----------
    partners
        The bodies that touch the pad, each with its forces.
    residual
        The fraction of a body's required load that its contacts do not explain. It is the largest
        fraction of all bodies that contacts connect with the pad.
    problem
        Why the forces are uncertain, or empty.
    usable
        Whether the forces can at least serve as an estimate.
    bodies
        The number of bodies that contacts connect with the pad.
    """

    partners: tuple[Partner, ...] = ()
    residual: float = 0.0
    problem: str = ""
    usable: bool = True
    bodies: int = 0
