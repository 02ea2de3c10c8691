# SPDX-License-Identifier: GPL-3.0-or-later
"""The places, doors, lamps and floors of a home that residents use, read from its marks.

Lengths are in metres in the world, z up. A yaw of 0 looks along +x and grows counter-clockwise,
seen from above.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.model import Array
from .ways import Floor

STAND, SIT, LIE, USE = "STAND", "SIT", "LIE", "USE"
DOOR, LAMP, TAP, APPLIANCE = "DOOR", "LAMP", "TAP", "APPLIANCE"
DRAWER, CURTAIN = "DRAWER", "CURTAIN"
# Leaves that a hand moves; residents only walk through a DOOR.
MOVED = (DOOR, DRAWER, CURTAIN)
# Half of the width that an adult needs, m.
BODY_M = 0.25


@dataclass(frozen=True, eq=False)
class Place:
    """A place where residents do something.

    Residents stand at `at` (3,) on the floor, looking along `yaw`, before and after. Sitting
    residents look along `yaw` too; lying residents have their head in that direction. `target` (3,)
    is the point for the hand or under the hips, `height` m above the floor. `edge` (3,) is where
    one sits on a bed before lying down. `storey` counts from the lowest. `room_guessed` tells that
    only nearby sensors name the room. `size` is the largest side, m.
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


@dataclass(frozen=True, eq=False)
class Door:
    """A leaf that a hand moves: it turns about an axis through a hinge, or slides along it.

    An opening is the rotation (rad) or shift (m) against the leaf in the file: `closed` when shut,
    `open` when fully open. `hinge` and `axis` (3,) are in the world.

    The leaf's frame has its origin at the hinge, or, if the leaf slides, at its leading edge. The
    columns of `frame` (3, 3) are its axes: x to the other edge, z up. `low` and `high` (3,) are the
    corners of the leaf's box, and `handle` (3,) is its handle, in that frame.
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
        """The length of the leaf's box along x, m."""
        return float(self.high[0] - self.low[0])

    def moved(self, opening: float) -> Array:
        """Return the matrix (4, 4) that moves the leaf from the file's state to `opening`."""
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
        """Transform points (…, 3) from the leaf's frame to the world, at an opening."""
        matrix = self.moved(opening)
        world = np.asarray(point, float) @ self.frame.T + self.hinge
        placed: Array = world @ matrix[:3, :3].T + matrix[:3, 3]
        return placed

    def handle_at(self, opening: float) -> Array:
        """Return the position (3,) of the handle at an opening."""
        return self.at(self.handle, opening)

    def line(self, opening: float, count: int = 11) -> Array:
        """Return `count` points (count, 2) on the floor along the middle of the leaf."""
        low, high = self.low, self.high
        points = np.zeros((count, 3))
        points[:, 0] = np.linspace(low[0], high[0], count)
        points[:, 1] = (low[1] + high[1]) / 2.0
        return self.at(points, opening)[:, :2]

    @property
    def middle(self) -> Array:
        """The middle (2,) of the shut leaf on the floor."""
        return self.line(self.closed, 3)[1]

    def side(self, point: Array) -> float:
        """Return +1 for points on the side to which the leaf opens, −1 on the other.

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
    """A lamp, whose place has the same name.

    `object` is the name of the lamp's object. `at` (3,) is the switch, or the lamp itself if it has
    no switch.
    """

    name: str
    object: str
    at: Array


@dataclass(frozen=True, eq=False)
class Storey:
    """A storey with the floor at `height` m.

    The floor is free under marked doors, because residents open them. `number` (nx, ny) has the
    index into `rooms` for each cell; `rooms` begins with "" for no room. `guessed` (nx, ny) tells
    where only sensors name the room.
    """

    height: float
    floor: Floor
    number: NDArray[np.int64]
    rooms: tuple[str, ...] = ("",)
    guessed: NDArray[np.bool_] | None = None

    def room_at(self, point: Array) -> str:
        """Return the room at a point (2,) or (3,), or "" if it is unknown."""
        return self.rooms[int(self.number[self.floor.cell(point)])]

    def is_guessed_at(self, point: Array) -> bool:
        """Return whether only sensors name the room at a point (2,) or (3,)."""
        return self.guessed is not None and bool(self.guessed[self.floor.cell(point)])


@dataclass(frozen=True, eq=False)
class Places:
    """All marks of a home, by name: places, doors and lamps; and the problems of the marks."""

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
        """Return the room of a place or door, or "" if it is unknown."""
        found = self.places.get(name) or self.doors.get(name)
        return found.room if found is not None else ""

    @property
    def guessed(self) -> tuple[str, ...]:
        """The names of the places whose room only sensors name."""
        return tuple(place.name for place in self.places.values() if place.room_guessed)

    def storey_at(self, height: float) -> int:
        """Return the storey of a person whose feet are at a height."""
        below = [k for k, storey in enumerate(self.storeys) if storey.height <= height + 0.3]
        return below[-1] if below else 0
