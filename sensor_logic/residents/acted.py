# SPDX-License-Identifier: GPL-3.0-or-later
"""What everybody did on one day: bodies, what hands moved, and the truth of it.

Times are seconds since midnight of the day. What began before midnight or goes on after the day is
there whole in the bodies and what is moved; the truth begins and ends with the day.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ..model import Array
from .timeline import Gesture, Hold, Swing, Timeline, merged

STANDING, WALKING, SITTING, LYING, AWAY = "standing", "walking", "sitting", "lying", "away"
# Hips and ankles of who sits down on something, gets up or stands are less above it, m.
OVER = 0.4


@dataclass(frozen=True)
class Swung(Swing):
    """A leaf that a person's hand moves from one opening to another (rad or m, as Door has it)."""

    person: str


@dataclass(frozen=True)
class Switch:
    """A lamp, by its `object`, that a person switches. At the time 0 or before: how the day
    begins, with no person."""

    time: float
    object: str
    on: bool
    person: str


@dataclass(frozen=True)
class ActedActivity:
    """An activity as it was acted, from when the way to its first step began; `place` is that of
    its places where most of it was done."""

    start: float
    end: float
    person: str
    activity: str
    place: str


@dataclass(frozen=True)
class Stay:
    """A time that a person spent in one place and posture. The place is empty on the way."""

    start: float
    end: float
    person: str
    place: str
    posture: str


@dataclass(frozen=True)
class Acted:
    """Persons are named as in the routine. Doors and things not in here stay as the file has them;
    of what swings, the first `before` is how the day begins. `sips`: when a thing in a hand is
    tilted to drink from it. Lists are in order of time."""

    bodies: Mapping[str, Timeline]
    swings: Mapping[str, list[Swung]] = field(default_factory=dict)
    switches: list[Switch] = field(default_factory=list)
    holds: Mapping[str, list[Hold]] = field(default_factory=dict)
    activities: list[ActedActivity] = field(default_factory=list)
    where: list[Stay] = field(default_factory=list)
    sips: Mapping[str, list[Gesture]] = field(default_factory=dict)

    def spans(self, start: float, end: float) -> Array:
        """(k, 2): when anything moves between two times, in order and apart. What changes at once
        has a span of no length."""
        spans = [body.moving() for body in self.bodies.values()]
        spans += [np.array([(s.start, s.end) for s in swings]) for swings in self.swings.values()]
        at_once = [switch.time for switch in self.switches]
        at_once += [held.start for holds in self.holds.values() for held in holds]
        # Who goes away or comes is hidden or shown.
        at_once += [time for body in self.bodies.values() for time in body.away().flat]
        spans.append(np.column_stack([at_once, at_once]))
        every = np.concatenate([span.reshape(-1, 2) for span in spans])
        inside = every[(every[:, 1] >= start) & (every[:, 0] <= end)]
        return merged(np.clip(inside, start, end).tolist())

    def borne(self, low: Array, high: Array, time: float) -> str:
        """The person whose hips or feet are at a time on something with these corners (3,) m, or
        come down on it; of several, who is lowest; empty where nobody is."""
        found = []
        for person, body in self.bodies.items():
            pose = body.poses(np.array([time]))
            points = np.concatenate([pose.pelvis, *pose.feet.ankle])
            over = ((points >= low) & (points <= high + (0.0, 0.0, OVER))).all(axis=1)
            found += [(float(z), person) for z in points[over, 2]]
        return min(found, default=(0.0, ""))[1]

    def mover(self, object: str, time: float) -> str:
        """The person that moves a door, lamp or thing at a time, or has done so last; empty where
        nobody has."""
        moves = [(swung.start, swung.person) for swung in self.swings.get(object, ())]
        moves += [(switch.time, switch.person) for switch in self.switches
                  if switch.object == object]  # fmt: skip
        last = ""
        for held in self.holds.get(object, ()):
            # Who puts a thing down is who had it.
            moves.append((held.start, held.person or last))
            last = held.person
        moves.sort()
        found = bisect_right(moves, time, key=lambda move: move[0])
        return moves[found - 1][1] if found else ""
