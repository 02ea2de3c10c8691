# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws who does what from when to when.

Fixed points come first, in the order of their drawn times; one that is still under way makes the
next one late. Fillers take what is left. Where nothing is planned and nothing fills, a person goes
on with what was last done, and a visitor is away.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import date, datetime, time, timedelta
from math import inf

from .draws import Draws, Stream
from .routine import AWAY, DAY, FixedPoint, Interruption, Person, Routine, Segment

# The shortest stretch of an activity, s: less than that nobody begins.
SHORTEST = 30.0


@dataclass(frozen=True)
class _Point:
    start: float
    end: float
    activity: str
    lasts: bool
    name: str


def timetable(routine: Routine, first: date, days: int, seed: int) -> list[Segment]:
    """What everybody does on `days` days from the date `first`: for each person segments without
    gaps, from the one that is under way at midnight of `first`, in s since then, to the end of the
    last day."""
    draws = Draws(seed, first)
    found: list[Segment] = []
    for person in routine.persons.values():
        # From a day before to a day after: the first night and the last are whole ones.
        drawn = list(_joined(_person(routine, person, days + 1, draws), inf))
        for number, rule in enumerate(routine.interruptions):
            if rule.person == person.name:
                drawn = list(_interrupted(drawn, rule, draws, number))
        for absence in routine.absences:
            if absence.person == person.name:
                away = _since(first, absence.begins), _since(first, absence.ends)
                drawn = list(_replaced(drawn, *away, AWAY))
        found += [s for s in _joined(drawn, days * DAY) if s.end > 0.0]
    return found


def _since(first: date, moment: datetime) -> float:
    return (moment - datetime.combine(first, time())).total_seconds()


def _person(routine: Routine, person: Person, days: int, draws: Draws) -> Iterator[Segment]:
    now, doing = -DAY, person.begins
    for day in range(-1, days):
        filling = draws.stream(person.name, day, "filler")
        for point in [*_points(routine, person, day, draws), None]:
            until = (day + 1) * DAY if point is None else max(point.start, now)
            while now < until:
                activity, end = _filled(
                    routine, person, draws.first, day, now, until, doing, filling
                )
                yield Segment(now, end, person.name, activity)
                now, doing = end, activity
            if point is None:
                continue
            end = point.end if not point.lasts else now + point.end - point.start
            if end - now >= SHORTEST:
                yield Segment(now, end, person.name, point.activity)
                now, doing = end, point.activity
                # Anew after each fixed point: what came before it changes nothing after it.
                filling = draws.stream(person.name, day, f"filler after {point.name}")
        if person.visitor:
            doing = AWAY


def _points(routine: Routine, person: Person, day: int, draws: Draws) -> list[_Point]:
    """The fixed points of a day that happen, in order."""
    found = []
    for number, plan in enumerate(routine.plans):
        if plan.person == person.name and draws.first + timedelta(day) in plan.days:
            for place, entry in enumerate(plan.entries):
                name = f"plan {number} {place}"
                stream = draws.stream(person.name, day, name)
                if stream.uniform() < entry.chance:
                    found.append(_point(entry, name, day * DAY, stream))
    return sorted(found, key=lambda point: point.start)


def _point(entry: FixedPoint, name: str, midnight: float, stream: Stream) -> _Point:
    start = midnight + entry.at + entry.spread * stream.normal()
    if entry.until is not None:
        end = midnight + entry.until + entry.spread * stream.normal()
        return _Point(start, max(end, start), entry.activity, False, name)
    end = start + stream.log_normal(entry.lasts or 0.0, entry.varies)
    return _Point(start, end, entry.activity, True, name)


def _filled(
    routine: Routine, person: Person, first: date, day: int, now: float, until: float,
    doing: str, stream: Stream,
) -> tuple[str, float]:  # fmt: skip
    """What is done from `now` on, and how long at most to `until`."""
    soonest = until
    for filler in routine.fillers:
        if filler.person != person.name:
            continue
        # Yesterday's may last past midnight.
        for since in (day, day - 1):
            begins, ends = since * DAY + filler.begins, since * DAY + filler.ends
            if first + timedelta(since) not in filler.days or ends <= now:
                continue
            if begins > now:
                soonest = min(soonest, begins)
                continue
            choice = filler.choices[stream.chosen([c.weight for c in filler.choices])]
            lasts = max(stream.log_normal(choice.lasts, choice.varies), SHORTEST)
            return choice.activity, min(now + lasts, until)
    return (AWAY if person.visitor else doing), soonest


def _interrupted(
    segments: list[Segment], rule: Interruption, draws: Draws, number: int
) -> Iterator[Segment]:
    for segment in segments:
        if segment.activity != rule.during:
            yield segment
            continue
        # Each stretch by its own stream: the ones before it on that day change nothing.
        purpose = f"interruption {number} {segment.start % DAY:.0f}"
        stream = draws.stream(rule.person, int(segment.start // DAY), purpose)
        now = segment.start
        times = sorted(
            segment.start + (segment.end - segment.start) * stream.uniform()
            for _ in range(stream.poisson(rule.times))
        )
        for start in times:
            end = start + max(stream.log_normal(rule.lasts, rule.varies), SHORTEST)
            if start - now < SHORTEST or segment.end - end < SHORTEST:
                continue
            yield Segment(now, start, segment.person, segment.activity)
            yield Segment(start, end, segment.person, rule.activity)
            now = end
        yield Segment(now, segment.end, segment.person, segment.activity)


def _replaced(
    segments: list[Segment], begins: float, ends: float, activity: str
) -> Iterator[Segment]:
    """The segments with another activity from `begins` to `ends`."""
    for segment in segments:
        start, end, person = segment.start, segment.end, segment.person
        if end <= begins or start >= ends:
            yield segment
            continue
        if start < begins:
            yield Segment(start, begins, person, segment.activity)
        yield Segment(max(start, begins), min(end, ends), person, activity)
        if end > ends:
            yield Segment(ends, end, person, segment.activity)


def _joined(segments: Iterable[Segment], ends: float) -> Iterator[Segment]:
    """What lies before a moment, neighbours of the same activity as one."""
    last: Segment | None = None
    for segment in segments:
        start, end = segment.start, min(segment.end, ends)
        if start >= end:
            continue
        if last is not None and segment.activity == last.activity:
            start = last.start
        elif last is not None:
            yield last
        last = Segment(start, end, segment.person, segment.activity)
    if last is not None:
        yield last
