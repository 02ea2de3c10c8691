# SPDX-License-Identifier: GPL-3.0-or-later
"""What one body does, as functions of time, how doors and things move with it, and what everybody
did on one day.

Times are seconds from the start of the day (or of a story), always as arrays (n,).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...sensor_logic.model import Array
from ..body.pose import BodyPose
from ..body.turns import ease


@dataclass(frozen=True)
class Clip:
    """The body from `start` to `end` s; `pose` takes the seconds (n,) since the start. A clip that
    is `still` has one pose throughout; in an `away` one the body is out of the home."""

    start: float
    end: float
    pose: Callable[[Array], BodyPose]
    still: bool = False
    away: bool = False

    def at(self, times: Array) -> BodyPose:
        pose = self.pose(np.clip(times - self.start, 0.0, self.end - self.start))
        return pose if len(pose) == len(times) else pose.repeated(len(times))


@dataclass(frozen=True)
class Gesture:
    """Something done on top of the clips: `apply` takes the poses of n moments, the times (n,) and
    the weights (n,), 0 … 1, which rise and fall in so many seconds. One that is `steady` keeps
    still in between."""

    start: float
    end: float
    rise: float
    fall: float
    apply: Callable[[BodyPose, Array, Array], BodyPose]
    steady: bool = False

    def weight(self, times: Array) -> Array:
        weight = ease((times - self.start) / self.rise) * ease((self.end - times) / self.fall)
        return np.where((times > self.start) & (times < self.end), weight, 0.0)

    def spans(self) -> list[tuple[float, float]]:
        """When it moves the body."""
        risen, falls = self.start + self.rise, self.end - self.fall
        if self.steady and risen < falls:
            return [(self.start, risen), (falls, self.end)]
        return [(self.start, self.end)]


@dataclass(frozen=True)
class Swing:
    """A leaf or drawer that goes from one place to another: `before` and `after` are angles of a
    hinge, or m along a slide."""

    start: float
    end: float
    before: float
    after: float


def swung(swings: Sequence[Swing], times: Array, resting: float) -> Array:
    """Where a leaf is at times (n,): the swings in the order of their starts; `resting` before the
    first."""
    where = np.full(len(times), resting)
    for swing in swings:
        begun = times >= swing.start
        share = ease((times[begun] - swing.start) / (swing.end - swing.start))
        where[begun] = swing.before + (swing.after - swing.before) * share
    return where


@dataclass(frozen=True)
class Hold:
    """Where a thing is from `start` on: in a hand (side 0 or 1) of a person, at a point (3,), or
    with neither where the file has it."""

    start: float
    hand: int | None
    at: Array | None = None
    person: str = ""


@dataclass
class Timeline:
    """What one body does: clips without gaps, gestures in the order in which they are applied."""

    clips: list[Clip] = field(default_factory=list)
    gestures: list[Gesture] = field(default_factory=list)

    @property
    def duration(self) -> float:
        return self.clips[-1].end

    def base(self, times: Array) -> BodyPose:
        """The body without gestures, n moments; before and after the clips it keeps still."""
        times = np.asarray(times, float)
        ends = np.array([clip.end for clip in self.clips])
        which = np.minimum(np.searchsorted(ends, times, side="right"), len(ends) - 1)
        pose: BodyPose | None = None
        for number in np.unique(which):
            index = np.flatnonzero(which == number)
            part = self.clips[number].at(times[index])
            if pose is None:
                pose = part.repeated(len(times))
            pose.put(index, part)
        assert pose is not None
        return pose

    def poses(self, times: Array) -> BodyPose:
        """The body at times (n,), n > 0."""
        times = np.asarray(times, float)
        pose = self.base(times)
        first, last = times.min(), times.max()
        for gesture in self.gestures:
            if gesture.end <= first or gesture.start >= last:
                continue
            during = np.flatnonzero((times > gesture.start) & (times < gesture.end))
            weight = gesture.weight(times[during])
            index, weight = during[weight > 0], weight[weight > 0]
            if len(index):
                pose.put(index, gesture.apply(pose.take(index), times[index], weight))
        return pose

    def moving(self) -> Array:
        """(k, 2) s: when this body moves at all, in order, without overlaps."""
        spans = [(clip.start, clip.end) for clip in self.clips if not clip.still]
        return merged([*spans, *(span for g in self.gestures for span in g.spans())])

    def away(self) -> Array:
        """(k, 2) s: when the body is out of the home."""
        return merged([(clip.start, clip.end) for clip in self.clips if clip.away])


def merged(spans: Sequence[tuple[float, float]]) -> Array:
    """(k, 2): the union of spans, in order, without overlaps."""
    result: list[list[float]] = []
    for start, end in sorted(spans):
        if result and start <= result[-1][1]:
            result[-1][1] = max(result[-1][1], end)
        else:
            result.append([start, end])
    return np.array(result, float).reshape(-1, 2)


# What everybody did on one day: bodies, what hands moved, and the truth of it.
#
# Times are seconds since midnight of the day. What began before midnight or goes on after the day
# is there whole in the bodies and what is moved; the truth begins and ends with the day.

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
