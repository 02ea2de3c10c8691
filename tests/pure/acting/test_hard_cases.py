# SPDX-License-Identifier: GPL-3.0-or-later
"""Impossible activities are an error of one line; difficult ones end well."""

import re
from dataclasses import replace
from datetime import date

import numpy as np
import pytest
from angen_sensors.residents.acting import act
from angen_sensors.residents.body.skeleton import ADULT, Build, Sort
from angen_sensors.residents.routine import file, timetable
from angen_sensors.residents.routine.routine import DAY, Segment
from angen_sensors.residents.routine.timetable import Draws
from angen_sensors.sensor_logic.logs.error import InputError

DRAWS = Draws(1, date(2026, 3, 2))
ACTIVITIES = """
Relax = sit Sofa
Toilet = sit Toilet 2 min, use Washbasin 20 s
Sleep = lie Bed while turn over every 30 min
"""
BUILDS = [
    Build(Sort.CHILD, 1.22, 23.0, 1.0),
    Build(Sort.OLDER_ADULT, 1.6, 68.0, 0.6, frame=True),
]


@pytest.mark.parametrize(
    ("steps", "told"),
    [
        ("sitt Sofa", "'sitt Sofa' does not begin with the word of a step; did you mean 'sit'?"),
        ("sit Sofe", "sit Sofe: no place is marked 'Sofe'; did you mean 'Sofa'?"),
        ("sit Stove", "this place is not marked for it; places to sit: 'Bed', 'Sofa'"),
        ("lie Sofa", "this place is not marked for it; places to lie: 'Bed'"),
        ("switch Lamp bedroom", "must end with \"on\" or \"off\""),
        ("switch Lamp on", "no lamp is marked 'Lamp'; known: 'Lamp bedroom'"),
        ("open Door", "no door or drawer is marked 'Door'; known: 'Door bathroom'"),
        ("wait", 'wait: give a duration, as in "wait 20 s"'),
        ("wait 20 s 1 min", "wait 20 s 1 min: '20 s 1 min' is not a duration"),
        ("use Stove 20 s 1 h", "use Stove 20 s 1 h: '20 s 1 h' is not a duration"),
        ("open Drawer for 20 s 1 min", "'20 s 1 min' is not a duration"),
        ("use", "use: the name of a place is missing; known: 'Bed'"),
        ("put Cup", 'the name of a place is missing, as in "put Cup at Table"; known: \'Bed\''),
        ("leave now", "'now' must be left out"),
        ("turn over", "the person must be lying: add a step before it"),
        ("sit Sofa, turn over", "the person must be lying: add a step before it"),
        ("put Cup at Stove", 'it is not in the hand; add a step "take" before it'),
        ("take Bed", "take Bed: only objects whose Use is Use can be carried, and its Use is Lie"),
        ("sit Sofa while drink Sofa every 5 min", "drink Sofa: only objects whose Use is Use"),
        ("drink Stoov", "drink Stoov: no thing is marked 'Stoov'"),
        ("take Safe", "take Safe: it is 1.9 m large; only objects up to 1 m can be carried"),
        ("sit Sofa, reach Stove", "away from 'anna' at 'Sofa'; add a step \"go\" before it"),
        ("use Safe", r"use Safe: 'anna' cannot reach it from 'Sofa'; the nearest point that can "
         r"be reached is \((\d\.\d+), (\d\.\d+)\) m"),
        ("sit Sofa while leave every 5 min", 'the step "leave" cannot be repeated'),
    ],
)  # fmt: skip
def test_what_cannot_be_is_told_with_its_line(play, steps: str, told: str) -> None:
    with pytest.raises(InputError) as caught:
        play(f"Relax = sit Sofa\nOdd = {steps}", {"anna": [(0, "Relax"), (60, "Odd")]})
    # The first activity is above line 6.
    assert re.match(r"week\.toml, line [6-9]: ", str(caught.value)), caught.value
    assert told in str(caught.value) or re.search(told, str(caught.value))


def test_activities_and_people_that_nobody_knows(home, floor_map) -> None:
    routine = file.read('schema = 1\n[person.anna]\nbegins = "Away"', "week.toml")
    _, segments = timetable.read(
        "start,end,person,activity\n2026-03-02 07:00,2026-03-02 08:00,anna,Nap\n", "d.csv"
    )
    with pytest.raises(InputError, match=r"^d\.csv, line 2: 'anna' does 'Nap'"):
        act(segments, routine, home, {"anna": ADULT}, DRAWS, 0, floor_map)
    with pytest.raises(InputError, match=r"^'bo' is not a person of the routine; known: 'anna'"):
        act([Segment(0.0, 60.0, "bo", "Away")], routine, home, {"anna": ADULT}, DRAWS, 0, floor_map)


def test_an_activity_shorter_than_the_way_there(play) -> None:
    plan = [(0, "Relax"), (60, "Toilet"), (60.2, "Relax"), (90, "Toilet"), (90.1, "Sleep"),
            (90.2, "Relax")]  # fmt: skip
    day = play(ACTIVITIES, {"anna": plan})
    # A begun activity is finished, so it ends late. Activities that ended before their turn are
    # dropped.
    assert [name for name, _ in day.told("anna")] == ["Relax", "Toilet", "Relax", "Toilet", "Relax"]
    toilet = day.acted.activities[1]
    assert toilet.start == 60 * 60 and 40 < toilet.end - toilet.start < 120


def test_who_is_where_the_next_activity_is_does_not_move(play) -> None:
    text = "One = sit Sofa\nTwo = sit Sofa\nThree = stand at Window\nFour = go Window"
    day = play(text, {"anna": [(0, "One"), (10, "Two"), (20, "Three"), (30, "Four")]})
    ((start, end),) = day.acted.bodies["anna"].moving()
    assert start == 20 * 60 and end < 21 * 60
    assert [d.start for d in day.acted.activities] == [0, 600, 1200, 1800]


def test_a_diary_with_gaps_and_a_row_that_goes_on_with_the_one_before(home, floor_map) -> None:
    rows = """start,end,person,activity
2026-03-02 07:00,2026-03-02 07:20,anna,Relax
2026-03-02 07:20,2026-03-02 07:30,anna,Relax
2026-03-02 08:00,2026-03-02 08:05,anna,Toilet
2026-03-02 22:00,2026-03-03 07:00,anna,Sleep
"""
    from_day = 'schema = 1\n[person.anna]\nbegins = "Away"\n'
    from_day += '[activity.Relax]\ndo = ["sit Sofa"]\nwhile = []\n'
    from_day += '[activity.Toilet]\ndo = ["sit Toilet 1 min"]\n'
    from_day += '[activity.Sleep]\ndo = ["lie Bed"]\nwhile = []\n'
    routine = file.read(from_day, "week.toml")
    _, segments = timetable.read(rows, "d.csv")
    for day in (0, 1):
        acted = act(segments, routine, home, {"anna": ADULT}, DRAWS, day, floor_map)
        told = [(done.activity, done.place) for done in acted.activities]
        if day == 0:
            names = ["Other", "Relax", "Other", "Toilet", "Other", "Sleep"]
            at = ["Sofa", "Sofa", "Sofa", "Toilet", "Toilet", "Bed"]
            assert told == list(zip(names, at, strict=True))
            # In the gaps nobody moves.
            moving = acted.bodies["anna"].moving()
            assert ((moving[:, 0] // 3600 == 8) | (moving[:, 0] // 3600 == 22)).all()
        else:
            # The diary ends in the morning, and with it its last activity.
            assert told == [("Sleep", "Bed")] and acted.activities[0].end == 7 * 3600


@pytest.mark.parametrize("build", BUILDS, ids=lambda build: build.sort.lower())
def test_other_bodies_live_as_well(play, build: Build) -> None:
    plan = [(0, "Sleep"), (400, "Toilet"), (410, "Relax"), (500, "Away"), (600, "Sleep")]
    day = play(ACTIVITIES, {"anna": plan}, builds={"anna": build})
    assert day.told("anna") == [("Sleep", "Bed"), ("Toilet", "Washbasin"), ("Relax", "Sofa"),
                                ("Away", ""), ("Sleep", "Bed")]  # fmt: skip
    times = day.moving_times("anna")
    hips = day.at("anna", *times[day.seen("anna", times)])
    steps = np.hypot(*np.diff(hips[:, :2], axis=0).T)[
        np.diff(times[day.seen("anna", times)]) < 0.11
    ]
    assert steps.max() < 0.16 and day.nearest_to_leaves("anna") > 0.2


def test_a_day_begins_and_ends_as_it_is_asked_however_long_the_activities(play) -> None:
    day = play(
        "Relax = sit Sofa", {"anna": [(-3000, "Away"), (-0.3, "Relax")]}, day=0, until=9000.0
    )
    assert day.told("anna") == [("Relax", "Sofa")]
    assert day.acted.where[0].posture != "sitting" and day.acted.where[0].start == 0.0
    assert day.acted.where[-1].end == DAY


def test_who_begins_the_day_with_a_thing_is_where_it_is(play, home) -> None:
    # The vault, whose place is the first of all, has no door.
    vault = replace(home.places["Safe"], name="A safe")
    places = replace(home, places={"A safe": vault, **home.places})
    text = "Drink = take Cup, drink Cup\nRelax = sit Sofa"
    day = play(text, {"anna": [(0, "Drink"), (600, "Relax")]}, places=places)
    assert day.told("anna") == [("Drink", "Cup"), ("Relax", "Sofa")]
    assert day.acted.where[0].place == "Cup"
