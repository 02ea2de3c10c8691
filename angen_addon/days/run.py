# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs days in the open home, one after the other, each from its routine alone."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import date, timedelta
from pathlib import Path
from typing import Any

import bpy

from ...sensor_logic.days.rows import Day
from ...sensor_logic.days.times import calendar_number
from ...sensor_logic.days.truth import activities, people
from ...sensor_logic.error import InputError
from ...sensor_logic.model import Array
from ...sensor_logic.residents.acted import Acted
from ...sensor_logic.residents.acting import Ground, act
from ...sensor_logic.residents.body.build import Build
from ...sensor_logic.residents.places import Places
from ...sensor_logic.routine import diary, file
from ...sensor_logic.routine.draws import Draws
from ...sensor_logic.routine.routine import DAY, Person, Routine, Segment
from ...sensor_logic.routine.timetable import timetable
from ..process.memory import give_back
from ..residents.keys import KeyedStretch
from ..residents.places.read import read_places
from ..residents.settings import build_of, residents_in
from ..runtime.simulation import Progress
from ..runtime.time_base import evaluated_depsgraph
from ..scene.placed import is_placed
from ..scene.sensors import Sensor
from .aside import put_aside
from .daylight import Daylight
from .living import DayRun

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
        plan = cls.of(_text(path), path.name)
        if diary_path is None:
            return plan
        told = _text(diary_path)
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


def _text(path: Path) -> str:
    """Raises InputError."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is not a text file in UTF-8") from None


class Household:
    """Who lives in the open home, and how: `residents` is the object of each person."""

    def __init__(
        self, scene: Any, sensors: Sequence[Sensor], plan: Plan, start: date, seed: int
    ) -> None:
        """Raises InputError."""
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
        self.places: Places = read_places(scene, evaluated_depsgraph())
        self._builds: dict[str, Build] = {}
        for name, obj in self.residents.items():
            try:
                self._builds[name] = build_of(obj)
            except ValueError as error:
                raise InputError(f"{plan.routine.persons[name].where}: {error}") from None
        self._ground = Ground(self.places)
        self._last: tuple[int, Acted] | None = None
        # Whether events are to be told with who and what made them.
        self.causes = True

    def date_of(self, number: int) -> date:
        return self.start + timedelta(number)

    def acted(self, number: int) -> Acted:
        """What is done on day `number`, whatever days are asked for. Raises InputError."""
        if self._last is None or self._last[0] != number:
            self._last = number, self._act(number)
        return self._last[1]

    def _act(self, number: int) -> Acted:
        segments = self.plan.segments(self.start, number + 2, self.seed)
        try:
            return act(
                segments,
                self.plan.routine,
                self.places,
                self._builds,
                Draws(self.seed, self.start),
                number,
                self._ground,
            )
        except InputError as error:
            raise InputError(f"{self.date_of(number)}: {error}") from None

    def run(
        self,
        number: int,
        keys: Any,
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
        lights = [
            light
            for lamp in self.places.lamps.values()
            for light in _lights(bpy.data.objects[lamp.object])
        ]
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


def _lights(obj: Any) -> list[Any]:
    return [one.data for one in (obj, *obj.children_recursive) if one.type == "LIGHT"]


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
) -> Iterator[Day]:
    """The days of these numbers, counted from 0. Raises AngenError."""
    with household.keyed() as keys:
        for number in numbers:
            run = household.run(number, keys)
            while True:
                try:
                    step = next(run)
                except StopIteration as end:
                    yield end.value
                    give_back()
                    break
                progress(number, step)
