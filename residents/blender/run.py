# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulate days in the open home, one after the other, each from its routine alone.

The home's own animation is replaced during the run, and restored at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from datetime import date, timedelta
from itertools import pairwise
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...angen_addon.process.system import release_memory
from ...angen_addon.runtime.simulation import Exchange, Progress, simulate
from ...angen_addon.runtime.time_base import evaluated_depsgraph
from ...angen_addon.scene.animation import all_animated
from ...angen_addon.scene.sensors import Sensor, decimal, is_placed
from ...angen_addon.scene.surfaces.warmth import heat_of
from ...angen_addon.scene.uses import watched_object
from ...sensor_logic.clock import exact
from ...sensor_logic.kind import USES
from ...sensor_logic.logs.error import InputError, explained
from ...sensor_logic.logs.files import read_text
from ...sensor_logic.logs.log import Event
from ...sensor_logic.logs.wording import uncapitalized
from ...sensor_logic.model import Array
from ...sensor_logic.progress import Work, finished
from ...sensor_logic.recording.tracks import Recording, Track
from ...sensor_logic.recording.validity import not_valid
from ..acting import FloorMap, acting
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
from .keys import IN_USE, KeyedStretch
from .lamps import unswitchable
from .places import read_marks_in_steps
from .settings import build_of, residents_in
from .unmovable import unmovable, unmovable_residents

# Types of constraints that use the scene's camera.
THROUGH_CAMERA = ("CAMERA_SOLVER", "FOLLOW_TRACK", "OBJECT_SOLVER")


@contextmanager
def without_animation(scene: Any) -> Iterator[None]:
    """Context manager: on entry, hold the home at its first frame; on exit, restore its animation.

    Drivers, constraints and modifiers stay active. Linked datablocks keep their animation.
    """
    scene.frame_set(scene.frame_start)
    before = []
    for owner in list(all_animated()):
        data = owner.animation_data
        if owner.library is None and (data.action or data.nla_tracks):
            before.append((owner, data.action, getattr(data, "action_slot", None), data.use_nla))
            data.action, data.use_nla = None, False
    camera, views = scene.camera, []
    if not _needs_camera():
        views = _hold_views(scene)
        # Blender's audio stores the camera's location for every frame from 0 on, and copies all of
        # them at each new frame. Late in a day, that takes milliseconds.
        scene.camera = None
    try:
        yield
    finally:
        scene.camera = camera
        for view in views:
            view.use_local_camera = False
        for owner, action, slot, use_nla in before:
            data = owner.animation_data_create()
            data.action, data.use_nla = action, use_nla
            if slot is not None:
                data.action_slot = slot


def _hold_views(scene: Any) -> list[Any]:
    """Let all 3D views keep the scene's camera as their own, and return them.

    Without this, views through the camera would jump when the scene has no camera.
    """
    windows = [w for w in bpy.context.window_manager.windows if w.scene == scene]
    spaces = [space for w in windows for area in w.screen.areas for space in area.spaces]
    views = [s for s in spaces if s.type == "VIEW_3D" and not s.use_local_camera]
    for view in views:
        view.use_local_camera, view.camera = True, scene.camera
    return views


def _needs_camera() -> bool:
    """Return whether anything can depend on the scene's active camera."""
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


# s of movement that have keyframes at a time. More would need much memory.
MOST_MOVEMENT = 200.0
# s: keyframes also cover this time after a stretch, for sensors that need later frames.
AFTER_S = 1.0
# *Explain* needs this many earlier updates: the last two scans at the same tilt.
TILTS_BACK = 24


class DayRun:
    """The simulation of one day, or of a part of the day.

    After `progress` has run, `events` are the events of the day. `recording` has the readings, in
    frames of the day. `midnight` is the start of the day, in s of the recording.

    Parameters
    ----------
    acted
        What the residents do on the day.
    residents
        The object of each person.
    keys
        The object that inserts the keyframes, for one part of the day at a time.
    number
        The number of the day, from 0.
    between
        Start and end of the part to simulate, in s of the day; None for the whole day.
    causes
        Whether to find the object and the person that caused each event.
    """

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
        self.midnight = LEAD_S + number * DAY_S
        self.recording = Recording()
        what = self.recording, acted, residents, self.midnight
        self._causes = Causes(scene, sensors, *what, causes)
        rates = [decimal(sensor.settings.update_rate) for sensor in sensors]
        self._before = max([TILTS_BACK / float(exact(rate)) for rate in rates] + [AFTER_S])
        begin, last = between or (0.0, DAY_S)
        first = begin - LEAD_S
        cuts = stretches(acted.spans(first, last), first, last, MOST_MOVEMENT)
        self._bounds = [first, *cuts, last]
        self.events: tuple[Event[int], ...] = ()

    def progress(self) -> Iterator[Progress]:
        """Simulate the day and yield the progress; raise `AngenError` if a sensor cannot sense."""
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
            )
            self._causes.add_events()
        self.events = attribute_events(_events(self._causes.events, self.midnight))

    def _shown(self, start: float, end: float) -> Callable[[], None]:
        def exchange() -> None:
            self._causes.add_events()
            self._show(start, end)
            release_memory()

        return exchange

    def _show(self, start: float, end: float) -> None:
        # No step before the run is evaluated, however rare the updates of a sensor are.
        before = max(start - self._before, self._bounds[0] - AFTER_S)
        self._keys.show(self._acted, before, end + AFTER_S)


def _events(events: Iterable[Event[float]], midnight: float) -> list[Event[int]]:
    """Return the events after midnight, and for each field one event with its value at midnight.

    Frames are set to 0, because days are not counted in frames.
    """
    begins: dict[tuple[str, str], Event[int]] = {}
    found = []
    for event in sorted(events):
        time = round((event.time - midnight) * US)
        if time <= 0:
            at_midnight = replace(event.at(0), frame=0.0, person="", because="")
            begins[event.sensor, event.field] = at_midnight
        else:
            found.append(replace(event.at(time), frame=0.0))
    return [*begins.values(), *found]


@contextmanager
def at_ten_frames(scene: Any) -> Iterator[None]:
    """Context manager: on entry, set 10 frames a second and no substeps; on exit, restore both."""
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


# Blender's integers have 32 bits.
LARGEST_SEED = 0x7FFFFFFF
# s: an activity with which a diary begins at midnight began so much earlier.
UNDER_WAY = 3600.0


@dataclass(frozen=True)
class Plan:
    """A routine and, optionally, a diary that says when activities are done.

    Attributes
    ----------
    name
        The name of the routine's file.
    text
        The text of all files.
    routine
        The routine as read from its file.
    diary
        What each person does according to the diary, in place of the routine's plans.
    first
        The date of the diary's first day. The diary's times are in s since that midnight.
    """

    name: str
    text: str
    routine: Routine
    diary: tuple[Segment, ...] = ()
    first: date | None = None

    @classmethod
    def read(cls, path: Path, diary_path: Path | None = None) -> Plan:
        """Read a routine file and, if a path is given, a diary: a file, or a folder of files.

        Raise `InputError` if one of them is invalid.
        """
        plan = cls.from_text(read_text(path), path.name, str(path))
        if diary_path is None:
            return plan
        is_folder = diary_path.is_dir()
        paths = sorted(diary_path.glob("*.csv")) if is_folder else [diary_path]
        if not paths:
            raise InputError(f"{diary_path} has no diary: name a folder with CSV files")
        texts = {str(path): read_text(path) for path in paths}
        first, segments = diary.read_all(texts)
        text = plan.text + "".join(texts.values())
        return replace(plan, text=text, diary=tuple(segments), first=first)

    @classmethod
    def from_text(cls, text: str, name: str, path: str = "") -> Plan:
        """Return the plan for a routine's text; raise `InputError` if the text is invalid.

        Errors name the file by its `path`, or by `name` if there is no path.
        """
        return cls(name, text, file.read(text, path or name))

    def segments(self, start: date, days: int, seed: int) -> list[Segment]:
        """Return what each person does on `days` days, in s since midnight of the date `start`.

        The first segment of a person can begin before that midnight.
        """
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


class HouseholdDays:
    """The people of a routine in the open home, and the simulation of their days.

    `residents` has the object of each person, by the person's name.
    """

    def __init__(
        self,
        scene: Any,
        sensors: Sequence[Sensor],
        plan: Plan,
        start: date,
        seed: int,
        read: bool = True,
    ) -> None:
        """Check seed and residents, and read the home if `read` is True.

        If `read` is False, the caller must run `read_in_steps`. Raise `InputError` if the seed or a
        resident is invalid.
        """
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
        # Whether events get their person and cause.
        self.causes = True
        # Called at the end of a whole day with its date, its readings, and its midnight in their
        # time (s).
        self.keep_samples: Callable[[date, Mapping[str, Track], float], object] | None = None
        if read:
            finished(self.read_in_steps())

    def read_in_steps(self) -> Work[None]:
        """Read the marked places; yield the progress.

        The scene must be at its first frame. Raise `AngenError` if the places cannot be read.
        """
        self.places: Places = (yield from read_marks_in_steps(evaluated_depsgraph())).places
        self._builds: dict[str, Build] = {}
        for name, obj in self.residents.items():
            with explained(self.plan.routine.persons[name].where, ValueError):
                self._builds[name] = build_of(obj)
        self._floor_map = FloorMap(self.places)
        # Found here, because later the animation, which says how bright lamps are, is held.
        lamps = [bpy.data.objects[lamp.object] for lamp in self.places.lamps.values()]
        self._unswitchable = list(unswitchable(lamps, evaluated_depsgraph()))
        self._last: tuple[int, Acted] | None = None
        # Sentences for the user, each given once.
        leaves = unmovable(bpy.data.objects[name] for name in self.places.doors)
        self._notes: dict[Any, str] = {
            problem: f"{problem}: {uncapitalized(mend)}"
            for problem, mend, _ in (*unmovable_residents(self.scene), *leaves)
        }

    def date_of(self, number: int) -> date:
        return self.start + timedelta(number)

    def acted(self, number: int) -> Acted:
        """Return what the residents do on day `number`.

        Raise `InputError` if a step of the routine cannot be performed in this home.
        """
        return finished(self.act_in_steps(number))

    def act_in_steps(self, number: int) -> Work[Acted]:
        """Compute the same as `acted`; yield the progress, and return the result."""
        if self._last is None or self._last[0] != number:
            self._last = number, (yield from self._act(number))
            used = {switch.object for switch in self._last[1].switches}
            for problem, mend, objects in self._unswitchable:
                if objects[0] in used:
                    self._notes.setdefault(problem, f"{problem}: {uncapitalized(mend)}")
            for wait in filter(lambda one: one.is_long, self._last[1].waits):
                text = f"{self.date_of(number)}: {wait.text}"
                self._notes.setdefault((wait.person, wait.place), text)
        return self._last[1]

    def take_notes(self) -> list[str]:
        """Return new sentences on who waits long for a place, and on what a day cannot move."""
        found = [text for text in self._notes.values() if text]
        self._notes = dict.fromkeys(self._notes, "")
        return found

    def _act(self, number: int) -> Work[Acted]:
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
                    self._floor_map,
                )
            )

    def run(
        self,
        number: int,
        keys: KeyedStretch,
        between: tuple[float, float] | None = None,
    ) -> Generator[Progress, None, Day]:
        """Simulate day `number`; yield the progress, and return the day.

        `keys` is from the context manager `keyed`. `between` has start and end of the part to
        simulate, in s of the day; None is for the whole day. Raise `AngenError` if the day cannot
        be acted or simulated.
        """
        acted, sensors = self.acted(number), self.sensors
        calendar = calendar_number(self.start) + number
        what = acted, self.residents, keys, calendar, between, self.causes
        day = DayRun(self.scene, sensors, *what)
        on = self.date_of(number)
        with Daylight(self.scene, sensors, on), self._seeded():
            yield from day.progress()
        if self.keep_samples is not None and between is None:
            self.keep_samples(on, day.recording.tracks, day.midnight)
        where = people(acted, self._room_at, self.places.room_of)
        done = activities(acted, self.places.room_of, where)
        invalid = tuple(not_valid(day.recording.tracks.values()))
        return Day(on, day.events, tuple(done), tuple(where), invalid)

    @contextmanager
    def keyed(self) -> Iterator[KeyedStretch]:
        """Context manager: on entry, stop the home's own animation; on exit, restore the home.

        Its value is the object that inserts the keyframes for residents, doors, lamps and carried
        objects.
        """
        self.scene.frame_set(self.scene.frame_start)
        keys = KeyedStretch(self.residents, self.places, uses=_uses_read(self.sensors))
        with without_animation(self.scene):
            try:
                yield keys
            finally:
                keys.clear()

    @contextmanager
    def _seeded(self) -> Iterator[None]:
        """Context manager: on entry, set the scene's seed for this run; on exit, restore it."""
        before = self.scene.angen_seed
        self.scene.angen_seed = self.seed
        try:
            yield
        finally:
            self.scene.angen_seed = before

    def _room_at(self, point: Array) -> str:
        storeys = self.places.storeys
        # The storey is found by height: the hips of a person who lies are lower than a metre.
        return storeys[self.places.storey_at(float(point[2]))].room_at(point) if storeys else ""


def _uses_read(sensors: Iterable[Sensor]) -> set[str]:
    """Return the names of the objects whose use a sensor or driver reads, or which it warms.

    The others need no keyframes: Blender evaluates each animated object at each frame.
    """
    found = {obj.name for obj in bpy.data.objects if heat_of(obj) is not None}
    found |= {w.name for s in sensors if s.kind.requires(USES) and (w := watched_object(s))}
    for owner in all_animated():
        variables = (v for curve in owner.animation_data.drivers for v in curve.driver.variables)
        targets = (target for variable in variables for target in variable.targets)
        found |= {one.id.name for one in targets if one.id and one.data_path.startswith(IN_USE)}
    return found


def _check_placed(resident: Any) -> None:
    """Raise `InputError` if a resident, or its walking frame, is not in the evaluated scene."""
    for obj in (resident, resident.angen_resident.walking_frame):
        if obj is not None and not is_placed(obj, evaluated_depsgraph()):
            raise InputError(
                f"'{obj.name}' is disabled in viewports or in no collection of this view layer, so "
                "no sensor notices it: enable it in the Outliner (monitor icon, its "
                "collection's tick)"
            )


def resident_of(person: Person) -> Any:
    """Return the object of the resident that a person of the routine names.

    Raise `InputError` if the home has no such resident.
    """
    obj = bpy.data.objects.get(person.resident)
    if obj is None:
        known = [one.name for one in residents_in(bpy.context.scene)]
        raise InputError(
            f"{person.where}: the home has no resident '{person.resident}'; its residents are "
            f"{', '.join(known) or 'none: add one with Shift+A, Sensor, Resident'}"
        )
    return obj


def run_days(
    household: HouseholdDays,
    numbers: Iterable[int],
    progress: Callable[[int, Progress], object] = lambda number, step: None,
    between: tuple[float, float] | None = None,
) -> Iterator[Day]:
    """Yield the simulated days with these numbers, which count from 0.

    Parameters
    ----------
    numbers
        The numbers of the days.
    progress
        Called with the number of the day in work, and its progress.
    between
        Start and end of the part of each day to simulate, in s; None for whole days.

    Raises
    ------
    AngenError
        If a day cannot be acted or simulated.
    """
    with closing(run_days_in_steps(household, numbers, between)) as steps:
        for step in steps:
            if isinstance(step, Day):
                yield step
            else:
                progress(*step)


def run_days_in_steps(
    household: HouseholdDays, numbers: Iterable[int], between: tuple[float, float] | None = None
) -> Generator[tuple[int, Progress] | Day, None, None]:
    """Simulate days as `run_days` does, but also yield the progress.

    Yield a day's number with its progress, or the day once it is complete.
    """
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
            release_memory()


def moved_share(spans: Array, part: float) -> float:
    """Return the progress of a run, 0 to 1, when a share `part` of the day has passed.

    This is how much of the day's movement is over, because times without movement take hardly any
    computing time. `spans` are start and end of each movement, shape (n, 2), in s.
    """
    moving = float(np.diff(spans).sum())
    before = float(np.diff(np.minimum(spans, part * DAY_S)).sum())
    return before / moving if moving else part
