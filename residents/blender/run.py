# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs days in the open home, one after the other, each from its routine alone; the home's own keys
are put aside for that."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from datetime import date, timedelta
from itertools import pairwise
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...angen_addon.process.standalone import give_back
from ...angen_addon.progress import Shares, finished
from ...angen_addon.runtime.simulation import Exchange, Progress, simulate
from ...angen_addon.runtime.time_base import evaluated_depsgraph
from ...angen_addon.scene.animation import all_animated
from ...angen_addon.scene.sensors import Sensor, decimal, is_placed
from ...sensor_logic.clock import exact
from ...sensor_logic.error import InputError, explained
from ...sensor_logic.files import read_text
from ...sensor_logic.log import Event
from ...sensor_logic.model import Array
from ...sensor_logic.recording.tracks import Recording
from ..acting import Ground, acting
from ..acting.places import Places
from ..acting.timeline import Acted
from ..body.skeleton import Build
from ..days.rows import (
    FPS,
    LEAD_S,
    Day,
    attribute_events,
    calendar_number,
    clock_of_day,
    frame_at,
    stretches,
)
from ..days.truth import DAY_S, US, activities, people
from ..routine import file
from ..routine import timetable as diary
from ..routine.routine import DAY, Person, Routine, Segment
from ..routine.timetable import Draws, timetable
from .causes import Causes
from .daylight import Daylight
from .keys import KeyedStretch, lights_of
from .places import reading_marks
from .settings import build_of, residents_in

# A home's own keys and strips put aside, and its camera: a day has its own story.

# Of constraints, those that ask for the scene's camera.
THROUGH_CAMERA = ("CAMERA_SOLVER", "FOLLOW_TRACK", "OBJECT_SOLVER")


@contextmanager
def put_aside(scene: Any, but: Collection[Any] = ()) -> Iterator[None]:
    """Everything stands as at the scene's first frame, until the end; drivers, constraints and
    modifiers go on. `but`: datablocks that keep their keys. What is linked keeps its own too."""
    scene.frame_set(scene.frame_start)
    before = []
    for owner in list(all_animated()):
        data = owner.animation_data
        if owner.library is None and owner not in but and (data.action or data.nla_tracks):
            before.append((owner, data.action, getattr(data, "action_slot", None), data.use_nla))
            data.action, data.use_nla = None, False
    camera = scene.camera
    if not _is_asked_for_camera():
        # There Blender's sound listens. It keeps its place at every frame from 0 on, and copies all
        # of them at each new one: milliseconds late in a day.
        scene.camera = None
    try:
        yield
    finally:
        scene.camera = camera
        for owner, action, slot, use_nla in before:
            data = owner.animation_data_create()
            data.action, data.use_nla = action, use_nla
            if slot is not None:
                data.action_slot = slot


def _is_asked_for_camera() -> bool:
    """Whether anything may depend on which camera is the scene's."""
    drivers = [curve.driver for owner in all_animated() for curve in owner.animation_data.drivers]
    targets = (t for driver in drivers for variable in driver.variables for t in variable.targets)
    nodes = (node for tree in bpy.data.node_groups for node in tree.nodes)
    constraints = (one for obj in bpy.data.objects for one in obj.constraints)
    return (
        any("camera" in driver.expression for driver in drivers)
        or any("camera" in target.data_path for target in targets)
        or any(node.bl_idname == "GeometryNodeInputActiveCamera" for node in nodes)
        or any(one.type in THROUGH_CAMERA for one in constraints)
    )


# One day in the open home: the keys of its stretches come and go, the sensors read on.

# s: with more movement than this between two exchanges keys take much memory.
MOST_MOVEMENT = 200.0
# s: keys go on for so long after a stretch, for what needs the frames after its own.
AFTER_S = 1.0
# Updates that *Explain* goes back to: of the same tilt, and the one before that.
TILTS_BACK = 24


class DayRun:
    """Day `number` (from 0) of a run, with what was `acted` on it, or the s `between` of it.
    `residents`: the object of each person; `causes`: whether events are to be told with who and
    what made them. After `progress` was gone through, `events` are those of the day, and
    `recording` is what was read, in the frames of the day."""

    def __init__(
        self,
        scene: Any,
        sensors: Sequence[Sensor],
        acted: Acted,
        residents: Mapping[str, Any],
        keys: KeyedStretch,
        number: int,
        between: tuple[float, float] | None = None,
        causes: bool = True,
    ) -> None:
        self._scene, self._sensors, self._keys, self._acted = scene, sensors, keys, acted
        self._clock = clock_of_day(number)
        self._midnight = LEAD_S + number * DAY_S
        self.recording = Recording()
        what = self.recording, acted, residents, self._midnight
        self._causes = Causes(scene, sensors, *what, causes)
        rates = [decimal(sensor.settings.update_rate) for sensor in sensors]
        self._before = max([TILTS_BACK / float(exact(rate)) for rate in rates] + [AFTER_S])
        begin, last = between or (0.0, DAY_S)
        first = begin - LEAD_S
        cuts = stretches(acted.spans(first, last), first, last, MOST_MOVEMENT)
        self._bounds = [first, *cuts, last]
        self.events: tuple[Event[int], ...] = ()

    def progress(self) -> Iterator[Progress]:
        """Does it. Raises AngenError."""
        first, *others = pairwise(self._bounds)
        begin, end = frame_at(self._bounds[0]), frame_at(self._bounds[-1]) - 1
        exchanges = [Exchange(frame_at(start), self._shown(start, end)) for start, end in others]
        with at_ten_frames(self._scene):
            self._show(*first)
            yield from simulate(
                self._scene,
                self._sensors,
                begin,
                end,
                self.recording,
                exchanges,
                self._clock,
                self._causes.note if self._causes.wanted else None,
            )
            self._causes.take_left()
        self.events = attribute_events(_events(self._causes.told, self._midnight))

    def _shown(self, start: float, end: float) -> Callable[[], None]:
        def exchange() -> None:
            self._causes.take_left()
            self._show(start, end)
            give_back()

        return exchange

    def _show(self, start: float, end: float) -> None:
        self._keys.show(self._acted, start - self._before, end + AFTER_S)


def _events(told: Iterable[Event[float]], midnight: float) -> list[Event[int]]:
    """How everything is at midnight, and what happens then; without frames, which a day has not."""
    begins: dict[tuple[str, str], Event[int]] = {}
    found = []
    for event in sorted(told):
        time = round((event.time - midnight) * US)
        if time <= 0:
            at_midnight = replace(event.at(0), frame=0.0, person="", because="")
            begins[event.sensor, event.field] = at_midnight
        else:
            found.append(replace(event.at(time), frame=0.0))
    return [*begins.values(), *found]


@contextmanager
def at_ten_frames(scene: Any) -> Iterator[None]:
    """The scene in the time of a day: 10 frames a second, each of them whole."""
    render = scene.render
    names = ("fps", "fps_base", "frame_map_old", "frame_map_new")
    before = [getattr(render, name) for name in names]
    substeps, frame, subframe = scene.angen_substeps, scene.frame_current, scene.frame_subframe
    render.fps, render.fps_base, render.frame_map_old, render.frame_map_new = FPS, 1.0, 100, 100
    scene.angen_substeps = 1
    try:
        yield
    finally:
        for name, value in zip(names, before, strict=True):
            setattr(render, name, value)
        scene.angen_substeps = substeps
        scene.frame_set(frame, subframe=subframe)


LARGEST_SEED = 0x7FFFFFFF
# s: what a diary begins with at the first midnight was begun so long before.
UNDER_WAY = 3600.0


@dataclass(frozen=True)
class Plan:
    """A routine that was read from the file `name`, and the segments of a diary in its place, in s
    since the midnight of its `first` day; `text` is that of both files."""

    name: str
    text: str
    routine: Routine
    diary: tuple[Segment, ...] = ()
    first: date | None = None

    @classmethod
    def read(cls, path: Path, diary_path: Path | None = None) -> Plan:
        """A diary tells what is done instead of the routine's plans. Raises InputError."""
        plan = cls.of(read_text(path), path.name)
        if diary_path is None:
            return plan
        told = read_text(diary_path)
        first, segments = diary.read(told, diary_path.name)
        return replace(plan, text=plan.text + told, diary=tuple(segments), first=first)

    @classmethod
    def of(cls, text: str, name: str) -> Plan:
        """From the text of a routine that is called so. Raises InputError."""
        return cls(name, text, file.read(text, name))

    def segments(self, start: date, days: int, seed: int) -> list[Segment]:
        """Who does what on `days` days from the date `start`, in s since its midnight; what is
        under way then was begun before."""
        if self.first is None:
            return timetable(self.routine, start, days, seed)
        shift = (self.first - start).days * DAY
        found = []
        for person in self.routine.persons:
            mine = [s for s in self.diary if s.person == person]
            mine = [replace(s, start=s.start + shift, end=s.end + shift) for s in mine]
            if mine and mine[0].start == 0.0:
                mine[0] = replace(mine[0], start=-UNDER_WAY)
            begins = [0.0, *(s.end for s in mine)]
            ends = [*(s.start for s in mine), days * DAY]
            gaps = zip(begins, ends, strict=True)
            found += mine
            found += [Segment(a, b, person, diary.OTHER) for a, b in gaps if a < b]
        return sorted(found, key=lambda s: (s.person, s.start))


class Household:
    """Who lives in the open home, and how: `residents` is the object of each person."""

    def __init__(
        self,
        scene: Any,
        sensors: Sequence[Sensor],
        plan: Plan,
        start: date,
        seed: int,
        read: bool = True,
    ) -> None:
        """`read`: at once; else whoever makes it goes through `reading`. Raises InputError."""
        if not 0 <= seed <= LARGEST_SEED:
            raise InputError(f"seed {seed} is not from 0 to {LARGEST_SEED}")
        self.scene, self.sensors, self.plan = scene, list(sensors), plan
        self.start, self.seed = start, seed
        self.residents = {
            name: resident_of(person) for name, person in plan.routine.persons.items()
        }
        scene.frame_set(scene.frame_start)
        for obj in self.residents.values():
            _check_placed(obj)
        # Whether events are to be told with who and what made them.
        self.causes = True
        if read:
            finished(self.reading())

    def reading(self) -> Shares[None]:
        """Reads the marked places, in steps, while the scene stands at its first frame. Raises
        AngenError."""
        self.places: Places = (yield from reading_marks(evaluated_depsgraph())).places
        self._builds: dict[str, Build] = {}
        for name, obj in self.residents.items():
            with explained(self.plan.routine.persons[name].where, ValueError):
                self._builds[name] = build_of(obj)
        self._ground = Ground(self.places)
        self._last: tuple[int, Acted] | None = None

    def date_of(self, number: int) -> date:
        return self.start + timedelta(number)

    def acted(self, number: int) -> Acted:
        """What is done on day `number`, whatever days are asked for. Raises InputError."""
        return finished(self.acting(number))

    def acting(self, number: int) -> Shares[Acted]:
        """The same in steps."""
        if self._last is None or self._last[0] != number:
            self._last = number, (yield from self._act(number))
        return self._last[1]

    def _act(self, number: int) -> Shares[Acted]:
        segments = self.plan.segments(self.start, number + 2, self.seed)
        with explained(str(self.date_of(number)), InputError):
            return (
                yield from acting(
                    segments,
                    self.plan.routine,
                    self.places,
                    self._builds,
                    Draws(self.seed, self.start),
                    number,
                    self._ground,
                )
            )

    def run(
        self,
        number: int,
        keys: KeyedStretch,
        between: tuple[float, float] | None = None,
    ) -> Generator[Progress, None, Day]:
        """Day `number`, or the s `between` of it, with the keys of `keyed`. Raises InputError,
        AngenError."""
        acted, sensors = self.acted(number), self.sensors
        calendar = calendar_number(self.start) + number
        what = acted, self.residents, keys, calendar, between, self.causes
        day = DayRun(self.scene, sensors, *what)
        on = self.date_of(number)
        with Daylight(self.scene, sensors, on), self._seeded():
            yield from day.progress()
        where = people(acted, self._room_at, self.places.room_of)
        done = activities(acted, self.places.room_of, where)
        return Day(on, day.events, tuple(done), tuple(where))

    @contextmanager
    def keyed(self) -> Iterator[KeyedStretch]:
        """Residents, doors, lamps and things in place of the home's own story, until the end."""
        # What a lamp shines with when it is on, its keys tell.
        lamps = [bpy.data.objects[lamp.object] for lamp in self.places.lamps.values()]
        lights = {light for lamp in lamps for light in lights_of(lamp)}
        with put_aside(self.scene, lights):
            keys = KeyedStretch(self.residents, self.places)
            try:
                yield keys
            finally:
                keys.clear()

    @contextmanager
    def _seeded(self) -> Iterator[None]:
        before = self.scene.angen_seed
        self.scene.angen_seed = self.seed
        try:
            yield
        finally:
            self.scene.angen_seed = before

    def _room_at(self, point: Array) -> str:
        storeys = self.places.storeys
        # A lying body's hips are lower than a metre.
        return storeys[self.places.storey_at(float(point[2]))].room_at(point) if storeys else ""


def _check_placed(resident: Any) -> None:
    """Raises InputError where Blender does not place a resident, or what it pushes."""
    for obj in (resident, resident.angen_resident.walking_frame):
        if obj is not None and not is_placed(obj, evaluated_depsgraph()):
            raise InputError(
                f"'{obj.name}' is disabled in viewports or in no collection of this view layer, so "
                "that no sensor meets it: enable it in the Outliner (monitor icon, its "
                "collection's tick)"
            )


def resident_of(person: Person) -> Any:
    """The object that acts for a person. Raises InputError."""
    obj = bpy.data.objects.get(person.resident)
    if obj is None:
        known = [one.name for one in residents_in(bpy.context.scene)]
        raise InputError(
            f"{person.where}: the home has no resident '{person.resident}'; there are "
            f"{', '.join(known) or 'none: add one with Shift+A, Sensor, Resident'}"
        )
    return obj


def run_days(
    household: Household,
    numbers: Iterable[int],
    progress: Callable[[int, Progress], object] = lambda number, step: None,
    between: tuple[float, float] | None = None,
) -> Iterator[Day]:
    """The days of these numbers, counted from 0, or the s `between` of them. Raises AngenError."""
    with closing(running_days(household, numbers, between)) as steps:
        for step in steps:
            if isinstance(step, Day):
                yield step
            else:
                progress(*step)


def running_days(
    household: Household, numbers: Iterable[int], between: tuple[float, float] | None = None
) -> Generator[tuple[int, Progress] | Day, None, None]:
    """The same in steps: the number of a day with how far it is, and last the day itself."""
    with household.keyed() as keys:
        for number in numbers:
            with closing(household.run(number, keys, between=between)) as run:
                while True:
                    try:
                        step = next(run)
                    except StopIteration as end:
                        day: Day = end.value
                        break
                    yield number, step
            yield day
            give_back()


def moved_share(spans: Array, part: float) -> float:
    """How much of a day's movement, `spans` (n, 2) in s, is in the first part of its time: while
    all rest, a run takes no time."""
    moving = float(np.diff(spans).sum())
    before = float(np.diff(np.minimum(spans, part * DAY_S)).sum())
    return before / moving if moving else part
