# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps that are not the same each time: chances, alternatives, order, repetition, shares."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby, pairwise

import numpy as np
import pytest
from angen_sensors.residents.acting.activity_steps import DrawnSteps, read_activities
from angen_sensors.residents.acting.day import _draw_steps
from angen_sensors.residents.acting.places import TAP, USE, Place, Places
from angen_sensors.residents.acting.timeline import openings_at
from angen_sensors.residents.body.poses import palm
from angen_sensors.residents.body.solve import solve
from angen_sensors.residents.routine import file
from angen_sensors.residents.routine.routine import DAY, Segment
from angen_sensors.residents.routine.text import routine_text
from angen_sensors.residents.routine.timetable import Draws
from angen_sensors.sensor_logic.logs.error import InputError

from .conftest import MONDAY

HEAD = """schema = 1
[person.anna]
begins = "Cook"
[activity.Cook]
do = """
# A thing on the sofa, and where one would stand before it.
CUSHION = Place("Cushion", USE, np.array([7.5, 1.17, 0.0]), 1.57, np.array([7.5, 1.0, 0.7]), 0.7)
# When each of three meals of a day begins, s since midnight.
MEALS = (7 * 3600.0, 12 * 3600.0, 18 * 3600.0)


def drawn(places: Places, do: str, days: int = 400) -> Iterator[tuple[int, DrawnSteps]]:
    """Yield the day and the drawn steps of each of three meals a day."""
    activities = read_activities(file.read(HEAD + do, "week.toml"), places)
    draws = Draws(1, MONDAY)
    for day in range(days):
        for at in MEALS:
            segment = Segment(day * DAY + at, day * DAY + at + 600.0, "anna", "Cook")
            steps = _draw_steps(segment, activities, draws)
            assert steps is not None
            yield day, steps


def named(steps: DrawnSteps) -> tuple[str, ...]:
    return tuple(step.name for step in steps.steps)


def test_a_step_with_a_chance_is_done_as_often(home: Places) -> None:
    do = '["use Stove 10 s", { do = ["use Cup 5 s", "use Stove 5 s"], chance = 0.3 }]'
    counts = Counter(named(steps) for _, steps in drawn(home, do))
    assert set(counts) == {("Stove",), ("Stove", "Cup", "Stove")}
    assert counts["Stove", "Cup", "Stove"] / 1200 == pytest.approx(0.3, abs=0.04)


def test_alternatives_are_drawn_once_a_day_by_their_weights(home: Places) -> None:
    do = '[{ either = ["use Stove", { do = ["use Cup", "use Washbasin"], weight = 3 }] }]'
    days = [list(group) for _, group in groupby(drawn(home, do), key=lambda one: one[0])]
    assert all(len({named(steps) for _, steps in meals}) == 1 for meals in days)
    counts = Counter(named(meals[0][1]) for meals in days)
    assert counts["Cup", "Washbasin"] / len(days) == pytest.approx(0.75, abs=0.06)


def test_alternatives_can_be_drawn_each_time(home: Places) -> None:
    do = '[{ either = ["use Stove", "use Cup"], drawn = "each time" }]'
    days = [list(group) for _, group in groupby(drawn(home, do), key=lambda one: one[0])]
    mixed = sum(len({named(steps) for _, steps in meals}) == 2 for meals in days)
    assert mixed / len(days) == pytest.approx(0.75, abs=0.06)


def test_steps_are_repeated_and_change_their_order(home: Places) -> None:
    do = '[{ do = ["use Stove", "use Cup", "use Washbasin"], any_order = true, times = [0, 2] }]'
    counts = Counter(len(steps.steps) for _, steps in drawn(home, do))
    assert set(counts) == {0, 3, 6}
    assert all(count / 1200 == pytest.approx(1 / 3, abs=0.04) for count in counts.values())
    firsts = Counter(named(steps)[0] for _, steps in drawn(home, do) if steps.steps)
    assert all(firsts[name] / 800 == pytest.approx(1 / 3, abs=0.06) for name in firsts)
    assert len(firsts) == 3


@pytest.mark.parametrize(
    ("share", "low", "high"),
    [('"first third"', 0.0, 1 / 3), ('"last quarter"', 0.75, 1.0), ("[0.2, 0.4]", 0.2, 0.4)],
)
def test_a_share_of_the_activity(home: Places, share: str, low: float, high: float) -> None:
    do = f'["use Stove", {{ do = "use Cup", during = {share}, times = 2 }}]'
    parts = [part for _, steps in drawn(home, do) for part, _ in steps.timed]
    assert len(parts) == 2400 and low <= min(parts) < low + 0.01
    assert high - 0.01 < max(parts) <= high
    assert all([part for part, _ in steps.timed] == sorted(part for part, _ in steps.timed)
               for _, steps in drawn(home, do, 20))  # fmt: skip


def test_another_group_changes_no_draw_of_those_before(home: Places) -> None:
    one = '{ do = "use Cup", chance = 0.5 }'
    alone = [named(steps).count("Cup") for _, steps in drawn(home, f"[{one}]", 50)]
    more = f'[{one}, {{ do = "use Stove", chance = 0.5, times = [1, 5] }}]'
    assert [named(steps).count("Cup") for _, steps in drawn(home, more, 50)] == alone


@pytest.mark.parametrize(
    ("do", "told"),
    [
        ('["lie Bed", { do = "sitt Sofa" }]', "'sitt Sofa' does not begin with the word of a step"),
        ('[{ either = ["sit Sofa", "use Stove"] }, "turn over"]', "the person must be lying"),
        ('["sit Sofa", { do = "leave", during = "first half" }]', "make it a separate activity"),
    ],
)
def test_steps_in_groups_are_checked(home: Places, do: str, told: str) -> None:
    with pytest.raises(InputError, match=r"^week\.toml, line 5: ") as caught:
        read_activities(file.read(HEAD + do, "week.toml"), home)
    assert told in str(caught.value)


def test_turning_over_is_allowed_where_one_can_lie(home: Places) -> None:
    do = '["sit Sofa", { do = "lie Bed", chance = 0.5 }, "turn over"]'
    read_activities(file.read(HEAD + do, "week.toml"), home)


@pytest.mark.parametrize(
    ("do", "told"),
    [
        ('[{ doo = "sit Sofa" }]', "give 'do', with steps, or 'either', with alternatives"),
        ('[{ do = "sit Sofa", either = ["sit Sofa"] }]', "and not both"),
        ('[{ either = ["sit Sofa"] }]', "give two alternatives or more"),
        ("[{ do = [] }]", "give at least one step"),
        ('[{ do = "sit Sofa", chance = 2 }]', "chance: 2 is not a number from 0 to 1"),
        ('[{ do = "sit Sofa", times = [3, 1] }]', "the second number is smaller than the first"),
        ('[{ do = "sit Sofa", times = 1.5 }]', "times: 1.5 is not a whole number"),
        (
            '[{ do = "sit Sofa", during = "first thrid" }]',
            "during: 'first thrid' is no part of an activity; did you mean 'first third'?",
        ),
        (
            '[{ do = [{ do = "sit Sofa", during = "whole" }], during = "first half" }]',
            "the steps around this one say 'during' already: leave it out",
        ),
        ('[{ do = "sit Sofa", weight = 2 }]', "the key 'weight' is unknown here"),
        ('["sit Sofa", 3]', "do: 3 is no text"),
        ("[]", "an activity must have at least one step"),
        (
            '[{ do = [{ do = [{ do = "sit Sofa", times = 50 }], times = [1, 50] }], times = 50 }]',
            "'Cook' has up to 125,000 steps, and 1,000 are the most",
        ),
        (
            '[{ do = "sit Sofa", times = 100 }, { either = ["sit Sofa", { do = "sit Sofa", times = '
            "91 }], times = 10 }]",
            "up to 1,010 steps",
        ),
    ],
)
def test_what_is_wrong_with_a_group_is_told_with_its_line(do: str, told: str) -> None:
    with pytest.raises(InputError, match=r"^week\.toml, line 5: ") as caught:
        file.read(HEAD + do, "week.toml")
    assert told in str(caught.value)


def test_groups_are_written_as_they_are_read() -> None:
    do = (
        '["use Stove", { either = ["use Cup", { do = ["sit Sofa"], weight = 2, '
        'varies = [0.5, 1.25] }], drawn = "each time", chance = 0.5 }, { do = ["use Cup 5 s", '
        '{ do = ["use Stove"], times = 2 }], times = [1, 3], any_order = true, during = '
        '"first third" }, { do = ["use Cup"], varies = 0.4, during = [0.1, 0.2] }]'
    )
    routine = file.read(HEAD + do, "week.toml")
    text = routine_text(routine, [], {})
    again = file.read(text, "week.toml")
    assert routine_text(again, [], {}) == text and f"do = {do}" in text


def test_a_timed_step_is_done_in_its_part_and_one_comes_back(play) -> None:
    relax = '["sit Sofa", { do = "use Stove 20 s", during = "second half" }]'
    day = play(f"Relax = {relax}", {"anna": [(-10, "Relax"), (60, "Relax")]}, until=120.0)
    stays = [s for s in day.acted.where if s.place and s.end - s.start > 5]
    assert [s.place for s in stays] == ["Sofa", "Stove", "Sofa", "Stove", "Sofa"]
    starts = [s.start / 60 for s in stays if s.place == "Stove"]
    assert 25 <= starts[0] < 61 and 90 <= starts[1] < 121


def test_an_activity_all_of_whose_steps_are_left_out_stays(play) -> None:
    cook = '[{ do = "use Stove 20 s", chance = 0 }]'
    plan = {"anna": [(-10, "Sleep"), (60, "Cook"), (70, "Away"), (80, "Cook"), (90, "Sleep")]}
    day = play(f"Sleep = lie Bed\nCook = {cook}", plan)
    places = [(s.place, s.posture) for s in day.acted.where if s.end - s.start > 300]
    assert places == [("Bed", "lying"), ("", "away"), ("", "standing"), ("Bed", "lying")]


def open_times(play, steps: str, head: str = "", times: int = 90) -> np.ndarray:
    """Return for how long a leaf is open each time, s."""
    spans = []
    for seed in (1, 2):
        day = play(
            f'Cook = [{{ do = [{steps}], times = {times} }}]\nSleep = lie Bed',
            {"anna": [(-1, "Sleep"), (10, "Cook"), (1400, "Sleep")]}, seed=seed, head=head,
        )  # fmt: skip
        swings = day.acted.swings["Drawer"]
        assert len(swings) == 2 * times and all(s.start < s.end for s in swings)
        assert all(a.end <= b.start for a, b in pairwise(swings))
        spans += [b.end - a.start for a, b in zip(swings[::2], swings[1::2], strict=True)]
    return np.array(spans)


def test_a_leaf_is_open_as_long_as_a_real_fridge(play) -> None:
    low, middle, high = np.quantile(
        open_times(play, '"open Drawer for a while"'), (0.05, 0.5, 0.95)
    )
    # Measured: 2, 6 and 47 s. The standard error of the quantiles of 180 draws is up to 15 %.
    assert np.log([low / 2, middle / 6, high / 47]) == pytest.approx(0, abs=0.35)


def test_the_file_says_how_long_each_use_lasts(play) -> None:
    head = '[uses]\nDrawer = { lasts = "20 s", varies = 0.0 }'
    assert open_times(play, '"open Drawer for a while"', head, 5) == pytest.approx(20, abs=0.4)
    assert open_times(play, '"open Drawer for 3 s"', head, 5) == pytest.approx(3, abs=0.1)
    varied = open_times(play, '{ do = "open Drawer for 8 s", varies = 0.5 }', head)
    assert np.std(np.log(varied)) == pytest.approx(0.5, abs=0.08)


def test_a_leaf_that_was_open_for_a_while_is_shut_the_day_after(play) -> None:
    lines = 'Cook = ["open Drawer for 8 s"]\nSleep = lie Bed'
    plan = {"anna": [(-1, "Sleep"), (600, "Cook"), (700, "Sleep")]}
    day = play(lines, plan, until=2880.0, day=1)
    assert openings_at(day.acted.swings.get("Drawer", []), np.array([100.0]), 0.0) == 0.0


def test_a_hand_stays_at_a_leaf_that_is_opened_briefly(play) -> None:
    day = play('Look = [{ do = "open Door bedroom for 3 s", varies = 0.0 }]\nStand = go Corner',
               {"anna": [(-1, "Stand"), (600, "Look"), (700, "Stand")]})  # fmt: skip
    first, last = day.acted.swings["Door bedroom"]
    assert last.end - first.start == pytest.approx(3.0) and last.after == 0.0
    times = np.arange(first.start + 0.1, last.end, 0.1)
    arms = solve(day.acted.bodies["anna"].poses(times))
    handle = day.places.doors["Door bedroom"].handle_at
    off = [
        min(np.linalg.norm(palm(arms, side, 1.0)[k] - handle(float(wide))) for side in (0, 1))
        for k, wide in enumerate(openings_at([first, last], times, 0.0))
    ]
    # Where the leaf is wide open, the hand follows as far as the arm reaches.
    assert max(off) < 0.6 and off[0] < 0.15 and off[-1] < 0.15


@pytest.mark.parametrize(
    ("head", "told"),
    [
        ("[uses]\nDrawr = { varies = 0.5 }", "line 5: nothing is marked 'Drawr'; did you mean"),
        ("[uses]\nDrawer = { vary = 0.5 }", "line 5: give 'lasts', 'varies' or both"),
        ('[uses]\nDrawer = { lasts = "5 s", vary = 0.5 }', "line 5: the key 'vary' is unknown"),
    ],
)
def test_what_is_wrong_with_uses_is_told_with_its_line(play, head: str, told: str) -> None:
    with pytest.raises(InputError, match=rf"^week\.toml, {told}"):
        play("Sleep = lie Bed", {"anna": [(-1, "Sleep")]}, head=head)


def test_who_rests_moves_as_often_as_measured(play) -> None:
    rest = {"anna": [(-5, "Rest")]}
    nights = [play("Rest = lie Bed while resting", rest, seed=seed) for seed in range(8)]
    hours = 24.0 * len(nights)
    spans = sum(len(night.acted.bodies["anna"].moving()) for night in nights)
    assert spans / hours == pytest.approx(4.6, rel=0.2)
    clips = [clip for night in nights for clip in night.acted.bodies["anna"].clips]
    turns = sum(not clip.still and abs(clip.end - clip.start - 2.6) < 1e-6 for clip in clips)
    assert turns / hours == pytest.approx(1.6, rel=0.2)
    seats = [play("Rest = sit Sofa while resting", rest, seed=seed) for seed in range(8)]
    spans = sum(len(seat.acted.bodies["anna"].moving()) for seat in seats)
    assert spans / hours == pytest.approx(7.8, rel=0.2)
    # A routine that says how somebody rests is followed.
    said = play("Rest = sit Sofa while shift every 600 min", rest)
    assert len(said.acted.bodies["anna"].moving()) < 30


def test_trunk_and_hands_move_at_work_and_as_at_that_place(play, home: Places) -> None:
    places = {**home.places, "Washbasin": replace(home.places["Washbasin"], use=TAP)}
    lines = ["Cook = use Stove 20 min", "Wash = use Washbasin 20 min",
             "Type = sit Sofa, reach Cushion 20 min"]  # fmt: skip
    plan = [(0, "Cook"), (60, "Wash"), (120, "Type"), (180, "Cook")]
    day = play("\n".join(lines), {"anna": plan},
               places=replace(home, places=places | {"Cushion": CUSHION}))  # fmt: skip
    widths = {}
    for name, start in (("Cook", 3), ("Wash", 63), ("Type", 123)):
        times = np.arange(start * 60.0, start * 60.0 + 240, 0.5)
        pose = day.acted.bodies["anna"].poses(times)
        arms = solve(pose)
        across = np.array([-np.sin(pose.heading[0]), np.cos(pose.heading[0]), 0.0])
        hands = [(palm(arms, side, 1.0) @ across).std() for side in (0, 1)]
        widths[name] = (
            max(hands),
            (arms.at["chest"] @ across).std(),
            (arms.at["head"] @ across).std(),
        )
        assert 0.01 < widths[name][0] < 0.2 and 0.002 < widths[name][1] < 0.06, widths
    assert widths["Cook"][0] > 1.5 * widths["Wash"][0]
