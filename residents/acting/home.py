# SPDX-License-Identifier: GPL-3.0-or-later
"""The home while people live in it: what stands open, what shines, where things are, and who is
where, so that nobody takes another's place or walks through anybody."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ...sensor_logic.model import Array
from .ground import Ground
from .places import DOOR, Door, Place, Places
from .timeline import LYING, SITTING, Gesture, Hold, Switch, Swung

# A room with such a name is for one at a time.
_PRIVATE = ("bath", "toilet", "wc", "shower")
# Nearer to each other than this two people do not walk, nor nearer than that to a leaf that swings,
# m between their middles; but somebody at a place does not mind who comes to the next one.
APART, FROM_LEAF, AT_PLACE, SAME_PLACE = 0.42, 0.27, 0.6, 0.3


class Someone(Protocol):
    """A person as the others see them."""

    name: str
    now: float
    place: str  # where the person is, or empty on the way
    posture: str
    unseen: bool  # away, or a cat
    since: float  # stands still from then on, as far as is known
    wish: Array | None  # the way (n, 2) that somebody stands in, of who waits for that
    wished: float  # since when
    cornered: bool  # has nowhere to go aside

    def where(self, times: Array) -> Array:
        """Middles (n, 2) at times (n,)."""


@dataclass(frozen=True, eq=False)
class Clash:
    """A person in the way, who stands there from `since` until at least `until`."""

    at: Array
    since: float
    until: float
    who: Someone

    def stands(self, time: float) -> bool:
        return self.since <= time


@dataclass(eq=False)
class HomeInUse:
    places: Places
    ground: Ground
    openings: dict[str, float] = field(default_factory=dict)
    lamps: dict[str, bool] = field(default_factory=dict)
    things: dict[str, str] = field(default_factory=dict)
    swings: dict[str, list[Swung]] = field(default_factory=dict)
    switches: list[Switch] = field(default_factory=list)
    holds: dict[str, list[Hold]] = field(default_factory=dict)
    sips: dict[str, list[Gesture]] = field(default_factory=dict)
    people: list[Someone] = field(default_factory=list)
    _taken: dict[str, Someone] = field(default_factory=dict)
    _free_from: dict[str, float] = field(default_factory=dict)
    _busy: dict[str, tuple[Someone, float]] = field(default_factory=dict)

    # --- what hands move ----------------------------------------------------------------------
    def opening(self, door: Door) -> float:
        """How far a leaf is open now; at first as in the file."""
        return self.openings.get(door.name, 0.0)

    def is_open(self, door: Door) -> bool:
        return abs(self.opening(door) - door.closed) > 0.02

    def stands_open(self, door: Door, someone: Someone) -> bool:
        """Whether one can just walk through, for nobody is about to shut it."""
        return self.is_open(door) and not self._is_busy(door, someone)

    def left_open(self, storey: int) -> dict[str, float]:
        """The openings of the doors of a storey that stand open, by name."""
        return {
            door.name: self.opening(door)
            for door in self.places.doors.values()
            if door.use == DOOR and door.storey == storey and self.is_open(door)
        }

    def swing(self, door: Door, start: float, end: float, after: float, person: str) -> None:
        swung = Swung(start, end, self.opening(door), after, person)
        self.swings.setdefault(door.name, []).append(swung)
        self.openings[door.name] = after

    def switch(self, object: str, on: bool, time: float, person: str) -> None:
        self.switches.append(Switch(time, object, on, person))
        self.lamps[object] = on

    def as_left(self) -> tuple[dict[str, bool], dict[str, float], dict[str, str]]:
        """Lamps, openings and things as they are now."""
        return dict(self.lamps), dict(self.openings), dict(self.things)

    def begins(
        self, left: tuple[dict[str, bool], dict[str, float], dict[str, str]], first: float
    ) -> None:
        """Tells what was so before the day's first moment, by nobody's doing."""
        lamps, openings, things = left
        self.switches += [Switch(first - 1.0, lamp, on, "") for lamp, on in lamps.items()]
        for name, opening in openings.items():
            so = Swung(first - 2.0, first - 1.0, opening, opening, "")
            self.swings[name] = [so, *self.swings.get(name, [])]
        for name, place in things.items():
            at = self.put_at(name, self.places.places[place])
            self.holds[name] = [Hold(first - 2.0, None, at), *self.holds.get(name, [])]

    @staticmethod
    def put_at(thing: str, place: Place) -> Array | None:
        """The place (3,) of a thing that is put down; None if that is its own place."""
        return None if place.name == thing else np.array(place.target)

    # --- who has what -------------------------------------------------------------------------
    def key(self, place: Place) -> str:
        """What is taken by whoever is at a place: that alone, or the room it is in."""
        room = place.room.lower()
        return f"room {place.room}" if any(word in room for word in _PRIVATE) else place.name

    def is_free(self, key: str, someone: Someone) -> bool:
        holder = self._taken.get(key)
        return holder is someone or (
            holder is None and self._free_from.get(key, -np.inf) <= someone.now
        )

    def take(self, key: str, someone: Someone) -> None:
        self._taken[key] = someone

    def release(self, key: str, someone: Someone) -> None:
        """Lets others have what the person took, from the person's own time on."""
        if self._taken.get(key) is someone:
            del self._taken[key]
            self._free_from[key] = someone.now

    def keep_only(self, key: str, someone: Someone) -> None:
        for other in [k for k, holder in self._taken.items() if holder is someone and k != key]:
            self.release(other, someone)

    def may_move(self, door: Door, someone: Someone, patient: bool) -> bool:
        """Whether nobody is at a door, and nobody stands where its leaf goes. Who is not patient
        any more minds only those who have a place there."""
        if self._is_busy(door, someone):
            return False
        now = np.array([someone.now])
        return not any(
            (patient or other.place) and self.ground.in_swing(door, other.where(now)[0], FROM_LEAF)
            for other in self._others(someone)
        )

    def occupy(self, door: Door, someone: Someone, until: float) -> None:
        self._busy[door.name] = someone, until

    def _is_busy(self, door: Door, someone: Someone) -> bool:
        holder, until = self._busy.get(door.name, (someone, 0.0))
        return holder is not someone and until > someone.now

    def who_waits_for(self, someone: Someone) -> Someone | None:
        """The person who has waited longest to get past `someone`, or None."""
        here = someone.where(np.array([someone.now]))[0]
        found = [
            other
            for other in self._others(someone)
            if other.wish is not None and float(np.hypot(*(other.wish - here).T).min()) < APART
        ]
        return min(found, key=lambda other: other.wished, default=None)

    def comes_near(self, other: Someone, someone: Someone) -> bool:
        """Whether another is on the way near to somebody, as far as that is known."""
        times = someone.now + np.linspace(0.0, 3.5, 8)
        off = other.where(times) - someone.where(np.array([someone.now]))
        return other.now > someone.now and float(np.hypot(*off.T).min()) < 2 * APART

    def _others(self, someone: Someone) -> list[Someone]:
        return [other for other in self.people if other is not someone and not other.unseen]

    def clash(self, someone: Someone, path: Array, speed: float) -> Clash | None:
        """Whom one meets who sets off now along a way of corner points (n, 2)."""
        others = self._others(someone)
        lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
        if someone.unseen or not others or not lengths[-1]:
            return None
        along = np.arange(0.0, lengths[-1] + 0.1, 0.1)
        here = np.column_stack([np.interp(along, lengths, path[:, k]) for k in (0, 1)])
        times = someone.now + 0.3 + along / speed
        for other in others:
            there = other.where(times)
            near = np.hypot(*(here - there).T) < APART
            # Who is at the next place already, or stood beside one, is not in the way.
            ends = (np.hypot(*(there - path[-1]).T) < AT_PLACE) & (
                np.hypot(*(there - path[-1]).T) > SAME_PLACE
            )
            beside = np.hypot(*(there - path[0]).T) < AT_PLACE
            # Who sits or lies is where nobody walks.
            rests = (other.posture in (SITTING, LYING)) & (times >= other.since)
            met = np.flatnonzero(near & ~ends & ~beside & ~rests)
            if len(met):
                return Clash(there[met[0]], other.since, other.now, other)
        return None
