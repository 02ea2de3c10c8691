# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion of bodies and objects on one day as functions of time, and what was acted.

Times are arrays (n,) in seconds from the start of the day, or of the animation in a home's file.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...sensor_logic.logs.wording import shown_duration
from ...sensor_logic.model import Array
from ..body.pose import BodyPose
from ..body.turns import ease

# A longer wait for a place is unusual, s.
LONG_WAIT = 900.0


@dataclass(frozen=True)
class Clip:
    """A piece of a body's motion.

    Attributes
    ----------
    start, end : float
        The times at which it begins and ends, s.
    pose : callable
        Takes the seconds (n,) since the start, and returns the poses.
    still : bool
        Whether the pose is the same from start to end.
    away : bool
        Whether the body is out of the home.
    """

    start: float
    end: float
    pose: Callable[[Array], BodyPose]
    still: bool = False
    away: bool = False

    def at(self, times: Array) -> BodyPose:
        """Return the poses at times (n,)."""
        pose = self.pose(np.clip(times - self.start, 0.0, self.end - self.start))
        return pose if len(pose) == len(times) else pose.repeated(len(times))


@dataclass(frozen=True)
class Gesture:
    """A movement that changes the poses of clips, such as reaching with one hand.

    Attributes
    ----------
    start, end : float
        The times at which it begins and ends, s.
    rise, fall : float
        The time in which the weight rises from 0 to 1 after the start, and falls to 0 before the
        end, s.
    apply : callable
        Takes poses, times (n,) and weights (n,) of 0 … 1, and returns the changed poses.
    steady : bool
        Whether the body is still between rise and fall.
    """

    start: float
    end: float
    rise: float
    fall: float
    apply: Callable[[BodyPose, Array, Array], BodyPose]
    steady: bool = False

    def weight(self, times: Array) -> Array:
        """Return the weights (n,) at times (n,)."""
        weight = ease((times - self.start) / self.rise) * ease((self.end - times) / self.fall)
        return np.where((times > self.start) & (times < self.end), weight, 0.0)

    def spans(self) -> list[tuple[float, float]]:
        """Return the times (start, end) between which the gesture moves the body, s."""
        risen, falls = self.start + self.rise, self.end - self.fall
        if self.steady and risen < falls:
            return [(self.start, risen), (falls, self.end)]
        return [(self.start, self.end)]


@dataclass(frozen=True)
class Swing:
    """A movement of a door leaf from the opening `before` to `after`, each in rad or m."""

    start: float
    end: float
    before: float
    after: float


def openings_at(swings: Sequence[Swing], times: Array, resting: float) -> Array:
    """Return the openings (n,) of a door leaf at times (n,), rad or m.

    Parameters
    ----------
    swings : sequence of Swing
        The leaf's movements, sorted by start.
    times : array, shape (n,)
        Seconds.
    resting : float
        The opening before the first movement, rad or m.
    """
    where = np.full(len(times), resting)
    for swing in swings:
        begun = times >= swing.start
        share = ease((times[begun] - swing.start) / (swing.end - swing.start))
        where[begun] = swing.before + (swing.after - swing.before) * share
    return where


@dataclass(frozen=True)
class Hold:
    """Where a carried object is from the time `start` on.

    It is in a hand of `person` (0 left, 1 right), or lies at the point `at` (3,). If `hand` and
    `at` are None, the object is where the blend file has it.
    """

    start: float
    hand: int | None
    at: Array | None = None
    person: str = ""


@dataclass
class Timeline:
    """The motion of one body: clips without gaps, and gestures that change their poses.

    Gestures apply in the order of the list.
    """

    clips: list[Clip] = field(default_factory=list)
    gestures: list[Gesture] = field(default_factory=list)

    @property
    def duration(self) -> float:
        """The end of the last clip, s."""
        return self.clips[-1].end

    def base(self, times: Array) -> BodyPose:
        """Return the poses at times (n,) without gestures.

        Before the first clip and after the last one the body is still.
        """
        times = np.asarray(times, float)
        ends = np.array([clip.end for clip in self.clips])
        numbers = np.minimum(np.searchsorted(ends, times, side="right"), len(ends) - 1)
        pose: BodyPose | None = None
        for number in np.unique(numbers):
            index = np.flatnonzero(numbers == number)
            part = self.clips[number].at(times[index])
            if pose is None:
                pose = part.repeated(len(times))
            pose.put(index, part)
        assert pose is not None
        return pose

    def poses(self, times: Array) -> BodyPose:
        """Return the poses at times (n,), gestures included; n must be above 0."""
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
        """Return the start and end of each movement of the body, s, shape (k, 2), sorted."""
        spans = [(clip.start, clip.end) for clip in self.clips if not clip.still]
        return merge_spans([*spans, *(span for g in self.gestures for span in g.spans())])

    def away(self) -> Array:
        """Return the start and end of each absence from the home, s, shape (k, 2)."""
        return merge_spans([(clip.start, clip.end) for clip in self.clips if clip.away])


def merge_spans(spans: Sequence[tuple[float, float]]) -> Array:
    """Return the union of time spans (start, end), sorted and without overlaps, shape (k, 2)."""
    result: list[list[float]] = []
    for start, end in sorted(spans):
        if result and start <= result[-1][1]:
            result[-1][1] = max(result[-1][1], end)
        else:
            result.append([start, end])
    return np.array(result, float).reshape(-1, 2)


# The acted day: bodies, the movements of leaves and things, and the truth.
#
# Times are seconds since midnight. Bodies and movements include those that begin before midnight or
# end after the day; the truth is cut at midnight.

STANDING, WALKING, SITTING, LYING, AWAY = "standing", "walking", "sitting", "lying", "away"
# Hips and ankles of a person on an object are at most this far above it, m.
OVER = 0.4


@dataclass(frozen=True)
class LeafSwing(Swing):
    """A movement of a door leaf by a person; see `Door` for the openings."""

    person: str


@dataclass(frozen=True)
class Switch:
    """The switching of a lamp on or off by a person.

    At a time of 0 or less, with `person` empty, this is the lamp's state at the start of the day.
    """

    time: float
    object: str
    on: bool
    person: str


@dataclass(frozen=True)
class ActedActivity:
    """An activity as a person did it, from setting out for its first step.

    `place` is where the person spent most of the activity.
    """

    start: float
    end: float
    person: str
    activity: str
    place: str


@dataclass(frozen=True)
class Stay:
    """A time that a person spent at one place in one posture.

    `place` is "" while the person walks from one place to another.
    """

    start: float
    end: float
    person: str
    place: str
    posture: str


@dataclass(frozen=True)
class Use:
    """A time for which a person sat or lay on an object, or worked at it with the hands."""

    start: float
    end: float
    person: str
    object: str


@dataclass(frozen=True)
class Wait:
    """A time for which a person waited for a place that another person used.

    `came` is whether the person then got the place, before the activity ended.
    """

    start: float
    end: float
    person: str
    place: str
    other: str
    came: bool

    @property
    def is_long(self) -> bool:
        """Whether the wait was in vain, or longer than people wait for a bathroom."""
        return not self.came or self.end - self.start > LONG_WAIT

    @property
    def text(self) -> str:
        """A sentence on the wait, and what to do about it."""
        minutes = round(self.start / 60.0)
        return (
            f"{self.person!r} waits {shown_duration(self.end - self.start)} from "
            f"{minutes // 60:02d}:{minutes % 60:02d} for {self.place!r}, which {self.other!r} "
            "uses: mark another place, or a bed or seat that is 1.2 m wide, or plan other times"
        )


@dataclass(frozen=True)
class Acted:
    """All that was acted on a day: motion, changes of the home, and who did what.

    Lists are sorted by time. A door or carried object without an entry stays as in the blend file.

    Attributes
    ----------
    bodies : mapping of str to Timeline
        The motion of each person.
    swings : mapping of str to list of LeafSwing
        The movements of each door leaf, from its opening at the start of the day.
    switches : list of Switch
        The switching of lamps.
    holds : mapping of str to list of Hold
        Where each carried object is.
    activities : list of ActedActivity
        What the persons did.
    where : list of Stay
        Where the persons were.
    sips : mapping of str to list of Gesture
        When each cup is tilted.
    waits : list of Wait
        Who waited for a place that another person used.
    uses : list of Use
        Who used which objects.
    """

    bodies: Mapping[str, Timeline]
    swings: Mapping[str, list[LeafSwing]] = field(default_factory=dict)
    switches: list[Switch] = field(default_factory=list)
    holds: Mapping[str, list[Hold]] = field(default_factory=dict)
    activities: list[ActedActivity] = field(default_factory=list)
    where: list[Stay] = field(default_factory=list)
    sips: Mapping[str, list[Gesture]] = field(default_factory=dict)
    waits: list[Wait] = field(default_factory=list)
    uses: list[Use] = field(default_factory=list)

    def times_in_use(self) -> dict[str, Array]:
        """Return start and end of each use of an object, s, shape (k, 2), by the object's name.

        The spans of an object are sorted and do not overlap. A lamp is in use while it is on.
        """
        found: dict[str, list[tuple[float, float]]] = {}
        for use in self.uses:
            found.setdefault(use.object, []).append((use.start, use.end))
        lit: dict[str, float] = {}
        for switch in self.switches:
            if switch.on:
                lit.setdefault(switch.object, switch.time)
            else:
                since = lit.pop(switch.object, switch.time)
                found.setdefault(switch.object, []).append((since, switch.time))
        for name, since in lit.items():
            found.setdefault(name, []).append((since, np.inf))
        return {name: merge_spans(spans) for name, spans in found.items()}

    def last_user(self, object: str, time: float) -> str:
        """Return the person who last used an object, or switched a lamp, at or before a time.

        Return "" if nobody has.
        """
        uses = [(use.start, use.person) for use in self.uses if use.object == object]
        uses += [(one.time, one.person) for one in self.switches if one.object == object]
        return max((use for use in uses if use[0] <= time), default=(0.0, ""))[1]

    def spans(self, start: float, end: float) -> Array:
        """Return the start and end of each movement between two times, s, shape (k, 2), sorted.

        The spans do not overlap. A change without duration, such as a lamp's, has a span of length
        0.
        """
        spans = [body.moving() for body in self.bodies.values()]
        spans += [np.array([(s.start, s.end) for s in swings]) for swings in self.swings.values()]
        at_once = [switch.time for switch in self.switches]
        at_once += [held.start for holds in self.holds.values() for held in holds]
        # A person who leaves or comes home is hidden or shown at once.
        at_once += [time for body in self.bodies.values() for time in body.away().flat]
        spans.append(np.column_stack([at_once, at_once]))
        every = np.concatenate([span.reshape(-1, 2) for span in spans])
        inside = every[(every[:, 1] >= start) & (every[:, 0] <= end)]
        return merge_spans(np.clip(inside, start, end).tolist())

    def person_on(self, low: Array, high: Array, time: float) -> str:
        """Return the person whose hips or feet are at most `OVER` m above an object.

        Parameters
        ----------
        low, high : array, shape (3,)
            The corners of the object's bounds, m.
        time : float
            Seconds since midnight.

        Returns
        -------
        str
            The name of the person whose hips or feet are lowest, or "" if there is
            none.
        """
        found = []
        for person, body in self.bodies.items():
            pose = body.poses(np.array([time]))
            points = np.concatenate([pose.pelvis, *pose.feet.ankle])
            over = ((points >= low) & (points <= high + (0.0, 0.0, OVER))).all(axis=1)
            found += [(float(z), person) for z in points[over, 2]]
        return min(found, default=(0.0, ""))[1]

    def last_mover(self, object: str, time: float) -> str:
        """Return the person who last moved a door, lamp or object at or before a time.

        Return "" if nobody has.
        """
        moves = [(swing.start, swing.person) for swing in self.swings.get(object, ())]
        moves += [(switch.time, switch.person) for switch in self.switches
                  if switch.object == object]  # fmt: skip
        last = ""
        for held in self.holds.get(object, ()):
            # A thing is put down by the person who held it.
            moves.append((held.start, held.person or last))
            last = held.person
        moves.sort()
        found = bisect_right(moves, time, key=lambda move: move[0])
        return moves[found - 1][1] if found else ""
