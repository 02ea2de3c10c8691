# SPDX-License-Identifier: GPL-3.0-or-later
"""The truth of a day beside its events: who did what where, and where everybody was."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...sensor_logic.formats.log import LoggedActivity
from ...sensor_logic.model import Array
from ..acting.timeline import AWAY, Acted

DAY_S = 86_400.0
US = 1_000_000
# s: so often whoever moves is told of at least, and looked for in another room.
TELL_EVERY, LOOK_EVERY = 60.0, 1.0
# m: who stops farther than this from where was told last is told of there.
ELSEWHERE = 0.05


Point = tuple[float, float, float]


class Whereabouts(NamedTuple):
    """Where somebody was: `time` in µs since midnight, or since the first midnight of several days;
    the middle of the hips in m. Who is away has no place."""

    time: int
    person: str
    room: str
    at: Point | None
    posture: str


# The room of a point (3,), and that of a place by its name.
RoomAt = Callable[[Array], str]
RoomOf = Callable[[str], str]


def activities(
    acted: Acted, room_of: RoomOf, where: Iterable[Whereabouts] = ()
) -> list[LoggedActivity]:
    """What was done between midnight and midnight; `room_of` tells a place's room. What has no
    place, or never came to it, is in the room where that person was longest meanwhile, as `people`
    tells `where`. Times in µs."""
    found, of = [], defaultdict(list)
    for row in where:
        of[row.person].append(row)
    for done in acted.activities:
        start, end = (round(min(max(t, 0.0), DAY_S) * US) for t in (done.start, done.end))
        if start < end:
            room = room_of(done.place) if done.place else _mostly(of[done.person], start, end)
            found.append(LoggedActivity(start, end, done.person, done.activity, room))
    return sorted(found)


def people(acted: Acted, room_at: RoomAt, room_of: RoomOf) -> list[Whereabouts]:
    """Everybody at midnight, at each change of posture, room or place, where a movement ends, and
    at least each minute of movement. Who is at a place is in its room, as in the activities; on the
    way in that of the point."""
    rooms = room_at, room_of
    found = [where for person in acted.bodies for where in _person(acted, person, *rooms)]
    return sorted(found, key=lambda where: (where.time, where.person))


def _mostly(rows: Sequence[Whereabouts], start: int, end: int) -> str:
    """The room of most of the time from `start` to `end`."""
    times = [max(row.time, start) for row in rows] + [end]
    spent: dict[str, int] = defaultdict(int)
    for row, begin, stop in zip(rows, times, times[1:], strict=False):
        spent[row.room] += max(min(stop, end) - begin, 0)
    return max(spent, key=spent.__getitem__, default="")


def _person(acted: Acted, person: str, room_at: RoomAt, room_of: RoomOf) -> Iterator[Whereabouts]:
    body = acted.bodies[person]
    moving = body.moving()
    last: Whereabouts | None = None
    ends = set(moving[:, 1].tolist())
    stays = [s for s in acted.where if s.person == person and s.start < DAY_S and s.end > 0.0]
    looks = [_looks(max(s.start, 0.0), min(s.end, DAY_S), moving) for s in stays]
    # Of all at once: each call goes through all gestures of the day.
    every = np.concatenate([np.zeros(0), *looks])
    hips = np.zeros((0, 3))
    if len(every):
        hips = np.broadcast_to(body.poses(every).pelvis, (len(every), 3))
    parts = np.split(hips, np.cumsum([len(times) for times in looks])[:-1])
    for stay, times, where in zip(stays, looks, parts, strict=True):
        first, gone, told = max(stay.start, 0.0), stay.posture == AWAY, -np.inf
        for time, at in zip(times.tolist(), where, strict=True):
            room = "" if gone else room_of(stay.place) if stay.place else room_at(at)
            place = None if gone else (float(at[0]), float(at[1]), float(at[2]))
            if last is not None and time > first and room == last.room:
                stopped = time in ends and _apart(place, last.at) > ELSEWHERE
                if not stopped and time - told < TELL_EVERY - 1e-6:
                    continue
            told = time
            last = Whereabouts(round(time * US), person, room, place, stay.posture)
            yield last


def _apart(a: Point | None, b: Point | None) -> float:
    return math.dist(a, b) if a is not None and b is not None else 0.0


def _looks(first: float, end: float, moving: Array) -> Array:
    """The beginning of a stay, and in it every second of movement, and its end."""
    parts = [np.array([first])]
    inside = moving[(moving[:, 1] > first) & (moving[:, 0] < end)]
    for start, stop in np.clip(inside, first, end).tolist():
        if start < stop:
            parts.append(np.arange(np.ceil(start / LOOK_EVERY), stop / LOOK_EVERY) * LOOK_EVERY)
            parts.append(np.array([stop])[: int(stop < end)])
    return np.unique(np.concatenate(parts))


def joined(parts: Iterable[Iterable[LoggedActivity]]) -> list[LoggedActivity]:
    """The activities of days one after the other, in time since the first midnight: what goes on
    over midnight is one, in the room of its longest part."""
    found: list[LoggedActivity] = []
    # By person and activity, the place of the last one in `found`, and the length of the part that
    # gave it its room.
    open_: dict[tuple[str, str], tuple[int, int]] = {}
    for number, part in enumerate(parts):
        shift = round(number * DAY_S) * US
        for a in part:
            key, lasts = (a.person, a.activity), a.end - a.start
            now = LoggedActivity(a.start + shift, a.end + shift, *key, a.room)
            index, longest = open_.get(key, (0, 0))
            before = found[index] if longest else None
            if before is None or now.start != shift or before.end != shift:
                open_[key] = len(found), lasts
                found.append(now)
                continue
            room = now.room if lasts > longest else before.room
            open_[key] = index, max(lasts, longest)
            found[index] = LoggedActivity(before.start, now.end, *key, room)
    return sorted(found)
