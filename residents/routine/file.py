# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a routine from TOML, and report each error with its line."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import date, datetime
from itertools import product
from typing import Any

from ...sensor_logic.logs.error import InputError, explained
from ...sensor_logic.logs.toml_table import (
    TomlTable,
    calendar_date,
    flag,
    number,
    read_table,
    suggestion,
    text,
    texts,
)
from .routine import (
    AWAY,
    DAY,
    SEASONS,
    SHARES,
    WEEKDAYS,
    Absence,
    Calendar,
    Filler,
    FixedPoint,
    FixedPoints,
    Interruption,
    Meanwhile,
    Pastime,
    Person,
    Routine,
    RoutineActivity,
    Spread,
    StepGroup,
    UsualUse,
    seconds,
    time_of_day,
)

# Checks of the whole routine.


def check_bodies(persons: Mapping[str, Person]) -> None:
    """Raise `InputError` if two persons have the same resident as their body."""
    bodies: dict[str, str] = {}
    for person in persons.values():
        other = bodies.setdefault(person.resident, person.name)
        if other != person.name:
            raise InputError(
                f"{person.where}: {person.resident!r} is already the resident of {other!r}; give "
                f"{person.name!r} another resident"
            )


def check(routine: Routine) -> None:
    """Raise `InputError` if the plans give a person two activities at the same time.

    Alternatives and entries with a chance below 1 are not checked: on a day with such an entry, the
    next entry begins late.
    """
    for person in routine.persons:
        plans = [plan for plan in routine.plans if plan.person == person]
        for month, weekday in product(range(1, 13), range(7)):
            entries = sorted(_daily_entries(plans, weekday, month), key=lambda entry: entry.at)
            tomorrow = _daily_entries(plans, (weekday + 1) % 7, month)
            after = [(entry, entry.at) for entry in entries]
            after += [(entry, entry.at + DAY) for entry in tomorrow]
            for place, entry in enumerate(entries):
                for other, at in after[place + 1 :]:
                    if at < _median_end(entry):
                        raise InputError(_overlap_text(person, entry, other, at))


def _daily_entries(plans: list[FixedPoints], weekday: int, month: int) -> list[FixedPoint]:
    """Return the plan entries that happen on every day with this weekday and month."""
    # Plans for some dates only are left out, since they can alternate with others.
    always = [plan for plan in plans if plan.days.first.year == 1 and plan.days.last.year == 9999]
    return [
        entry
        for plan in always
        if weekday in plan.days.weekdays and month in plan.days.months
        for entry in plan.entries
        if entry.chance == 1.0 and not entry.either
    ]


def _median_end(entry: FixedPoint) -> float:
    """Return the time at which a plan entry ends with its median duration, s."""
    if entry.until is not None:
        return entry.until
    return entry.at + (entry.lasts or 0.0)


def _hhmm(seconds: float) -> str:
    """Return a time of day in s as text, such as 07:05."""
    minutes = round(seconds % DAY / 60)
    return f"{minutes // 60:02d}:{minutes % 60:02d}"


def _overlap_text(person: str, entry: FixedPoint, other: FixedPoint, at: float) -> str:
    """Return the error text for `other`, which begins at the time `at` (s) before `entry` ends."""
    lasting = f"{entry.activity!r} from {_hhmm(entry.at)} lasts until {_hhmm(_median_end(entry))}"
    if _median_end(entry) - entry.at > DAY:
        lasting = f"{entry.activity!r} lasts {(_median_end(entry) - entry.at) / 3600:.0f} hours"
    what = f"{other.activity!r}" if other is not entry else "it"
    return (
        f"{other.where}: {person!r} cannot do two things at once: {lasting}, "
        f"and {what} begins {'again ' if other is entry else ''}at {_hhmm(at)}"
    )


SCHEMA = 1
# Default spread of log-normal durations: about a third of the median.
VARIES = 0.3
# Steps that an activity has at most, with all repetitions: hours of them.
MOST_STEPS = 1000
# How often alternatives are drawn; the first is the default.
_DRAWN = ("daily", "each time")
_DAYS: dict[str, Sequence[int]] = {day: [number] for number, day in enumerate(WEEKDAYS)}
_DAYS |= {"daily": range(7), "weekdays": range(5), "weekend": (5, 6)}


def read(content: str, name: str) -> Routine:
    """Return the routine that a TOML text describes; raise `InputError` for errors.

    `name` is the file's name, used in errors.
    """
    top = read_table(content, name)
    if top.take("schema", number(0, 1e6)) != SCHEMA:
        raise top.error(f"this version of Ängen Sensors reads only schema = {SCHEMA}", "schema")
    activities = {key: _activity(key, table) for key, table in top.named("activity")}
    if AWAY in activities:
        raise top.error(
            f"{AWAY!r} is the activity of people who are out; give this activity another name"
        )
    known = {*activities, AWAY}
    persons = {key: _person(key, table, known) for key, table in top.named("person")}
    if not persons:
        raise top.error("the routine has no person: add a table [person.NAME]")
    check_bodies(persons)
    found = Routine(
        persons,
        activities,
        tuple(_plan(table, persons, known) for table in top.tables("plan")),
        tuple(_filler(table, persons, known) for table in top.tables("filler")),
        tuple(_interruption(table, persons, known) for table in top.tables("interruption")),
        tuple(_absence(table, persons) for table in top.tables("absence")),
        {name: _use(table) for name, table in top.named("uses")},
    )
    top.finish()
    check(found)
    return found


def _activity(name: str, table: TomlTable) -> RoutineActivity:
    meanwhile = []
    for row in table.tables("while"):
        varies = row.take("varies", number(0, 3), VARIES)
        every = row.take("every", _positive)
        burst = row.take("burst", number(1, 1000), None)
        among = row.take("do", _one_or_more)
        where = (row.where("do"),) * len(among)
        meanwhile.append(Meanwhile(among, every, varies, burst, where))
        row.finish()
    labels = {}
    for vocabulary, label in table.take("labels", dict, {}).items():
        labels[vocabulary] = text(label)
    do, where, _ = _steps(table, "do")
    if not do:
        raise table.error("an activity must have at least one step", "do")
    if (steps := _most_steps(do)) > MOST_STEPS:
        raise table.error(
            f"{name!r} has up to {steps:,} steps, and {MOST_STEPS:,} are the most: give groups "
            "within each other smaller 'times'",
            "do",
        )
    table.finish()
    return RoutineActivity(
        name, do, tuple(meanwhile), labels, where, usual_rest="while" not in table.values
    )


def _most_steps(do: tuple[str | StepGroup, ...], among: bool = False) -> int:
    """Return how many of the steps are done at most; if `among` is True, one of them is."""
    counts = [
        one.times[1] * _most_steps(one.do, bool(one.weights)) if isinstance(one, StepGroup) else 1
        for one in do
    ]
    return max(counts, default=0) if among else sum(counts)


def _steps(
    table: TomlTable, key: str, within: bool = False
) -> tuple[tuple[str | StepGroup, ...], tuple[str, ...], tuple[float, ...]]:
    """Return the steps or alternatives at `key`, their positions, and the weights of alternatives.

    `within` is whether a group around them says in which part of the activity they are done.
    """
    values = table.take(key, _list_or_one)
    steps: list[str | StepGroup] = []
    weights = []
    for place, value in enumerate(values):
        weight = 1.0
        if isinstance(value, Mapping):
            row = table.below(value, key, place)
            if key == "either":
                weight = row.take("weight", number(0, 1e6), 1.0)
            steps.append(_group(row, within))
        else:
            with explained(f"{table.where(key, place)}: {key}", ValueError):
                steps.append(text(value))
        weights.append(weight)
    where = tuple(table.where(key, place) for place in range(len(values)))
    return tuple(steps), where, tuple(weights)


def _group(table: TomlTable, within: bool) -> StepGroup:
    if ("do" in table.values) == ("either" in table.values):
        raise table.error("give 'do', with steps, or 'either', with alternatives, and not both")
    share = table.take("during", _share, None)
    if share is not None and within:
        raise table.error("the steps around this one say 'during' already: leave it out", "during")
    among, daily, any_order = "either" in table.values, True, False
    do, where, weights = _steps(table, "either" if among else "do", within or share is not None)
    if among:
        daily = table.one_of("drawn", _DRAWN, _DRAWN[0]) == _DRAWN[0]
        if len(do) < 2 or sum(weights) <= 0:
            raise table.error("give two alternatives or more, one with a weight above 0", "either")
    else:
        any_order = table.take("any_order", flag, False)
        if not do:
            raise table.error("give at least one step", "do")
    chance = table.take("chance", number(0, 1), 1.0)
    times, varies = table.take("times", _times, (1, 1)), table.take("varies", _spread, None)
    table.finish()
    return StepGroup(
        do, where, weights if among else (), daily, chance, times, any_order, varies, share
    )


def _use(table: TomlTable) -> UsualUse:
    lasts, varies = table.take("lasts", _positive, None), table.take("varies", _spread, None)
    if not {"lasts", "varies"}.intersection(table.values):
        raise table.error("give 'lasts', 'varies' or both")
    table.finish()
    return UsualUse(lasts, varies, table.where())


def _person(name: str, table: TomlTable, activities: set[str]) -> Person:
    visitor = table.take("visitor", flag, False)
    resident = table.take("resident", text, name)
    if not visitor and "begins" not in table.values:
        raise table.error(
            "'begins' is missing: give the activity of the person at the first midnight"
        )
    begins = table.one_of("begins", activities, AWAY)
    table.finish()
    return Person(name, resident, visitor, begins, table.where("resident"))


def _days(table: TomlTable) -> Calendar:
    weekdays = table.take("on", _names_reader(_DAYS, "day"), frozenset(range(7)))
    months = table.take("season", _names_reader(SEASONS, "season"), frozenset(range(1, 13)))
    first, last = (
        table.take("from", calendar_date, date.min),
        table.take("to", calendar_date, date.max),
    )
    if last < first:
        raise table.error("'to' is before 'from'", "to")
    return Calendar(weekdays, months, first, last)


def _plan(table: TomlTable, persons: Any, activities: set[str]) -> FixedPoints:
    person = table.one_of("person", persons)
    days = _days(table)
    entries: list[FixedPoint] = []
    for place, row in enumerate(table.tables("entries")):
        if "either" in row.values:
            entries += _alternatives(row, f"either {place}", activities)
        else:
            entries.append(_entry(row, activities))
    table.finish()
    return FixedPoints(person, days, tuple(entries))


def _entry(row: TomlTable, activities: set[str]) -> FixedPoint:
    at = row.take("at", time_of_day)
    lasts, until = _lasts_or_until(row)
    if until is not None and until <= at:
        until += DAY
    found = FixedPoint(
        row.one_of("activity", activities),
        at,
        row.take("spread", _spreads, (0.0, 0.0)),
        lasts,
        until,
        row.take("varies", _spread, (VARIES, VARIES)),
        row.take("chance", number(0, 1), 1.0),
        row.where(),
    )
    row.finish()
    return found


def _alternatives(table: TomlTable, name: str, activities: set[str]) -> Iterator[FixedPoint]:
    """Yield the entries of which one happens on a day; `name` is that of these alternatives."""
    chance = table.take("chance", number(0, 1), 1.0)
    rows = list(table.tables("either"))
    weights = [row.take("weight", number(0, 1e6), 1.0) for row in rows]
    if len(rows) < 2 or sum(weights) <= 0:
        raise table.error("give two alternatives or more, one with a weight above 0", "either")
    begins = 0.0
    for row, weight in zip(rows, weights, strict=True):
        share = chance * weight / sum(weights)
        yield replace(_entry(row, activities), either=name, share=(begins, begins + share))
        begins += share
    table.finish()


def _regular(row: TomlTable) -> tuple[tuple[float, float], float]:
    """Return how often a choice is usual, and how much its weight depends on it."""
    if ("usual" in row.values) != ("regular" in row.values):
        raise row.error("give both 'usual' and 'regular', or neither")
    return row.take("usual", _usual, (0.0, 0.0)), row.take("regular", number(0, 100), 0.0)


def _lasts_or_until(row: TomlTable) -> tuple[float | None, float | None]:
    """Return the duration of an entry or choice, or the time of day at which it ends."""
    lasts = row.take("lasts", _positive, None)
    until = row.take("until", time_of_day, None)
    if (until is None) == (lasts is None):
        raise row.error("give either 'lasts' or 'until', and not both")
    return lasts, until


def _filler(table: TomlTable, persons: Any, activities: set[str]) -> Filler:
    person, days = table.one_of("person", persons), _days(table)
    begins, ends = table.take("between", _between)
    choices = []
    for name, row in table.named("choose"):
        if name not in activities:
            raise row.error(f"the activity {name!r} is unknown; {suggestion(name, activities)}")
        lasts, until = _lasts_or_until(row)
        choices.append(
            Pastime(
                name,
                row.take("weight", number(0, 1e6)),
                lasts,
                row.take("varies", _spread, (VARIES, VARIES)),
                until,
                row.take("spread", seconds, 0.0),
                _after(row, activities),
                *_regular(row),
            )
        )
        row.finish()
    if sum(choice.weight for choice in choices) <= 0:
        raise table.error("no activity can be chosen: give at least one a weight above 0")
    table.finish()
    return Filler(person, days, begins, ends, tuple(choices))


def _after(row: TomlTable, activities: set[str]) -> dict[str, float]:
    """Return the weights of a filler's choice after each of some activities."""
    found: dict[str, float] = {}
    weights = row.below(row.take("after", dict, {}), "after")
    for name in weights.values:
        if name not in activities:
            raise weights.error(
                f"the activity {name!r} is unknown; {suggestion(name, activities)}", name
            )
        found[name] = weights.take(name, number(0, 1e6))
    return found


def _interruption(table: TomlTable, persons: Any, activities: set[str]) -> Interruption:
    found = Interruption(
        table.one_of("person", persons),
        table.one_of("during", activities),
        table.one_of("activity", activities),
        table.take("times", number(0, 100)),
        table.take("lasts", _positive),
        table.take("varies", _spread, (VARIES, VARIES)),
    )
    table.finish()
    return found


def _absence(table: TomlTable, persons: Any) -> Absence:
    person = table.one_of("person", persons)
    begins, ends = table.take("from", _moment), table.take("to", _moment)
    if ends <= begins:
        raise table.error("'to' must be after 'from'", "to")
    table.finish()
    return Absence(person, begins, ends)


def _list_or_one(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _one_or_more(value: Any) -> tuple[str, ...]:
    found = (value,) if isinstance(value, str) else texts(value)
    if not found:
        raise ValueError("it must have at least one activity")
    return found


def _positive(value: Any) -> float:
    found = seconds(value)
    if not 0 < found <= 30 * DAY:
        raise ValueError(f"{value!r} must be above 0 and at most 30 days")
    return found


def _spreads(value: Any) -> tuple[float, float]:
    """Read the spread of a start and an end: a duration for both, or one for each."""
    if not isinstance(value, list):
        return seconds(value), seconds(value)
    if len(value) != 2:
        raise ValueError('give one duration, or two for start and end, such as ["5 min", "20 min"]')
    return seconds(value[0]), seconds(value[1])


def _spread(value: Any) -> Spread:
    """Read the spread of a duration: a number, or one below and one above the median."""
    if not isinstance(value, list):
        return (number(0, 3)(value),) * 2
    if len(value) != 2:
        raise ValueError(f"{value!r} is not two numbers: below and above the median")
    below, above = (number(0, 3)(one) for one in value)
    return below, above


def _share(value: Any) -> tuple[float, float]:
    """Read a part of an activity: its name, or two numbers from 0 to 1."""
    if isinstance(value, str):
        if value not in SHARES:
            raise ValueError(f"{value!r} is no part of an activity; {suggestion(value, SHARES)}")
        return SHARES[value]
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f'{value!r} is neither two numbers nor a part, such as "first third"')
    begins, ends = (number(0, 1)(one) for one in value)
    if ends < begins:
        raise ValueError(f"{value!r}: the second number is smaller than the first")
    return begins, ends


def _times(value: Any) -> tuple[int, int]:
    """Read how often steps are repeated: a whole number, or the least and the largest one."""
    least, largest = value if isinstance(value, list) and len(value) == 2 else (value, value)
    for one in (least, largest):
        if isinstance(one, bool) or not isinstance(one, int) or not 0 <= one <= 100:
            raise ValueError(f"{value!r} is not a whole number from 0 to 100, nor two of them")
    if largest < least:
        raise ValueError(f"{value!r}: the second number is smaller than the first")
    return least, largest


def _usual(value: Any) -> tuple[float, float]:
    """Read how often an activity has usually begun when a filler begins, and when it ends."""
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"{value!r} is not two numbers: when the filler begins, and when it ends")
    before, later = (number(0, 1000)(one) for one in value)
    if later < before:
        raise ValueError(f"{value!r}: the second number is smaller than the first")
    return before, later


def _names_reader(known: Mapping[str, Sequence[int]], what: str) -> Callable[[Any], frozenset[int]]:
    """Return a function that reads one or several names of days or months.

    `known` has the numbers for each name. `what` says in errors what is named.
    """

    def read_names(value: Any) -> frozenset[int]:
        names = [value] if isinstance(value, str) else texts(value)
        for name in names:
            if name not in known:
                raise ValueError(f"{name!r} is not a {what}; {suggestion(name, known)}")
        return frozenset(number for name in names for number in known[name])

    return read_names


def _between(value: Any) -> tuple[float, float]:
    times = [time_of_day(part) for part in texts(value)]
    if len(times) != 2 or times[0] == times[1]:
        raise ValueError(f'{value!r} is not two times of day, such as ["07:00", "23:00"]')
    begins, ends = times
    return begins, ends if ends > begins else ends + DAY


def _moment(value: Any) -> datetime:
    if not isinstance(value, datetime) or value.tzinfo is not None:
        raise ValueError(f"{value!r} is not a local date and time, such as 2026-03-02T08:00:00")
    return value
