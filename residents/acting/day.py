# SPDX-License-Identifier: GPL-3.0-or-later
"""One day of a home: from who does what when to what everybody does with body and hands.

A day depends on no other: it begins with what was under way at midnight, acted from its own start,
and with whatever the steps before that left switched on, open or put somewhere.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from ...angen_addon.progress import Shares, finished
from ...sensor_logic.error import InputError
from ...sensor_logic.toml_table import suggestion
from ..body.skeleton import Build
from ..routine.routine import DAY, Routine, Segment
from ..routine.timetable import OTHER, Draws, Stream
from .ground import Ground
from .home import HomeInUse
from .living import Living
from .places import Places
from .timeline import AWAY, STANDING, Acted, ActedActivity, Stay
from .words import Deeds, check_body, read_activities

# How long somebody goes on after midnight with what was begun before, s.
AFTER = 60.0
T = TypeVar("T", ActedActivity, Stay)


def act(
    segments: Sequence[Segment],
    routine: Routine,
    places: Places,
    residents: Mapping[str, Build],
    draws: Draws,
    day: int,
    ground: Ground | None = None,
) -> Acted:
    """What happens on a day, counted from 0, as `acting` does it in steps."""
    return finished(acting(segments, routine, places, residents, draws, day, ground))


def acting(
    segments: Sequence[Segment],
    routine: Routine,
    places: Places,
    residents: Mapping[str, Build],
    draws: Draws,
    day: int,
    ground: Ground | None = None,
) -> Shares[Acted]:
    """What happens on a day, counted from 0. `segments` are all that is known, in s since midnight
    of day 0, whose date the `draws` have; `residents` the bodies by the names of the persons. With
    the `ground` of an earlier day, ways that were found need not be found again; it changes nothing
    else. Raises InputError where something cannot be done."""
    activities = read_activities(routine, places)
    _check_known(segments, activities, residents, places)
    home = HomeInUse(places, ground or Ground(places))
    plans = {person: _plan(segments, person, day, draws) for person in residents}
    _begin_home(home, segments, activities, plans, day)
    left = home.as_left()
    people: list[Living] = []
    for person, build in residents.items():
        begun = min((s.start for s, _ in plans[person]), default=0.0)
        living = Living(person, build, home, begun, activities)
        _begin(living, segments, day)
        home.people.append(living)
        people.append(living)
    first = min((living.now for living in people), default=0.0)
    yield from _together([(living, plans[living.name]) for living in people])
    home.begins(left, first)
    return _acted(home, people)


def _check_known(
    segments: Sequence[Segment],
    activities: Mapping[str, Deeds],
    residents: Mapping[str, Build],
    places: Places,
) -> None:
    for segment in {(s.person, s.activity): s for s in segments}.values():
        name, told = segment.activity, f"{segment.where}: " if segment.where else ""
        if name not in activities and name != OTHER:
            raise InputError(
                f"{told}{segment.person!r} does {name!r}, which is no activity of the routine; "
                f"add a table [activity.{name}], or {suggestion(name, activities)}"
            )
        if segment.person not in residents:
            raise InputError(
                f"{told}{segment.person!r} is no person of the routine; "
                f"{suggestion(segment.person, residents)}"
            )
        deeds = activities.get(name)
        if deeds is None:
            continue
        for step in deeds.all_steps:
            check_body(step, places, residents[segment.person].is_cat)
            if step.word == "leave" and not places.entrances:
                raise step.error("the home has no way out; mark its door as an entrance")


def _plan(
    segments: Sequence[Segment], person: str, day: int, draws: Draws
) -> list[tuple[Segment, Stream]]:
    """A person's segments of a day, from the one that is under way at midnight, in s of the day."""
    mine = [s for s in segments if s.person == person]
    inside = [s for s in mine if s.end > day * DAY and s.start < (day + 1) * DAY]
    found = []
    for segment in inside:
        since = int(segment.start // DAY)
        purpose = f"acting {segment.start - since * DAY:.3f}"
        moved = replace(segment, start=segment.start - day * DAY, end=segment.end - day * DAY)
        found.append((moved, draws.stream(person, since, purpose)))
    return found


# --- how a day begins ---------------------------------------------------------------------------
def _before(segments: Sequence[Segment], person: str, day: int) -> list[Segment]:
    """The person's segments that have ended by the midnight before the day."""
    return [s for s in segments if s.person == person and s.end <= day * DAY]


def _begin_home(
    home: HomeInUse,
    segments: Sequence[Segment],
    activities: Mapping[str, Deeds],
    plans: Mapping[str, list[tuple[Segment, Stream]]],
    day: int,
) -> None:
    """Sets the home as earlier steps left it: lamps, doors, things."""
    earlier = [s for person in plans for s in _before(segments, person, day)]
    for segment in sorted(earlier, key=lambda s: (s.start, s.person)):
        deeds = activities.get(segment.activity)
        for step in deeds.steps if deeds is not None else ():
            if step.word == "switch":
                home.lamps[home.places.lamps[step.name].object] = step.on
            elif step.word in ("open", "close"):
                door = home.places.doors[step.name]
                home.openings[door.name] = door.open if step.word == "open" else door.closed
            elif step.word == "put":
                home.things[step.name] = step.at


def _begin(living: Living, segments: Sequence[Segment], day: int) -> None:
    """Puts a person where the steps before the first segment of the day end. Where none of them
    ends at a place, the person is where the first steps of all end or, if they end nowhere, stands
    at the first place that they name, because others need not have a way to it."""
    mine = [s for s in segments if s.person == living.name]
    count = len(_before(segments, living.name, day))
    known = living.home.places.places
    for number, segment in enumerate([*mine[:count][::-1], *mine[count:]]):
        deeds = living.activities.get(segment.activity)
        if deeds is None:
            continue
        if deeds.posture == AWAY:
            living.begin_away()
            return
        place, posture = known.get(deeds.place or ""), deeds.posture
        if place is None and number >= count:
            named = (known[step.name] for step in deeds.all_steps if step.name in known)
            place, posture = next(named, None), STANDING
        if place is not None and living.home.is_free(living.key(place), living):
            living.begin_at(place, posture or STANDING)
            return
    for place in known.values():
        if living.home.is_free(living.key(place), living):
            living.begin_at(place, STANDING)
            return
    raise InputError(f"there is no place for {living.name!r} to be at midnight; mark another")


# --- all together -------------------------------------------------------------------------------
def _together(people: list[tuple[Living, list[tuple[Segment, Stream]]]]) -> Shares[None]:
    """Whoever is earliest goes on; of several the first in the list."""
    lives = [living.live(plan) for living, plan in people]
    queue = [(living.now, number) for number, (living, _) in enumerate(people)]
    heapq.heapify(queue)
    while queue:
        now, number = heapq.heappop(queue)
        yield min(max(now / DAY, 0.0), 1.0)
        try:
            # What is under way at midnight is still done.
            if now < DAY + AFTER:
                next(lives[number])
                heapq.heappush(queue, (people[number][0].now, number))
        except StopIteration:
            continue
    for living, _ in people:
        living.end()


def _acted(home: HomeInUse, people: list[Living]) -> Acted:
    stays = [stay for living in people for stay in living.stays]
    done = [
        _placed(one, stays, living.activities.get(one.activity))
        for living in people
        for one in living.done
    ]
    for swings in home.swings.values():
        swings.sort(key=lambda swung: swung.start)
    for holds in home.holds.values():
        holds.sort(key=lambda hold: hold.start)
    return Acted(
        {living.name: living.line for living in people},
        home.swings,
        sorted(home.switches, key=lambda switch: switch.time),
        home.holds,
        sorted(_of_day(done), key=lambda one: (one.start, one.person)),
        sorted(_of_day(stays), key=lambda one: (one.start, one.person)),
        home.sips,
    )


def _of_day(found: list[T]) -> list[T]:
    inside = [one for one in found if one.end > 0.0 and one.start < DAY]
    return [replace(one, start=max(one.start, 0.0), end=min(one.end, DAY)) for one in inside]


def _placed(done: ActedActivity, stays: list[Stay], deeds: Deeds | None) -> ActedActivity:
    """The activity with its place: of the places that its steps name the one where it was done
    longest, or of all places if it was done at none of those."""
    lasting: dict[str, float] = {}
    for stay in stays:
        both = min(stay.end, done.end) - max(stay.start, done.start)
        if stay.person == done.person and (stay.place or stay.posture == AWAY) and both > 0:
            lasting[stay.place] = lasting.get(stay.place, 0.0) + both
    own = {place: t for place, t in lasting.items() if deeds is not None and place in deeds.places}
    lasting = own or lasting
    return replace(done, place=max(lasting, key=lambda place: lasting[place], default=""))
