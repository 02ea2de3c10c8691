# SPDX-License-Identifier: GPL-3.0-or-later
"""`angen learn`: logs of activities in several forms, habits learnt from them, and drawn days."""

from __future__ import annotations

import functools
import tomllib
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from datetime import date, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from angen_sensors.residents.routine import file
from angen_sensors.residents.routine import learn as learning
from angen_sensors.residents.routine import timetable as diary
from angen_sensors.residents.routine.learn import Begun, Days, draw, learn, lived_days
from angen_sensors.residents.routine.routine import AWAY, Person, Routine, Segment
from angen_sensors.residents.routine.text import clock, duration, routine_text
from angen_sensors.sensor_logic.logs.comparison.compare import ks_distance
from angen_sensors.sensor_logic.logs.error import InputError
from angen_sensors.sensor_logic.logs.formats.activities import (
    DoneActivity,
    is_activities,
    read,
    without_overlaps,
)
from invented_log import (
    MONDAY,
    Done,
    casas,
    casas_csv,
    invented,
    lengths,
    ordonez,
    punctual,
    pyadlml,
    table,
)

HOUR = 3600.0
Angen = Callable[..., tuple[int, str, str]]


# Logs of activities


@pytest.mark.parametrize("form", [table, ordonez, lengths, casas, casas_csv])
def test_a_log_reads_the_same_in_every_form(
    form: Callable[[list[Done]], str], tmp_path: Path
) -> None:
    rows, path = invented(5), tmp_path / "log.txt"
    path.write_text(form(rows))
    found, notes = read(path)
    # Words in CASAS have no spaces.
    same = [(one.start, one.end, one.activity.replace("Watch_TV", "Watch TV")) for one in found]
    assert (same, notes) == (rows, [])
    assert is_activities(path) == (form in (table, ordonez))


def test_folders_name_persons(tmp_path: Path) -> None:
    rows = invented(5)
    pyadlml(rows, tmp_path / "pyadlml")
    days = tmp_path / "days"
    days.mkdir()
    lines = [f"{a.isoformat()}.000,{b.isoformat()}.000,anna,{name},room" for a, b, name in rows]
    days.joinpath("activities.csv").write_text(
        "start,end,person,activity,room\n" + "\n".join(lines)
    )
    for folder in ("pyadlml", "days"):
        found, _ = read(tmp_path / folder)
        assert {one.person for one in found} == {"anna"}
        assert [(one.start, one.end, one.activity) for one in found] == rows


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("start,end,activity\nMonday,2026-03-02,Sleep\n", r"log\.txt, line 2: "),
        ("2012-11-11 21:14:00\t2012-11-12 00:22:59\tTV\nnow 5\n", r"log\.txt, line 2 is not start"),
        ("time,value\n1,2\n", "has no activities: give a table with the columns start, end"),
        ("25-Fob-2008 00:22:46\t25-Fob-2008 00:25:12\t6\n", "line 1: .*is not a date and time"),
    ],
)
def test_what_is_no_log_is_told_in_a_line(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_text(text)
    with pytest.raises(InputError, match=told) as caught:
        read(path)
    assert "\n" not in str(caught.value)


def test_kasteren_writes_months_as_words(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_text("25-Feb-2008 9:22:46\t25-Feb-2008 09:25:12\t6\n")
    assert read(path)[0] == [
        DoneActivity(datetime(2008, 2, 25, 9, 22, 46), datetime(2008, 2, 25, 9, 25, 12), "", "6")
    ]


def test_what_begins_later_interrupts_what_is_under_way() -> None:
    def done(*rows: tuple[int, int, str]) -> list[DoneActivity]:
        minute = timedelta(minutes=1)
        return [DoneActivity(MONDAY + a * minute, MONDAY + b * minute, "", n) for a, b, n in rows]

    given = done((0, 100, "Sleep"), (20, 25, "Toilet"), (90, 120, "TV"), (120, 130, "TV"))
    assert without_overlaps(given) == done(
        (0, 20, "Sleep"), (20, 25, "Toilet"), (25, 90, "Sleep"), (90, 130, "TV")
    )


def test_what_flickers_between_two_stretches_is_part_of_them() -> None:
    second = timedelta(seconds=1)
    rows = [(0, 100, "TV"), (100, 103, "Other"), (103, 400, "TV"), (400, 403, "Sleep")]
    given = [DoneActivity(MONDAY + a * second, MONDAY + b * second, "", n) for a, b, n in rows]
    found = [(one.activity, (one.end - one.start) / second) for one in without_overlaps(given)]
    assert found == [("TV", 400.0), ("Sleep", 3.0)]


def test_rows_with_a_label_each_are_activities_until_the_next_label(tmp_path: Path) -> None:
    path = tmp_path / "data"
    path.write_text(
        "2026-01-05 07:00:00.5 Bedroom Bedroom ON Sleep\n"
        "2026-01-05 07:10:00.5 Bedroom Bedroom OFF Sleep\n"
        "2026-01-05 07:12:00.5 Kitchen Kitchen ON Cook\n"
        "2026-01-05 07:13:00.5 Kitchen Kitchen OFF\n"
        "2026-01-05 07:20:00.5 Kitchen Kitchen OFF Eat\n"
    )
    assert [(one.activity, one.start.minute, one.end.minute) for one in read(path)[0]] == [
        ("Sleep", 0, 12),
        ("Cook", 12, 13),
    ]


# Habits


@functools.cache
def log(days: int = 28) -> Any:
    return lived_days(DoneActivity(a, b, "", name) for a, b, name in invented(days))


@functools.cache
def learnt() -> Routine:
    """The routine as its text is read back."""
    text = routine_text(learn(log(), Person("anna", "Adult", False, "")), ["About."], {})
    return file.read(text, "learnt.toml")


@functools.cache
def drawn(seed: int = 7, days: int = 140) -> Any:
    return draw(learnt(), "anna", days, seed)


def cases(days: Days, activity: str) -> list[Begun]:
    return [one for begun in days.values() for one in begun if one.activity == activity]


def times_a_day(days: Days, activity: str) -> np.ndarray:
    return np.array([sum(one.activity == activity for one in begun) for begun in days.values()])


@pytest.mark.parametrize("activity", ["Sleep", "Use_Toilet", "Wash", "Breakfast", "Watch TV"])
def test_drawn_days_are_like_the_log(activity: str) -> None:
    real, ours = log().begun, drawn().begun
    for of in (lambda one: one.begins, lambda one: one.lasts):
        # The log has whole minutes.
        values = [
            np.array([float(round(of(one) / 60)) for one in cases(days, activity)])
            for days in (real, ours)
        ]
        assert ks_distance(*values) < 0.25
    assert ks_distance(*(times_a_day(days, activity) for days in (real, ours))) < 0.25


@functools.cache
def regular() -> tuple[Any, Routine, Any]:
    """The log of a punctual person, the routine that is read back, and 30 days drawn from it."""
    lived = lived_days(DoneActivity(a, b, "", name) for a, b, name in punctual())
    text = routine_text(learn(lived, Person("anna", "anna", False, "")), [], {})
    routine = file.read(text, "learnt.toml")
    return lived, routine, draw(routine, "anna", 30, 1)


def hours(days: Days, activity: str, end: bool = False) -> np.ndarray:
    return np.array([(one.ends if end else one.begins) / HOUR for one in cases(days, activity)])


def test_who_is_punctual_is_drawn_so() -> None:
    found = regular()[2].outer
    assert np.abs(hours(found, "Sleep") - (23 + 5 / 60)).max() < 0.25
    assert np.abs(hours(found, "Sleep", end=True) - 31.0).max() < 0.5
    assert np.abs(hours(found, "Lunch") - 12.0).max() < 0.25
    assert len(hours(found, "Sleep")) == len(hours(found, "Lunch")) == len(found)


def test_what_follows_something_else_has_no_time_of_its_own() -> None:
    _, routine, found = regular()
    planned = {entry.activity for plan in routine.plans for entry in plan.entries}
    assert planned == {"Sleep", "Lunch"}
    before = Counter(one.before for one in cases(found.outer, "Breakfast"))
    assert before["Use_Toilet"] > 0.7 * before.total()
    assert np.median(hours(found.outer, "Breakfast")) == pytest.approx(7.12, abs=0.1)


def test_entries_that_touch_read_back() -> None:
    """An entry can last until another begins, and their medians differ by a minute."""
    random, done = np.random.default_rng(63), []
    now = MONDAY - timedelta(minutes=60)
    for number in range(16):
        day = MONDAY + timedelta(days=number)
        wake, work = 420 + 3 * random.normal(), 900 + 20 * random.normal()
        for until, name in ((wake, "Sleep"), (work, "Read"), (1380 + random.normal(), "Work")):
            then = day + timedelta(minutes=round(until))
            done.append(DoneActivity(now, then, "", name))
            now = then
    routine = learn(lived_days(done), Person("anna", "anna", False, ""))
    assert len([entry for plan in routine.plans for entry in plan.entries]) >= 2
    assert file.read(routine_text(routine, [], {}), "again.toml").plans


def test_what_an_entry_cuts_short_would_have_lasted_longer() -> None:
    """Kaplan and Meier: a case that was cut gives its weight to the longer ones."""
    cut = np.array([False, True, False, False])
    weights = learning._uncut(np.array([4.0, 2.0, 1.0, 3.0]), np.ones(4), cut)
    assert weights == pytest.approx([1.5, 0.0, 1.0, 1.5])


def test_weekends_have_habits_of_their_own() -> None:
    def median_start(weekend: bool) -> float:
        days = {d: b for d, b in drawn().begun.items() if (d.weekday() > 4) == weekend}
        return float(np.median([one.begins for one in cases(days, "Breakfast")])) / HOUR

    assert median_start(False) == pytest.approx(7.2, abs=0.4)
    assert median_start(True) == pytest.approx(9.2, abs=0.5)


def test_what_is_done_once_a_day_is_drawn_once_a_day() -> None:
    assert np.mean(times_a_day(log().begun, "Breakfast") == 1) == 1.0
    assert np.mean(times_a_day(drawn().begun, "Breakfast") == 1) > 0.85


def test_what_follows_what_is_learnt() -> None:
    def share(days: Days) -> float:
        before = Counter(one.before for one in cases(days, "Wash"))
        return before["Use_Toilet"] / before.total()

    assert share(log().begun) == 1.0
    assert share(drawn().begun) > 0.9


def test_nights_are_interrupted_and_end_in_the_morning() -> None:
    found = drawn()
    assert (log().rest, found.rest) == ("Sleep", "Sleep")
    shares = [np.mean([bool(of.interruptions[d]) for d in of.outer]) for of in (log(), found)]
    assert 0.2 < shares[0] < 0.6 and shares[1] == pytest.approx(shares[0], abs=0.15)
    nights = [one for one in cases(found.outer, "Sleep") if one.lasts > 2 * HOUR]
    ends = np.array([(one.begins + one.lasts) / HOUR % 24 for one in nights])
    assert np.mean((ends > 6) & (ends < 10)) > 0.95


def test_nights_with_several_activities_in_a_row_are_learnt_as_days_are() -> None:
    found = []
    for a, b, name in invented(28):
        found.append(DoneActivity(a, b, "", name))
        if name == "Use_Toilet" and a.hour < 6:
            found[-1] = DoneActivity(a, a + timedelta(minutes=1), "", "Wake up")
            found.append(DoneActivity(a + timedelta(minutes=1), b, "", name))
    lived = lived_days(found)
    assert lived.rest == "Sleep" and not any(lived.interruptions.values())
    assert any(one.before == "Wake up" for one in cases(lived.outer, "Use_Toilet"))


def test_a_week_is_too_short_for_habits_of_weekends() -> None:
    routine = learn(log(8), Person("anna", "Adult", False, ""))
    assert {filler.days.weekdays for filler in routine.fillers} == {frozenset(range(7))}


def test_without_a_whole_day_there_is_nothing_to_learn() -> None:
    with pytest.raises(InputError, match="there is no whole day, from 04:00 to 04:00"):
        lived_days([DoneActivity(MONDAY, MONDAY + timedelta(hours=3), "", "Sleep")])


def test_one_activity_all_the_time_is_no_habit() -> None:
    one = lived_days([DoneActivity(MONDAY, MONDAY + timedelta(days=5), "", "Sleep")])
    with pytest.raises(InputError, match="one activity goes on all the time"):
        learn(one, Person("anna", "anna", False, "Sleep", ""))


def test_any_name_in_a_log_reads_back() -> None:
    hours = [MONDAY + timedelta(hours=h) for h in range(0, 97, 4)]
    names = ["a\x7fb", 'S\u00f6"\\', "#\x01 = [1]"] * 8
    done = [DoneActivity(a, b, "", n) for a, b, n in zip(hours[:-1], hours[1:], names, strict=True)]
    routine = learn(lived_days(done), Person("anna", "anna", False, "x", ""))
    assert set(file.read(routine_text(routine, [], {}), "again.toml").activities) == set(names)


def test_the_text_of_a_routine_reads_back_as_the_same_text() -> None:
    said = {"Wash": "Often.\nAnd more."}
    text = routine_text(learnt(), ["About."], said)
    again = file.read(text, "again.toml")
    for one, two in zip(learnt().fillers, again.fillers, strict=True):
        assert (one.days, one.begins, one.ends) == (two.days, two.begins, two.ends)
        assert [c.activity for c in one.choices] == [c.activity for c in two.choices]
    assert learnt().interruptions == again.interruptions
    plans = [
        [replace(entry, where="") for plan in of.plans for entry in plan.entries]
        for of in (learnt(), again)
    ]
    assert plans[0] == plans[1] != []
    assert "# Often.\n# And more.\n[activity.Wash]\n" in text


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(5, "5 s"), (60, "1 min"), (119.6, "2 min"), (125, "2 min 5 s"), (3600, "1 h"), (0, "0 s"),
     (599.7, "10 min"), (5400, "1 h 30 min"), (0.3, "0.3 s")],
)  # fmt: skip
def test_durations_as_text(seconds: float, text: str) -> None:
    assert duration(seconds) == text


def test_times_of_day_as_text() -> None:
    assert [clock(h * HOUR) for h in (0, 7.1, 24, 25.5)] == ["00:00", "07:06", "24:00", "01:30"]


# What a filler can say

FILLER = """
schema = 1
[person.anna]
begins = "Rest"
[activity]
Rest = { do = ["wait 5 s"] }
Tea = { do = ["wait 5 s"] }
Night = { do = ["wait 5 s"] }
[[filler]]
person = "anna"
between = ["06:00", "22:00"]
[filler.choose]
Rest = { weight = 5, lasts = "10 min", varies = 0, after = { Rest = 0 } }
Tea = { weight = 5, lasts = "10 min", varies = [0, 1], after = { Tea = 0 } }
[[filler]]
person = "anna"
between = ["22:00", "06:00"]
[filler.choose]
Night = { weight = 1, until = "07:30", spread = "5 min" }
"""


def segments(text: str, days: int = 30, seed: int = 1) -> list[Segment]:
    return diary.timetable(file.read(text, "f.toml"), date(2026, 3, 2), days, seed)


def begins_a_day(found: Iterable[Segment], activity: str, days: int = 30) -> np.ndarray:
    starts = [one.start for one in found if one.activity == activity]
    return np.histogram(starts, [86_400.0 * n + 4 * HOUR for n in range(days)])[0]


def test_an_activity_of_weight_0_after_another_never_follows_it() -> None:
    found = [one.activity for one in segments(FILLER) if one.activity != "Night"]
    assert found.count("Rest") > 100
    text = FILLER.replace("after = { Rest = 0 }", "after = { Rest = 0, Tea = 0 }")
    # Nothing can follow tea: it goes on until the filler ends.
    assert max(begins_a_day(segments(text), "Tea")) == 1


def test_spread_above_the_median_alone() -> None:
    lasts = np.array([one.end - one.start for one in segments(FILLER) if one.activity == "Tea"])
    assert np.quantile(lasts, 0.3) == pytest.approx(600.0)
    assert np.quantile(lasts, 0.9) > 1200.0


def test_a_night_that_a_filler_draws_goes_over_midnight_to_its_end() -> None:
    nights = [one for one in segments(FILLER) if one.activity == "Night"][1:-1]
    assert len(nights) > 25
    ends = np.array([one.end / HOUR % 24 for one in nights])
    assert ends == pytest.approx(7.5, abs=0.4) and ends.std() > 0.02


def test_midnight_ends_what_a_filler_chose_unless_it_depends_on_what_was_before() -> None:
    text = FILLER[: FILLER.rindex("[[filler]]")].replace('["06:00", "22:00"]', '["00:00", "24:00"]')
    text = text.replace("10 min", "5 h")
    free = text.replace(", after = { Rest = 0 }", "").replace(", after = { Tea = 0 }", "")
    at_midnight = [
        sum(one.end % 86_400.0 == 0.0 for one in segments(of)[:-1]) for of in (free, text)
    ]
    assert at_midnight[0] > 5 and at_midnight[1] == 0


def test_what_is_usual_and_regular_is_made_up_for() -> None:
    text = FILLER.replace(", after = { Rest = 0 }", "").replace(", after = { Tea = 0 }", "")
    text = text.replace('5, lasts = "10 min", varies = [0, 1]',
                        '0.5, lasts = "10 min", usual = [0, 8], regular = REGULAR')  # fmt: skip
    free, regular = (
        begins_a_day(segments(text.replace("REGULAR", k), 60), "Tea", 60)[1:] for k in ("0", "2")
    )
    assert free.std() > 1.5 * regular.std()
    assert free.mean() == pytest.approx(8, abs=1.5) and regular.mean() == pytest.approx(8, abs=1.0)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("varies = [0, 1]", "varies = [0, 1, 2]", "varies: .* is not two numbers: below and above"),
        ("varies = [0, 1]", "varies = [0, 4]", "varies: 4 is not a number from 0 to 3"),
        ("{ Tea = 0 }", "{ Teo = 0 }", "the activity 'Teo' is unknown; did you mean 'Tea'"),
        ("{ Tea = 0 }", "{ Tea = -1 }", "Tea: -1 is not a number"),
        ("varies = [0, 1]", "usual = [0, 1]", "give both 'usual' and 'regular', or neither"),
        ("varies = [0, 1]", "usual = [2, 1], regular = 1", "the second number is smaller"),
        ("varies = [0, 1]", "usual = 3, regular = 1", "usual: 3 is not two numbers"),
        ('until = "07:30"', 'until = "07:30", lasts = "1 h"', "give either 'lasts' or 'until'"),
    ],
)
def test_what_is_wrong_in_a_filler_is_told_with_its_line(old: str, new: str, told: str) -> None:
    assert FILLER.count(old) == 1
    line = FILLER[: FILLER.index(old)].count("\n") + 1
    with pytest.raises(InputError, match=rf"^f\.toml, line {line}: .*{told}"):
        file.read(FILLER.replace(old, new), "f.toml")


# The command

HOME = """
schema = 1
[person.karin]
resident = "Person rig"
begins = "Sleeping"
[activity.Sleeping]
do = ["lie Bed"]
while = [{ do = ["turn over"], every = "20 min", varies = 1.0 }]
labels = { casas = "Sleep" }
[activity."Use toilet"]
do = ["sit Toilet 2 min"]
[activity.Television]
do = ["sit Sofa"]
"""


@pytest.fixture
def given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a log, a routine of the home, and a map of labels; learning is quick."""
    monkeypatch.setattr(learning, "ROUNDS", 1)
    tmp_path.joinpath("log.csv").write_text(table(invented(14)))
    tmp_path.joinpath("home.toml").write_text(HOME)
    tmp_path.joinpath("map.toml").write_text(
        '[labels]\n"Watch TV" = "Television"\nBreakfast = "Away"\n'
    )
    return tmp_path


def learn_from(angen: Angen, folder: Path, *options: Any) -> tuple[int, str]:
    out = folder / "out.toml"
    status, printed, told = angen("learn", folder / "log.csv", "--out", out, *options)
    assert printed == ""
    return status, told


def test_activities_of_the_home_are_taken_over_and_others_are_named(
    angen: Angen, given: Path
) -> None:
    options = ["--routine", given / "home.toml", "--labels", given / "map.toml"]
    status, told = learn_from(angen, given, *options)
    assert status == 0
    assert told.count("\n") == 1 and "has no activity for 'Wash': add what is done to it" in told
    text = given.joinpath("out.toml").read_text()
    found = tomllib.loads(text)
    assert found["person"] == {"karin": {"resident": "Person rig", "begins": "Sleep"}}
    # A name, a label, and a name of the map.
    assert found["activity"]["Sleep"]["do"] == ["lie Bed"]
    assert found["activity"]["Sleep"]["while"][0]["every"] == "20 min"
    assert found["activity"]["Use_Toilet"]["do"] == ["sit Toilet 2 min"]
    assert found["activity"]["Television"]["labels"] == {"log": "Watch TV"}
    assert found["activity"]["Wash"]["do"] == ["wait 5 s"]
    assert AWAY not in found["activity"]
    assert "# Say in 'do' what is done" in text
    assert file.read(text, "out.toml").fillers


def test_without_a_routine_of_the_home_one_line_says_what_to_fill_in(
    angen: Angen, given: Path
) -> None:
    status, told = learn_from(angen, given)
    assert status == 0 and told.count("\n") == 1 and "fill in what is done ('do')" in told


def test_a_log_is_compared_with_a_folder_of_diaries(angen: Angen, given: Path) -> None:
    days, one = given / "diaries", given / "one.csv"
    assert angen("learn", given / "log.csv", "--diaries", 6, days)[0] == 0
    # The nights that midnight cuts are whole again.
    _, rows = diary.read_all({str(p): p.read_text() for p in sorted(days.glob("*.csv"))})
    zero = datetime.combine(
        date.fromisoformat(min(p.stem for p in days.iterdir())), datetime.min.time()
    )
    one.write_text(
        table(
            [
                Done(*(zero + timedelta(seconds=at) for at in (row.start, row.end)), row.activity)
                for row in rows
                if row.activity != "Other"
            ]
        )
    )
    # A day without activities is a day too.
    (days / "none.csv").write_text("start,end,person,activity\n")
    found = [angen("compare", given / "log.csv", of) for of in (days, one)]
    assert [status for status, *_ in found] == [0, 0]
    assert found[0][1].replace("diaries", "one.csv") == found[1][1]
    assert "Sleep" in found[0][1]
    # Nor is a folder with anything else a log of activities.
    (days / "other.csv").write_text("a,b\n")
    status, _, told = angen("compare", given / "log.csv", days)
    assert status == 2 and "has no activities: give" in told


def test_drawn_days_are_a_diary(angen: Angen, given: Path) -> None:
    found = []
    for seed in (1, 1, 2):
        folder = given / f"days {len(found)}"
        options = ["--diaries", 4, folder, "--start", "2026-03-07", "--seed", seed]
        assert angen("learn", given / "log.csv", *options) == (0, "", "")
        names = [f"2026-03-{day:02}.csv" for day in range(7, 11)]
        assert sorted(path.name for path in folder.iterdir()) == names
        found.append({name: folder.joinpath(name).read_text() for name in names})
    assert found[0] == found[1] != found[2]
    for name, text in found[0].items():
        first, rows = diary.read(text, name)
        assert first == date.fromisoformat(name.removesuffix(".csv"))
        assert {one.person for one in rows} == {"resident"}
        assert rows[0].start == 0.0 and rows[-1].end == 86_400.0
    first, rows = diary.read_all(found[0])
    assert first == date(2026, 3, 7)
    assert rows[0].start == 0.0 and rows[-1].end == 4 * 86_400.0
    nights = [one for one in rows if (one.start // 86_400.0) < (one.end - 1) // 86_400.0]
    assert len(nights) == 3, "who sleeps over midnight does not get up for it"


def test_a_routine_and_diaries_are_written_together_or_one_of_them(
    angen: Angen, given: Path
) -> None:
    folder = given / "days"
    assert learn_from(angen, given, "--diaries", 2, folder)[0] == 0
    assert file.read(given.joinpath("out.toml").read_text(), "out.toml").fillers
    assert len(list(folder.iterdir())) == 2
    # The same days again, but no others beside them.
    assert learn_from(angen, given, "--diaries", 2, folder, "--seed", 3)[0] == 0
    status, _, told = angen("learn", given / "log.csv", "--diaries", 1, folder)
    other = f"--diaries: {folder} has other files than these diaries; name a new one\n"
    assert (status, told) == (2, f"angen: {other}")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "learn has nothing to write: give --out, --diaries or both"),
        (["--diaries", "2"], "--diaries: expected 2 arguments"),
        (["--diaries", "many", "days"], "'many' is not a whole number from 1 to 10000"),
        (["--diaries", "2", "log.csv"], "--diaries: log.csv is not a folder"),
        (["--diaries", "2", "no/days"], "--diaries: the folder no does not exist; make it first"),
        (["--diaries", "2", "."], "--diaries: . has other files than these diaries"),
    ],
    ids=str,
)
def test_what_learn_cannot_write_is_one_line(
    angen: Angen,
    given: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    words: str,
) -> None:
    monkeypatch.chdir(given)
    before = sorted(given.iterdir())
    status, printed, told = angen("learn", "log.csv", *options)
    assert (status, printed, told.count("\n")) == (2, "", 1)
    assert words in told
    assert sorted(given.iterdir()) == before


def test_each_person_has_habits_of_their_own(angen: Angen, given: Path) -> None:
    rows = [f"{a},{b},{who},{name}" for who in ("anna", "bo") for a, b, name in punctual(8)]
    given.joinpath("log.csv").write_text("start,end,person,activity\n" + "\n".join(rows))
    assert learn_from(angen, given)[0] == 0
    both = file.read(given.joinpath("out.toml").read_text(), "out.toml")
    assert set(both.persons) == {filler.person for filler in both.fillers} == {"anna", "bo"}
    assert {plan.person for plan in both.plans} == {"anna", "bo"}
    assert learn_from(angen, given, "--person", "bo")[0] == 0
    one = file.read(given.joinpath("out.toml").read_text(), "out.toml")
    assert set(one.persons) == {"bo"}
    status, told = learn_from(angen, given, "--person", "eva")
    assert status == 2 and "nobody is called 'eva': there are 'anna', 'bo'" in told


def test_the_log_is_never_written_over(angen: Angen, given: Path) -> None:
    path = given / "log.csv"
    before = path.read_bytes()
    status, _, told = angen("learn", path, "--out", path)
    assert status == 2 and told.count("\n") == 1
    assert path.read_bytes() == before
