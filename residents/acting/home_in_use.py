# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of a home during a day: open doors, lamps, carried objects and people.

People reserve places, so that no two of them use the same one. They also check their paths, so that
they do not walk through each other.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ...sensor_logic.model import Array
from .floor_map import FloorMap
from .places import DOOR, Door, Place, Places
from .timeline import LYING, SITTING, Gesture, Hold, LeafSwing, Switch, Wait

# Rooms whose name contains one of these are for one person at a time.
_PRIVATE = ("bath", "toilet", "wc", "shower")
# Least distances between the middles of two people, and of a person and a swinging leaf, m. People
# at two places less than AT_PLACE, but more than SAME_PLACE apart are no obstacle to each other.
APART, FROM_LEAF, AT_PLACE, SAME_PLACE = 0.42, 0.27, 0.6, 0.3


class Occupant(Protocol):
    """A person or cat in the home, as the other people see it."""

    name: str
    now: float
    place: str  # name of the present place, empty on the way
    posture: str
    is_ignored: bool  # no obstacle to others: away, or a cat
    since: float  # time of the last arrival
    wanted_path: Array | None  # the blocked path (n, 2) of a person who waits for it
    waiting_since: float  # start of that waiting
    is_cornered: bool  # has no room to step aside

    def positions_at(self, times: Array) -> Array:
        """Return the body's positions (n, 2) at times (n,)."""


@dataclass(frozen=True, eq=False)
class Clash:
    """A person who is in the way of another person.

    Attributes
    ----------
    at : array, shape (2,)
        The point at which the person is in the way, m.
    since, until : float
        The person is there from `since` until at least `until`, s.
    who : Occupant
        The person in the way.
    """

    at: Array
    since: float
    until: float
    who: Occupant

    def is_standing_at(self, time: float) -> bool:
        """Return whether the person in the way stands still at a time, s."""
        return self.since <= time


@dataclass(eq=False)
class HomeInUse:
    """The present state of a home, and the record of its changes during the day.

    Attributes
    ----------
    places : Places
        The marked places, doors and lamps.
    floor_map : FloorMap
        The floors and the paths on them.
    openings : dict of str to float
        The present opening of each leaf that was moved, rad or m.
    lamps : dict of str to bool
        Whether each lamp that was switched is on.
    things : dict of str to str
        The place of each carried object.
    swings, switches, holds, sips
        The changes so far, as in `Acted`.
    people : list of Occupant
        The persons and cats.
    users : dict of str to list of str
        The persons whose activities use each place, by its name.
    waits
        The times for which persons waited for a place so far.
    """

    places: Places
    floor_map: FloorMap
    openings: dict[str, float] = field(default_factory=dict)
    lamps: dict[str, bool] = field(default_factory=dict)
    things: dict[str, str] = field(default_factory=dict)
    swings: dict[str, list[LeafSwing]] = field(default_factory=dict)
    switches: list[Switch] = field(default_factory=list)
    holds: dict[str, list[Hold]] = field(default_factory=dict)
    sips: dict[str, list[Gesture]] = field(default_factory=dict)
    people: list[Occupant] = field(default_factory=list)
    users: dict[str, list[str]] = field(default_factory=dict)
    waits: list[Wait] = field(default_factory=list)
    _reserved: dict[str, Occupant] = field(default_factory=dict)
    _free_from: dict[str, float] = field(default_factory=dict)
    _busy: dict[str, tuple[Occupant, float]] = field(default_factory=dict)

    # Doors, lamps and things.

    def opening(self, door: Door) -> float:
        """Return the present opening of a door leaf, rad or m; 0 if nobody has moved it."""
        return self.openings.get(door.name, 0.0)

    def is_open(self, door: Door) -> bool:
        """Return whether a door leaf is at least a little open."""
        return abs(self.opening(door) - door.closed) > 0.02

    def stands_open(self, door: Door, occupant: Occupant) -> bool:
        """Return whether a door is open and no other person is using it."""
        return self.is_open(door) and not self._is_busy(door, occupant)

    def open_doors(self, storey: int) -> dict[str, float]:
        """Return the openings of a storey's open doors, by name."""
        return {
            door.name: self.opening(door)
            for door in self.places.doors.values()
            if door.use == DOOR and door.storey == storey and self.is_open(door)
        }

    def record_swing(self, door: Door, start: float, end: float, after: float, person: str) -> None:
        """Record that a person moves a door leaf to the opening `after` (rad or m)."""
        swing = LeafSwing(start, end, self.opening(door), after, person)
        self.swings.setdefault(door.name, []).append(swing)
        self.openings[door.name] = after

    def record_switch(self, object: str, on: bool, time: float, person: str) -> None:
        """Record that a person switches the lamp `object` on or off."""
        self.switches.append(Switch(time, object, on, person))
        self.lamps[object] = on

    def state(self) -> tuple[dict[str, bool], dict[str, float], dict[str, str]]:
        """Return copies of `lamps`, `openings` and `things`."""
        return dict(self.lamps), dict(self.openings), dict(self.things)

    def record_initial_state(
        self, left: tuple[dict[str, bool], dict[str, float], dict[str, str]], first: float
    ) -> None:
        """Record the state `left`, a result of `state`, as the state at the start of the day.

        The record has changes without a person, just before the time `first` (s).
        """
        lamps, openings, things = left
        self.switches += [Switch(first - 1.0, lamp, on, "") for lamp, on in lamps.items()]
        for name, opening in openings.items():
            resting = LeafSwing(first - 2.0, first - 1.0, opening, opening, "")
            self.swings[name] = [resting, *self.swings.get(name, [])]
        for name, place in things.items():
            at = self.put_position(name, self.places.places[place])
            self.holds[name] = [Hold(first - 2.0, None, at), *self.holds.get(name, [])]

    @staticmethod
    def put_position(thing: str, place: Place) -> Array | None:
        """Return the position (3,) of a carried object after it is put down at a place, m.

        Return None at the object's own place, because the blend file has this position.
        """
        return None if place.name == thing else np.array(place.target)

    # Reservations.

    def place_for(self, place: Place, person: str) -> Place:
        """Return the place, or a person's own side of it.

        A bed or seat for two has sides if several persons use it. One person alone uses the middle.
        """
        users = self.users.get(place.name, [])
        if len(users) < 2 or not place.sides or person not in users:
            return place
        return place.sides[users.index(person) % len(place.sides)]

    def holder_of(self, key: str) -> str:
        """Return the name of the person who has reserved `key`, or ""."""
        holder = self._reserved.get(key)
        return holder.name if holder is not None else ""

    def reservation_key(self, place: Place) -> str:
        """Return the name under which a place is reserved.

        This is the place's name, and the number of its side. In a bath or toilet it is "room" and
        the room's name, so that one person reserves the whole room.
        """
        room = place.room.lower()
        if any(word in room for word in _PRIVATE):
            return f"room {place.room}"
        return f"{place.name} side {place.side}" if place.side else place.name

    def is_free(self, key: str, occupant: Occupant) -> bool:
        """Return whether a person can now reserve `key`, a name from `reservation_key`."""
        holder = self._reserved.get(key)
        return holder is occupant or (
            holder is None and self._free_from.get(key, -np.inf) <= occupant.now
        )

    def reserve(self, key: str, occupant: Occupant) -> None:
        """Reserve `key`, a name from `reservation_key`, for a person."""
        self._reserved[key] = occupant

    def release(self, key: str, occupant: Occupant) -> None:
        """End a person's reservation of `key`; do nothing without one.

        Others can reserve `key` from this person's time `now` on.
        """
        if self._reserved.get(key) is occupant:
            del self._reserved[key]
            self._free_from[key] = occupant.now

    def release_all_but(self, key: str, occupant: Occupant) -> None:
        """End all reservations of a person except the reservation of `key`."""
        for other in [k for k, holder in self._reserved.items() if holder is occupant and k != key]:
            self.release(other, occupant)

    def can_move(self, door: Door, occupant: Occupant, patient: bool) -> bool:
        """Return whether a person can move a door now.

        This is False if somebody else uses the door, or stands where its leaf moves. If `patient`
        is True, it is also False if somebody walks there.
        """
        if self._is_busy(door, occupant):
            return False
        now = np.array([occupant.now])
        return not any(
            (patient or other.place)
            and self.floor_map.in_swing(door, other.positions_at(now)[0], FROM_LEAF)
            for other in self._others(occupant)
        )

    def occupy(self, door: Door, occupant: Occupant, until: float) -> None:
        """Reserve a door for a person until a time, s, so that others wait."""
        self._busy[door.name] = occupant, until

    def _is_busy(self, door: Door, occupant: Occupant) -> bool:
        holder, until = self._busy.get(door.name, (occupant, 0.0))
        return holder is not occupant and until > occupant.now

    def longest_waiting(self, occupant: Occupant) -> Occupant | None:
        """Return the person who waits longest because `occupant` is in the way, or None."""
        here = occupant.positions_at(np.array([occupant.now]))[0]
        found = [
            other
            for other in self._others(occupant)
            if other.wanted_path is not None
            and float(np.hypot(*(other.wanted_path - here).T).min()) < APART
        ]
        return min(found, key=lambda other: other.waiting_since, default=None)

    def will_come_near(self, other: Occupant, occupant: Occupant) -> bool:
        """Return whether another person's path comes near to `occupant` in the next 3.5 s."""
        times = occupant.now + np.linspace(0.0, 3.5, 8)
        off = other.positions_at(times) - occupant.positions_at(np.array([occupant.now]))
        return other.now > occupant.now and float(np.hypot(*off.T).min()) < 2 * APART

    def _others(self, occupant: Occupant) -> list[Occupant]:
        """Return all people who can be in the way of `occupant`."""
        return [other for other in self.people if other is not occupant and not other.is_ignored]

    def find_clash(self, occupant: Occupant, path: Array, speed: float) -> Clash | None:
        """Return the first clash on a path that `occupant` begins to walk now.

        Parameters
        ----------
        occupant : Occupant
            The person who walks.
        path : array, shape (n, 2)
            The corner points of the path, m.
        speed : float
            The walking speed, m/s.

        Returns
        -------
        Clash or None
            The first person in the way; None if nobody is.
        """
        others = self._others(occupant)
        lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
        if occupant.is_ignored or not others or not lengths[-1]:
            return None
        along = np.arange(0.0, lengths[-1] + 0.1, 0.1)
        here = np.column_stack([np.interp(along, lengths, path[:, k]) for k in (0, 1)])
        times = occupant.now + 0.3 + along / speed
        for other in others:
            there = other.positions_at(times)
            near = np.hypot(*(here - there).T) < APART
            # People at the next place, or beside the start, are not in the way.
            ends = (np.hypot(*(there - path[-1]).T) < AT_PLACE) & (
                np.hypot(*(there - path[-1]).T) > SAME_PLACE
            )
            beside = np.hypot(*(there - path[0]).T) < AT_PLACE
            # People who sit or lie are not on the walkable floor.
            rests = (other.posture in (SITTING, LYING)) & (times >= other.since)
            met = np.flatnonzero(near & ~ends & ~beside & ~rests)
            if len(met):
                return Clash(there[met[0]], other.since, other.now, other)
        return None
