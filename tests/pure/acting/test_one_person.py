# SPDX-License-Identifier: GPL-3.0-or-later
"""A day of one person, and of one with a walking frame: body, doors, lamps, things and truth."""

from itertools import pairwise

import numpy as np
import pytest
from angen_sensors.residents.acting.timeline import openings_at
from angen_sensors.residents.body.poses import palm
from angen_sensors.residents.body.skeleton import Build, Sort
from angen_sensors.residents.body.solve import solve
from angen_sensors.residents.days.truth import activities, people
from angen_sensors.residents.routine.routine import DAY

ACTIVITIES = """
Sleep = lie Bed while turn over every 30 min
Toilet = sit Toilet 2 min, use Washbasin 20 s
Relax = sit Sofa while shift every 6 min
Cook = use Stove 1 min
Dark = switch Lamp bedroom off, lie Bed
Light = switch Lamp bedroom on, stand at Window
Drink = take Cup, sit Sofa 1 min, drink Cup, put Cup at Stove, sit Sofa east
Tidy = open Drawer, stand at Window
Shut = close Drawer, sit Sofa
Sip = use Stove 1 min while drink Cup every 5 min
"""
DAY_PLAN = [(-120, "Sleep"), (400, "Toilet"), (405, "Relax"), (500, "Away"), (600, "Cook"),
            (700, "Toilet"), (800, "Relax"), (1320, "Sleep")]  # fmt: skip


@pytest.fixture
def day(play):
    return play(ACTIVITIES, {"anna": DAY_PLAN})


def test_the_truth_has_no_gaps_and_is_what_was_acted(day) -> None:
    assert day.told("anna") == [
        ("Sleep", "Bed"), ("Toilet", "Toilet"), ("Relax", "Sofa"), ("Away", ""),
        ("Cook", "Stove"), ("Toilet", "Washbasin"), ("Relax", "Sofa"), ("Sleep", "Bed"),
    ]  # fmt: skip
    for told in (day.acted.activities, day.acted.where):
        assert told[0].start == 0.0 and told[-1].end == DAY
        assert all(a.end == b.start for a, b in pairwise(told))
    # Each begins with the first walk to it, as planned.
    starts = [done.start / 60 for done in day.acted.activities]
    assert np.allclose(starts, [0, 400, 405, 500, 600, 700, 800, 1320], atol=0.2)


def test_the_body_is_where_the_truth_says_in_the_posture_it_says(day) -> None:
    heights = {"standing": (0.8, 1.0), "sitting": (0.5, 0.75), "lying": (0.55, 0.7)}
    for stay in day.acted.where:
        if not stay.place or stay.posture == "away" or stay.end - stay.start < 8:
            continue
        hips = day.at("anna", (stay.start + stay.end) / 2)[0]
        place = day.places.places[stay.place]
        wanted = place.at if stay.posture == "standing" else place.target
        assert np.hypot(*(hips - wanted)[:2]) < 0.12, stay
        low, high = heights[stay.posture]
        assert low < hips[2] < high, stay


def test_whoever_stands_still_is_where_the_truth_said_last(day) -> None:
    storey, of = day.places.storeys[0], {p.name: p.room for p in day.places.places.values()}
    rows = people(day.acted, storey.room_at, lambda name: of.get(name, ""))
    moving, times = day.acted.bodies["anna"].moving(), np.arange(0.5, DAY, 30.0)
    still = ~((times[:, None] > moving[:, 0]) & (times[:, None] < moving[:, 1])).any(axis=1)
    last = np.searchsorted([row.time / 1e6 for row in rows], times[still], side="right") - 1
    at = np.array([row.at or (np.nan,) * 3 for row in rows])[last]
    off = np.linalg.norm(day.at("anna", *times[still]) - at, axis=1)
    assert still.sum() > 2000 and np.nanmax(off) < 0.06
    # A few rows, not one for each gesture.
    assert len(rows) < 200
    named = activities(day.acted, lambda name: of.get(name, ""), rows)
    assert [a.room == "" for a in named] == [a.activity == "Away" for a in named]


def test_the_body_never_jumps_nor_goes_through_things(day) -> None:
    times = day.moving_times("anna")
    times = times[day.seen("anna", times)]
    hips = day.at("anna", *times)[:, :2]
    steps = np.hypot(*np.diff(hips, axis=0).T)[np.diff(times) < 0.11]
    assert steps.max() < 0.16
    floor = day.places.storeys[0].floor
    walking = np.array(
        [any(s.start < t < s.end and s.posture == "walking" for s in day.acted.where)
         for t in times]
    )  # fmt: skip
    room = np.array([floor.clearance[floor.cell(hip)] for hip in hips[walking]])
    assert (room > 0.2).mean() > 0.95 and room.min() > 0.0
    assert day.nearest_to_leaves("anna") > 0.25


def test_doors_are_opened_before_and_shut_behind_with_the_hand_on_the_handle(day) -> None:
    acted = day.acted
    assert set(acted.swings) == {"Door bedroom", "Door bathroom", "Entrance"}
    for name, swings in acted.swings.items():
        door = day.places.doors[name]
        assert [s.after for s in swings] == [door.open, door.closed] * (len(swings) // 2)
        assert [s.before for s in swings] == [door.closed, door.open] * (len(swings) // 2)
        for swing in swings:
            opens = swing.after == door.open
            # The hand lets go of the handle that goes out of reach.
            held = np.array([swing.start + 0.1] if opens else [swing.end - 0.1])
            bones = solve(acted.bodies["anna"].poses(held))
            grip = door.handle_at(float(openings_at([swing], held, 0.0)[0]))
            hands = [palm(bones, side, 1.0)[0] for side in (0, 1)]
            assert min(np.linalg.norm(hand - grip) for hand in hands) < 0.15, (name, swing)
            assert acted.last_mover(name, swing.start) == "anna"
    # Who is out is hidden, and the entrance is shut.
    ((start, end),) = acted.bodies["anna"].away()
    assert 500 * 60 < start < 501 * 60 and end == 600 * 60
    swings = acted.swings["Entrance"]
    assert swings[1].end <= start and swings[2].start >= end


def test_lamps_things_and_drawers(play) -> None:
    plan = [(0, "Relax"), (60, "Light"), (120, "Light"), (180, "Dark"), (240, "Drink"),
            (300, "Tidy"), (360, "Shut"), (400, "Sip"), (500, "Relax")]  # fmt: skip
    day = play(ACTIVITIES, {"anna": plan})

    def palms(time: float) -> tuple:
        bones = solve(day.acted.bodies["anna"].poses(np.array([time])))
        return bones.at["head"][0], [palm(bones, side, 1.0)[0] for side in (0, 1)]

    # A lamp that is on is not switched on again.
    assert [(s.object, s.on, s.person) for s in day.acted.switches] == [
        ("Bulb bedroom", True, "anna"), ("Bulb bedroom", False, "anna")]  # fmt: skip
    switch = day.places.lamps["Lamp bedroom"].at
    _, hands = palms(day.acted.switches[0].time)
    assert min(np.linalg.norm(hand - switch) for hand in hands) < 0.1
    taken, put, *lifted = day.acted.holds["Cup"]
    assert (taken.person, taken.hand is None, put.hand) == ("anna", False, None)
    stove = day.places.places["Stove"].target
    assert np.allclose(put.at, stove)
    sip = day.acted.sips["Cup"][0]
    head, hands = palms((sip.start + sip.end) / 2)
    assert taken.start < sip.start < sip.end < put.start
    assert np.linalg.norm(hands[taken.hand] - head) < 0.3
    assert [s.after for s in day.acted.swings["Drawer"]] == [0.4, 0.0]
    # A drink in between lifts the cup and puts it back.
    assert len(lifted) >= 4 and all(np.allclose(put.at, stove) for put in lifted[1::2])
    for taken, put in zip(lifted[::2], lifted[1::2], strict=True):
        head, hands = palms((taken.start + put.start) / 2)
        assert np.linalg.norm(hands[taken.hand] - head - [0.0, 0.0, 0.05]) < 0.3
        assert 4 < put.start - taken.start < 8


def test_what_was_left_on_open_or_put_somewhere_is_so_on_the_next_day(play) -> None:
    plan = [(0, "Light"), (60, "Drink"), (120, "Tidy"), (180, "Relax"), (1500, "Dark"),
            (1600, "Shut"), (1700, "Drink")]  # fmt: skip
    day = play(ACTIVITIES, {"anna": plan}, day=1, until=2880.0)
    assert [(s.on, s.person) for s in day.acted.switches] == [(True, ""), (False, "anna")]
    assert [(s.before, s.after) for s in day.acted.swings["Drawer"]] == [(0.4, 0.4), (0.4, 0.0)]
    # The cup is taken from its last place.
    was, taken, _ = day.acted.holds["Cup"]
    stove = day.places.places["Stove"]
    assert was.start < 0 and was.hand is None and np.allclose(was.at, stove.target)
    assert np.hypot(*(day.at("anna", taken.start)[0] - stove.at)[:2]) < 0.2


def test_the_room_of_a_visit_is_that_of_its_own_places(play) -> None:
    """The lamp of the bedroom stands for any that is switched elsewhere at the end, for long."""
    day = play("Relax = sit Sofa\nVisit = use Washbasin 20 s, switch Lamp bedroom on",
               {"anna": [(0, "Relax"), (10, "Visit"), (30, "Relax")]})  # fmt: skip
    stays = {s.place: s.end - s.start for s in day.acted.where}
    assert stays["Lamp bedroom"] > 10 * stays["Washbasin"]
    assert day.told("anna")[1] == ("Visit", "Washbasin")


def test_who_sits_is_on_the_seat_and_nobody_else(day) -> None:
    seat = day.places.places["Sofa"].target
    low, high = seat - (0.4, 0.4, 0.2), seat + (0.4, 0.4, 0.0)
    sat = next(s for s in day.acted.where if (s.place, s.posture) == ("Sofa", "sitting"))
    assert day.acted.person_on(low, high, sat.start + 60.0) == "anna"
    # Also while she sits down, but not from where she stands before it.
    assert day.acted.person_on(low, high, sat.start) == "anna"
    assert day.acted.person_on(low, high, sat.start - 3.0) == ""
    assert day.acted.person_on(low, high, 550 * 60.0) == ""


def test_whole_turns_are_taken_back(week) -> None:
    day = week(WEEK, 2)
    body, times = day.acted.bodies["anna"], day.moving_times("anna")
    pose = body.poses(times)
    assert np.abs(pose.heading).max() < 3 * np.pi
    # No jump is visible.
    steps = np.angle(np.exp(1j * np.diff(pose.heading)))[np.diff(times) < 0.11]
    assert np.abs(steps).max() < 0.5 and np.abs(np.diff(pose.heading)).max() > 6.0


def test_days_join_at_midnight(play) -> None:
    plans = {"anna": [(0, "Relax"), (1439.9, "Sleep"), (1900, "Relax")]}
    first = play(ACTIVITIES, plans, day=0, until=2880.0)
    second = play(ACTIVITIES, plans, day=1, until=2880.0)
    # The walk to the bed began six seconds before midnight.
    times = np.arange(0.0, 40.0, 0.5)
    assert np.allclose(first.at("anna", *(times + DAY)), second.at("anna", *times), atol=1e-9)
    assert first.told("anna")[-1][0] == second.told("anna")[0][0] == "Sleep"
    assert second.acted.where[0].posture in ("walking", "standing")


NIGHT = """
schema = 1
[person.anna]
begins = "Sleep"
[activity.Sleep]
do = ["switch Lamp bedroom off", "lie Bed"]
while = []
[activity.Read]
do = ["switch Lamp bedroom on", "sit Sofa"]
while = []
[[plan]]
person = "anna"
entries = [
  { at = "20:00", activity = "Read", until = "22:00" },
  { at = "22:00", activity = "Sleep", until = "07:00" },
]
"""


@pytest.mark.parametrize("planned", [True, False])
def test_what_is_under_way_at_the_first_midnight_was_begun_before(week, planned: bool) -> None:
    """By the evening's plan, or else by what the person `begins` with."""
    day = week(NIGHT if planned else NIGHT.partition("[[plan]]")[0], 0)
    assert len(day.acted.spans(0.0, 6.9 * 3600)) == 0
    first = day.acted.where[0]
    assert (first.posture, first.place, first.start) == ("lying", "Bed", 0.0)
    switched = [s for s in day.acted.switches if s.time < 0.0]
    assert not switched[-1].on and switched[-1].person == "anna"


def test_a_day_needs_only_its_own_random_numbers(week) -> None:
    text = WEEK.replace('on = ["sun"]', 'on = ["sat", "sun"]')
    for day in (0, 2):
        one, other = week(WEEK, day), week(text, day, days=9)
        assert one.acted.activities == other.acted.activities
        assert one.acted.where == other.acted.where
        times = np.arange(0.0, DAY, 97.3)
        assert np.array_equal(one.at("anna", *times), other.at("anna", *times))
    assert week(WEEK, 5).acted.where != week(text, 5).acted.where
    assert week(WEEK, 2, seed=2).acted.where != week(WEEK, 2).acted.where


WEEK = """
schema = 1
[person.anna]
begins = "Sleep"
[activity.Sleep]
do = ["lie Bed"]
while = [{ do = "turn over", every = "25 min", varies = 0.8 }]
[activity.Relax]
do = ["sit Sofa"]
while = [{ do = "use Stove 20 s", every = "40 min" }]
[activity.Toilet]
do = ["sit Toilet 2 min", "use Washbasin 20 s"]
[[plan]]
person = "anna"
entries = [{ at = "22:45", spread = "25 min", activity = "Sleep", until = "07:00" }]
[[plan]]
person = "anna"
on = ["sun"]
entries = [{ at = "10:00", activity = "Away", lasts = "2 h" }]
[[filler]]
person = "anna"
between = ["05:00", "23:30"]
[filler.choose]
Relax = { weight = 6, lasts = "52 min", varies = 0.8 }
Toilet = { weight = 2, lasts = "3 min", varies = 0.4 }
"""


FRAMED = Build(Sort.OLDER_ADULT, 1.65, 68.0, 0.85, frame=True)
FRAMED_ACTIVITIES = """
Sleep = lie Bed
Toilet = sit Toilet 2 min, use Washbasin 20 s
Relax = sit Sofa
Cook = use Stove 1 min
Look = stand at Window
"""
FRAMED_PLAN = [(0, "Sleep"), (60, "Toilet"), (70, "Relax"), (100, "Cook"), (130, "Look"),
               (160, "Away"), (200, "Cook"), (230, "Sleep")]  # fmt: skip


@pytest.fixture
def framed_day(play):
    return play(FRAMED_ACTIVITIES, {"anna": FRAMED_PLAN}, builds={"anna": FRAMED})


def on_furniture(framed_day, times: np.ndarray) -> np.ndarray:
    """Return the share (n,) of the frame, 0.57 m by 0.63 m, that is over furniture."""
    floor = framed_day.places.storeys[0].floor
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(-0.3, 0.3, 9), np.linspace(-0.27, 0.27, 9)))
    found = []
    for x, y, _, yaw in framed_day.acted.bodies["anna"].poses(times).walker:
        points = np.column_stack(
            [x + np.cos(yaw) * u - np.sin(yaw) * v, y + np.sin(yaw) * u + np.cos(yaw) * v]
        )
        cells = np.array([floor.cell(point) for point in points])
        found.append(float(np.mean(~floor.free[cells[:, 0], cells[:, 1]])))
    return np.array(found)


def test_at_a_place_the_frame_stands_in_nothing(framed_day) -> None:
    stays = [s for s in framed_day.acted.where if s.place and s.end - s.start > 15]
    assert {s.place for s in stays} >= {"Bed", "Toilet", "Sofa", "Stove", "Window"}
    middles = np.array([(s.start + s.end) / 2 for s in stays])
    assert on_furniture(framed_day, middles).max() == 0.0
    # It stays there, without a hand on it, and within a few steps.
    body = framed_day.acted.bodies["anna"]
    for stay, middle in zip(stays, middles, strict=True):
        pose = body.poses(np.array([middle, stay.end - 1.0]))
        assert np.allclose(pose.walker[0], pose.walker[1])
        assert np.hypot(*(pose.walker[0, :2] - pose.pelvis[0, :2])) < 2.5


def test_it_is_pushed_everywhere_else_and_never_jumps(framed_day) -> None:
    times = framed_day.moving_times("anna")
    times = times[framed_day.seen("anna", times)]
    pose = framed_day.acted.bodies["anna"].poses(times)
    steps = np.hypot(*np.diff(pose.walker[:, :2], axis=0).T)[np.diff(times) < 0.11]
    assert steps.max() < 0.25
    gap = np.hypot(*(pose.walker[:, :2] - pose.pelvis[:, :2]).T)
    walks = [s for s in framed_day.acted.where if s.posture == "walking" and s.end - s.start > 4]
    with_it = [np.median(gap[(times > s.start) & (times < s.end)]) for s in walks]
    assert len(walks) > 8 and np.median(with_it) < 0.5
    # On the way it is over less furniture than at places.
    assert np.mean(on_furniture(framed_day, times[::7])) < 0.03


def test_who_gives_up_a_place_takes_the_frame_out_of_the_home(play) -> None:
    """The frame does not fit at the bedside, but anna never gets there.

    Bo stands where the leaf of the bedroom's door opens to.
    """
    anna = [(0, "Look"), (30, "Tidy"), (35, "Away")]
    text = FRAMED_ACTIVITIES + "Tidy = stand at Bedside\nBlock = stand at Behind the door"
    day = play(text, {"anna": anna, "bo": [(0, "Block")]}, builds={"anna": FRAMED})
    (away,) = (s for s in day.acted.where if s.person == "anna" and s.posture == "away")
    assert 35 * 60 < away.start < 37 * 60
    pose = day.acted.bodies["anna"].poses(np.array([away.start - 1.0]))
    assert np.hypot(*(pose.walker[0, :2] - pose.pelvis[0, :2])) < 0.5


def test_what_a_person_uses_is_in_use_from_the_start_to_the_end(play) -> None:
    exact = [f"{name} = {{ varies = 0.0 }}" for name in ("Stove", "Washbasin", "Toilet")]
    day = play(ACTIVITIES, {"anna": DAY_PLAN}, head="\n".join(["[uses]", *exact]))
    used = day.acted.times_in_use()
    # Nobody only stands at a place that is in use: hands work there for as long as the step says.
    assert np.allclose(np.diff(used["Stove"]), 60.0) and len(used["Stove"]) == 1
    assert np.allclose(np.diff(used["Washbasin"]), 20.0) and len(used["Washbasin"]) == 2
    assert "Window" not in used
    # A seat is in use from when the person sits on it until the person gets up.
    sat = [
        (s.start, s.end) for s in day.acted.where if (s.place, s.posture) == ("Toilet", "sitting")
    ]
    assert np.allclose(used["Toilet"], sat) and np.allclose(np.diff(sat), 120.0)
    assert day.acted.last_user("Toilet", sat[0][0] + 1.0) == "anna"
    assert day.acted.last_user("Toilet", sat[0][0] - 1.0) == ""
    # The day starts in bed, and ends there.
    bed = used["Bed"]
    assert bed[0][0] <= 0.0 < bed[0][1] < bed[-1][0] < DAY <= bed[-1][1]
    lamp = play(ACTIVITIES, {"anna": [(0, "Relax"), (60, "Light"), (180, "Dark"), (240, "Light")]})
    ((on, off), (again, end)) = lamp.acted.times_in_use()["Bulb bedroom"]
    assert 3600 < on < 3700 and 10800 < off < 10900 and again < DAY and end == np.inf
