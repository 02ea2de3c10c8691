# SPDX-License-Identifier: GPL-3.0-or-later
"""The state of a home during a day: open doors, lamps, carried objects and reserved places.

People reserve places, so that no two of them use the same one.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...sensor_logic.model import Array
from .actor import Actor
from .floor_map import FloorMap
from .places import DOOR, Door, Place, Places
from .timeline import Gesture, Hold, LeafSwing, Switch, Use, Wait
from .traffic import Traffic

# Rooms whose name contains one of these are for one person at a time.
_PRIVATE = ("bath", "toilet", "wc", "shower")
# Least distance between a person and a swinging leaf, m.
FROM_LEAF = 0.27


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
    traffic : Traffic
        The persons and cats, and who is in whose way.
    users : dict of str to list of str
        The persons whose activities use each place, by its name.
    waits
        The times for which persons waited for a place so far.
    uses
        The times for which persons worked at places with their hands so far.
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
    traffic: Traffic = field(default_factory=Traffic)
    users: dict[str, list[str]] = field(default_factory=dict)
    waits: list[Wait] = field(default_factory=list)
    uses: list[Use] = field(default_factory=list)
    _reserved: dict[str, Actor] = field(default_factory=dict)
    _free_from: dict[str, float] = field(default_factory=dict)
    _busy: dict[str, tuple[Actor, float]] = field(default_factory=dict)

    # Doors, lamps and things.

    def opening(self, door: Door) -> float:
        """Return the present opening of a door leaf, rad or m; 0 if nobody has moved it."""
        return self.openings.get(door.name, 0.0)

    def is_open(self, door: Door) -> bool:
        """Return whether a door leaf is at least a little open."""
        return abs(self.opening(door) - door.closed) > 0.02

    def stands_open(self, door: Door, person: Actor) -> bool:
        """Return whether a door is open and no other person is using it."""
        return self.is_open(door) and not self._is_busy(door, person)

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
        self, initial: tuple[dict[str, bool], dict[str, float], dict[str, str]], begins: float
    ) -> None:
        """Record `initial`, a result of `state`, as the state at the start of the day.

        The record has changes without a person, just before the time `begins` (s).
        """
        lamps, openings, things = initial
        self.switches += [Switch(begins - 1.0, lamp, on, "") for lamp, on in lamps.items()]
        for name, opening in openings.items():
            resting = LeafSwing(begins - 2.0, begins - 1.0, opening, opening, "")
            self.swings[name] = [resting, *self.swings.get(name, [])]
        for name, place in things.items():
            at = self.put_position(name, self.places.places[place])
            self.holds[name] = [Hold(begins - 2.0, None, at), *self.holds.get(name, [])]

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

    def is_free(self, key: str, person: Actor) -> bool:
        """Return whether a person can now reserve `key`, a name from `reservation_key`."""
        holder = self._reserved.get(key)
        return holder is person or (
            holder is None and self._free_from.get(key, -np.inf) <= person.now
        )

    def reserve(self, key: str, person: Actor) -> None:
        """Reserve `key`, a name from `reservation_key`, for a person."""
        self._reserved[key] = person

    def release(self, key: str, person: Actor) -> None:
        """End a person's reservation of `key`; do nothing without one.

        Others can reserve `key` from this person's time `now` on.
        """
        if self._reserved.get(key) is person:
            del self._reserved[key]
            self._free_from[key] = person.now

    def release_all_but(self, key: str, person: Actor) -> None:
        """End all reservations of a person except the reservation of `key`."""
        for other in [k for k, holder in self._reserved.items() if holder is person and k != key]:
            self.release(other, person)

    def can_move(self, door: Door, person: Actor, patient: bool) -> bool:
        """Return whether a person can move a door now.

        This is False if somebody else uses the door, or stands where its leaf moves. If `patient`
        is True, it is also False if somebody walks there.
        """
        if self._is_busy(door, person):
            return False
        now = np.array([person.now])
        return not any(
            (patient or other.place)
            and self.floor_map.in_swing(door, other.body.positions_at(now)[0], FROM_LEAF)
            for other in self.traffic.others(person)
        )

    def occupy(self, door: Door, person: Actor, until: float) -> None:
        """Reserve a door for a person until a time, s, so that others wait."""
        self._busy[door.name] = person, until

    def _is_busy(self, door: Door, person: Actor) -> bool:
        holder, until = self._busy.get(door.name, (person, 0.0))
        return holder is not person and until > person.now
