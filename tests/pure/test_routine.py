# SPDX-License-Identifier: GPL-3.0-or-later
"""Routines from a file, and days without Blender: activities, the sun, splits and tables."""

from __future__ import annotations

import csv
import io
import math
import re
import tomllib
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from datetime import date, datetime, timedelta
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from angen_sensors.residents.acting.timeline import AWAY as GONE
from angen_sensors.residents.acting.timeline import SITTING, WALKING, Acted, ActedActivity, Stay
from angen_sensors.residents.days.rows import (
    DAY_US,
    Day,
    DayRows,
    GrowingEvents,
    attribute_events,
    stretches,
    toml,
)
from angen_sensors.residents.days.sun import Site, direction, position, skylight, sunlight
from angen_sensors.residents.days.truth import Whereabouts, activities, people
from angen_sensors.residents.routine import file
from angen_sensors.residents.routine import timetable as diary
from angen_sensors.residents.routine.routine import AWAY, DAY, Segment
from angen_sensors.residents.routine.timetable import timetable
from angen_sensors.sensor_logic.logs.error import InputError
from angen_sensors.sensor_logic.logs.formats.log import LoggedActivity
from angen_sensors.sensor_logic.logs.log import Event
from angen_sensors.sensor_logic.recording.validity import NotValid, often_not_valid

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


LATE = TEXT.replace('lasts = "25 min" }', 'lasts = "45 min", varies = 1.5 }')


@pytest.mark.parametrize(("text", "seed"), [*((TEXT, seed) for seed in range(5)), (LATE, 1)])
def test_everybody_is_somewhere_at_every_moment_and_never_twice(text: str, seed: int) -> None:
    for segments in by_person(drawn(text, days=365, seed=seed)).values():
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


def test_nights_are_interrupted_as_often_as_the_file_says_and_who_is_absent_is_away() -> None:
    anna = by_person(drawn(days=400, seed=3))["anna"]
    triples = zip(anna, anna[1:], anna[2:], strict=False)
    count = sum(
        (a.activity, b.activity, c.activity) == ("Sleep", "Toilet", "Sleep") for a, b, c in triples
    )
    # One night in 400 is the absence; interruptions too near to each other or to the ends are
    # dropped.
    assert 1.2 < count / 400 < 1.6
    begins, ends = 12 * DAY + 10 * HOUR, 13 * DAY + 18 * HOUR
    assert [s.activity for s in anna if s.end > begins and s.start < ends] == [AWAY]


def test_another_person_day_or_length_of_the_run_changes_nothing_else() -> None:
    week = by_person(drawn())["anna"]
    alone = TEXT.replace('on = ["mon", "thu"]', 'on = ["tue"]')
    assert by_person(drawn(alone))["anna"] == week
    longer = by_person(drawn(days=9))["anna"]
    assert longer[: len(week) - 1] == week[:-1]
    # Thursday's night differs: the draws before it, and a day later, stay the same.
    other = TEXT.replace('on = "weekdays"', 'on = ["mon", "tue", "wed", "fri"]')
    changed = by_person(drawn(other))["anna"]
    before = [s for s in week if s.end < 3 * DAY]
    assert changed[: len(before)] == before
    after = [s for s in week if s.start > 4.5 * DAY]
    assert after and changed[-len(after) :] == after
    assert drawn(seed=2) != drawn(seed=1)


def test_a_date_is_drawn_the_same_whichever_day_the_run_begins_with() -> None:
    def told(segments: list[Segment], shift: int) -> list[tuple[float, float, str]]:
        """Return the activities from Wednesday noon to Saturday, in s since Monday."""
        moved = [(s.start + shift * DAY, s.end + shift * DAY, s.activity) for s in segments]
        inside = [m for m in moved if m[0] > 2.5 * DAY and m[1] < 5 * DAY]
        return [(round(begin, 3), round(end, 3), activity) for begin, end, activity in inside]

    week = by_person(drawn())["anna"]
    assert len(told(week, 0)) > 20
    for day in (-7, 1, 2):
        own = by_person(drawn(first=MONDAY + timedelta(day), days=7 - day))["anna"]
        assert told(own, day) == told(week, 0), day
    # Another Monday differs.
    before = by_person(drawn(first=MONDAY - timedelta(7)))["anna"]
    assert told(before, 0) != told(week, 0)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("schema = 1", "schema = 2", "this version of Ängen Sensors reads only schema = 1"),
        ("schema = 1", "schema = 1\nseed = 3 #", "the key 'seed' is unknown here"),
        (
            'begins = "Sleep"',
            'begins = "Slep"',
            "begins: 'Slep' is unknown; did you mean 'Sleep'?",
        ),
        ("[person.anna]\nbegins", "[person.anna]\n#", "'begins' is missing"),
        ('every = "25 min"', 'every = "25 mins"', "every: '25 mins' is not a duration"),
        ('at = "18:00"', 'at = "18:60"', "at: '18:60' is not a time of day"),
        ('activity = "Visit", lasts', 'activity = "Vist", lasts', "activity: 'Vist' is unknown"),
        ("chance = 0.9", "chance = 1.9", "chance: 1.9 is not a number from 0 to 1"),
        (
            '"40 min"',
            '"40 min", until = "19:00"',
            "give either 'lasts' or 'until', and not both",
        ),
        (
            'on = "weekend"',
            'on = "weekends"',
            "on: 'weekends' is not a day; did you mean 'weekend'?",
        ),
        ("{ weight = 6", "{ wight = 6", "'weight' is missing"),
        ("times = 1.5", "times = -1", "times: -1 is not a number"),
        ("to = 2026-03-15", "to = 2026-03-13", "'to' must be after 'from'"),
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
    # A missing key is reported at its table; of two that collide, either may be named.
    assert near <= line <= near + new.count("\n") or ("lasts" in told and abs(line - near) <= 5)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("schema = 1", "line 1: the routine has no person"),
        ("schema = 1\n[person.a\n", "line 2: Expected ']'"),
    ],
)
def test_files_that_are_no_routine(text: str, told: str) -> None:
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
        f"week.toml, line {line}: '{body}' is already the resident of 'anna'; give 'nurse' another "
        "resident"
    )


ROWS = """start,end,person,activity
2026-03-02 07:00,2026-03-02 07:10,anna,Toilet
2026-03-02T07:10:30.5,2026-03-02T07:40:00,anna,Meal
2026-03-02T09:00:00,2026-03-03T01:00:00,bo,Sleep
"""


def test_a_diary_that_excel_in_german_has_saved_is_the_same() -> None:
    assert diary.read(ROWS.replace(",", ";"), "diary.csv") == diary.read(ROWS, "diary.csv")


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
        ("07:40:00", "07:10:00", "line 3: the end must be after the start"),
        ("2026-03-02 07:00", "Monday", "line 2: Invalid isoformat string: 'Monday'"),
        (",bo,", ",,", "line 4: give a person and an activity"),
    ],
)
def test_a_diary_that_cannot_be_is_told_with_its_line(old: str, new: str, told: str) -> None:
    with pytest.raises(InputError, match=r"^diary\.csv, ") as caught:
        diary.read(ROWS.replace(old, new), "diary.csv")
    assert told in str(caught.value)


def test_an_end_by_the_clock_can_spread_otherwise_than_the_start() -> None:
    entry = '{ at = "23:05", spread = ["1 min", "40 min"], activity = "Sleep", until = "07:00" }'
    text = f"""
schema = 1
[person.anna]
begins = "Sleep"
[activity]
Sleep = {{ do = ["wait 5 s"] }}
Idle = {{ do = ["wait 5 s"] }}
[[plan]]
person = "anna"
entries = [{entry}]
[[filler]]
person = "anna"
between = ["00:00", "24:00"]
choose = {{ Idle = {{ weight = 1, lasts = "20 h" }} }}
"""
    nights = [
        s for s in timetable(file.read(text, "f.toml"), MONDAY, 60, 1) if s.activity == "Sleep"
    ]
    begins, ends = (
        np.array([getattr(s, of) % DAY for s in nights[1:-1]]) for of in ("start", "end")
    )
    assert begins.std() == pytest.approx(60.0, rel=0.3)
    assert ends.std() == pytest.approx(2400.0, rel=0.3)
    for wrong in ('["1 min"]', '["1 min", 5]'):
        with pytest.raises(InputError, match=r"f\.toml, line 10: spread: "):
            file.read(text.replace('["1 min", "40 min"]', wrong), "f.toml")


def left_out(rows: str, start: date, days: int, persons: Sequence[str] = ("anna",)) -> list[str]:
    first, segments = diary.read(f"start,end,person,activity\n{rows}", "d.csv")
    return diary.check_covers(segments, first, persons, start, days, "d.csv")


NIGHT = "2026-03-02 00:00,2026-03-03 06:30,anna,Sleep\n"


def test_a_diary_without_the_first_day_is_refused_with_its_days() -> None:
    for start in (MONDAY - timedelta(1), MONDAY + timedelta(2)):
        with pytest.raises(InputError) as caught:
            left_out(NIGHT, start, 7)
        assert str(caught.value) == (
            f"d.csv says nothing of {start}: begin on one of its days, 2026-03-02 to 2026-03-03"
        )


def test_a_diary_of_others_is_refused_with_their_names() -> None:
    with pytest.raises(InputError, match=r"^d\.csv is of 'anna', and the routine has only 'bo':"):
        left_out(NIGHT, MONDAY, 1, ["bo"])


def test_long_gaps_of_a_diary_are_told_with_whom_and_when() -> None:
    assert left_out(NIGHT, MONDAY, 1) == []
    [gap] = left_out(NIGHT, MONDAY, 3)
    assert gap == (
        "d.csv says nothing of 'anna' from 2026-03-03 06:30 to 2026-03-05 00:00: 'Other' is done "
        "then"
    )
    # Gaps within a day, and a person of whom it has nothing.
    rows = NIGHT + "2026-03-03 11:00,2026-03-04 00:00,anna,Meal\n"
    inner, other = left_out(rows, MONDAY, 2, ["anna", "bo"])
    assert "'anna' from 2026-03-03 06:30 to 2026-03-03 11:00:" in inner
    assert "'bo' from 2026-03-02 00:00 to 2026-03-04 00:00:" in other
    assert left_out(rows.replace("11:00", "10:00"), MONDAY, 2) == []
    [stranger] = left_out(NIGHT + NIGHT.replace("anna", "eve"), MONDAY, 1)
    assert stranger == "d.csv: the routine has no 'eve', whose rows are left out"


def test_a_routine_without_fillers_goes_on_with_what_was_done() -> None:
    routine = replace(file.read(TEXT, "week.toml"), fillers=(), interruptions=())
    anna = by_person(timetable(routine, MONDAY, 1, 1))["anna"]
    assert {s.activity for s in anna} <= {"Sleep", "Meal", AWAY}


def test_an_entry_after_midnight_that_is_drawn_to_the_evening_before_ends_what_fills() -> None:
    text = """schema = 1
[person.anna]
begins = "Sleeping"
[activity.Sleeping]
do = "wait 1 s"
[activity.Reading]
do = "wait 1 s"
[activity.Tea]
do = "wait 1 s"
[[plan]]
person = "anna"
entries = [{ at = "00:10", spread = "40 min", activity = "Sleeping", until = "08:00" }]
[[filler]]
person = "anna"
between = ["06:00", "23:59"]
[filler.choose]
Reading = { weight = 1, lasts = "50 min", after = { Reading = 0 } }
Tea = { weight = 1, lasts = "10 min", after = { Tea = 0 } }
"""
    nights = [s for s in drawn(text, days=14) if s.activity == "Sleeping"]
    before = [s for s in nights if (s.start - DAY / 2) % DAY < DAY / 2]
    assert len(nights) >= 14 and 3 < len(before) < 11


# Days

D = math.radians


@pytest.mark.parametrize(
    ("site", "when", "altitude", "azimuth"),
    [
        # Reda and Andreas, NREL/TP-560-34302, appendix A.5: zenith 50.11162°, azimuth 194.34024°.
        (Site(D(39.742476), D(-105.1786), -7), "2003-10-17T12:30:30", 39.88838, 194.34024),
        # Meeus, Astronomical Algorithms, example 25.a: declination -7.78507° and ascension
        # 198.38083° on 1992-10-13, 0 h; seen from the pole its altitude is the declination.
        (Site(D(89.9999), 0.0), "1992-10-13T00:00", -7.78507, None),
        # The northern solstice of 2024 was on June 20 at 20:51 UTC, at 23.438° of declination.
        (Site(D(89.9999), 0.0), "2024-06-20T20:51", 23.438 + 0.038, None),
        # At the equinox of 2024, March 20 at 03:06 UTC, it was on the equator: on the horizon
        # there, lifted by half a degree.
        (Site(D(89.9999), 0.0), "2024-03-20T03:06", 0.483, None),
    ],
)
def test_the_sun_stands_where_almanacs_say(
    site: Site, when: str, altitude: float, azimuth: float | None
) -> None:
    found = position(site, datetime.fromisoformat(when))
    assert math.degrees(found[0]) == pytest.approx(altitude, abs=0.015)
    if azimuth is not None:
        assert math.degrees(found[1]) == pytest.approx(azimuth, abs=0.015)


def test_it_rises_and_sets_at_published_times() -> None:
    # Stockholm, 2026-06-21, timeanddate.com and the almanac: 03:31 and 22:08 by summer time.
    site, midnight = Site(D(59.33), D(18.07), 2.0), datetime(2026, 6, 21)
    up = [m for m in range(1440) if sunlight(position(site, midnight + timedelta(minutes=m))[0])]
    assert up[0] == pytest.approx(3 * 60 + 31, abs=2)
    assert up[-1] == pytest.approx(22 * 60 + 8, abs=2)


def test_light_of_sun_and_sky() -> None:
    # North is +Y: the sun of noon shines from -Y, and a turned home turns the sun along.
    assert direction(Site(0, 0), 0.0, D(180)) == pytest.approx((0, -1, 0), abs=1e-12)
    assert direction(Site(0, 0, north=D(90)), 0.0, D(180)) == pytest.approx((1, 0, 0), abs=1e-12)
    # Meinel's formula in the zenith; nothing once the upper edge has set.
    assert sunlight(D(90)) == pytest.approx(0.7, rel=1e-3)
    assert sunlight(D(-0.3)) == 0.0 < sunlight(D(0.1)) < sunlight(D(1))
    assert skylight(D(90)) == 21_300.0
    assert skylight(D(-6)) == pytest.approx(3.4) and skylight(D(-40)) == 6.5e-4
    heights = np.radians(np.linspace(-30, 90, 600))
    assert (np.diff([skylight(h) for h in heights]) >= 0).all()


def test_a_day_is_cut_in_its_rests_if_it_has_any() -> None:
    spans = np.array([[10.0, 60.0], [70.0, 120.0], [121.0, 125.0], [500.0, 900.0]])
    cuts = stretches(spans, -120.0, 1000.0, 100.0)
    assert cuts == [65.0, 312.5, 600.0, 700.0, 800.0]
    moved = [
        np.clip(spans, a, b) @ [-1, 1] for a, b in zip([-120, *cuts], [*cuts, 1000], strict=True)
    ]
    assert max(part.sum() for part in moved) <= 100.0 + 1e-9
    assert stretches(np.zeros((0, 2)), -120.0, 1000.0, 100.0) == []


def test_what_ends_is_of_who_began_it() -> None:
    told = [
        moved(5, "PIR", True, "anna", "Door"), moved(6, "PIR", True),
        moved(7, "PIR", True, "", "Door"), moved(8, "PIR", True, "", "Wind"), moved(9, "PIR", True),
    ]  # fmt: skip
    found = attribute_events([*told[2:], moved(8, "A", True), moved(0, "PIR", True), *told[:2]])
    assert [e.time for e in found] == [0, 5, 6, 7, 8, 8, 9]
    assert [e.person for e in found] == ["", "anna", "anna", "anna", "", "", ""]
    assert found[4].sensor == "A"


class Body:
    """A body that sits at x = 1 m, walks to x = 121 m from 100 s to 220 s, and sits there."""

    def moving(self) -> Any:
        return np.array([[100.0, 220.0]])

    def away(self) -> Any:
        return np.zeros((0, 2))

    def poses(self, times: Any) -> Any:
        x = np.interp(times, [100.0, 220.0], [1.0, 121.0])
        at = np.column_stack([x, 0 * x, 0 * x + 0.9])
        return type("Pose", (), {"pelvis": at})()


ACTED = Acted(
    {"anna": Body()},
    activities=[
        ActedActivity(-50.0, 100.0, "anna", "Rest", "Sofa"),
        ActedActivity(100.0, 90_000.0, "anna", "Walk", ""),
    ],
    where=[
        Stay(-200.0, 100.0, "anna", "Sofa", SITTING),
        Stay(100.0, 220.0, "anna", "", WALKING),
        Stay(220.0, 50_000.0, "anna", "Chair", SITTING),
        Stay(50_000.0, 99_000.0, "anna", "", GONE),
    ],
)


def test_the_truth_of_a_day_ends_with_it_and_tells_each_minute_of_movement() -> None:
    rooms = {"Sofa": "living"}
    assert activities(ACTED, lambda place: rooms.get(place, "")) == [
        LoggedActivity(0, 100_000_000, "anna", "Rest", "living"),
        LoggedActivity(100_000_000, DAY_US, "anna", "Walk", ""),
    ]
    # The chair is in the hall, but belongs to the living room.
    of_places = {"Sofa": "living", "Chair": "living"}.__getitem__
    found = people(ACTED, lambda at: "living" if at[0] < 31.0 else "hall", of_places)
    assert activities(ACTED, lambda place: rooms.get(place, ""), found)[1].room == "living"
    told = [(w.time / 1e6, w.room, w.at and w.at[0], w.posture) for w in found]
    assert told == [
        (0.0, "living", 1.0, SITTING),
        (100.0, "living", 1.0, WALKING),
        (130.0, "hall", 31.0, WALKING),
        (190.0, "hall", 91.0, WALKING),
        (220.0, "living", 121.0, SITTING),
        (50_000.0, "", None, GONE),
    ]


def moved(time: int, sensor: str, value: bool, person: str = "", because: str = "") -> Event[int]:
    return Event(time, sensor, "moved", 0.0, "PIR", value, 0, person, because)


def day(number: int, begins: bool, *events: Event[int]) -> Day:
    first = moved(0, "pir", begins)
    rest = LoggedActivity(DAY_US - 10, DAY_US, "anna", "Sleep", "bedroom")
    early = LoggedActivity(0, 20, "anna", "Sleep", "bedroom")
    at = (1.0, -0.0, 0.9)
    where = (Whereabouts(0, "anna", "bedroom", at, "lying"),)
    return Day(date(2026, 3, 2 + number), (first, *events), (early, rest), where)


DAYS = [
    day(0, False, moved(1_500_000, "pir", True, "anna", "Anna's body")),
    day(1, True),
    day(2, False),
]


def test_days_become_tables_without_a_seam_at_midnight() -> None:
    files = DayRows.joined(DAYS).files()
    rows = {name: list(csv.reader(io.StringIO(text))) for name, text in files.items()}
    assert rows["events.csv"] == [
        ["time", "sensor", "kind", "field", "value", "person", "because"],
        ["2026-03-02T00:00:00.000", "pir", "PIR", "moved", "0", "", ""],
        ["2026-03-02T00:00:01.500", "pir", "PIR", "moved", "1", "anna", "Anna's body"],
        # The state before midnight has one row; what another day begins with is not hidden.
        ["2026-03-04T00:00:00.000", "pir", "PIR", "moved", "0", "", ""],
    ]
    assert [row[:2] for row in rows["activities.csv"][2:]] == [
        ["2026-03-02T23:59:59.999", "2026-03-03T00:00:00.000"],
        ["2026-03-03T23:59:59.999", "2026-03-04T00:00:00.000"],
        ["2026-03-04T23:59:59.999", "2026-03-05T00:00:00.000"],
    ]
    assert rows["people.csv"][1:] == [
        ["2026-03-02T00:00:00.000", "anna", "bedroom", "1.000", "0.000", "0.900", "lying"]
    ]
    assert Day.of_json(DAYS[0].as_json("run 1"), "run 1") == DAYS[0]
    assert Day.of_json(DAYS[0].as_json("run 1"), "run 2") is None


def test_events_grow_a_day_at_a_time_into_the_same_table() -> None:
    grown = GrowingEvents()
    assert "".join(map(grown.text_of, DAYS)) == DayRows.joined(DAYS).files()["events.csv"]
    assert grown.days == 3


def test_how_often_a_sensor_was_not_valid_is_kept_with_its_day() -> None:
    kept = replace(DAYS[0], not_valid=(NotValid("pad", 100, {"no mass": 20, "torn": 1}),))
    assert Day.of_json(kept.as_json("run 1"), "run 1") == kept
    texts = [*often_not_valid((*kept.not_valid, NotValid("pad", 100, {"torn": 2})))]
    assert texts == ["'pad' was not valid in 12 % of its updates: no mass"]
    assert not [*often_not_valid((*kept.not_valid, NotValid("pad", 110, {})))]


def test_what_goes_on_over_midnight_is_one_also_from_room_to_room() -> None:
    """For example a filler that is drawn before midnight and again after it."""
    late = LoggedActivity(DAY_US - 10, DAY_US, "anna", "Clean", "bedroom")
    early = LoggedActivity(0, 20, "anna", "Clean", "hall")
    again = LoggedActivity(30, 40, "anna", "Clean", "hall")
    days = [replace(DAYS[0], activities=(late,)), replace(DAYS[1], activities=(early, again))]
    assert DayRows.joined(days).activities == (
        LoggedActivity(DAY_US - 10, DAY_US + 20, "anna", "Clean", "hall"),
        LoggedActivity(DAY_US + 30, DAY_US + 40, "anna", "Clean", "hall"),
    )
    log = DayRows.joined(DAYS).log({}, {"home": "home.blend"}, {"Sleep": "Sleeping"})
    assert {activity.activity for activity in log.activities} == {"Sleeping"}
    assert log.start == datetime(2026, 3, 2) and log.changes[1].time == 1_500_000


def test_toml_reads_back() -> None:
    values = {"a b": 'x"y\\\n', "n": 1, "on": True, "at": [0.5, -1e-7], "t": datetime(2026, 3, 2)}
    sensor = {"name": "π", "parameters": {"range": 4.0, "partner": None}, "gone": None}
    text = toml({**values, "versions": {"blender": "4.5"}}, [sensor])
    assert tomllib.loads(text) == {
        **values,
        "versions": {"blender": "4.5"},
        "sensors": [{"name": "π", "parameters": {"range": 4.0}}],
    }


ONE_PERSON = """schema = 1
[person.anna]
begins = "Sleep"
[activity.Sleep]
do = ["lie Bed"]
[activity.Read]
do = ["sit Sofa"]
[[plan]]
person = "anna"
entries = [{entries}]
"""


@pytest.mark.parametrize("spread", ["0 s", "5 min", "20 min", "1 h", "3 h"])
@pytest.mark.parametrize(
    ("at", "until", "before"),
    [
        ("09:00", "10:00", 'at = "10:30", activity = "Sleep", lasts = "18 h"'),
        ("09:00", "10:00", 'at = "22:00", spread = "20 min", activity = "Sleep", until = "07:00"'),
        ("09:00", "09:10", 'at = "23:00", activity = "Sleep", lasts = "9 h", varies = 0.5'),
        ("23:30", "00:30", 'at = "02:00", activity = "Sleep", until = "23:00"'),
    ],
)
def test_an_entry_without_chance_is_done_every_day(spread, at, until, before) -> None:
    entry = f'at = "{at}", spread = "{spread}", activity = "Read", until = "{until}"'
    text = ONE_PERSON.format(entries=f"{{ {entry} }}, {{ {before} }}")
    for seed in range(5):
        read = [s for s in drawn(text, days=30, seed=seed) if s.activity == "Read"]
        # What begins before midnight can be on the day before the first one too.
        assert len(read) in ((30, 31) if at == "23:30" else (30,))
        length = 600 if until == "09:10" else HOUR
        # All but what the begin or the end of the run cuts off last a quarter of the length.
        assert min(s.end - s.start for s in read[1:-1]) >= 0.25 * length - 1


def test_a_short_entry_is_done_every_day() -> None:
    entry = 'at = "09:00", activity = "Read", lasts = "1 min", varies = 1.5'
    night = 'at = "09:30", activity = "Sleep", until = "08:00"'
    text = ONE_PERSON.format(entries=f"{{ {entry} }}, {{ {night} }}")
    read = [s for s in drawn(text, days=60) if s.activity == "Read"]
    assert len(read) == 60


@pytest.mark.parametrize("spread", ["20 min", "1 h"])
def test_each_of_a_row_of_entries_is_done_every_day(spread) -> None:
    """Each has a fixed end, or is short, and their drawn times overlap on most days."""
    ends = ['until = "09:10"', 'lasts = "9 min"', 'until = "09:30"', 'until = "09:40"']
    row = ", ".join(
        f'{{ at = "09:{10 * place:02d}", spread = "{spread}", activity = "Do{place}", {end} }}'
        for place, end in enumerate(ends)
    )
    row += ', { at = "14:00", activity = "Sleep", lasts = "2 h" }'
    acts = "".join(f'[activity.Do{place}]\ndo = ["sit Sofa"]\n' for place in range(4))
    text = ONE_PERSON.format(entries=row).replace("[[plan]]", f"{acts}[[plan]]")
    for seed in range(10):
        found = drawn(text, days=20, seed=seed)
        for place in range(4):
            done = [s for s in found if s.activity == f"Do{place}"]
            assert len(done) == 20 and min(s.end - s.start for s in done) >= 29.0


EITHER = """{ chance = 0.8, either = [
  { at = "12:00", activity = "Read", lasts = "20 min", weight = 3 },
  { at = "13:00", activity = "Away", lasts = "2 h" },
] }"""


def test_of_alternatives_one_is_done_a_day() -> None:
    night = '{ at = "20:00", activity = "Sleep", lasts = "1 h" }'
    segments = drawn(ONE_PERSON.format(entries=f"{EITHER}, {night}"), 1000)
    days = [int(s.start // DAY) for s in segments if s.activity != "Sleep"]
    assert len(set(days)) == len(days) == pytest.approx(800, abs=40)
    reading = sum(s.activity == "Read" for s in segments)
    assert reading / len(days) == pytest.approx(0.75, abs=0.05)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (", weight = 3", ", wight = 3", "line 11: the key 'wight' is unknown here"),
        ("chance = 0.8", "chance = 8", "line 10: chance: 8 is not a number from 0 to 1"),
        ("chance = 0.8", 'at = "9:00"', "line 10: the key 'at' is unknown here"),
        ('"Away"', '"Awaay"', "line 12: activity: 'Awaay' is unknown"),
    ],
)
def test_what_is_wrong_with_alternatives_is_told_with_its_line(old, new, told) -> None:
    text = ONE_PERSON.format(entries=EITHER.replace(old, new))
    with pytest.raises(InputError, match=rf"^week\.toml, {re.escape(told)}"):
        file.read(text, "week.toml")
