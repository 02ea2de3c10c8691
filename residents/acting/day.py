# SPDX-License-Identifier: GPL-3.0-or-later
"""Act out one day: turn the segments of a routine into motion of bodies, doors and objects.

A segment is what a person does from one time to another. A day can be acted without acting the days
before it. It begins with the activity that is under way at midnight, acted from that activity's
start. Steps before that only set lamps, doors and carried objects.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.toml_table import suggestion
from ...sensor_logic.progress import Doing, Work, finished
from ..body.skeleton import Build
from ..routine.routine import DAY, NEW_DAY, Routine, Segment
from ..routine.timetable import OTHER, Draws, Stream
from .activity_steps import ActivitySteps, DrawnSteps, check_can_do, read_activities
from .floor_map import FloorMap
from .home_in_use import HomeInUse
from .performer import Performer, PlannedActivity
from .places import Places
from .timeline import AWAY, LYING, SITTING, STANDING, Acted, ActedActivity, Stay, Use, Wait

# How long the activity at the end of the day is acted past midnight, s.
AFTER = 60.0
T = TypeVar("T", ActedActivity, Stay, Wait)


def act(
    segments: Sequence[Segment],
    routine: Routine,
    places: Places,
    residents: Mapping[str, Build],
    draws: Draws,
    day: int,
    floor_map: FloorMap | None = None,
) -> Acted:
    """Act out the day with the number `day`; see `acting` for the parameters."""
    return finished(acting(segments, routine, places, residents, draws, day, floor_map))


def acting(
    segments: Sequence[Segment],
    routine: Routine,
    places: Places,
    residents: Mapping[str, Build],
    draws: Draws,
    day: int,
    floor_map: FloorMap | None = None,
) -> Work[Acted]:
    """Act out the day with the number `day`, and yield the progress.

    Parameters
    ----------
    segments : sequence of Segment
        What all persons do on all days, in s since midnight of day 0.
    routine : Routine
        The activities and persons.
    places : Places
        The marked places, doors and lamps of the home.
    residents : mapping of str to Build
        The bodies, by the names of the persons.
    draws : Draws
        The random numbers, with the date of day 0.
    day : int
        The number of the day to act, from 0.
    floor_map : FloorMap, optional
        The floors from an earlier call, with their cached paths.

    Yields
    ------
    float
        The progress, 0 to 1.

    Returns
    -------
    Acted
        The acted day.

    Raises
    ------
    InputError
        If a step cannot be performed in this home.
    """
    activities = read_activities(routine, places)
    _check_segments(segments, activities, residents, places)
    users = _users_of_places(segments, routine, activities, residents)
    home = HomeInUse(places, floor_map or FloorMap(places), users=users)
    plans = {person: _plan_of_day(segments, person, activities, day, draws) for person in residents}
    _restore_home(home, segments, activities, residents, draws, day)
    initial = home.state()
    people: list[Performer] = []
    for person, build in residents.items():
        begun = min((planned.segment.start for planned in plans[person]), default=0.0)
        performer = Performer(person, build, home, begun, activities)
        _put_at_start(performer, segments, draws, day)
        home.traffic.people.append(performer.actor)
        people.append(performer)
    first = min((performer.actor.now for performer in people), default=0.0)
    yield from _run_all([(performer, plans[performer.actor.name]) for performer in people])
    home.record_initial_state(initial, first)
    return _collect_acted(home, people)


def _check_segments(
    segments: Sequence[Segment],
    activities: Mapping[str, ActivitySteps],
    residents: Mapping[str, Build],
    places: Places,
) -> None:
    """Raise `InputError` for an unknown activity or person, or for a step that is impossible."""
    for segment in {(s.person, s.activity): s for s in segments}.values():
        name, prefix = segment.activity, f"{segment.where}: " if segment.where else ""
        if name not in activities and name != OTHER:
            raise InputError(
                f"{prefix}{segment.person!r} does {name!r}, which is not an activity of the "
                f"routine; add a table [activity.{name}], or {suggestion(name, activities)}"
            )
        if segment.person not in residents:
            raise InputError(
                f"{prefix}{segment.person!r} is not a person of the routine; "
                f"{suggestion(segment.person, residents)}"
            )
        activity_steps = activities.get(name)
        if activity_steps is None:
            continue
        for step in activity_steps.all_steps:
            check_can_do(step, places, residents[segment.person].is_cat)
            if step.word == "leave" and not places.entrances:
                raise step.error("the home has no entrance: mark its front door as Entrance")


def _users_of_places(
    segments: Sequence[Segment],
    routine: Routine,
    activities: Mapping[str, ActivitySteps],
    residents: Mapping[str, Build],
) -> dict[str, list[str]]:
    """Return the persons who use each place in any activity of the routine, by the place's name.

    Cats are left out. The result is the same for each part of a run.
    """
    done = {(s.person, s.activity) for s in segments} | set(routine.done())
    found: dict[str, list[str]] = {}
    for person, build in residents.items():
        mine = [activities[a] for who, a in done if who == person and a in activities]
        for name in sorted(set().union(*(one.places for one in mine))):
            if not build.is_cat:
                found.setdefault(name, []).append(person)
    return found


def _plan_of_day(
    segments: Sequence[Segment],
    person: str,
    activities: Mapping[str, ActivitySteps],
    day: int,
    draws: Draws,
) -> list[PlannedActivity]:
    """Return what a person does on a day, in s since its midnight."""
    mine = [s for s in segments if s.person == person]
    inside = [s for s in mine if s.end > day * DAY and s.start < (day + 1) * DAY]
    found = []
    for segment in inside:
        since = int(segment.start // DAY)
        at = f"{segment.start - since * DAY:.3f}"
        moved = replace(segment, start=segment.start - day * DAY, end=segment.end - day * DAY)
        acting, durations, rests = (
            draws.stream(person, since, f"{what} {at}") for what in ("acting", "durations", "rests")
        )
        drawn = _draw_steps(segment, activities, draws)
        found.append(PlannedActivity(moved, acting, durations, rests, drawn))
    return found


def _draw_steps(
    segment: Segment, activities: Mapping[str, ActivitySteps], draws: Draws
) -> DrawnSteps | None:
    """Return what is done in a segment, or None for an activity without steps."""
    activity_steps, start = activities.get(segment.activity), segment.start
    if activity_steps is None:
        return None

    def stream(group: str, daily: bool) -> Stream:
        if daily:
            day, purpose = (start - NEW_DAY) // DAY, f"alternative {segment.activity} {group}"
        else:
            day, purpose = start // DAY, f"steps {start % DAY:.3f} {group}"
        return draws.stream(segment.person, int(day), purpose)

    return activity_steps.draw(stream)


# The start of a day.


def _earlier_segments(segments: Sequence[Segment], person: str, day: int) -> list[Segment]:
    return [s for s in segments if s.person == person and s.end <= day * DAY]


def _restore_home(
    home: HomeInUse,
    segments: Sequence[Segment],
    activities: Mapping[str, ActivitySteps],
    persons: Iterable[str],
    draws: Draws,
    day: int,
) -> None:
    """Set lamps, doors and carried objects to the state after all steps of earlier days."""
    earlier = [s for person in persons for s in _earlier_segments(segments, person, day)]
    for segment in sorted(earlier, key=lambda s: (s.start, s.person)):
        drawn = _draw_steps(segment, activities, draws)
        for step in drawn.all_steps if drawn is not None else ():
            if step.word == "switch":
                home.lamps[home.places.lamps[step.name].object] = step.on
            elif step.word in ("open", "close"):
                door = home.places.doors[step.name]
                is_left_open = step.word == "open" and step.lasts is None
                home.openings[door.name] = door.open if is_left_open else door.closed
            elif step.word == "put":
                home.things[step.name] = step.at


def _put_at_start(
    performer: Performer, segments: Sequence[Segment], draws: Draws, day: int
) -> None:
    """Put a person where the last segment before the day ends.

    If no earlier segment ends at a place, use the first later one that does. Without such a
    segment, the person stands at the first free place that a step names.
    """
    mine = [s for s in segments if s.person == performer.actor.name]
    count = len(_earlier_segments(segments, performer.actor.name, day))
    known = performer.home.places.places
    for number, segment in enumerate([*mine[:count][::-1], *mine[count:]]):
        drawn = _draw_steps(segment, performer.activities, draws)
        if drawn is None:
            continue
        if drawn.posture == AWAY:
            performer.start_away()
            return
        place, posture = known.get(drawn.place or ""), drawn.posture
        if place is None and number >= count:
            later = performer.activities[segment.activity].all_steps
            named = (known[step.name] for step in later if step.name in known)
            place, posture = next(named, None), STANDING
        if place is not None and performer.is_free(place):
            performer.start_at(place, posture or STANDING)
            return
    for place in known.values():
        if performer.is_free(place):
            performer.start_at(place, STANDING)
            return
    raise InputError(
        f"no marked place is free for {performer.actor.name!r} at midnight; mark one more "
        "place, such as a bed"
    )


# All persons together.


def _run_all(people: list[tuple[Performer, list[PlannedActivity]]]) -> Work[None]:
    """Advance the persons until all have ended, always the one whose time is earliest.

    Of persons with the same time, the first in the list is advanced. Yield the progress, 0 to 1.
    """
    lives = [performer.live(plan) for performer, plan in people]
    queue = [(performer.actor.now, number) for number, (performer, _) in enumerate(people)]
    heapq.heapify(queue)
    while queue:
        now, number = heapq.heappop(queue)
        yield Doing(min(max(now / DAY, 0.0), 1.0))
        try:
            # The activity under way at midnight goes on for a while.
            if now < DAY + AFTER:
                next(lives[number])
                heapq.heappush(queue, (people[number][0].actor.now, number))
        except StopIteration:
            continue
    for performer, _ in people:
        performer.end()


def _collect_acted(home: HomeInUse, people: list[Performer]) -> Acted:
    """Return the motion of all persons, the changes of the home, and what was done."""
    stays = [stay for performer in people for stay in performer.actor.stays]
    done = [
        _with_main_place(one, stays, performer.activities.get(one.activity))
        for performer in people
        for one in performer.done
    ]
    for swings in home.swings.values():
        swings.sort(key=lambda swing: swing.start)
    for holds in home.holds.values():
        holds.sort(key=lambda hold: hold.start)
    return Acted(
        {performer.actor.name: performer.actor.body.timeline for performer in people},
        home.swings,
        sorted(home.switches, key=lambda switch: switch.time),
        home.holds,
        sorted(_cut_to_day(done), key=lambda one: (one.start, one.person)),
        sorted(_cut_to_day(stays), key=lambda one: (one.start, one.person)),
        home.sips,
        sorted(_cut_to_day(home.waits), key=lambda one: (one.start, one.person)),
        sorted([*home.uses, *_rests(stays)], key=lambda one: (one.start, one.person)),
    )


def _rests(stays: list[Stay]) -> Iterator[Use]:
    """Yield the times for which persons sat or lay on objects, as uses of these objects."""
    for stay in stays:
        if stay.place and stay.posture in (SITTING, LYING):
            yield Use(stay.start, stay.end, stay.person, stay.place)


def _cut_to_day(entries: list[T]) -> list[T]:
    """Return the entries that overlap the day, cut at both midnights."""
    inside = [one for one in entries if one.end > 0.0 and one.start < DAY]
    return [replace(one, start=max(one.start, 0.0), end=min(one.end, DAY)) for one in inside]


def _with_main_place(
    done: ActedActivity, stays: list[Stay], activity_steps: ActivitySteps | None
) -> ActedActivity:
    """Return the activity with the place at which the person spent most of it.

    Places that the activity's steps name are preferred.
    """
    lasting: dict[str, float] = {}
    for stay in stays:
        both = min(stay.end, done.end) - max(stay.start, done.start)
        if stay.person == done.person and (stay.place or stay.posture == AWAY) and both > 0:
            lasting[stay.place] = lasting.get(stay.place, 0.0) + both
    named = {
        place: t
        for place, t in lasting.items()
        if activity_steps is not None and place in activity_steps.places
    }
    lasting = named or lasting
    return replace(done, place=max(lasting, key=lambda place: lasting[place], default=""))
