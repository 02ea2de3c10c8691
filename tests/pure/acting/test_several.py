# SPDX-License-Identifier: GPL-3.0-or-later
"""Several people in one home wait for each other, and never overlap for long.

Two meet head-on in a passage that is too narrow to pass.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from angen_sensors.residents.acting.path_search import Floor
from angen_sensors.residents.acting.places import STAND, Place, Places, Storey
from angen_sensors.residents.acting.timeline import STANDING, Stay
from angen_sensors.residents.routine.routine import DAY
from angen_sensors.sensor_logic.logs.error import InputError
from tiers import mostly_slow

ACTIVITIES = """
Sleep = lie Bed
Toilet = sit Toilet 3 min, use Washbasin 20 s
Relax = sit Sofa
East = sit Sofa east
Cook = use Stove 1 min
Look = stand at Window
Corner = stand at Corner
Block = stand at Behind the door
Wash = use Washbasin 1 min
"""


def stays(day, person: str, place: str) -> list[Stay]:
    return [s for s in day.acted.where if (s.person, s.place) == (person, place)]


def apart(day, people: tuple[str, ...] = ("anna", "bo")) -> None:
    """Assert that each person at a place is alone there, and that a bathroom has one user."""
    for one in day.acted.where:
        for other in day.acted.where:
            if one.person >= other.person or not one.place or not other.place:
                continue
            places = day.places.places
            shared = one.place == other.place or (
                places[one.place].room == places[other.place].room == "bathroom"
            )
            if shared:
                assert min(one.end, other.end) <= max(one.start, other.start) + 1e-6, (one, other)


def test_two_want_the_bathroom_at_once(play) -> None:
    plan = [(0, "Relax"), (60, "Toilet"), (64, "Relax")]
    other = [(0, "East"), (60, "Toilet"), (70, "East")]
    day = play(ACTIVITIES, {"anna": plan, "bo": other})
    apart(day)
    for person in ("anna", "bo"):
        assert sum(s.end - s.start for s in stays(day, person, "Toilet")) > 175
        assert [name for name, _ in day.told(person)][1] == "Toilet"
    # The waiting person stands in the hall, away from the door.
    waits = min(day.acted.activities, key=lambda d: (d.activity != "Toilet", -d.end)).person
    waiting = max(
        (s for s in day.acted.where if s.person == waits and s.posture == "standing"
         and 3600 < s.start < 4200 and not s.place),
        key=lambda s: s.end - s.start,
    )  # fmt: skip
    assert waiting.end - waiting.start > 120
    hips = day.at(waits, (waiting.start + waiting.end) / 2)[0]
    assert 3.2 < hips[1] < 4.6
    assert day.nearest_to_leaves("anna") > 0.25 and day.nearest_to_leaves("bo") > 0.25
    assert day.nearest_to_each_other("anna", "bo") > 0.2


def test_two_change_places_and_neither_waits_for_ever(play) -> None:
    day = play(ACTIVITIES, {"anna": [(0, "Relax"), (30, "Toilet"), (60, "Relax")],
                            "bo": [(0, "Toilet"), (30, "Relax"), (60, "Toilet")]})  # fmt: skip
    apart(day)
    assert day.told("anna") == [("Relax", "Sofa"), ("Toilet", "Washbasin"), ("Relax", "Sofa")]
    assert [name for name, _ in day.told("bo")] == ["Toilet", "Relax", "Toilet"]
    assert stays(day, "bo", "Sofa") and stays(day, "anna", "Toilet")


def test_who_never_gets_the_place_gives_up_when_the_activity_ends(play) -> None:
    day = play(ACTIVITIES, {"anna": [(0, "Toilet"), (120, "Relax")],
                            "bo": [(0, "East"), (30, "Wash"), (40, "Cook")]})  # fmt: skip
    apart(day)
    assert not stays(day, "bo", "Washbasin")
    wash = day.acted.activities[2]
    assert (wash.person, wash.activity, wash.place) == ("bo", "Wash", "")
    assert 40 * 60 <= wash.end < 41 * 60
    assert stays(day, "bo", "Stove")


def test_who_gave_up_and_leaves_the_home_is_away(play) -> None:
    """Bo, who wanted a thing that anna holds, has nothing to return."""
    bo = [(0, "East"), (30, "Wash"), (40, "Away"), (200, "Cook")]
    day = play(ACTIVITIES, {"anna": [(0, "Toilet"), (120, "Relax")], "bo": bo})
    (away,) = (s for s in day.acted.where if s.person == "bo" and s.posture == "away")
    assert 40 * 60 < away.start < 45 * 60 and 200 * 60 <= away.end < 201 * 60
    assert not day.seen("bo", np.array([100.0 * 60])).any()
    assert stays(day, "bo", "Stove")


def test_a_leaf_waits_until_nobody_stands_where_it_goes(play) -> None:
    """The bedroom's door opens to where anna stands until the 40th minute."""
    day = play(ACTIVITIES, {"anna": [(0, "Block"), (40, "Cook")],
                            "bo": [(0, "Relax"), (30, "Sleep")]})  # fmt: skip
    opened = day.acted.swings["Door bedroom"]
    assert opened[0].start > 40 * 60 and opened[0].person == "anna"
    assert day.nearest_to_leaves("anna") > 0.25
    assert stays(day, "bo", "Bed")[0].posture in ("standing", "sitting", "lying")


@pytest.mark.parametrize("seed", mostly_slow(range(2)))
def test_a_busy_day_of_three_ends(play, seed: int) -> None:
    rng = np.random.default_rng(seed)
    names = ["Sleep", "Toilet", "Relax", "East", "Cook", "Look", "Corner", "Block", "Wash", "Away"]
    plans = {
        person: [(float(at), str(rng.choice(names))) for at in np.sort(rng.uniform(0, 600, 40))]
        for person in ("anna", "bo", "cleo")
    }
    for plan in plans.values():
        plan[0] = 0.0, plan[0][1]
    day = play(ACTIVITIES, plans)
    apart(day)
    for person in plans:
        mine = [s for s in day.acted.where if s.person == person]
        assert mine[0].start == 0.0 and mine[-1].end == DAY
        assert all(a.end == b.start for a, b in pairwise(mine))
        assert day.nearest_to_leaves(person) > 0.12
        # Nobody is late for long.
        first = [d for d in day.acted.activities if d.person == person]
        assert len(first) > 25


def test_who_is_elsewhere_changes_nothing(play) -> None:
    plan = [(0, "Relax"), (60, "Toilet"), (70, "Relax"), (200, "Sleep")]
    alone = play(ACTIVITIES, {"anna": plan})
    day = play(ACTIVITIES, {"anna": plan, "bo": [(0, "Away")]})
    assert [s for s in day.acted.where if s.person == "anna"] == alone.acted.where
    times = np.arange(0.0, DAY, 61.7)
    assert np.array_equal(day.at("anna", *times), alone.at("anna", *times))


def test_a_cat_walks_sits_and_lies_where_doors_stand_open(play) -> None:
    text = """
Nap = lie Sofa while turn over every 20 min
Eat = use Window 30 s
Bedroom = lie Bed
Open = open Door bedroom, stand at Corner
Shut = close Door bedroom, sit Sofa east
"""
    naps = [(0, "Nap"), (60, "Eat"), (90, "Bedroom"), (300, "Nap"), (400, "Eat")]
    day = play(text, {"anna": [(0, "Shut"), (100, "Open"), (200, "Shut")], "cat": naps})
    assert day.told("cat")[:4] == [("Nap", "Sofa"), ("Eat", "Window"), ("Bedroom", "Bed"),
                                   ("Nap", "Bed")]  # fmt: skip
    # The bedroom was shut until the 100th minute, and again from the 200th on.
    lies = stays(day, "cat", "Bed")
    assert 100 * 60 < lies[0].start < 102 * 60 and lies[0].posture != "away"
    hips = day.at("cat", 50.0 * 60, 65.0 * 60, 150.0 * 60)
    assert hips[0][2] > 0.45 and hips[1][2] < 0.35 and hips[2][2] > 0.5
    steps = np.diff(day.at("cat", *np.arange(3600.0, 3640.0, 0.1)), axis=0)
    assert np.hypot(*steps[:, :2].T).max() < 0.12
    assert {swing.person for swing in day.acted.swings["Door bedroom"]} == {"anna"}
    with pytest.raises(
        InputError, match="open Drawer: a cat cannot do this; its steps are go, lie"
    ):
        play("Steal = open Drawer", {"cat": [(0, "Steal")]})


SIZE = 0.05
ENDS = "West = stand at West\nEast = stand at East"
# In the third the two places are the passage's ends; in the last a room is behind a door.
ROOMS = {
    "rooms at both ends": [(0.0, 0.0, 2.0, 2.0), (7.0, 0.0, 9.0, 2.0)],
    "a room at one end": [(0.0, 0.0, 2.0, 2.0)],
    "none": [],
    "a closet with a door": [(4.0, 1.4, 6.0, 3.0)],
}


PLANS = {"anna": [(0, "West"), (10, "East")], "bo": [(0, "East"), (10, "West")]}


@pytest.fixture
def passage(home: Places):
    def made(rooms: str) -> Places:
        low, free = np.array([-0.5, -0.5]), np.zeros((200, 80), bool)
        boxes = [*ROOMS[rooms], (1.0, 0.7, 8.0, 1.3)]
        if "door" in rooms:
            boxes.append((4.5, 1.3, 5.3, 1.4))
        for box in boxes:
            i, j, k, m = (round((v + 0.5) / SIZE) for v in box)
            free[i:k, j:m] = True
        storey = Storey(0.0, Floor(low, SIZE, free), np.zeros(free.shape, np.int64))
        east = 8.4 if "both" in rooms else 7.7
        places = {
            name: Place(name, STAND, np.array([x, 1.0, 0.0]), 0.0, np.array([x, 1.0, 0.0]))
            for name, x in (("West", 0.6 if "room" in rooms else 1.3), ("East", east))
        }
        door = replace(home.doors["Door bathroom"], hinge=np.array([4.5, 1.4, 0.0]))
        return Places(places, {door.name: door} if "door" in rooms else {}, {}, (storey,))

    return made


@pytest.mark.parametrize("rooms", list(ROOMS)[:2] + list(ROOMS)[3:])
def test_one_goes_back_to_where_there_is_room(play, passage, rooms: str) -> None:
    day = play(ENDS, PLANS, places=passage(rooms))
    assert day.nearest_to_each_other("anna", "bo") > 0.35
    for person, place in (("anna", "East"), ("bo", "West")):
        last = [stay for stay in day.acted.where if stay.person == person][-1]
        assert (last.place, last.posture) == (place, STANDING)
        assert last.start < 600 + 120


def test_where_there_is_none_one_line_says_so(play, passage) -> None:
    told = r"line \d+: stand at \w+: '\w+' and '\w+' meet where they cannot pass each other, and"
    with pytest.raises(InputError, match=told):
        play(ENDS, PLANS, places=passage("none"))


def for_two(places: Places, name: str, apart: float) -> Places:
    """Return the places, with a bed or seat that has two sides, `apart` m from each other."""
    one = places.places[name]
    ahead = np.array([-np.sin(one.yaw), np.cos(one.yaw), 0.0]) * apart / 2
    sides = tuple(
        replace(
            one, target=one.target + k * ahead, at=one.at + k * ahead * np.array([1, 1, 0]), side=n
        )
        for n, k in enumerate((1, -1), start=1)
    )
    return replace(places, places={**places.places, name: replace(one, sides=sides)})


COUPLE = {"anna": [(0, "Corner"), (60, "Rest"), (400, "Cook")],
          "bo": [(0, "East"), (70, "Rest"), (420, "East")]}  # fmt: skip


@pytest.mark.parametrize(("steps", "posture"), [("lie Bed", "lying"), ("sit Sofa", "sitting")])
def test_a_couple_shares_a_bed_or_sofa_for_two(play, home, steps, posture) -> None:
    places = for_two(home, steps.split()[1], 0.7)
    day = play(f"{ACTIVITIES}\nRest = {steps}", COUPLE, places=places)
    place = steps.split()[1]
    rests = [s for s in day.acted.where if (s.place, s.posture) == (place, posture)]
    rests = [s for s in rests if s.end - s.start > 3600 * 4]
    assert {s.person for s in rests} == {"anna", "bo"} and len(rests) == 2
    both = day.at("anna", 200 * 60.0)[0], day.at("bo", 200 * 60.0)[0]
    assert np.hypot(*(both[0] - both[1])[:2]) == pytest.approx(0.7, abs=0.02)
    assert not [wait for wait in day.acted.waits if wait.is_long]


@pytest.mark.parametrize("steps", ["lie Bed", "sit Toilet", "sit Sofa"])
def test_who_waits_for_a_place_for_one_is_told(play, steps) -> None:
    day = play(f"{ACTIVITIES}\nRest = {steps}", COUPLE)
    (wait,) = (wait for wait in day.acted.waits if wait.is_long)
    assert (wait.person, wait.other, wait.place) == ("bo", "anna", steps.split()[1])
    assert wait.text.startswith(
        f"'bo' waits 5.5 h from 01:10 for '{wait.place}', which 'anna' uses"
    )


def test_who_waits_all_day_is_told_once(play) -> None:
    day = play(
        f"{ACTIVITIES}\nRest = lie Bed", {"anna": [(0, "Rest")], "bo": [(0, "East"), (70, "Rest")]}
    )
    (wait,) = day.acted.waits
    assert (wait.person, wait.came) == ("bo", False) and wait.end == DAY


def test_one_person_alone_uses_the_middle_and_a_third_waits(play, home) -> None:
    places = for_two(home, "Bed", 0.7)
    alone = play(f"{ACTIVITIES}\nRest = lie Bed", {"anna": COUPLE["anna"]}, places=places)
    assert alone.at("anna", 200 * 60.0)[0][:2] == pytest.approx(
        home.places["Bed"].target[:2], abs=0.05
    )
    three = COUPLE | {"cleo": [(0, "Relax"), (80, "Rest"), (500, "Relax")]}
    day = play(f"{ACTIVITIES}\nRest = lie Bed", three, places=places)
    (wait,) = (wait for wait in day.acted.waits if wait.is_long)
    assert (wait.person, wait.came) == ("cleo", True)


def test_both_rest_at_midnight_already(play, home) -> None:
    places = for_two(home, "Bed", 0.7)
    plan = {"anna": [(0, "Rest"), (400, "Cook")], "bo": [(0, "Rest"), (420, "East")]}
    day = play(f"{ACTIVITIES}\nRest = lie Bed", plan, places=places)
    assert {s.person for s in day.acted.where if s.posture == "lying" and s.start < 120.0} == {
        "anna",
        "bo",
    }
