# SPDX-License-Identifier: GPL-3.0-or-later
"""Learn the habits of a person from a log of activities, as plans and fillers of a routine.

What begins at about the same time on most days is an entry of a plan. The rest is a semi-Markov
process that depends on the time of day: what follows what, for each hour and kind of day, and how
long it lasts. What is done about equally often each day is made up for when it has been done less
often than usual. The night's rest ends at a time of day, and other activities interrupt it.

Days are counted from `NEW_DAY`, 04:00, so that a late evening belongs to its day.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date, datetime, time, timedelta

import numpy as np
import numpy.typing as npt

from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.formats.activities import DoneActivity, gaps, without_overlaps
from .file import check
from .routine import (
    DAY,
    NEW_DAY,
    Calendar,
    Filler,
    FixedPoint,
    FixedPoints,
    Interruption,
    Pastime,
    Person,
    Routine,
    RoutineActivity,
    Segment,
    seconds,
)
from .text import duration
from .timetable import OTHER, SHORTEST, timetable

HOUR = 3600.0
Values = npt.NDArray[np.float64]
# Days of the week that can have habits of their own, and how many days of each that takes.
KINDS_OF_DAY = (frozenset(range(5)), frozenset((5, 6)))
LEAST_DAYS = 4
# From this time on, habits are those of the kind of day that follows: an evening before work.
EVENING = 18 * HOUR
# A day counts as observed if activities cover this share of it. Assumed.
LEAST_COVERED = 0.2

# An activity is an entry of a plan if it begins so near to a time of day (s) on this share of the
# days, and if this share of all its starts is so near. Assumed.
PUNCTUAL, MOST_DAYS, MOST_STARTS = 30 * 60.0, 0.75, 1 / 3
# It follows another activity rather than the clock if its spread after that one is smaller by this
# factor. Assumed.
CHAINED = 0.5

# The greatest chance of entries that overlap.
ALMOST = 0.99

# The constants of the method were chosen with the homes B of Ordonez and A and C of Kasteren.
# Hours of the day in which fewer activities began than this are learnt together with the next.
LEAST_BEGUN = 10
# s: what began so long before or after an hour still counts for it, with less weight (Gaussian).
NEAR = 0.5 * HOUR
# What follows an activity is taken to be like what follows any, with the weight of so many cases;
# and how long an activity lasts in an hour like in any, with the weight of so many.
PRIOR_CASES, PRIOR_DURATIONS = 1.0, 3.0
# Fewer cases do not say what follows an activity.
LEAST_CASES = 2.0
# Choices that are rarer than this in their hour are left out.
RAREST = 0.003
# s: a rest at least this long is a night's; interruptions of a night last at most this long.
NIGHT, LONGEST_INTERRUPTION = 2 * HOUR, 20 * 60.0
# With more activities than this in an interruption, on average, nights are learnt as days are.
MOST_INNER = 1.5
# The least and the greatest `regular` that is learnt.
LEAST_REGULAR, MOST_REGULAR = 0.05, 20.0
# Rounds in which weights are corrected by drawn days, the number of these days, and the exponent.
ROUNDS, DRAWN_DAYS, STEP = 6, 120, 0.7
# Any date: that of the first drawn day, a Monday.
FIRST_DRAWN = date(2026, 3, 2)


@dataclass(frozen=True)
class Begun:
    """An activity that began on a day.

    Attributes
    ----------
    begins : float
        The start, s since the midnight of the day: from `NEW_DAY` to a day later.
    lasts : float
        The duration, s.
    activity, before : str
        The activity, and the one before it, or "" if that is unknown.
    """

    begins: float
    lasts: float
    activity: str
    before: str = ""

    @property
    def ends(self) -> float:
        """The end, s since the midnight of the day."""
        return self.begins + self.lasts


Days = Mapping[date, Sequence[Begun]]


@dataclass(frozen=True)
class LivedDays:
    """What a person did on whole days, of a log or drawn from a routine.

    Attributes
    ----------
    begun : mapping
        What began on each day, in order, with `OTHER` in gaps of a minute or more.
    outer : mapping
        The same with each interrupted night's rest as one activity.
    interruptions : mapping
        What interrupted the night's rest that began on a day.
    rest : str
        The activity that is the night's rest, or "".
    """

    begun: Days
    outer: Days
    interruptions: Days
    rest: str = ""

    def only(self, days: Collection[date]) -> LivedDays:
        """Return some of the days."""
        begun, outer, interruptions = (
            {day: begun for day, begun in of.items() if day in days}
            for of in (self.begun, self.outer, self.interruptions)
        )
        return LivedDays(begun, outer, interruptions, self.rest)


def lived_days(activities: Iterable[DoneActivity]) -> LivedDays:
    """Return the whole days of a log of one person's activities.

    Raise InputError if it has no whole day.
    """
    done = without_overlaps(activities)
    if not done:
        raise InputError("there are no activities")
    first = done[0].start.date()
    zero = datetime.combine(first, time())
    rows = [
        Segment(
            (one.start - zero).total_seconds(),
            (one.end - zero).total_seconds(),
            one.person,
            one.activity or OTHER,
        )
        for one in sorted([*done, *gaps(done)])
    ]
    found = lived(rows, first)
    if not found.begun:
        raise InputError("there is no whole day, from 04:00 to 04:00")
    return found


def lived(segments: Sequence[Segment], first: date) -> LivedDays:
    """Return the whole days of the segments of one person; `first` is the date of 0 s."""
    # Within an hour of a day's begin or end counts as whole.
    begin = math.ceil((segments[0].start - NEW_DAY - HOUR) / DAY)
    covered: dict[int, float] = defaultdict(float)
    for one in segments:
        for number in range(_day(one.start), _day(one.end) + 1):
            if one.activity != OTHER:
                low = number * DAY + NEW_DAY
                covered[number] += max(min(one.end, low + DAY) - max(one.start, low), 0.0)
    whole = range(begin, _day(segments[-1].end + HOUR))
    numbers = [number for number in whole if covered[number] >= LEAST_COVERED * DAY]
    rest = _rest(segments, len(numbers))
    outer, interruptions = _with_whole_nights(segments, rest)
    return LivedDays(
        _by_day(segments, numbers, first),
        _by_day(outer, numbers, first),
        _by_day(interruptions, numbers, first),
        rest,
    )


def _day(seconds: float) -> int:
    """Return the number of the day that a time is in."""
    return math.floor((seconds - NEW_DAY) / DAY)


def _by_day(segments: Sequence[Segment], numbers: Iterable[int], first: date) -> Days:
    """Return what began on each of the days with some numbers."""
    found: dict[int, list[Begun]] = {number: [] for number in numbers}
    before = ""
    for one in segments:
        number = _day(one.start)
        if number in found:
            begins, lasts = one.start - number * DAY, one.end - one.start
            found[number].append(Begun(begins, lasts, one.activity, before))
        before = one.activity
    return {first + timedelta(number): begun for number, begun in found.items()}


def _rest(segments: Sequence[Segment], days: int) -> str:
    """Return the activity that is under way at `NEW_DAY` on more than half of the days, or ""."""
    over = Counter(one.activity for one in segments if _day(one.start) < _day(one.end))
    activity, times = over.most_common(1)[0] if over else (OTHER, 0)
    return activity if activity != OTHER and 2 * times > days else ""


def _with_whole_nights(
    segments: Sequence[Segment], rest: str
) -> tuple[list[Segment], list[Segment]]:
    """Return the segments with each interrupted night's rest as one, and the interruptions.

    Interruptions have the start of the night's rest that they interrupt.
    """
    found: list[Segment] = []
    interruptions: list[Segment] = []
    inner: list[Segment] = []
    at = 0
    while at < len(segments):
        one, last = segments[at], at
        if one.activity == rest:
            for later in range(at + 1, len(segments)):
                if segments[later].start - segments[last].end > LONGEST_INTERRUPTION:
                    break
                if segments[later].activity == rest:
                    last = later
        end = segments[last].end
        if last > at and end - one.start >= NIGHT:
            interruptions += _between_rests(segments[at : last + 1], rest)
            inner += [of for of in segments[at + 1 : last] if of.activity not in (rest, OTHER)]
            one = replace(one, end=end)
        else:
            last = at
        found.append(one)
        at = last + 1
    if len(inner) > MOST_INNER * len(interruptions):
        # Several activities in a row follow each other as by day.
        return list(segments), []
    return found, interruptions


def _between_rests(night: Sequence[Segment], rest: str) -> Iterator[Segment]:
    """Yield one interruption for each time between two rests, named by what took longest then."""
    between: list[Segment] = []
    for one in night:
        if one.activity != rest:
            between.append(one)
        elif between:
            most = max(
                between, key=lambda inner: (inner.activity != OTHER, inner.end - inner.start)
            )
            start = night[0].start
            lasts = between[-1].end - between[0].start
            yield replace(most, start=start, end=start + lasts)
            between = []


# Habits of a kind of day.


@dataclass(frozen=True)
class _Habits:
    """The starts of a kind of day, as arrays of n cases, and how often each activity is done.

    Attributes
    ----------
    begins, lasts : array, shape (n,)
        Start, s since the day's midnight, and duration, s.
    activity, before : array, shape (n,)
        The activity, and the one before it.
    free, cut : array, shape (n,)
        Whether no entry of a plan stands for the case, and whether one ends it.
    times : mapping
        How many times each activity began on each of the days.
    """

    begins: Values
    lasts: Values
    activity: npt.NDArray[np.str_]
    before: npt.NDArray[np.str_]
    free: npt.NDArray[np.bool_]
    cut: npt.NDArray[np.bool_]
    times: Mapping[str, Values]

    @classmethod
    def of(cls, days: Days, planned: Collection[tuple[date, Begun]] = ()) -> _Habits:
        """Return the habits that `days` show; entries of a plan stand for the cases `planned`.

        An activity whose previous activity is unknown counts only for the number of times a day.
        """
        dated = [(day, one) for day, begun in days.items() for one in begun if one.before]
        rows = [one for _, one in dated]
        names = sorted({one.activity for begun in days.values() for one in begun})
        return cls(
            np.array([one.begins for one in rows]),
            np.array([one.lasts for one in rows]),
            np.array([one.activity for one in rows]),
            np.array([one.before for one in rows]),
            np.array([case not in planned for case in dated], bool),
            np.array([case in planned for case in (*dated[1:], None)], bool),
            {
                name: np.array([sum(b.activity == name for b in begun) for begun in days.values()])
                for name in names
            },
        )

    @property
    def days(self) -> int:
        """The number of days."""
        return max((len(times) for times in self.times.values()), default=0)

    def weights(self, begins: float, ends: float) -> Values:
        """Return how much each case (n,) counts between two times of day: 1 within, less near."""
        middle, half = (begins + ends) / 2, (ends - begins) / 2
        apart = np.abs((self.begins - middle + DAY / 2) % DAY - DAY / 2) - half
        found: Values = np.exp(-0.5 * (np.maximum(apart, 0.0) / NEAR) ** 2)
        return found

    def by(self, activity: str, at: float) -> float:
        """Return how many times a day an activity usually begins before a time of the day."""
        begun = (self.activity == activity) & (self.begins < at)
        return float(begun.sum()) / max(self.days, 1)

    def regularity(self, activity: str) -> float:
        """Return by how much the times a day of an activity are drawn to their mean.

        Where the rate of a count changes by the share k for each that is missing, the variance of
        the count is (1 − exp(−2km)) / 2k after m are due (the process of Ornstein and Uhlenbeck).
        """
        times = self.times[activity]
        mean, variance = times.mean(), times.var()
        if activity == OTHER or variance >= mean:
            return 0.0
        low, high = 0.0, MOST_REGULAR
        for _ in range(40):
            k = (low + high) / 2
            is_too_weak = (1 - math.exp(-2 * k * mean)) / (2 * k) > variance
            low, high = (k, high) if is_too_weak else (low, k)
        return high

    def spans(self) -> list[tuple[float, float]]:
        """Return spans of whole hours, from `NEW_DAY` on, in which habits are learnt together."""
        found: list[tuple[float, float]] = []
        begins = NEW_DAY
        for hour in range(24):
            ends = NEW_DAY + (hour + 1) * HOUR
            count = np.sum(self.free & (self.begins >= begins) & (self.begins < ends))
            # A span never goes over a time at which another kind or day of the week begins.
            if count >= LEAST_BEGUN or ends in (EVENING, DAY, DAY + NEW_DAY):
                found.append((begins, ends))
                begins = ends
        return found


def _quantiles(values: Values, weights: Values, at: Sequence[float]) -> list[float]:
    """Return quantiles of values (n,) with weights."""
    order = np.argsort(values, kind="stable")
    below = np.cumsum(weights[order]) - weights[order] / 2
    return [float(q) for q in np.interp(at, below / weights.sum(), values[order])]


# Quantiles (90 and 99 %) of a standard normal distribution; that of 84 % is 1.
Q90, Q99 = 1.2816, 2.3263
# A spread above the median up to which durations may be longer than any of the log.
USUAL_SPREAD = 1.5


def _duration(lasts: Values, weights: Values) -> tuple[float, tuple[float, float]]:
    """Return the median of durations, s, and their spread below and above it."""
    logs = np.log(np.maximum(lasts, SHORTEST))
    low, middle, high = _quantiles(logs, weights, (0.1, 0.5, 0.9))
    # Where most are short and some long, as in two sorts, one in 100 is as long as the longest.
    most = max((float(logs.max()) - middle) / Q99, USUAL_SPREAD)
    return math.exp(middle), ((middle - low) / Q90, min((high - middle) / Q90, most))


def _uncut(lasts: Values, weights: Values, cut: npt.NDArray[np.bool_]) -> Values:
    """Return the weights of durations, with those of activities that were cut given to longer ones.

    References
    ----------
    Efron, The two sample problem with censored data, Proc. Fifth Berkeley Symposium 4, 1967:
    redistribution to the right, which is the estimator of Kaplan and Meier.
    """
    found = weights.copy()
    order = np.argsort(lasts, kind="stable")
    for place, index in enumerate(order[:-1]):
        if cut[index]:
            longer = order[place + 1 :]
            found[longer] *= 1.0 + found[index] / found[longer].sum()
            found[index] = 0.0
    return found


def _choices(habits: _Habits, begins: float, ends: float, rest: str) -> list[Pastime]:
    """Return what is done between two times of day, with what it follows."""
    near = habits.weights(begins, ends) * habits.free
    total = near.sum()
    if total <= 0.0:
        return []
    share = {name: near[habits.activity == name].sum() / total for name in habits.times}
    follows: dict[str, dict[str, float]] = {}
    for before in np.unique(habits.before):
        cases = habits.before == before
        count = near[cases].sum()
        if count >= LEAST_CASES:
            left = max(1.0 - share.get(before, 0.0), 1e-6)
            follows[str(before)] = {
                # Comparable with the shares after other activities.
                name: (left * near[cases & (habits.activity == name)].sum()
                       + PRIOR_CASES * share[name]) / (count + PRIOR_CASES)
                for name in share
            }  # fmt: skip
    found = []
    for name in sorted(share, key=lambda name: -share[name]):
        if share[name] < RAREST:
            continue
        mine = habits.free & (habits.activity == name)
        # A night's rest says nothing about how long a nap lasts.
        naps = mine & (habits.lasts < NIGHT) if name == rest else mine
        like = naps if naps.any() else mine
        weights = _uncut(
            habits.lasts[like], near[like] + PRIOR_DURATIONS / like.sum(), habits.cut[like]
        )
        lasts, varies = _duration(habits.lasts[like], weights)
        after = {before: of[name] for before, of in follows.items() if before != name}
        choice = Pastime(name, share[name], lasts, varies, after={name: 0.0, **after})
        if name == rest:
            choice = _until(choice, habits, mine, near)
        regular = habits.regularity(name)
        if regular >= LEAST_REGULAR:
            usual = habits.by(name, begins), habits.by(name, ends)
            choice = replace(choice, usual=usual, regular=regular)
        found.append(choice)
    return found


def _until(choice: Pastime, habits: _Habits, mine: npt.NDArray[np.bool_], near: Values) -> Pastime:
    """Return the choice of a rest, which ends at a time of day where it is mostly a night's."""
    nights = mine & (habits.lasts >= NIGHT)
    weights = near[nights]
    if weights.sum() <= 0.5 * near[mine].sum():
        return choice
    # Ends of nights lie between two noons.
    ends = (habits.begins[nights] + habits.lasts[nights] - DAY / 2) % DAY + DAY / 2
    low, middle, high = _quantiles(ends, weights + 1e-9, (0.16, 0.5, 0.84))
    return replace(choice, lasts=None, until=middle % DAY, spread=(high - low) / 2)


# Plans.


@dataclass(frozen=True)
class _Regular:
    """An activity that begins at about the same time on most days.

    Attributes
    ----------
    entry : FixedPoint
        The entry of a plan, with `at` from `NEW_DAY` to a day later.
    cases : mapping
        The case on each day.
    """

    entry: FixedPoint
    cases: Mapping[date, Begun]


def _regulars(days: Days, rest: str) -> list[_Regular]:
    """Return the activities that begin at about the same time on most of the days, in order.

    Activities are left out that are more regular after the night's rest, or after an activity
    before them that is returned, than by the time of day.
    """
    names = {one.activity for begun in days.values() for one in begun} - {OTHER}
    found = [one for name in sorted(names) if (one := _regular(days, name)) is not None]
    found.sort(key=lambda one: one.entry.at)
    woken = {day: one for day, begun in days.items() for one in begun[::-1] if one.before == rest}
    ends = [{day: one.begins for day, one in woken.items()}]
    kept: list[_Regular] = []
    for one in found:
        last = kept[-1].entry if kept else None
        if last is not None and one.entry.at < (last.until or last.at + (last.lasts or 0.0)):
            continue
        if not any(_follows(one, before) for before in ends):
            kept.append(one)
            ends.append({day: case.ends for day, case in one.cases.items()})
    return kept


def _regular(days: Days, name: str) -> _Regular | None:
    """Return an activity as a regular one if it begins near one time of day on most of the days."""
    of = {day: [one for one in begun if one.activity == name] for day, begun in days.items()}
    starts = np.sort([one.begins for begun in of.values() for one in begun])
    best = max((_nearest(of, at, PUNCTUAL) for at in np.unique(starts)), key=len, default={})
    if len(best) < max(MOST_DAYS * len(days), LEAST_DAYS) or len(best) < MOST_STARTS * len(starts):
        return None
    # With the days on which it began a little earlier or later.
    best = _nearest(of, _middle(np.array([one.begins for one in best.values()]))[0], 2 * PUNCTUAL)
    begins, lasts, ends = (
        np.array([getattr(one, key) for one in best.values()])
        for key in ("begins", "lasts", "ends")
    )
    (middle, spread), (until, spread_of_end) = _middle(begins), _middle(ends)
    median, varies = _duration(lasts, np.ones(len(lasts)))
    # As the text of a routine has them.
    middle, until = 60.0 * round(middle / 60), 60.0 * round(until / 60)
    median = seconds(duration(max(median, 1.0)))
    is_by_clock = spread_of_end < _middle(lasts)[1] and middle < until < middle + DAY
    entry = FixedPoint(
        name, middle, (spread, spread_of_end if is_by_clock else spread),
        None if is_by_clock else median, until if is_by_clock else None,
        varies, len(best) / len(days), "",
    )  # fmt: skip
    return _Regular(entry, best)


def _nearest(of: Days, at: float, most: float) -> dict[date, Begun]:
    """Return the case of each day that begins nearest to a time of day, at most so far from it."""
    near = {day: min(b, key=lambda one: abs(one.begins - at)) for day, b in of.items() if b}
    return {day: one for day, one in near.items() if abs(one.begins - at) <= most}


def _middle(values: Values) -> tuple[float, float]:
    """Return the median of values, and their spread: half the distance of 16 and 84 %."""
    low, middle, high = _quantiles(values, np.ones(len(values)), (0.16, 0.5, 0.84))
    return middle, (high - low) / 2


def _follows(one: _Regular, before: Mapping[date, float]) -> bool:
    """Return whether an activity is more regular after some times than by the time of day."""
    after = [case.begins - before[day] for day, case in one.cases.items() if day in before]
    known = [gap for gap in after if gap >= 0.0]
    if 2 * len(known) <= len(one.cases):
        return False
    return _middle(np.array(known))[1] < CHAINED * one.entry.spread[0]


def _dated(
    entry: FixedPoint, kind: frozenset[int], days: frozenset[int]
) -> tuple[Calendar, FixedPoint]:
    """Return an entry with its calendar, which after midnight has the next day."""
    if entry.at < DAY:
        return Calendar(days), entry
    until = entry.until - DAY if entry.until is not None else None
    return Calendar(kind), replace(entry, at=entry.at - DAY, until=until)


def _plans(
    person: Person, entries: Mapping[Calendar, Sequence[FixedPoint]]
) -> tuple[FixedPoints, ...]:
    """Return the plans with these entries.

    Entries that overlap by a little, as their medians can, get a chance below 1: the later one
    begins late then.
    """
    found = tuple(FixedPoints(person.name, on, tuple(of)) for on, of in entries.items())
    try:
        check(Routine({person.name: person}, {}, found, (), (), ()))
    except InputError:
        found = tuple(
            replace(
                plan, entries=tuple(replace(e, chance=min(e.chance, ALMOST)) for e in plan.entries)
            )
            for plan in found
        )
    return found


# Routines of one person.


@dataclass(frozen=True)
class _Span:
    """A filler with what it was learnt from.

    Attributes
    ----------
    days : frozenset of int
        The days of the week, from `NEW_DAY` to `NEW_DAY`.
    begins, ends : float
        The times between which it applies, s since the midnight of such a day.
    wanted : mapping
        How many times a day each activity begins then.
    """

    filler: Filler
    days: frozenset[int]
    begins: float
    ends: float
    wanted: Mapping[str, float]


def learn(log: LivedDays, person: Person) -> Routine:
    """Return a routine with the habits of the days of a log, for one person.

    Its activities have no steps of their own: `wait` stands in for them. Raise `InputError` if no
    activity begins in any of the days.
    """
    entries: dict[Calendar, list[FixedPoint]] = defaultdict(list)
    spans = [span for of in _kinds_of_day(log.outer) for span in _spans(log, person, of, entries)]
    plans = _plans(person, entries)
    interruptions = tuple(_interruptions(log, person))
    names = {choice.activity for span in spans for choice in span.filler.choices}
    names |= {rule.activity for rule in interruptions}
    names |= {entry.activity for plan in plans for entry in plan.entries}
    activities = {name: RoutineActivity(name, ("wait 5 s",)) for name in sorted(names)}
    if not activities:
        raise InputError("one activity goes on all the time, so there are no habits to learn")
    person = replace(person, begins=log.rest or min(activities))
    routine = Routine({person.name: person}, activities, plans, (), interruptions, ())
    for number in range(ROUNDS):
        routine = replace(routine, fillers=tuple(span.filler for span in spans))
        drawn = draw(routine, person.name, DRAWN_DAYS, number)
        spans = _corrected(spans, drawn)
    return replace(routine, fillers=tuple(span.filler for span in spans))


def draw(
    routine: Routine, person: str, days: int, seed: int, first: date = FIRST_DRAWN
) -> LivedDays:
    """Return what a person of a routine does on some days, by its plans and fillers."""
    segments = timetable(routine, first, days, seed)
    return lived([one for one in segments if one.person == person], first)


def _kinds_of_day(days: Days) -> tuple[frozenset[int], ...]:
    """Return the kinds of day that have habits of their own: weekdays and weekend, or all days."""
    counts = [len(_on(days, of)) for of in KINDS_OF_DAY]
    return KINDS_OF_DAY if min(counts) >= LEAST_DAYS else (frozenset(range(7)),)


def _on(days: Days, weekdays: Collection[int]) -> Days:
    """Return the days that are on some days of the week."""
    return {day: begun for day, begun in days.items() if day.weekday() in weekdays}


def _spans(
    log: LivedDays, person: Person, kind: frozenset[int], entries: dict[Calendar, list[FixedPoint]]
) -> Iterator[_Span]:
    """Yield the fillers for a kind of day and the evening before, in order of time.

    Add what is done regularly then to the entries of plans.
    """
    before = frozenset((day - 1) % 7 for day in kind)
    for days, is_evening in ((before, True), (kind, False)):
        lived = _on(log.outer, days)
        regulars = _regulars(lived, log.rest)
        for one in regulars:
            if (one.entry.at >= EVENING) == is_evening:
                calendar, entry = _dated(one.entry, kind, days)
                entries[calendar].append(entry)
        habits = _Habits.of(lived, {case for one in regulars for case in one.cases.items()})
        for begins, ends in habits.spans():
            if (begins >= EVENING) != is_evening:
                continue
            choices = tuple(_choices(habits, begins, ends, log.rest))
            if choices:
                # After midnight, the calendar has the next day.
                on = Calendar(days if begins < DAY else kind)
                since, until = begins % DAY, ends % DAY or DAY
                filler = Filler(person.name, on, since, until, choices)
                yield _Span(filler, days, begins, ends, _rates(habits, begins, ends))


def _rates(habits: _Habits, begins: float, ends: float) -> dict[str, float]:
    """Return how many times a day each activity begins between two times."""
    within = (habits.begins >= begins) & (habits.begins < ends)
    return {
        name: float(np.sum(within & (habits.activity == name))) / max(habits.days, 1)
        for name in habits.times
    }


def _corrected(spans: Sequence[_Span], drawn: LivedDays) -> list[_Span]:
    """Return the fillers with weights that bring drawn rates nearer to those of the log."""
    habits = {days: _Habits.of(_on(drawn.outer, days)) for days in {span.days for span in spans}}
    found = []
    for span in spans:
        rates = _rates(habits[span.days], span.begins, span.ends)
        choices = []
        for choice in span.filler.choices:
            name, factor = choice.activity, 1.0
            if name != OTHER:
                # 0.02 so that what is rare is not corrected by chance.
                factor = ((span.wanted[name] + 0.02) / (rates.get(name, 0.0) + 0.02)) ** STEP
            after = {before: weight * factor for before, weight in choice.after.items()}
            choices.append(replace(choice, weight=choice.weight * factor, after=after))
        found.append(replace(span, filler=replace(span.filler, choices=tuple(choices))))
    return found


def _interruptions(log: LivedDays, person: Person) -> Iterator[Interruption]:
    """Yield what interrupts the night's rest."""
    nights = sum(one.activity == log.rest for begun in log.outer.values() for one in begun)
    lasts: dict[str, list[float]] = defaultdict(list)
    for begun in log.interruptions.values():
        for one in begun:
            lasts[one.activity].append(one.lasts)
    for name, of in sorted(lasts.items()):
        median, varies = _duration(np.array(of), np.ones(len(of)))
        yield Interruption(person.name, log.rest, name, len(of) / nights, median, varies)
