# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw what each person does at which time, or read it from a diary.

The entries of plans, called fixed points, come first, in the order of their drawn times. If one is
still under way when the next should start, the next one is late. Fillers take the time that is
left. Without a filler, a person continues the last activity, and a visitor is away.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
import random
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime, time, timedelta
from math import inf
from statistics import NormalDist

from ...sensor_logic.logs.error import InputError, explained
from ...sensor_logic.logs.wording import listed, named
from .routine import (
    AWAY,
    DAY,
    NEW_DAY,
    FixedPoint,
    Interruption,
    Pastime,
    Person,
    Routine,
    Segment,
    Spread,
)

# Random numbers for routines: one stream for each seed, person, date and purpose, so that another
# day, person or entry changes nothing else. They are the same in every version of Python.

_NORMAL = NormalDist()
# Day 0 of the streams. Any date is good, but another one would change all drawn days.
ORIGIN = date(2026, 3, 2)


class Stream:
    """A generator of random numbers for one person, one day and one purpose.

    Streams are independent, so further draws from one of them change no other.
    """

    def __init__(self, seed: int, person: str, day: int, purpose: str) -> None:
        key = repr((seed, person, day, purpose)).encode()
        # `Random.random` is the only method that Python promises to keep the same.
        self._uniform = random.Random(int.from_bytes(hashlib.sha256(key).digest()[:16])).random

    def uniform(self) -> float:
        """Draw a number from 0 to below 1."""
        return self._uniform()

    def normal(self) -> float:
        """Draw a standard normal number, limited to ±4."""
        value = _NORMAL.inv_cdf(min(max(self._uniform(), 1e-9), 1 - 1e-9))
        return min(max(value, -4.0), 4.0)

    def log_normal(self, median: float, varies: float | Spread) -> float:
        """Draw a log-normal number with a median.

        `varies` is the standard deviation of its logarithm, or a pair of them: below and above the
        median.
        """
        value = self.normal()
        sigma = varies if isinstance(varies, float) else varies[value > 0]
        return median * math.exp(sigma * value)

    def poisson(self, mean: float) -> int:
        """Draw a Poisson number by multiplying uniform numbers (Knuth), for small means."""
        limit, product, count = math.exp(-mean), self._uniform(), 0
        while product > limit:
            product *= self._uniform()
            count += 1
        return count

    def geometric(self, mean: float) -> int:
        """Draw a geometric number, which is at least 1; a `mean` below 1 counts as 1."""
        if mean <= 1.0:
            return 1
        return 1 + int(math.log(1.0 - self._uniform()) / math.log(1.0 - 1.0 / mean))

    def weighted_choice(self, weights: Sequence[float]) -> int:
        """Draw an index with probability proportional to its weight."""
        point = self._uniform() * sum(weights)
        for index, weight in enumerate(weights):
            point -= weight
            if point < 0:
                return index
        return max(index for index, weight in enumerate(weights) if weight > 0)


@dataclass(frozen=True)
class Draws:
    """The streams of random numbers for a seed; days are counted from the date `first`."""

    seed: int
    first: date

    def stream(self, person: str, day: int, purpose: str) -> Stream:
        """Return the stream of random numbers for a person, day and purpose."""
        return Stream(self.seed, person, day_number(self.first) + day, purpose)


def day_number(of: date) -> int:
    """Return the number of days from `ORIGIN` to a date; it is negative before `ORIGIN`."""
    return (of - ORIGIN).days


# The shortest stretch of an activity, s.
SHORTEST = 30.0
# The part of its length that an entry with a fixed end lasts at least. Assumed.
LEAST = 0.25


@dataclass(frozen=True)
class _DrawnEntry:
    """An entry of a plan with drawn times.

    If `lasts` is True, a late start makes the end late too. Otherwise, the end is fixed, and the
    entry should begin by the time `latest`, when what is still under way ends. It lasts at least
    `least` s, also if it begins later.
    """

    start: float
    end: float
    activity: str
    lasts: bool
    name: str
    least: float = SHORTEST
    latest: float = inf


def timetable(routine: Routine, first: date, days: int, seed: int) -> list[Segment]:
    """Draw what all persons do on all days.

    Parameters
    ----------
    routine : Routine
        The persons, activities and plans.
    first : date
        The first day; its midnight is 0 s.
    days : int
        The number of days.
    seed : int
        The seed of all random numbers.

    Returns
    -------
    list of Segment
        What each person does, in order and without gaps. A person's first segment begins
        at or before the first midnight, and the last one ends with the last day.
    """
    draws = Draws(seed, first)
    found: list[Segment] = []
    for person in routine.persons.values():
        # From a day before to a day after, so that the first and last night are complete.
        drawn = list(_join_segments(_person_segments(routine, person, days + 1, draws), inf))
        for number, rule in enumerate(routine.interruptions):
            if rule.person == person.name:
                drawn = list(_with_interruptions(drawn, rule, draws, number))
        for absence in routine.absences:
            if absence.person == person.name:
                away = _since(first, absence.begins), _since(first, absence.ends)
                drawn = list(_with_absence(drawn, *away, AWAY))
        found += [s for s in _join_segments(drawn, days * DAY) if s.end > 0.0]
    return found


def _since(first: date, moment: datetime) -> float:
    return (moment - datetime.combine(first, time())).total_seconds()


def _person_segments(
    routine: Routine, person: Person, days: int, draws: Draws
) -> Iterator[Segment]:
    """Yield what a person does, before interruptions and absences are applied."""
    now, doing = -DAY, person.begins
    times: Counter[tuple[float, str]] = Counter()
    drawn = [_draw_plan_entries(routine, person, day, draws) for day in range(-1, days)]
    for day, points in enumerate(drawn, start=-1):
        filling = draws.stream(person.name, day, "filler")
        later = [*points, *(drawn[day + 2] if day + 2 < len(drawn) else ())]
        for number, point in enumerate([*points, None]):
            # The next entry cuts an activity short, and midnight if the activity does not go on.
            cut = max(later[number].start, now) if number < len(later) else inf
            # An entry just after midnight can be drawn to before it.
            until = min((day + 1) * DAY, cut) if point is None else cut
            while now < until:
                activity, end = _draw_filler(
                    routine, person, draws.first, day, now, until, cut, doing, times, filling
                )
                times[_counted(now, activity)] += activity != doing
                yield Segment(now, end, person.name, activity)
                now, doing = end, activity
            if point is None:
                continue
            end = point.end if not point.lasts else now + point.end - point.start
            # What is under way ends in time for all entries of this day and the next.
            end = min([end, *(other.latest for other in later[number + 1 :])])
            # Where the draws leave no time for it, the next one is late.
            end = max(end, now + point.least)
            times[_counted(now, point.activity)] += point.activity != doing
            yield Segment(now, end, person.name, point.activity)
            now, doing = end, point.activity
            # A new stream after each fixed point: earlier draws change nothing later.
            filling = draws.stream(person.name, day, f"filler after {point.name}")
        if person.visitor:
            doing = AWAY


def _counted(time: float, activity: str) -> tuple[float, str]:
    """Return the day in which an activity that begins at a time is counted, with its name."""
    return (time - NEW_DAY) // DAY, activity


def _draw_plan_entries(
    routine: Routine, person: Person, day: int, draws: Draws
) -> list[_DrawnEntry]:
    found = []
    for number, plan in enumerate(routine.plans):
        if plan.person == person.name and draws.first + timedelta(day) in plan.days:
            for place, entry in enumerate(plan.entries):
                name = f"plan {number} {place}"
                if entry.either:
                    either = draws.stream(person.name, day, f"plan {number} {entry.either}")
                    if not entry.share[0] <= either.uniform() < entry.share[1]:
                        continue
                stream = draws.stream(person.name, day, name)
                if stream.uniform() < entry.chance:
                    found.append(_draw_plan_entry(entry, name, day * DAY, stream))
    return sorted(found, key=lambda point: point.start)


def _draw_plan_entry(entry: FixedPoint, name: str, midnight: float, stream: Stream) -> _DrawnEntry:
    start = midnight + entry.at + entry.spread[0] * stream.normal()
    if entry.until is not None:
        # So that it happens every day, whatever was drawn.
        least = max(LEAST * (entry.until - entry.at), SHORTEST)
        start = min(start, midnight + entry.until - least)
        end = midnight + entry.until + entry.spread[1] * stream.normal()
        end = max(end, start + least)
        return _DrawnEntry(start, end, entry.activity, False, name, least, end - least)
    end = start + max(stream.log_normal(entry.lasts or 0.0, entry.varies), SHORTEST)
    return _DrawnEntry(start, end, entry.activity, True, name)


def _draw_filler(
    routine: Routine, person: Person, first: date, day: int, now: float, until: float, cut: float,
    doing: str, times: Counter[tuple[float, str]], stream: Stream,
) -> tuple[str, float]:  # fmt: skip
    """Return an activity that a person does from `now` on, and its end.

    It ends at `until`, the next entry or midnight, or at `cut`, the next entry, if it goes on over
    midnight. A filler draws the activity. Without a filler it is `doing`, the last one; visitors
    are away.
    """
    soonest = until
    for filler in routine.fillers:
        if filler.person != person.name:
            continue
        # The filler of the previous day can last past midnight.
        for since in (day, day - 1):
            begins, ends = since * DAY + filler.begins, since * DAY + filler.ends
            if ends <= now or begins >= soonest or first + timedelta(since) not in filler.days:
                continue
            if begins > now:
                soonest = begins
                continue
            part = (now - begins) / (ends - begins)
            weights = [
                choice.weight_now(doing, times[_counted(now, choice.activity)], part)
                for choice in filler.choices
            ]
            if sum(weights) <= 0:
                # Nothing may follow what was done last, so it goes on.
                soonest = min(soonest, ends)
                continue
            choice = filler.choices[stream.weighted_choice(weights)]
            latest = cut if choice.goes_on else until
            return choice.activity, min(_drawn_end(choice, now, stream), latest)
    return (AWAY if person.visitor else doing), soonest


def _drawn_end(choice: Pastime, now: float, stream: Stream) -> float:
    """Return when an activity that a filler chose `now` ends."""
    if choice.until is None:
        lasts = stream.log_normal(choice.lasts or 0.0, choice.varies)
    else:
        lasts = (choice.until - now) % DAY + choice.spread * stream.normal()
    return now + max(lasts, SHORTEST)


def _with_interruptions(
    segments: list[Segment], rule: Interruption, draws: Draws, number: int
) -> Iterator[Segment]:
    """Yield the segments with the interruptions that a rule of the routine adds."""
    for segment in segments:
        if segment.activity != rule.during:
            yield segment
            continue
        # One stream for each stretch, so that earlier stretches of the day change nothing.
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


def _with_absence(
    segments: list[Segment], begins: float, ends: float, activity: str
) -> Iterator[Segment]:
    """Yield the segments with `activity` in place of all others from `begins` to `ends`."""
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


def _join_segments(segments: Iterable[Segment], ends: float) -> Iterator[Segment]:
    """Yield the segments up to the time `ends`, joined where the activity is the same."""
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


# A diary: a CSV `start,end,person,activity` that is acted in place of a routine's plans.

COLUMNS = ("start", "end", "person", "activity")
# The activity in the gaps of a diary.
OTHER = "Other"


def read(content: str, name: str) -> tuple[date, list[Segment]]:
    """Read a diary: a CSV file of the activities that persons do, with times.

    The parameters are those of `read_all`, for one file, and so is what is returned.
    """
    return read_all({name: content})


def read_all(contents: Mapping[str, str]) -> tuple[date, list[Segment]]:
    """Read the files of a diary as one.

    An activity that ends one file and begins the next, at the same time, is one.

    Parameters
    ----------
    contents : mapping of str to str
        The text of each CSV file, by its name, which is used in errors.

    Returns
    -------
    first : date
        The date whose midnight is 0 s.
    segments : list of Segment
        What each person does, in order, with the activity `OTHER` in the gaps.

    Raises
    ------
    InputError
        If a column or row is missing or wrong.
    """
    read_rows = [(name, *row) for name, content in contents.items() for row in _rows(content, name)]
    if not read_rows:
        raise InputError(f"{next(iter(contents))} has no rows: add at least one activity")
    first = min(start for _, _, start, *_ in read_rows).date()
    midnight = datetime.combine(first, time())
    found: dict[str, list[Segment]] = {}
    files: dict[str, str] = {}
    for name, line, start, end, person, activity in sorted(read_rows, key=lambda row: row[2:4]):
        segments = found.setdefault(person, [])
        begins, ends = ((moment - midnight).total_seconds() for moment in (start, end))
        before = segments[-1].end if segments else 0.0
        if begins < before:
            raise InputError(
                f"{name}, line {line}: {person!r} cannot do two things at once: "
                f"{segments[-1].activity!r} ends after {activity!r} begins"
            )
        if begins > before:
            segments.append(Segment(before, begins, person, OTHER))
        where = f"{name}, line {line}"
        goes_on = begins == before and files.get(person, name) != name
        files[person] = name
        if goes_on and segments[-1].activity == activity:
            begins, where = segments[-1].start, segments[-1].where
            segments.pop()
        segments.append(Segment(begins, ends, person, activity, where))
    return first, [segment for segments in found.values() for segment in segments]


# s: a time without activities in a diary that is so long is told. Assumed.
LONG_GAP = 4 * 3600.0


def check_covers(
    segments: Sequence[Segment],
    first: date | None,
    persons: Collection[str],
    start: date,
    days: int,
    name: str,
) -> list[str]:
    """Return a sentence on each person whom a diary leaves out for long on the days to simulate.

    Parameters
    ----------
    segments, first
        The diary, as `read_all` returns it; None for no diary.
    persons
        The persons of the routine.
    start, days
        The first day to simulate, and the number of days.
    name
        The name of the diary, used in errors and sentences.

    Raises
    ------
    InputError
        If the diary says nothing of the first day or of any person of the routine.
    """
    if first is None:
        return []
    rows = [one for one in segments if one.where]
    known = [one for one in rows if one.person in persons]
    if not known:
        raise InputError(
            f"{name} is of {named({one.person for one in rows})}, and the routine has only "
            f"{named(persons)}: give both the same names"
        )
    begin = (start - first).days * DAY
    end = begin + days * DAY
    if not any(one.start < begin + DAY and one.end > begin for one in known):
        last = first + timedelta(int((max(one.end for one in known) - 1) // DAY))
        earliest = first + timedelta(int(min(one.start for one in known) // DAY))
        span = str(last) if earliest == last else f"{earliest} to {last}"
        raise InputError(f"{name} says nothing of {start}: begin on one of its days, {span}")
    found = []
    for person in persons:
        mine = [one for one in rows if one.person == person and one.end > begin]
        ends = [begin, *(one.end for one in mine)]
        begins = [*(one.start for one in mine), end]
        gaps = [(a, min(b, end)) for a, b in zip(ends, begins, strict=True)]
        long = [f"{_shown(first, a)} to {_shown(first, b)}" for a, b in gaps if b - a >= LONG_GAP]
        if long:
            found.append(
                f"{name} says nothing of '{person}' from {listed(long)}: '{OTHER}' is done then"
            )
    if others := {one.person for one in rows} - set(persons):
        found.append(f"{name}: the routine has no {named(sorted(others))}, whose rows are left out")
    return found


def _shown(first: date, seconds: float) -> str:
    return f"{datetime.combine(first, time()) + timedelta(seconds=seconds):%Y-%m-%d %H:%M}"


def _rows(content: str, name: str) -> list[tuple[int, datetime, datetime, str, str]]:
    """Return line, start, end, person and activity of each row of a diary's file."""
    head = content.partition("\n")[0]
    # As Excel writes where numbers have decimal commas.
    rows = csv.DictReader(io.StringIO(content), delimiter="," if "," in head else ";")
    missing = [column for column in COLUMNS if column not in (rows.fieldnames or ())]
    if missing:
        raise InputError(f"{name}, line 1: the column {missing[0]!r} is missing")
    return [(rows.line_num, *_row(row, f"{name}, line {rows.line_num}")) for row in rows]


def _row(row: dict[str, str], where: str) -> tuple[datetime, datetime, str, str]:
    """Return start, end, person and activity of a diary's row.

    Raise `InputError` if the row is invalid.
    """
    with explained(where, ValueError):
        start, end = (datetime.fromisoformat((row[key] or "").strip()) for key in ("start", "end"))
    person, activity = ((row[key] or "").strip() for key in ("person", "activity"))
    if start.tzinfo is not None or end.tzinfo is not None:
        raise InputError(f"{where}: a time has a time zone; give local times without one")
    if end <= start:
        raise InputError(f"{where}: the end must be after the start")
    if not person or not activity:
        raise InputError(f"{where}: give a person and an activity")
    return start, end, person, activity
