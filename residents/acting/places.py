# SPDX-License-Identifier: GPL-3.0-or-later
"""The places, doors, lamps and floors of a home that residents use, read from its marks.

Lengths are in metres, positions in world coordinates with z up. A yaw is an angle about z: 0 is +x,
and it grows counter-clockwise seen from above.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array
from .path_search import Floor

STAND, SIT, LIE, USE = "STAND", "SIT", "LIE", "USE"
DOOR, LAMP, TAP, APPLIANCE = "DOOR", "LAMP", "TAP", "APPLIANCE"
DRAWER, CURTAIN, CUPBOARD = "DRAWER", "CURTAIN", "CUPBOARD"
# Leaves that a hand moves; residents only walk through a DOOR.
MOVED = (DOOR, DRAWER, CURTAIN, CUPBOARD)
# Parts of furniture, in which there is no floor.
INSIDE = (DRAWER, CUPBOARD)
# Leaves that turn or slide along their width.
LEAVES = (DOOR, CURTAIN, CUPBOARD)
# Half of the width that an adult needs, m.
BODY_M = 0.25


@dataclass(frozen=True, eq=False)
class Place:
    """A place where residents do something.

    Attributes
    ----------
    name, use : str
        The name of the marked object, and its use: STAND, SIT, LIE, USE or another.
    at : array, shape (3,)
        Where residents stand on the floor before and after using the place.
    yaw : float
        The direction in which they look while standing or sitting, rad. Lying, their head points
        in this direction.
    target : array, shape (3,)
        The point that the hand touches, or on which the hips rest.
    height : float
        The height of `target` above the floor, m.
    room : str
        The name of the room, or "".
    edge : array, shape (3,), or None
        Where a person sits on a bed before lying down.
    storey : int
        The storey's index; 0 is the lowest.
    room_guessed : bool
        Whether the room's name was guessed from the rooms of nearby sensors.
    size : float
        The largest side of the object, m.
    sides : tuple of Place
        For a bed or seat that is wide enough for two: the place of each, with the same name.
    side : int
        The number of a side, from 1; 0 for a place that is not one of the `sides`.
    """

    name: str
    use: str
    at: Array
    yaw: float
    target: Array
    height: float = 0.0
    room: str = ""
    edge: Array | None = None
    storey: int = 0
    room_guessed: bool = False
    size: float = 0.0
    sides: tuple[Place, ...] = ()
    side: int = 0


@dataclass(frozen=True, eq=False)
class Door:
    """A door, drawer or curtain: a leaf that turns about a hinge or slides.

    An opening is the leaf's rotation (rad) or shift (m) from its position in the blend file. The
    origin of the leaf's own coordinates is the hinge or, if the leaf slides, its leading edge.

    Attributes
    ----------
    name, use : str
        The name of the marked object, and DOOR, DRAWER or CURTAIN.
    hinge, axis : array, shape (3,)
        The hinge's position, and the axis about which the leaf turns or along which it slides.
    closed, open : float
        The opening of the shut leaf, and of the fully open one.
    frame : array, shape (3, 3)
        The axes of the leaf's own coordinates as columns: x to the other edge, z up.
    low, high : array, shape (3,)
        The corners of the leaf's box, in its own coordinates, m.
    handle : array, shape (3,)
        The handle, in the leaf's own coordinates, m.
    slides : bool
        Whether the leaf slides.
    entrance : bool
        Whether the door leads out of the home.
    room : str
        The name of the room, or "".
    storey : int
        The storey's index; 0 is the lowest.
    """

    name: str
    use: str
    hinge: Array
    axis: Array
    closed: float
    open: float
    frame: Array
    low: Array
    high: Array
    handle: Array
    slides: bool = False
    entrance: bool = False
    room: str = ""
    storey: int = 0

    @property
    def width(self) -> float:
        """The length of the leaf along its own x axis, m."""
        return float(self.high[0] - self.low[0])

    def moved(self, opening: float) -> Array:
        """Return the matrix (4, 4) that moves the leaf from where the file has it to `opening`."""
        matrix = np.eye(4)
        if self.slides:
            matrix[:3, 3] = self.axis * opening
            return matrix
        x, y, z = self.axis
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        turn = np.eye(3) + np.sin(opening) * cross + (1.0 - np.cos(opening)) * cross @ cross
        matrix[:3, :3], matrix[:3, 3] = turn, self.hinge - turn @ self.hinge
        return matrix

    def at(self, point: Array, opening: float) -> Array:
        """Transform points (…, 3) from the leaf's own to world coordinates, at an opening."""
        matrix = self.moved(opening)
        world = np.asarray(point, float) @ self.frame.T + self.hinge
        placed: Array = world @ matrix[:3, :3].T + matrix[:3, 3]
        return placed

    def handle_at(self, opening: float) -> Array:
        """Return the position (3,) of the handle at an opening, m."""
        return self.at(self.handle, opening)

    def line(self, opening: float, count: int = 11) -> Array:
        """Return points (count, 2) on the floor along the middle of the leaf, at an opening."""
        low, high = self.low, self.high
        points = np.zeros((count, 3))
        points[:, 0] = np.linspace(low[0], high[0], count)
        points[:, 1] = (low[1] + high[1]) / 2.0
        return self.at(points, opening)[:, :2]

    @property
    def middle(self) -> Array:
        """The middle (2,) of the shut leaf on the floor, m."""
        return self.line(self.closed, 3)[1]

    def side(self, point: Array) -> float:
        """Return the side of the door that a point is on: +1 where the leaf opens to, else −1.

        For a leaf that slides, +1 is the side to the left of its x axis.
        """
        first, last = self.line(self.closed, 2)
        along = last - first
        swing = self.line(self.open, 2)[1] - last
        if self.slides:
            swing = np.array([-along[1], along[0]])
        off = np.asarray(point, float)[:2] - first
        turns = along[0] * swing[1] - along[1] * swing[0]
        here = along[0] * off[1] - along[1] * off[0]
        return 1.0 if here * turns >= 0.0 else -1.0


@dataclass(frozen=True, eq=False)
class LampPlace:
    """A lamp that residents switch.

    Attributes
    ----------
    name : str
        The name of the marked object; a `Place` for the lamp has the same name.
    object : str
        The name of the lamp's object.
    at : array, shape (3,)
        The position of the switch or, without a switch, of the lamp.
    """

    name: str
    object: str
    at: Array


@dataclass(frozen=True, eq=False)
class Storey:
    """A storey of a home, with its floor and rooms.

    Attributes
    ----------
    height : float
        The height of the floor, m.
    floor : Floor
        Its free cells. Cells under marked doors are free too, because residents open these doors.
    number : array, shape (nx, ny)
        The index into `rooms` for each cell.
    rooms : tuple of str
        The rooms' names. The first is "", for cells of no known room.
    guessed : array, shape (nx, ny), or None
        Whether the room of each cell was guessed from the rooms of nearby sensors.
    """

    height: float
    floor: Floor
    number: NDArray[np.int64]
    rooms: tuple[str, ...] = ("",)
    guessed: NDArray[np.bool_] | None = None

    def room_at(self, point: Array) -> str:
        """Return the name of the room at a point (2,) or (3,), or "" if it is unknown."""
        return self.rooms[int(self.number[self.floor.cell(point)])]

    def is_guessed_at(self, point: Array) -> bool:
        """Return whether the room at a point (2,) or (3,) was guessed from nearby sensors."""
        return self.guessed is not None and bool(self.guessed[self.floor.cell(point)])


@dataclass(frozen=True, eq=False)
class Places:
    """All marked places, doors and lamps of a home by name, and its storeys.

    `problems` are sentences on marks that could not be read.
    """

    places: Mapping[str, Place]
    doors: Mapping[str, Door]
    lamps: Mapping[str, LampPlace]
    storeys: tuple[Storey, ...] = ()
    problems: tuple[str, ...] = ()

    @property
    def entrances(self) -> tuple[Door, ...]:
        """The doors that lead out of the home."""
        return tuple(door for door in self.doors.values() if door.entrance)

    def room_of(self, name: str) -> str:
        """Return the name of a place's or door's room, or "" if it is unknown."""
        found = self.places.get(name) or self.doors.get(name)
        return found.room if found is not None else ""

    @property
    def guessed(self) -> tuple[str, ...]:
        """The names of the places whose room was guessed from nearby sensors."""
        return tuple(place.name for place in self.places.values() if place.room_guessed)

    def storey_at(self, height: float) -> int:
        """Return the index of the storey of a person whose feet are at a height, m."""
        below = [k for k, storey in enumerate(self.storeys) if storey.height <= height + 0.3]
        return below[-1] if below else 0
