# SPDX-License-Identifier: GPL-3.0-or-later
"""Routines from a file: who does what from when to when."""

import re
from collections import defaultdict
from dataclasses import replace
from datetime import date, timedelta
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from angen_sensors.residents.routine import file
from angen_sensors.residents.routine import timetable as diary
from angen_sensors.residents.routine.routine import AWAY, DAY, Segment
from angen_sensors.residents.routine.timetable import timetable
from angen_sensors.sensor_logic.error import InputError

TEXT = Path(__file__).with_name("week.toml").read_text(encoding="utf-8")
MONDAY = date(2026, 3, 2)
HOUR = 3600.0


def drawn(text: str = TEXT, days: int = 7, seed: int = 1, first: date = MONDAY) -> list[Segment]:
    return timetable(file.read(text, "week.toml"), first, days, seed)


def by_person(segments: list[Segment]) -> dict[str, list[Segment]]:
    found: dict[str, list[Segment]] = defaultdict(list)
    for segment in segments:
        found[segment.person].append(segment)
    return found


@pytest.mark.parametrize("seed", range(5))
def test_everybody_is_somewhere_at_every_moment_and_never_twice(seed: int) -> None:
    for segments in by_person(drawn(days=365, seed=seed)).values():
        assert segments[0].start <= 0.0 < segments[0].end and segments[-1].end == 365 * DAY
        for before, after in pairwise(segments):
            assert before.end == after.start and before.activity != after.activity
        assert min(segment.end - segment.start for segment in segments) > 0


def test_days_follow_the_plan() -> None:
    anna, nurse = (by_person(drawn(days=364))[name] for name in ("anna", "nurse"))
    # In the morning, and not back in bed after an interruption.
    up = np.array(
        [
            s.end % DAY
            for s, _, later in zip(anna, anna[1:], anna[2:], strict=False)
            if s.activity == "Sleep" != later.activity and 5 * HOUR < s.end % DAY < 10 * HOUR
        ]
    )
    assert len(up) > 350
    # Five nights end at 07:00, two at 07:10.
    assert abs(np.mean(up) - 7 * HOUR - 171) < 300
    assert 0.8 * 1500 < np.std(up) < 1.5 * 1800
    visits = [s for s in nurse if s.activity == "Visit"]
    assert len(visits) == 104
    assert {int(s.start // DAY) % 7 for s in visits} == {0, 3}
    lasting = np.array([s.end - s.start for s in visits])
    assert abs(np.median(lasting) - 1800) < 150
    assert abs(np.std(np.log(lasting)) - 0.3) < 0.07
    assert {s.activity for s in nurse} == {"Visit", AWAY}


def test_nights_are_interrupted_as_often_as_the_file_says() -> None:
    anna = by_person(drawn(days=400, seed=3))["anna"]
    triples = zip(anna, anna[1:], anna[2:], strict=False)
    count = sum(
        (a.activity, b.activity, c.activity) == ("Sleep", "Toilet", "Sleep") for a, b, c in triples
    )
    # One night in 400 is the absence; too near to each other or to the ends they do not happen.
    assert 1.2 < count / 400 < 1.6


def test_who_is_absent_is_away_all_the_time() -> None:
    begins, ends = 12 * DAY + 10 * HOUR, 13 * DAY + 18 * HOUR
    inside = [s for s in drawn(days=14) if s.person == "anna" and s.end > begins and s.start < ends]
    assert [s.activity for s in inside] == [AWAY]


def test_another_person_day_or_length_of_the_run_changes_nothing_else() -> None:
    week = by_person(drawn())["anna"]
    alone = TEXT.replace('on = ["mon", "thu"]', 'on = ["tue"]')
    assert by_person(drawn(alone))["anna"] == week
    longer = by_person(drawn(days=9))["anna"]
    assert longer[: len(week) - 1] == week[:-1]
    # Thursday's night is another one: what was drawn before it, and a day later, stays.
    other = TEXT.replace('on = "weekdays"', 'on = ["mon", "tue", "wed", "fri"]')
    changed = by_person(drawn(other))["anna"]
    before = [s for s in week if s.end < 3 * DAY]
    assert changed[: len(before)] == before
    after = [s for s in week if s.start > 4.5 * DAY]
    assert after and changed[-len(after) :] == after
    assert drawn(seed=2) != drawn(seed=1)


def test_a_date_is_drawn_the_same_whichever_day_the_run_begins_with() -> None:
    def told(segments: list[Segment], shift: int) -> list[tuple[float, float, str]]:
        """From the Wednesday's noon to Saturday, in s since Monday."""
        moved = [(s.start + shift * DAY, s.end + shift * DAY, s.activity) for s in segments]
        inside = [m for m in moved if m[0] > 2.5 * DAY and m[1] < 5 * DAY]
        return [(round(begin, 3), round(end, 3), activity) for begin, end, activity in inside]

    week = by_person(drawn())["anna"]
    assert len(told(week, 0)) > 20
    for day in (-7, 1, 2):
        own = by_person(drawn(first=MONDAY + timedelta(day), days=7 - day))["anna"]
        assert told(own, day) == told(week, 0), day
    # Another Monday is not the same one again.
    before = by_person(drawn(first=MONDAY - timedelta(7)))["anna"]
    assert told(before, 0) != told(week, 0)


def test_the_order_of_a_late_day_is_kept() -> None:
    text = TEXT.replace('lasts = "25 min" }', 'lasts = "45 min", varies = 1.5 }')
    for segments in by_person(drawn(text, days=60)).values():
        for before, after in pairwise(segments):
            assert before.end == after.start


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("schema = 1", "schema = 2", "this version reads schema = 1"),
        ("schema = 1", "schema = 1\nseed = 3 #", "'seed' means nothing here"),
        (
            'begins = "Sleep"',
            'begins = "Slep"',
            "begins: 'Slep' is not known; did you mean 'Sleep'?",
        ),
        ("[person.anna]\nbegins", "[person.anna]\n#", "'begins' is missing"),
        ('every = "25 min"', 'every = "25 mins"', "every: '25 mins' is no duration"),
        ('at = "18:00"', 'at = "18:60"', "at: '18:60' is no time of day"),
        ('activity = "Visit", lasts', 'activity = "Vist", lasts', "activity: 'Vist' is not known"),
        ("chance = 0.9", "chance = 1.9", "chance: 1.9 is no number from 0 to 1"),
        ('"40 min"', '"40 min", until = "19:00"', "an entry has either 'lasts' or 'until'"),
        ('on = "weekend"', 'on = "weekends"', "on: 'weekends' is no day; did you mean 'weekend'?"),
        ("{ weight = 6", "{ wight = 6", "'weight' is missing"),
        ("times = 1.5", "times = -1", "times: -1 is no number"),
        ("to = 2026-03-15", "to = 2026-03-13", "'to' is not after 'from'"),
        (
            'at = "18:00", spread = "20 min", activity = "Meal", lasts = "40 min"',
            'at = "18:00", activity = "Meal", lasts = "30 h"',
            "'anna' cannot do two things at once: 'Meal' lasts 30 hours",
        ),
        (
            'at = "18:00"',
            'at = "07:30"',
            "'Meal' from 07:20 lasts until 07:45, and 'Meal' begins at 07:30",
        ),
    ],
)
def test_what_is_wrong_is_told_with_its_line(old: str, new: str, told: str) -> None:
    assert TEXT.count(old) == 1
    text = TEXT.replace(old, new)
    with pytest.raises(InputError) as caught:
        file.read(text, "week.toml")
    line = int(re.match(r"week\.toml, line (\d+): ", str(caught.value)).group(1))
    near = text[: text.index(new)].count("\n") + 1
    assert told in str(caught.value)
    # What is missing is told at its table; of two that collide, either may be named.
    assert near <= line <= near + new.count("\n") or ("lasts" in told and abs(line - near) <= 5)


def test_files_that_are_no_routine() -> None:
    for text, told in (
        ("schema = 1", "line 1: there is nobody"),
        ("schema = 1\n[person.a\n", "line 2: Expected ']'"),
        ("schema = 1\nperson = [\n\n", "line 4: Invalid value"),
    ):
        with pytest.raises(InputError, match=rf"^week\.toml, {re.escape(told)}"):
            file.read(text, "week.toml")


@pytest.mark.parametrize(
    ("anna", "nurse", "line"),
    [("Olle", "Olle", 8), ("nurse", "", 7), ("", "anna", 7), ("Olle", "", 0), ("bo", "anna", 0)],
)
def test_two_persons_have_two_bodies(anna: str, nurse: str, line: int) -> None:
    """Without a `resident`, a person's name is that of the body."""
    text = TEXT
    for name, body in (("anna", anna), ("nurse", nurse)):
        if body:
            text = text.replace(f"[person.{name}]", f'[person.{name}]\nresident = "{body}"')
    if not line:
        assert len({p.resident for p in file.read(text, "week.toml").persons.values()}) == 2
        return
    with pytest.raises(InputError) as caught:
        file.read(text, "week.toml")
    body = anna or nurse
    assert str(caught.value) == (
        f"week.toml, line {line}: '{body}' is the body of 'anna' already; give 'nurse' another "
        "resident"
    )


ROWS = """start,end,person,activity
2026-03-02 07:00,2026-03-02 07:10,anna,Toilet
2026-03-02T07:10:30.5,2026-03-02T07:40:00,anna,Meal
2026-03-02T09:00:00,2026-03-03T01:00:00,bo,Sleep
"""


def test_a_diary_is_taken_as_it_stands() -> None:
    first, segments = diary.read(ROWS, "diary.csv")
    assert first == MONDAY
    assert segments == [
        Segment(0.0, 25200.0, "anna", "Other"),
        Segment(25200.0, 25800.0, "anna", "Toilet"),
        Segment(25800.0, 25830.5, "anna", "Other"),
        Segment(25830.5, 27600.0, "anna", "Meal"),
        Segment(0.0, 32400.0, "bo", "Other"),
        Segment(32400.0, 90000.0, "bo", "Sleep"),
    ]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("person,", "who,", "line 1: the column 'person' is missing"),
        ("07:10:30.5", "07:09:00", "line 3: 'anna' cannot do two things at once: 'Toilet'"),
        ("07:40:00", "07:10:00", "line 3: the end is not after the start"),
        ("2026-03-02 07:00", "Monday", "line 2: Invalid isoformat string: 'Monday'"),
        (",bo,", ",,", "line 4: person and activity must be named"),
    ],
)
def test_a_diary_that_cannot_be_is_told_with_its_line(old: str, new: str, told: str) -> None:
    with pytest.raises(InputError, match=r"^diary\.csv, ") as caught:
        diary.read(ROWS.replace(old, new), "diary.csv")
    assert told in str(caught.value)


def test_a_routine_without_fillers_goes_on_with_what_was_done() -> None:
    routine = replace(file.read(TEXT, "week.toml"), fillers=(), interruptions=())
    anna = by_person(timetable(routine, MONDAY, 1, 1))["anna"]
    assert {s.activity for s in anna} <= {"Sleep", "Meal", AWAY}
