# SPDX-License-Identifier: GPL-3.0-or-later
"""Perform the activities of a person's day, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...sensor_logic.model import Array
from ..body.skeleton import Build
from ..routine.routine import DAY, Segment
from ..routine.timetable import Stream
from .activity_steps import POSTURES, USUAL, ActivityStep, ActivitySteps, DrawnSteps, RepeatedSteps
from .actor import LOOK, Actor
from .floor_map import Spot
from .hands import AT_BASIN, AT_COUNTER, AT_DESK, Hands
from .home_in_use import HomeInUse
from .navigator import ActivityAbandoned, Navigator, Process
from .places import TAP, Door, Place
from .timeline import AWAY, LYING, SITTING, STANDING, ActedActivity, Use

# Duration of a step that comes too late, s.
LATE = 5.0
# Pause between two movements of a burst, s, and size of small movements: median and log-normal
# spread. LARGEST limits the size.
PAUSE, SIZE, LARGEST = (1.2, 1.0), (1.3, 0.5), 2.2
# Reach of a standing person's hand, on the floor from the hips, m.
ARM_WAY = 0.85
# The same for a sitting person who takes or puts things, m.
LEANING = 1.2
# Repeated movements earlier than this before midnight are left out, s.
BEFORE = 60.0


@dataclass(frozen=True)
class PlannedActivity:
    """What a person is to do on a day.

    Attributes
    ----------
    segment : Segment
        The activity and its times, s since the day's midnight.
    stream, durations, rests : Stream
        Random numbers for the movements, for how long steps take, and for how somebody rests.
    drawn : DrawnSteps or None
        The drawn steps; None for an activity without steps.
    """

    segment: Segment
    stream: Stream
    durations: Stream
    rests: Stream
    drawn: DrawnSteps | None


class Performer:
    """A person who performs activities during a day.

    Parameters
    ----------
    name : str
        The person's name in the routine.
    build : Build
        The person's build.
    home : HomeInUse
        The home, shared with the other persons.
    now : float
        The time at which the person begins, s since midnight.
    activities : mapping of str to ActivitySteps
        The steps of each activity, by its name.
    """

    def __init__(
        self,
        name: str,
        build: Build,
        home: HomeInUse,
        now: float,
        activities: Mapping[str, ActivitySteps],
    ) -> None:
        self.home, self.activities = home, activities
        self.actor = Actor(name, build, home.places.storeys, now)
        self.hands = Hands(self.actor, home)
        self.navigator = Navigator(self.actor, self.hands, home)
        self.done: list[ActedActivity] = []
        # The present activity and its start.
        self._current: tuple[str, float] | None = None
        self._durations: Stream | None = None  # the random numbers of its steps' durations
        self._exit: Door | None = None  # the door by which the person left

    def start_at(self, place: Place, posture: str) -> None:
        """Put the person at a place in a posture, and reserve the place."""
        place = self.home.place_for(place, self.actor.name)
        self.navigator.reserve(place)
        self.actor.put_at_place(place, posture, self.home.floor_map.floor(place.storey, {}))

    def start_away(self) -> None:
        """Put the person outside the home, in front of its first entrance."""
        door = self.home.places.entrances[0]
        spot, _ = self._spot_outside(door)
        self.actor.put_away(spot.at, spot.yaw, door.storey)

    def is_free(self, place: Place) -> bool:
        """Return whether the person can now reserve a place, or the own side of it."""
        return self.navigator.is_free(self.home.place_for(place, self.actor.name))

    # The day.

    def live(self, plan: list[PlannedActivity]) -> Process:
        """Perform the activities of the day, in order."""
        for number, planned in enumerate(plan):
            segment = planned.segment
            if number and segment.end <= self.actor.now + LATE:
                continue
            self.actor.stay_until(segment.start)
            yield
            if self.actor.now >= DAY:
                break
            self._begin_activity(segment.activity)
            self.navigator.deadline, self._durations = segment.end, planned.durations
            try:
                if planned.drawn is not None:
                    yield from self._perform(planned.drawn, planned)
            except ActivityAbandoned:
                self.navigator.abandon()
            self.actor.stay_until(segment.end)
            yield

    def end(self) -> None:
        """End the last activity and the day."""
        self.navigator.end_wait(came=False)
        self._end_activity()
        self.hands.empty()
        self.actor.end_stay()
        # Gestures apply in order: a carrying hand must be posed before it reaches.
        self.actor.body.timeline.gestures.sort(key=lambda gesture: gesture.start)

    def _begin_activity(self, activity: str) -> None:
        if self._current is None or self._current[0] != activity:
            self._end_activity()
            self._current = activity, self.actor.now

    def _end_activity(self) -> None:
        if self._current is not None and self.actor.now > self._current[1]:
            activity, start = self._current
            self.done.append(ActedActivity(start, self.actor.now, self.actor.name, activity, ""))

    def _perform(self, drawn: DrawnSteps, planned: PlannedActivity) -> Process:
        """Perform the steps of an activity; a person who is away comes home first."""
        if self.actor.posture == AWAY:
            if drawn.posture == AWAY and len(drawn.steps) == 1:
                return
            all_steps = self.activities[planned.segment.activity].all_steps
            yield from self._come_in((*drawn.steps, *all_steps)[0])
        for number, step in enumerate(drawn.steps):
            last = number == len(drawn.steps) - 1
            yield from self._perform_step(step, last, planned.stream)
            yield
        yield from self._perform_later(drawn, planned)

    def _perform_later(self, drawn: DrawnSteps, planned: PlannedActivity) -> Process:
        """Perform what an activity has at certain times and again and again, until it ends."""
        segment, activity_steps = planned.segment, self.activities[planned.segment.activity]
        meanwhile = [(one, planned.stream) for one in activity_steps.meanwhile]
        meanwhile += [(one, planned.rests) for one in activity_steps.rests(drawn.posture)]
        times = []
        for number, (one, stream) in enumerate(meanwhile):
            rest = one.every * one.burst
            # The activity can begin in the middle of a rest.
            time = segment.start + stream.uniform() * stream.log_normal(rest, one.varies)
            while time < segment.end:
                times.append((time, number))
                time += stream.log_normal(rest, one.varies)
        for number, (part, _) in enumerate(drawn.timed, len(meanwhile)):
            times.append((segment.start + part * (segment.end - segment.start), number))
        settled = next((s for s in reversed(drawn.steps) if s.word in POSTURES), None)
        for time, number in sorted(times):
            repeated = number < len(meanwhile)
            if self.actor.posture == AWAY or (
                time < max(self.actor.now, -BEFORE) if repeated else self._is_over
            ):
                continue
            if time > DAY:
                break
            self.actor.stay_until(time)
            yield
            posture, place = self.actor.posture, self.actor.place
            if repeated:
                yield from self._burst(*meanwhile[number])
            else:
                for step in drawn.timed[number - len(meanwhile)][1]:
                    yield from self._perform_step(step, False, planned.stream)
                    yield
            if settled is not None and (posture, place) != (self.actor.posture, self.actor.place):
                yield from self._perform_step(settled, True, planned.stream)

    @property
    def _is_over(self) -> bool:
        """Whether the time of the present activity is over."""
        return self.actor.now >= self.navigator.deadline

    def _burst(self, repeated: RepeatedSteps, stream: Stream) -> Process:
        for number in range(stream.geometric(repeated.burst)):
            if number:
                self.actor.stay_until(self.actor.now + stream.log_normal(*PAUSE))
                yield
            if self._is_over:
                return
            step = repeated.steps[stream.weighted_choice([1.0] * len(repeated.steps))]
            yield from self._perform_step(step, False, stream)

    # Steps.

    def _perform_step(self, step: ActivityStep, last: bool, stream: Stream) -> Process:
        """Perform one step of an activity; `last` says whether no further step follows."""
        if step.word in ("go", "stand at", "use", "sit", "lie"):
            place = self.home.place_for(self.home.places.places[step.name], self.actor.name)
            yield from self._take_posture(step, place)
            lasts = step.lasts
            if lasts is None:
                lasts = 0.0 if last or step.word == "go" else USUAL
            lasts = self._drawn_duration(step, lasts)
            if step.word == "use":
                work = AT_BASIN if place.use == TAP else AT_COUNTER
                self.hands.work(place.target, lasts, stream, work)
                use = Use(self.actor.now - lasts, self.actor.now, self.actor.name, place.name)
                self.home.uses.append(use)
            else:
                self.actor.stay_until(self.actor.now + lasts)
        elif step.word == "leave":
            yield from self._leave(step)
        elif step.word in ("open", "close"):
            yield from self._open_or_close(step, stream)
        elif step.word == "switch":
            yield from self._switch(step)
        elif step.word in ("take", "put"):
            yield from self._carry(step)
        elif step.word == "drink":
            yield from self._drink(step)
        else:
            self._move_a_little(step, stream)

    def _drawn_duration(self, step: ActivityStep, median: float) -> float:
        """Draw how long a step takes, s, but not longer than its activity."""
        if step.varies is not None and median and self._durations is not None:
            median = self._durations.log_normal(median, step.varies)
        return self._cut_to_activity(median)

    def _cut_to_activity(self, seconds: float) -> float:
        """Return a duration, or the time until the activity ends if that is shorter, s."""
        return min(seconds, max(self.navigator.deadline - self.actor.now, LATE))

    def _move_a_little(self, step: ActivityStep, stream: Stream) -> None:
        """Perform a step that needs no walking: a small movement, a touch or a wait."""
        if step.word == "wait":
            self.actor.stay_until(self.actor.now + self._drawn_duration(step, step.lasts or 0.0))
        elif step.word == "turn over":
            seated = self.actor.seated
            now = 0 if seated is None else seated.side
            others = [side for side in (0, 1, -1) if side != now]
            self.actor.turn_over(others[stream.weighted_choice([1, 1])])
        elif step.word == "shift":
            self.actor.shift(min(stream.log_normal(*SIZE), LARGEST))
        elif step.word == "look around":
            self.actor.look_around(self._drawn_duration(step, step.lasts or LOOK))
        else:
            self._reach(step, self.home.places.places[step.name].target, stream)

    def _reach(self, step: ActivityStep, point: Array, stream: Stream) -> None:
        """Touch a point (3,), or work there; raise `InputError` if it is too far away."""
        off = self._distance_to(point)
        if off > 2 * ARM_WAY:
            name, place = self.actor.name, self.actor.last_place
            raise step.error(
                f'it is {off:.1f} m away from {name!r} at {place!r}; add a step "go" before it'
            )
        if step.lasts is None:
            self.hands.touch(point)
            return
        work = AT_DESK if self.actor.posture == SITTING else AT_COUNTER
        began = self.actor.now
        self.hands.work(point, self._drawn_duration(step, step.lasts), stream, work)
        self.home.uses.append(Use(began, self.actor.now, self.actor.name, step.name))

    def _take_posture(self, step: ActivityStep, place: Place) -> Process:
        posture = POSTURES[step.word]
        actor = self.actor
        if (actor.place, actor.posture) == (place.name, posture):
            return
        if (actor.place, actor.posture, posture) == (place.name, SITTING, LYING):
            actor.lie(place)
            return
        yield from self.navigator.go_to_place(step, place)
        if posture != STANDING:
            actor.sit(place)
        if posture == LYING:
            actor.stay_until(actor.now + 0.4)
            actor.lie(place)

    def _carry(self, step: ActivityStep) -> Process:
        where = step.at or self.home.things.get(step.name, step.name)
        if step.word == "take" and step.name in self.hands.held:
            return
        if step.word == "put" and step.name not in self.hands.held:
            raise step.error('it is not in the hand; add a step "take" before it')
        if step.word == "take" and len(self.hands.held) == 2:
            raise step.error(
                f"both hands are full: {', '.join(self.hands.held)}; add the step `put` before it"
            )
        place = self.home.places.places[where]
        reach = LEANING if self.actor.posture == SITTING else ARM_WAY
        if self._distance_to(place.target) > reach:
            yield from self.navigator.go_to_place(step, place)
        if step.word == "take":
            self.hands.take(step.name, place.target)
        else:
            self.hands.put(step.name, place)
            self.home.things[step.name] = where

    def _drink(self, step: ActivityStep) -> Process:
        """Drink from a cup; if it is not in the hand, take it first and put it back afterwards."""
        held = step.name in self.hands.held
        if not held:
            yield from self._carry(replace(step, word="take"))
        self.hands.drink(step.name)
        if not held:
            where = self.home.things.get(step.name, step.name)
            yield from self._carry(replace(step, word="put", at=where))

    def _distance_to(self, point: Array) -> float:
        """Return the horizontal distance from the person's hips to a point, m."""
        return float(np.hypot(*(point[:2] - self.actor.body.pose.pelvis[0, :2])))

    def _switch(self, step: ActivityStep) -> Process:
        lamp = self.home.places.lamps[step.name]
        if self.home.lamps.get(lamp.object) is step.on:
            return
        place = self.home.places.places.get(step.name)
        at = self.actor.now
        if place is not None:
            if self._distance_to(lamp.at) > ARM_WAY:
                yield from self.navigator.go_to_place(step, place)
            at = self.hands.touch(lamp.at)
        self.home.record_switch(lamp.object, step.on, at, self.actor.name)

    def _open_or_close(self, step: ActivityStep, stream: Stream) -> Process:
        door = self.home.places.doors[step.name]
        after = door.open if step.word == "open" else door.closed
        if step.lasts is None and abs(self.home.opening(door) - after) < 0.02:
            return
        yield from self.navigator.go_to_leaf(step, door)
        if step.lasts is None:
            self.hands.move_leaf(door, after)
        else:
            self.hands.look_into(door, self._drawn_duration(step, step.lasts), stream)
        self.home.occupy(door, self.actor, self.actor.now)

    # Leaving and coming home.

    def _leave(self, step: ActivityStep) -> Process:
        actor, navigator = self.actor, self.navigator
        if actor.posture == AWAY:
            return
        door, side = navigator.planner.nearest_entrance(step)
        actor.rise()
        spot = navigator.planner.spot_at_door(door, side)
        yield from navigator.fetch_walking_frame()
        yield from navigator.walk_to_point(step, spot.at, spot.yaw, door.storey)
        yield from navigator.pass_door(step, door, side)
        navigator.release_place()
        actor.set_posture(AWAY)
        self._exit = door

    def _come_in(self, step: ActivityStep) -> Process:
        """Come home through the door by which the person left; `step` is what the person then does.

        A person who was away from the start comes in through the first entrance.
        """
        door = self._exit or self.home.places.entrances[0]
        yield from self.navigator.wait_for_door(step, door)
        spot, side = self._spot_outside(door)
        self.actor.put(spot.at, spot.yaw, door.storey)
        self.actor.set_posture(STANDING)
        yield from self.navigator.pass_door(step, door, side)

    def _spot_outside(self, door: Door) -> tuple[Spot, float]:
        """Return where the person stands in front of an entrance, and which side (±1) that is."""
        outside = -self.navigator.planner.inner_side(door)
        return self.navigator.planner.spot_at_door(door, outside), outside
