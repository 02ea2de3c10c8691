# SPDX-License-Identifier: GPL-3.0-or-later
"""A small home, drawn in rectangles, and days acted in it.

Metres: a hall along y 3.2 … 4.6 with a bedroom and a bathroom south of it (doors at x 1.5 and 4.2),
an entrance to the north (x 1.0), and a living room at its east end; a vault that has no door.
"""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from math import pi

import numpy as np
import pytest
from angen_sensors.residents.acting import FloorMap, act
from angen_sensors.residents.acting.path_search import Floor
from angen_sensors.residents.acting.places import (
    DOOR,
    DRAWER,
    LAMP,
    LIE,
    SIT,
    STAND,
    USE,
    Door,
    LampPlace,
    Place,
    Places,
    Storey,
)
from angen_sensors.residents.acting.timeline import Acted, openings_at
from angen_sensors.residents.body.skeleton import ADULT, CAT, Build
from angen_sensors.residents.routine import file
from angen_sensors.residents.routine.routine import Segment
from angen_sensors.residents.routine.timetable import Draws, timetable

SIZE = 0.05
ROOMS = {
    "bedroom": (0.0, 0.0, 3.4, 3.0),
    "bathroom": (3.6, 0.0, 5.6, 3.0),
    "hall": (0.0, 3.2, 5.8, 4.6),
    "living room": (5.8, 0.0, 10.0, 4.6),
    "vault": (7.0, 5.0, 9.0, 6.5),
    "": (0.0, 4.8, 4.0, 6.5),
}
DOORWAYS = [(1.5, 3.0, 2.4, 3.2), (4.2, 3.0, 5.0, 3.2), (1.0, 4.6, 1.95, 4.8)]
THINGS = [(0.0, 0.0, 2.0, 1.0), (5.1, 0.0, 5.6, 0.6), (7.0, 0.0, 9.0, 0.9), (9.2, 3.8, 10.0, 4.6)]
# Name: use, x, y, yaw, and the target of the hand or the support of the hips.
MONDAY = date(2026, 3, 2)
PLACES = {
    "Bed": (LIE, 1.0, 1.6, pi, (1.0, 0.5, 0.5)),
    "Toilet": (SIT, 5.0, 0.95, pi / 2, (5.35, 0.4, 0.45)),
    "Washbasin": (USE, 4.1, 1.0, pi, (3.7, 1.0, 0.9)),
    "Sofa": (SIT, 7.5, 1.17, pi / 2, (7.5, 0.6, 0.45)),
    "Sofa east": (SIT, 8.5, 1.17, pi / 2, (8.5, 0.6, 0.45)),
    "Stove": (USE, 8.8, 3.9, 0.0, (9.3, 3.9, 0.9)),
    "Window": (STAND, 9.7, 2.5, 0.0, (10.0, 2.5, 1.5)),
    "Corner": (STAND, 0.4, 3.9, pi, (0.0, 3.9, 1.0)),
    "Cup": (USE, 8.8, 3.5, 0.0, (9.25, 3.85, 0.95)),
    "Bedside": (STAND, 2.6, 0.5, pi, (2.2, 0.5, 0.6)),
    "Behind the door": (STAND, 2.0, 2.45, -pi / 2, (2.0, 2.0, 1.0)),
    "Lamp bedroom": (LAMP, 2.9, 2.5, pi / 2, (2.9, 3.0, 1.1)),
    "Safe": (USE, 8.0, 5.8, 0.0, (8.4, 5.8, 1.0)),
}
X, Y, Z = np.eye(3)


def leaf(
    name: str, x: float, y: float, yaw: float, width: float, opens: float, entrance: bool = False
) -> Door:
    c, s = np.cos(yaw), np.sin(yaw)
    frame = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    low, high = np.array([0.0, 0.0, 0.02]), np.array([width, 0.04, 2.0])
    handle = np.array([width - 0.08, 0.02, 1.05])
    return Door(
        name, DOOR, np.array([x, y, 0.0]), Z, 0.0, opens, frame, low, high, handle,
        entrance=entrance,
    )  # fmt: skip


def small_home() -> Places:
    low, shape = np.array([-0.5, -0.5]), (220, 150)
    free, number = np.zeros(shape, bool), np.zeros(shape, np.int64)

    def cells(x0: float, y0: float, x1: float, y1: float) -> tuple[slice, slice]:
        i, j, k, m = (round((v + 0.5) / SIZE) for v in (x0, y0, x1, y1))
        return slice(i, k), slice(j, m)

    names = ["", *(room for room in ROOMS if room)]
    for room, box in ROOMS.items():
        free[cells(*box)], number[cells(*box)] = True, names.index(room)
    for box in DOORWAYS:
        free[cells(*box)] = True
    for box in THINGS:
        free[cells(*box)] = False
    storey = Storey(0.0, Floor(low, SIZE, free), number, tuple(names))
    places = {}
    for name, (use, x, y, yaw, target) in PLACES.items():
        at = np.array([x, y, 0.0])
        edge = np.array([1.0, 0.9, 0.5]) if use == LIE else None
        room = storey.room_at(at)
        size = 1.9 if name == "Safe" else 0.1
        places[name] = Place(name, use, at, yaw, np.array(target), target[2], room, edge, size=size)
    doors = [
        leaf("Door bedroom", 1.5, 3.0, 0.0, 0.9, -1.6),
        leaf("Door bathroom", 4.2, 3.2, 0.0, 0.8, 1.6),
        leaf("Entrance", 1.0, 4.6, 0.0, 0.95, -1.7, entrance=True),
        Door("Drawer", DRAWER, np.array([9.2, 4.0, 0.0]), -X, 0.0, 0.4, np.eye(3), np.zeros(3),
             np.array([0.1, 0.5, 0.2]), np.array([0.0, 0.25, 0.8]), slides=True),
    ]  # fmt: skip
    switch = np.array([2.9, 3.0, 1.1])
    lamps = {"Lamp bedroom": LampPlace("Lamp bedroom", "Bulb bedroom", switch)}
    return Places(places, {door.name: door for door in doors}, lamps, (storey,))


@dataclass
class Played:
    """A day that was acted, and the queries of tests on it."""

    acted: Acted
    places: Places

    def told(self, person: str) -> list[tuple[str, str]]:
        """Return a person's activities, with their places."""
        return [(d.activity, d.place) for d in self.acted.activities if d.person == person]

    def at(self, person: str, *times: float) -> np.ndarray:
        """Return the hips (n, 3)."""
        return self.acted.bodies[person].poses(np.array(times, float)).pelvis

    def moving_times(self, person: str) -> np.ndarray:
        spans = self.acted.bodies[person].moving()
        return np.concatenate([np.arange(start, end, 0.1) for start, end in spans])

    def seen(self, person: str, times: np.ndarray) -> np.ndarray:
        """Return (n,) whether the body is in the home."""
        away = self.acted.bodies[person].away()
        return ~((times[:, None] > away[:, 0]) & (times[:, None] < away[:, 1])).any(axis=1)

    def nearest_to_leaves(self, person: str) -> float:
        """Return the least distance (m) between the centre of a body and a leaf."""
        times = self.moving_times(person)
        times = times[self.seen(person, times)]
        hips, least = self.at(person, *times)[:, :2], np.inf
        for door in self.places.doors.values():
            where = openings_at(self.acted.swings.get(door.name, []), times, 0.0)
            for opening in np.unique(where.round(1)):
                now = np.abs(where - opening) <= 0.05
                off = hips[now, None] - door.line(opening, 31)
                least = min(least, float(np.hypot(*np.moveaxis(off, -1, 0)).min()))
        return least

    def nearest_to_each_other(self, one: str, other: str) -> float:
        times = np.union1d(self.moving_times(one), self.moving_times(other))
        times = times[self.seen(one, times) & self.seen(other, times)]
        off = self.at(one, *times) - self.at(other, *times)
        return float(np.hypot(*off[:, :2].T).min())


@pytest.fixture(scope="session")
def home() -> Places:
    return small_home()


@pytest.fixture(scope="session")
def floor_map(home: Places) -> FloorMap:
    return FloorMap(home)


@pytest.fixture
def play(home: Places, floor_map: FloorMap) -> Callable[..., Played]:
    """Act activities, `Name = steps` one per line, by the minutes at which each begins.

    Steps are separated by commas, or a TOML array. Who rests keeps still, unless the line ends with
    `while resting`.

    They are acted in the small home, or in `places`. `head` is further text of the routine.
    """

    def played(
        activities: str, days: dict[str, list[tuple[float, str]]], day: int = 0, seed: int = 1,
        builds: dict[str, Build] | None = None, until: float = 1440.0,
        places: Places | None = None, head: str = "",
    ) -> Played:  # fmt: skip
        routine = file.read(routine_text(activities, list(days), head), "week.toml")
        segments = []
        for person, begins in days.items():
            ends = [at for at, _ in begins[1:]] + [until]
            for (at, activity), end in zip(begins, ends, strict=True):
                segments.append(Segment(at * 60.0, end * 60.0, person, activity))
        bodies = {person: CAT if person == "cat" else ADULT for person in days} | (builds or {})
        at, over = (home, floor_map) if places is None else (places, FloorMap(places))
        return Played(act(segments, routine, at, bodies, Draws(seed, MONDAY), day, over), at)

    return played


def routine_text(activities: str, people: list[str], head: str) -> str:
    lines = ["schema = 1", *(f'[person.{person}]\nbegins = "Away"' for person in people)]
    lines += filter(None, [head])
    for line in filter(None, map(str.strip, activities.split("\n"))):
        name, _, steps = line.partition(" = ")
        do, _, meanwhile = steps.partition(" while ")
        quoted = ", ".join(f'"{step.strip()}"' for step in do.split(","))
        array = do if do.startswith("[") else f"[{quoted}]"
        lines.append(f"[activity.{name}]\ndo = {array}")
        if not meanwhile:
            lines.append("while = []")
        elif meanwhile != "resting":
            movement, _, every = meanwhile.partition(" every ")
            lines.append(f'while = [{{ do = "{movement}", every = "{every}" }}]')
    return "\n".join(lines)


@pytest.fixture(scope="session")
def week(home: Places, floor_map: FloorMap) -> Callable[..., Played]:
    """Act a day of a routine file, as it is drawn."""

    def played(text: str, day: int, days: int = 7, seed: int = 1) -> Played:
        routine = file.read(text, "week.toml")
        segments = timetable(routine, MONDAY, days, seed)
        bodies = dict.fromkeys(routine.persons, ADULT)
        return Played(
            act(segments, routine, home, bodies, Draws(seed, MONDAY), day, floor_map), home
        )

    return played
