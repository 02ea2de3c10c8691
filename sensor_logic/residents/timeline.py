# SPDX-License-Identifier: GPL-3.0-or-later
"""What one body does, as functions of time, and how doors and things move with it.

Times are seconds from the start of the day (or of a story), always as arrays (n,).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..model import Array
from .body.pose import BodyPose
from .body.turns import ease


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
        return pose if len(pose) == len(times) else pose.spread(len(times))


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
                pose = part.spread(len(times))
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
