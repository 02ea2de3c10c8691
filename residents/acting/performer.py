# SPDX-License-Identifier: GPL-3.0-or-later
"""Perform the activities of a person's day, step by step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...sensor_logic.model import Array
from ..body.skeleton import Build
from ..routine.routine import DAY, Segment
from ..routine.timetable import Stream
from .actor import LOOK
from .floor_map import Spot
from .home_in_use import HomeInUse
from .navigator import ActivityAbandoned, Navigator, Process
from .places import Door, Place
from .timeline import AWAY, LYING, SITTING, STANDING, ActedActivity
from .words import POSTURES, ActivityStep, ActivitySteps, RepeatedSteps

# Default duration of a step, and duration of a step that comes too late, s.
USUAL, LATE = 10.0, 5.0
# Pause between two movements of a burst, s, and size of small movements: median and log-normal
# spread. LARGEST limits the size.
PAUSE, SIZE, LARGEST = (1.2, 1.0), (1.3, 0.5), 2.2
# Reach of a standing person's hand, on the floor from the hips, m.
ARM_WAY = 0.85
# The same for a sitting person who takes or puts things, m.
LEANING = 1.2
# Repeated movements earlier than this before midnight are left out, s.
BEFORE = 60.0


class Performer(Navigator):
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
        super().__init__(name, build, home, now)
        self.activities = activities
        self.done: list[ActedActivity] = []
        # The present activity and its start.
        self._current: tuple[str, float] | None = None
        self._out_by: Door | None = None

    def start_at(self, place: Place, posture: str) -> None:
        """Put the person at a place in a posture, and reserve the place."""
        place = self.home.place_for(place, self.name)
        self._key = self.key(place)
        self.home.reserve(self._key, self)
        self.rest_at(place, posture)

    def start_away(self) -> None:
        """Put the person outside the home, in front of its first entrance."""
        door = self.home.places.entrances[0]
        side = self.home.floor_map.inner_side(door, self.radius)
        spot = self.home.floor_map.spot_or_estimate(door, -side, self.radius)
        self.place_at(spot.at, spot.yaw, door.storey)
        self.posture, self.place, self.is_ignored = AWAY, "", True

    # The day.

    def live(self, segments: list[tuple[Segment, Stream]]) -> Process:
        """Perform the segments of the day, in order.

        A segment is what a person does from one time to another, in s since this day's midnight. It
        comes with its random numbers.
        """
        for number, (segment, stream) in enumerate(segments):
            if number and segment.end <= self.now + LATE:
                continue
            self.stay_until(segment.start)
            yield
            if self.now >= DAY:
                break
            self._begin_activity(segment.activity)
            self.until = segment.end
            activity_steps = self.activities.get(segment.activity)
            try:
                if activity_steps is not None:
                    yield from self._perform(activity_steps, segment, stream)
            except ActivityAbandoned:
                self.end_wait(came=False)
                self.abandon()
            self.stay_until(segment.end)
            yield

    def end(self) -> None:
        """End the last activity and the day."""
        self.end_wait(came=False)
        self._end_activity()
        self.finish()

    def _begin_activity(self, activity: str) -> None:
        if self._current is None or self._current[0] != activity:
            self._end_activity()
            self._current = activity, self.now

    def _end_activity(self) -> None:
        if self._current is not None and self.now > self._current[1]:
            activity, start = self._current
            self.done.append(ActedActivity(start, self.now, self.name, activity, ""))

    def _perform(self, activity_steps: ActivitySteps, segment: Segment, stream: Stream) -> Process:
        """Perform the steps of an activity; a person who is away comes home first."""
        self.step = activity_steps.steps[0]
        if self.posture == AWAY:
            if activity_steps.posture == AWAY and len(activity_steps.steps) == 1:
                return
            yield from self._come_in()
        for number, step in enumerate(activity_steps.steps):
            last = number == len(activity_steps.steps) - 1
            yield from self._perform_step(step, last, stream)
            yield
        yield from self._repeat_movements(activity_steps, segment, stream)

    def _repeat_movements(
        self, activity_steps: ActivitySteps, segment: Segment, stream: Stream
    ) -> Process:
        """Perform the small movements of an activity, with rests between them, until it ends."""
        times = []
        for number, one in enumerate(activity_steps.meanwhile):
            rest = one.every * one.burst
            # The activity can begin in the middle of a rest.
            time = segment.start + stream.uniform() * stream.log_normal(rest, one.varies)
            while time < segment.end:
                times.append((time, number))
                time += stream.log_normal(rest, one.varies)
        settled = next((s for s in reversed(activity_steps.steps) if s.word in POSTURES), None)
        for time, number in sorted(times):
            if time < max(self.now, -BEFORE) or self.posture == AWAY:
                continue
            if time > DAY:
                break
            self.stay_until(time)
            yield
            posture, place = self.posture, self.place
            yield from self._burst(activity_steps.meanwhile[number], stream)
            if settled is not None and (posture, place) != (self.posture, self.place):
                yield from self._perform_step(settled, True, stream)

    def _burst(self, repeated: RepeatedSteps, stream: Stream) -> Process:
        for number in range(stream.geometric(repeated.burst)):
            if number:
                self.stay_until(self.now + stream.log_normal(*PAUSE))
                yield
            if self.now >= self.until:
                return
            step = repeated.steps[stream.weighted_choice([1.0] * len(repeated.steps))]
            yield from self._perform_step(step, False, stream)

    # Steps.

    def _perform_step(self, step: ActivityStep, last: bool, stream: Stream) -> Process:
        """Perform one step of an activity; `last` says whether no further step follows."""
        self.step = step
        if step.word in ("go", "stand at", "use", "sit", "lie"):
            place = self.home.place_for(self.home.places.places[step.name], self.name)
            yield from self._take_posture(step, place)
            lasts = step.lasts
            if lasts is None:
                lasts = USUAL if step.word == "use" or (not last and step.word != "go") else 0.0
            lasts = min(lasts, max(self.until - self.now, LATE))
            if step.word == "use":
                self.work(place.target, lasts, stream)
            else:
                self.stay_until(self.now + lasts)
        elif step.word == "leave":
            yield from self._leave(step)
        elif step.word in ("open", "close"):
            yield from self._open_or_close(step)
        elif step.word == "switch":
            yield from self._switch(step)
        elif step.word in ("take", "put"):
            yield from self._carry(step)
        elif step.word == "drink":
            yield from self._drink(step)
        else:
            self._move_a_little(step, stream)

    def _move_a_little(self, step: ActivityStep, stream: Stream) -> None:
        """Perform a step that needs no walking: a small movement, a touch or a wait."""
        if step.word == "wait":
            self.stay_until(self.now + min(step.lasts or 0.0, max(self.until - self.now, LATE)))
        elif step.word == "turn over":
            self.turn_over(
                [side for side in (0, 1, -1) if side != self.side][stream.weighted_choice([1, 1])]
            )
        elif step.word == "shift":
            self.shift(min(stream.log_normal(*SIZE), LARGEST))
        elif step.word == "look around":
            self.look_around(step.lasts or LOOK)
        else:
            self._reach(step, self.home.places.places[step.name].target)

    def _reach(self, step: ActivityStep, point: Array) -> None:
        """Touch a point (3,); raise `InputError` if it is too far away."""
        off = self._distance_to(point)
        if off > 2 * ARM_WAY:
            raise step.error(
                f"it is {off:.1f} m away from {self.name!r} at {self.last_place!r}; add a step "
                '"go" before it'
            )
        self.touch(point)

    def _take_posture(self, step: ActivityStep, place: Place) -> Process:
        posture = POSTURES[step.word]
        if (self.place, self.posture) == (place.name, posture):
            return
        if (self.place, self.posture, posture) == (place.name, SITTING, LYING):
            self.lie(place)
            return
        yield from self.go_to_place(step, place)
        if posture != STANDING:
            self.sit(place)
        if posture == LYING:
            self.stay_until(self.now + 0.4)
            self.lie(place)

    def _carry(self, step: ActivityStep) -> Process:
        where = step.at or self.home.things.get(step.name, step.name)
        if step.word == "take" and step.name in self.hands:
            return
        if step.word == "put" and step.name not in self.hands:
            raise step.error('it is not in the hand; add a step "take" before it')
        if step.word == "take" and len(self.hands) == 2:
            raise step.error(
                f"both hands are full: {', '.join(self.hands)}; add the step `put` before it"
            )
        place = self.home.places.places[where]
        if self._distance_to(place.target) > (LEANING if self.posture == SITTING else ARM_WAY):
            yield from self.go_to_place(step, place)
        if step.word == "take":
            self.take(step.name, place.target)
        else:
            self.put(step.name, place)
            self.home.things[step.name] = where

    def _drink(self, step: ActivityStep) -> Process:
        """Drink from a cup; if it is not in the hand, take it first and put it back afterwards."""
        held = step.name in self.hands
        if not held:
            yield from self._carry(replace(step, word="take"))
        self.drink(step.name)
        if not held:
            where = self.home.things.get(step.name, step.name)
            yield from self._carry(replace(step, word="put", at=where))

    def _distance_to(self, point: Array) -> float:
        """Return the horizontal distance from the person's hips to a point, m."""
        return float(np.hypot(*(point[:2] - self.pose.pelvis[0, :2])))

    def _switch(self, step: ActivityStep) -> Process:
        lamp = self.home.places.lamps[step.name]
        if self.home.lamps.get(lamp.object) is step.on:
            return
        place = self.home.places.places.get(step.name)
        at = self.now
        if place is not None:
            if self._distance_to(lamp.at) > ARM_WAY:
                yield from self.go_to_place(step, place)
            at = self.touch(lamp.at)
        self.home.record_switch(lamp.object, step.on, at, self.name)

    def _open_or_close(self, step: ActivityStep) -> Process:
        door = self.home.places.doors[step.name]
        after = door.open if step.word == "open" else door.closed
        if abs(self.home.opening(door) - after) < 0.02:
            return
        yield from self.wait_for_door(door)
        spot = self._spot_at(door, step)
        if spot is not None and float(np.hypot(*(spot.at - self.position))) > 0.3:
            yield from self.walk_to_point(step, spot.at, spot.yaw, door.storey, self._key)
        self.move_leaf(door, after)
        self.home.occupy(door, self, self.now)

    def _spot_at(self, door: Door, step: ActivityStep) -> Spot | None:
        """Return where the person stands to move a door leaf; raise `InputError` without room."""
        place = self.home.places.places.get(door.name)
        if place is not None:
            return Spot(place.at[:2], place.yaw)
        floor_map = self.home.floor_map
        spots = [spot for side in (1.0, -1.0) if (spot := floor_map.spot(door, side, self.radius))]
        if not spots:
            raise step.error("there is no room to stand before it")
        opened = self.home.open_doors(self.storey)

        def trouble(spot: Spot) -> float:
            between = floor_map.doors_between(
                self.storey, self.position, spot.at, self.radius, opened
            )
            many = 99.0 if between is None else 5.0 * len(between)
            return many + float(np.hypot(*(spot.at - self.position)))

        return min(spots, key=trouble)

    # Leaving and coming home.

    def _leave(self, step: ActivityStep) -> Process:
        if self.posture == AWAY:
            return
        door, side = self._entrance(step)
        self.rise()
        spot = self.home.floor_map.spot_or_estimate(door, side, self.radius)
        yield from self._fetch_walking_frame()
        yield from self.walk_to_point(step, spot.at, spot.yaw, door.storey)
        yield from self.pass_door(door, side)
        if self._key:
            self.home.release(self._key, self)
        self.set_posture(AWAY)
        self._out_by = door

    def _come_in(self) -> Process:
        door = self._out_by or self.home.places.entrances[0]
        side = self.home.floor_map.inner_side(door, self.radius)
        yield from self.wait_for_door(door)
        spot = self.home.floor_map.spot_or_estimate(door, -side, self.radius)
        self.place_at(spot.at, spot.yaw, door.storey)
        self.set_posture(STANDING)
        yield from self.pass_door(door, -side)

    def _entrance(self, step: ActivityStep) -> tuple[Door, float]:
        """Return the nearest entrance, and its side (+1 or −1) that is in the home."""
        floor_map, opened = self.home.floor_map, self.home.open_doors(self.storey)
        found = []
        for door in self.home.places.entrances:
            side = floor_map.inner_side(door, self.radius)
            spot = floor_map.spot_or_estimate(door, side, self.radius)
            between = floor_map.doors_between(
                self.storey, self.position, spot.at, self.radius, opened
            )
            if between is not None:
                found.append(
                    (len(between), float(np.hypot(*(spot.at - self.position))), door, side)
                )
        if not found:
            raise step.error(f"{self.name!r} cannot reach an entrance from {self.last_place!r}")
        _, _, door, side = min(found, key=lambda one: one[:2])
        return door, side
