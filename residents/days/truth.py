# SPDX-License-Identifier: GPL-3.0-or-later
"""The truth of a day: what each person did, and where each person was."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...sensor_logic.logs.formats.log import LoggedActivity
from ...sensor_logic.model import Array
from ..acting.timeline import AWAY, Acted

DAY_S = 86_400.0
US = 1_000_000
# Longest time between two rows of a moving person, and time between two checks of the room, s.
ROW_EVERY, CHECK_EVERY = 60.0, 1.0
# A person who stops farther than this from the last row's position gets a row, m.
MOVED_M = 0.05


Point = tuple[float, float, float]


class Whereabouts(NamedTuple):
    """Where a person is from a time on.

    Attributes
    ----------
    time : int
        µs since midnight, or since the first of several midnights.
    person : str
        The person's name.
    room : str
        The name of the room, or "".
    at : Point or None
        The middle of the hips, m; None while the person is away.
    posture : str
        The posture, such as "sitting".
    """

    time: int
    person: str
    room: str
    at: Point | None
    posture: str


# Functions that return the room of a point (3,), and the room of a place by name.
RoomAt = Callable[[Array], str]
RoomOf = Callable[[str], str]


def activities(
    acted: Acted, room_of: RoomOf, where: Iterable[Whereabouts] = ()
) -> list[LoggedActivity]:
    """Return the activities of a day, sorted by time, with their rooms.

    Parameters
    ----------
    acted : Acted
        The acted day.
    room_of : callable
        Takes the name of a place and returns its room.
    where : iterable of Whereabouts
        The rows of `people`. An activity without a place gets the room in which the person was
        longest.

    Returns
    -------
    list of LoggedActivity
        The activities with times in µs, cut at midnight.
    """
    found, stays = [], defaultdict(list)
    for row in where:
        stays[row.person].append(row)
    for done in acted.activities:
        start, end = (round(min(max(t, 0.0), DAY_S) * US) for t in (done.start, done.end))
        if start < end:
            room = (
                room_of(done.place) if done.place else _longest_room(stays[done.person], start, end)
            )
            found.append(LoggedActivity(start, end, done.person, done.activity, room))
    return sorted(found)


def people(acted: Acted, room_at: RoomAt, room_of: RoomOf) -> list[Whereabouts]:
    """Return rows that say where all persons were on a day.

    There is a row at midnight, at changes of posture, room or place, and after movements. A
    movement has a row at least each minute. A person at a place is in the place's room. A walking
    person is in the room at their position.

    Parameters
    ----------
    acted : Acted
        The acted day.
    room_at, room_of : callable
        Take a point (3,), or the name of a place, and return the room.
    """
    rooms = room_at, room_of
    found = [where for person in acted.bodies for where in _rows_of_person(acted, person, *rooms)]
    return sorted(found, key=lambda where: (where.time, where.person))


def _longest_room(rows: Sequence[Whereabouts], start: int, end: int) -> str:
    times = [max(row.time, start) for row in rows] + [end]
    spent: dict[str, int] = defaultdict(int)
    for row, begin, stop in zip(rows, times, times[1:], strict=False):
        spent[row.room] += max(min(stop, end) - begin, 0)
    return max(spent, key=spent.__getitem__, default="")


def _rows_of_person(
    acted: Acted, person: str, room_at: RoomAt, room_of: RoomOf
) -> Iterator[Whereabouts]:
    body = acted.bodies[person]
    moving = body.moving()
    last: Whereabouts | None = None
    ends = set(moving[:, 1].tolist())
    stays = [s for s in acted.where if s.person == person and s.start < DAY_S and s.end > 0.0]
    looks = [_times_to_check(max(s.start, 0.0), min(s.end, DAY_S), moving) for s in stays]
    # One call for all times, because each call goes through all gestures of the day.
    every = np.concatenate([np.zeros(0), *looks])
    hips = np.zeros((0, 3))
    if len(every):
        hips = np.broadcast_to(body.poses(every).pelvis, (len(every), 3))
    parts = np.split(hips, np.cumsum([len(times) for times in looks])[:-1])
    for stay, times, where in zip(stays, looks, parts, strict=True):
        first, gone, row_time = max(stay.start, 0.0), stay.posture == AWAY, -np.inf
        for time, at in zip(times.tolist(), where, strict=True):
            room = "" if gone else room_of(stay.place) if stay.place else room_at(at)
            place = None if gone else (float(at[0]), float(at[1]), float(at[2]))
            if last is not None and time > first and room == last.room:
                stopped = time in ends and _distance_between(place, last.at) > MOVED_M
                if not stopped and time - row_time < ROW_EVERY - 1e-6:
                    continue
            row_time = time
            last = Whereabouts(round(time * US), person, room, place, stay.posture)
            yield last


def _distance_between(a: Point | None, b: Point | None) -> float:
    return math.dist(a, b) if a is not None and b is not None else 0.0


def _times_to_check(first: float, end: float, moving: Array) -> Array:
    """Return the start of a stay, each second of movement in it, and its end."""
    parts = [np.array([first])]
    inside = moving[(moving[:, 1] > first) & (moving[:, 0] < end)]
    for start, stop in np.clip(inside, first, end).tolist():
        if start < stop:
            parts.append(np.arange(np.ceil(start / CHECK_EVERY), stop / CHECK_EVERY) * CHECK_EVERY)
            parts.append(np.array([stop])[: int(stop < end)])
    return np.unique(np.concatenate(parts))


def join_activities(parts: Iterable[Iterable[LoggedActivity]]) -> list[LoggedActivity]:
    """Return the activities of consecutive days, in time since the first midnight.

    An activity that continues over midnight becomes one, with the room of its longest part.
    """
    found: list[LoggedActivity] = []
    # By person and activity: the index of the last one in `found`, and the length of the part whose
    # room it has.
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
