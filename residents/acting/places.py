# SPDX-License-Identifier: GPL-3.0-or-later
"""What residents do where: places, doors, lamps and floors of a home, as its marks tell them.

Lengths in metres in the world, z up; a yaw of 0 looks along +x, counter-clockwise from above.
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
# What a hand moves; only through a DOOR does anybody walk.
MOVED = (DOOR, DRAWER, CURTAIN)
# Half the width, m, that an adult needs to get through.
BODY_M = 0.25


@dataclass(frozen=True, eq=False)
class Place:
    """Where something is done. One stands at `at` (3,) on the floor before and after it, looking
    along `yaw`; who sits looks that way too, who lies has the head there. `target` (3,) is where
    the hand goes, or what the hips rest on, `height` m above the floor. `edge` (3,): of a bed,
    where one sits before lying down, the back to the bed. `storey` counts from the lowest.
    `room_guessed`: only the sensors nearby tell the room. `size`: of its largest side, m."""

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
    """A leaf that a hand moves: it turns about `axis` (3,) through `hinge` (3,), or slides along
    `axis`.

    How far it is open is `opening`, in rad or m from how it stands in the file: it is shut at
    `closed`, and as far open as it goes at `open`. The leaf's frame, as it stands in the file, has
    its origin at the hinge (of what slides: at the edge that goes ahead when it opens) and the
    columns of `frame` (3, 3): x from there to the other edge, z up. `low`, `high`, `handle` (3,)
    are the leaf's box and its handle in it.
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
        return float(self.high[0] - self.low[0])

    def moved(self, opening: float) -> Array:
        """(4, 4): what takes the leaf from how it stands in the file to `opening`."""
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
        """(…, 3) in the world of points (…, 3) of the leaf's frame."""
        matrix = self.moved(opening)
        world = np.asarray(point, float) @ self.frame.T + self.hinge
        placed: Array = world @ matrix[:3, :3].T + matrix[:3, 3]
        return placed

    def handle_at(self, opening: float) -> Array:
        return self.at(self.handle, opening)

    def line(self, opening: float, count: int = 11) -> Array:
        """(count, 2): points on the floor along the middle of the leaf's thickness."""
        low, high = self.low, self.high
        points = np.zeros((count, 3))
        points[:, 0] = np.linspace(low[0], high[0], count)
        points[:, 1] = (low[1] + high[1]) / 2.0
        return self.at(points, opening)[:, :2]

    @property
    def middle(self) -> Array:
        """(2,): the middle of the shut leaf, on the floor."""
        return self.line(self.closed, 3)[1]

    def side(self, point: Array) -> float:
        """+1 where the leaf opens to (of what slides: one side of it), -1 on the other."""
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
    """`object` is what shines; `at` (3,) is its switch, or the lamp itself where it has none.
    Where one stands to switch it is the place of the same name."""

    name: str
    object: str
    at: Array


@dataclass(frozen=True, eq=False)
class Storey:
    """A floor at `height` m. Under a shut door that is marked it is free: residents open it.
    `number` (nx, ny) is the room of each of its cells in `rooms`, which begins with "" for none.
    `guessed` (nx, ny): whether only sensors tell the room of a cell."""

    height: float
    floor: Floor
    number: NDArray[np.int64]
    rooms: tuple[str, ...] = ("",)
    guessed: NDArray[np.bool_] | None = None

    def room_at(self, point: Array) -> str:
        """The room that a point (2,) or (3,) is in; empty where that is not known."""
        return self.rooms[int(self.number[self.floor.cell(point)])]

    def is_guessed_at(self, point: Array) -> bool:
        """Whether only sensors tell the room that a point (2,) or (3,) is in."""
        return self.guessed is not None and bool(self.guessed[self.floor.cell(point)])


@dataclass(frozen=True, eq=False)
class Places:
    """By name: all that is marked but doors; what hands move; lamps. `problems`: what of the marks
    could not be read."""

    places: Mapping[str, Place]
    doors: Mapping[str, Door]
    lamps: Mapping[str, LampPlace]
    storeys: tuple[Storey, ...] = ()
    problems: tuple[str, ...] = ()

    @property
    def entrances(self) -> tuple[Door, ...]:
        return tuple(door for door in self.doors.values() if door.entrance)

    def room_of(self, name: str) -> str:
        """The room of a place or door; empty where that is not known."""
        found = self.places.get(name) or self.doors.get(name)
        return found.room if found is not None else ""

    @property
    def guessed(self) -> tuple[str, ...]:
        """The names of the places whose room only sensors tell."""
        return tuple(place.name for place in self.places.values() if place.room_guessed)

    def storey_at(self, height: float) -> int:
        """The storey on which somebody's feet are at a height."""
        below = [k for k, storey in enumerate(self.storeys) if storey.height <= height + 0.3]
        return below[-1] if below else 0
