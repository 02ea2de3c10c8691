# SPDX-License-Identifier: GPL-3.0-or-later
"""Lets a person live through the day, step by step as the routine says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...sensor_logic.model import Array
from ..body.skeleton import Build
from ..routine.routine import DAY, Segment
from ..routine.timetable import Stream
from .actor import LOOK
from .going import GaveUp, Going, Taking
from .ground import Spot
from .home import HomeInUse
from .places import Door, Place
from .timeline import AWAY, LYING, SITTING, STANDING, ActedActivity
from .words import POSTURES, ActivityStep, Deeds, Repeated

# Seconds: how long a step takes that the routine says nothing of, and one that comes too late.
USUAL, LATE = 10.0, 5.0
# Between two movements of a burst, s; how large small movements are. Median, log-normal.
PAUSE, SIZE, LARGEST = (1.2, 1.0), (1.3, 0.5), 2.2
# How near a hand gets to things without a step, m on the floor from the hips.
ARM_WAY = 0.85
# So far does who sits, to take things and put them down, m.
LEANING = 1.2
# Nothing is shown of what was done so long before midnight, s.
BEFORE = 60.0


class Living(Going):
    """`activities` are what the names in the segments mean."""

    def __init__(
        self, name: str, build: Build, home: HomeInUse, now: float, activities: Mapping[str, Deeds]
    ) -> None:
        super().__init__(name, build, home, now)
        self.activities = activities
        self.done: list[ActedActivity] = []
        # The activity that is under way, and since when.
        self._begun: tuple[str, float] | None = None
        self._out_by: Door | None = None

    def begin_at(self, place: Place, posture: str) -> None:
        self._key = self.key(place)
        self.home.take(self._key, self)
        self.rest_at(place, posture)

    def begin_away(self) -> None:
        door = self.home.places.entrances[0]
        side = self.home.ground.inside(door, self.radius)
        spot = self.home.ground.spot_before(door, -side, self.radius)
        self.put_down(spot.at, spot.yaw, door.storey)
        self.posture, self.place, self.unseen = AWAY, "", True

    # --- through the day --------------------------------------------------------------------
    def live(self, segments: list[tuple[Segment, Stream]]) -> Taking:
        """Segments in s since the day's midnight, each with random numbers of its own."""
        for number, (segment, stream) in enumerate(segments):
            if number and segment.end <= self.now + LATE:
                continue
            self.stay(segment.start)
            yield
            if self.now >= DAY:
                break
            self._begin(segment.activity)
            self.until = segment.end
            deeds = self.activities.get(segment.activity)
            try:
                if deeds is not None:
                    yield from self._perform(deeds, segment, stream)
            except GaveUp:
                self.stop()
            self.stay(segment.end)
            yield

    def end(self) -> None:
        """The day is over."""
        self._end_activity()
        self.finish()

    def _begin(self, activity: str) -> None:
        if self._begun is None or self._begun[0] != activity:
            self._end_activity()
            self._begun = activity, self.now

    def _end_activity(self) -> None:
        if self._begun is not None and self.now > self._begun[1]:
            activity, start = self._begun
            self.done.append(ActedActivity(start, self.now, self.name, activity, ""))

    def _perform(self, deeds: Deeds, segment: Segment, stream: Stream) -> Taking:
        self.step = deeds.steps[0]
        if self.posture == AWAY:
            if deeds.posture == AWAY and len(deeds.steps) == 1:
                return
            yield from self._come_in()
        for number, step in enumerate(deeds.steps):
            last = number == len(deeds.steps) - 1
            yield from self._do(step, last, stream)
            yield
        yield from self._go_on(deeds, segment, stream)

    def _go_on(self, deeds: Deeds, segment: Segment, stream: Stream) -> Taking:
        """Repeats bursts of movement and rests until the activity ends."""
        times = []
        for number, one in enumerate(deeds.meanwhile):
            rest = one.every * one.burst
            # At its start a rest may be under way.
            time = segment.start + stream.uniform() * stream.log_normal(rest, one.varies)
            while time < segment.end:
                times.append((time, number))
                time += stream.log_normal(rest, one.varies)
        settled = next((s for s in reversed(deeds.steps) if s.word in POSTURES), None)
        for time, number in sorted(times):
            if time < max(self.now, -BEFORE) or self.posture == AWAY:
                continue
            if time > DAY:
                break
            self.stay(time)
            yield
            posture, place = self.posture, self.place
            yield from self._burst(deeds.meanwhile[number], stream)
            if settled is not None and (posture, place) != (self.posture, self.place):
                yield from self._do(settled, True, stream)

    def _burst(self, one: Repeated, stream: Stream) -> Taking:
        for number in range(stream.geometric(one.burst)):
            if number:
                self.stay(self.now + stream.log_normal(*PAUSE))
                yield
            if self.now >= self.until:
                return
            step = one.steps[stream.chosen([1.0] * len(one.steps))]
            yield from self._do(step, False, stream)

    # --- steps --------------------------------------------------------------------------------
    def _do(self, step: ActivityStep, last: bool, stream: Stream) -> Taking:
        self.step = step
        if step.word in ("go", "stand at", "use", "sit", "lie"):
            place = self.home.places.places[step.name]
            yield from self._settle(step, place)
            lasts = step.lasts
            if lasts is None:
                lasts = USUAL if step.word == "use" or (not last and step.word != "go") else 0.0
            lasts = min(lasts, max(self.until - self.now, LATE))
            if step.word == "use":
                self.busy(place.target, lasts, stream)
            else:
                self.stay(self.now + lasts)
        elif step.word == "leave":
            yield from self._leave(step)
        elif step.word in ("open", "close"):
            yield from self._move(step)
        elif step.word == "switch":
            yield from self._switch(step)
        elif step.word in ("take", "put"):
            yield from self._carry(step)
        elif step.word == "drink":
            yield from self._drink(step)
        else:
            self._move_a_little(step, stream)

    def _move_a_little(self, step: ActivityStep, stream: Stream) -> None:
        if step.word == "wait":
            self.stay(self.now + min(step.lasts or 0.0, max(self.until - self.now, LATE)))
        elif step.word == "turn over":
            self.turn_over(
                [side for side in (0, 1, -1) if side != self.side][stream.chosen([1, 1])]
            )
        elif step.word == "shift":
            self.shift(min(stream.log_normal(*SIZE), LARGEST))
        elif step.word == "look around":
            self.look_around(step.lasts or LOOK)
        else:
            self._reach(step, self.home.places.places[step.name].target)

    def _reach(self, step: ActivityStep, point: Array) -> None:
        off = self._off(point)
        if off > 2 * ARM_WAY:
            raise step.error(
                f"it is {off:.1f} m away from {self.name!r} at {self.last_place!r}; go there before"
            )
        self.touch(point)

    def _settle(self, step: ActivityStep, place: Place) -> Taking:
        """Takes up the word's posture at a place."""
        posture = POSTURES[step.word]
        if (self.place, self.posture) == (place.name, posture):
            return
        if (self.place, self.posture, posture) == (place.name, SITTING, LYING):
            self.lie(place)
            return
        yield from self.come_to(step, place)
        if posture != STANDING:
            self.sit(place)
        if posture == LYING:
            self.stay(self.now + 0.4)
            self.lie(place)

    def _carry(self, step: ActivityStep) -> Taking:
        where = step.at or self.home.things.get(step.name, step.name)
        if step.word == "take" and step.name in self.hands:
            return
        if step.word == "put" and step.name not in self.hands:
            raise step.error("it is not in the hand; take it before")
        if step.word == "take" and len(self.hands) == 2:
            raise step.error(f"both hands are full: {', '.join(self.hands)}")
        place = self.home.places.places[where]
        if self._off(place.target) > (LEANING if self.posture == SITTING else ARM_WAY):
            yield from self.come_to(step, place)
        if step.word == "take":
            self.take(step.name, place.target)
        else:
            self.put(step.name, place)
            self.home.things[step.name] = where

    def _drink(self, step: ActivityStep) -> Taking:
        """Drinks from a cup. One that the person did not hold before is put back."""
        held = step.name in self.hands
        if not held:
            yield from self._carry(replace(step, word="take"))
        self.drink(step.name)
        if not held:
            where = self.home.things.get(step.name, step.name)
            yield from self._carry(replace(step, word="put", at=where))

    def _off(self, point: Array) -> float:
        """How far a point is from the hips on the floor, m."""
        return float(np.hypot(*(point[:2] - self.pose.pelvis[0, :2])))

    def _switch(self, step: ActivityStep) -> Taking:
        lamp = self.home.places.lamps[step.name]
        if self.home.lamps.get(lamp.object) is step.on:
            return
        place = self.home.places.places.get(step.name)
        at = self.now
        if place is not None:
            if self._off(lamp.at) > ARM_WAY:
                yield from self.come_to(step, place)
            at = self.touch(lamp.at)
        self.home.switch(lamp.object, step.on, at, self.name)

    def _move(self, step: ActivityStep) -> Taking:
        """Opens or closes what a hand moves."""
        door = self.home.places.doors[step.name]
        after = door.open if step.word == "open" else door.closed
        if abs(self.home.opening(door) - after) < 0.02:
            return
        yield from self.wait_for(door)
        spot = self._spot_at(door, step)
        if spot is not None and float(np.hypot(*(spot.at - self.here))) > 0.3:
            yield from self.to_point(step, spot.at, spot.yaw, door.storey, self._key)
        self.move_leaf(door, after)
        self.home.occupy(door, self, self.now)

    def _spot_at(self, door: Door, step: ActivityStep) -> Spot | None:
        """A spot from which a person moves a leaf without being in its way."""
        place = self.home.places.places.get(door.name)
        if place is not None:
            return Spot(place.at[:2], place.yaw)
        ground = self.home.ground
        spots = [spot for side in (1.0, -1.0) if (spot := ground.spot(door, side, self.radius))]
        if not spots:
            raise step.error("there is no room to stand before it")
        opened = self.home.left_open(self.storey)

        def trouble(spot: Spot) -> float:
            between = ground.doors_between(self.storey, self.here, spot.at, self.radius, opened)
            many = 99.0 if between is None else 5.0 * len(between)
            return many + float(np.hypot(*(spot.at - self.here)))

        return min(spots, key=trouble)

    # --- out and in -----------------------------------------------------------------------------
    def _leave(self, step: ActivityStep) -> Taking:
        if self.posture == AWAY:
            return
        door, side = self._entrance(step)
        self.rise()
        spot = self.home.ground.spot_before(door, side, self.radius)
        yield from self._fetch_frame()
        yield from self.to_point(step, spot.at, spot.yaw, door.storey)
        yield from self.through(door, side)
        if self._key:
            self.home.release(self._key, self)
        self.be(AWAY)
        self._out_by = door

    def _come_in(self) -> Taking:
        door = self._out_by or self.home.places.entrances[0]
        side = self.home.ground.inside(door, self.radius)
        yield from self.wait_for(door)
        spot = self.home.ground.spot_before(door, -side, self.radius)
        self.put_down(spot.at, spot.yaw, door.storey)
        self.be(STANDING)
        yield from self.through(door, -side)

    def _entrance(self, step: ActivityStep) -> tuple[Door, float]:
        """The nearest way out, and the side of it that is within."""
        ground, opened = self.home.ground, self.home.left_open(self.storey)
        found = []
        for door in self.home.places.entrances:
            side = ground.inside(door, self.radius)
            spot = ground.spot_before(door, side, self.radius)
            between = ground.doors_between(self.storey, self.here, spot.at, self.radius, opened)
            if between is not None:
                found.append((len(between), float(np.hypot(*(spot.at - self.here))), door, side))
        if not found:
            raise step.error(f"{self.name!r} finds no way to an entrance from {self.last_place!r}")
        _, _, door, side = min(found, key=lambda one: one[:2])
        return door, side
