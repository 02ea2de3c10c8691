# SPDX-License-Identifier: GPL-3.0-or-later
"""A home with residents, opened by a script: its places, days, and parts of a day."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ...angen_addon.api import home
from ...angen_addon.runtime.simulation import Progress
from ...angen_addon.runtime.time_base import evaluated_depsgraph
from ...angen_addon.scene.instances import objects_of
from ...angen_addon.scene.sensors import Sensor, named_block, unit_scale
from ...sensor_logic.logs.error import AngenError, InputError, explained
from ...sensor_logic.logs.log import parse_date
from ...sensor_logic.logs.wording import hint
from ..acting.places import Place
from ..acting.timeline import LYING, SITTING, STANDING
from ..body.skeleton import Sort
from ..days.rows import Day
from ..routine.routine import time_of_day
from ..routine.timetable import check_covers
from .marks import LABELS
from .places import read_places
from .run import HouseholdDays, Plan, run_days
from .settings import (
    add_resident,
    build_of,
    is_resident,
    posed,
    residents_in,
    show_pose,
)


def household_of(
    sensors: Sequence[Sensor], plan: Plan, start: date | str, seed: int
) -> HouseholdDays:
    """Return the people of a routine in the open home, for days from the date `start` on.

    Raise `AngenError` if an argument is invalid.
    """
    with explained("start", InputError):
        first = parse_date(start) if isinstance(start, str) else start
    return HouseholdDays(bpy.context.scene, sensors, plan, first, seed)


def _warn_of_notes(household: HouseholdDays) -> None:
    for text in household.take_notes():
        warnings.warn(text, stacklevel=3)


SORTS = [sort.value for sort in Sort]
# Properties of a mark that are not settings.
NO_SETTINGS = ("rna_type", "name", "use")


def _seconds(between: tuple[str, str]) -> tuple[float, float]:
    try:
        begin, end = (time_of_day(one) for one in between)
    except (TypeError, ValueError):
        begin = end = 0.0
    if not begin < end:
        raise AngenError(f"between={between!r} is not two times of day such as ('19:00', '19:05')")
    return begin, end


class Home(home.Home):
    """An open blend file, with the residents of its home.

    Opening another file closes this one, because Blender holds one file at a time.
    """

    def days(
        self,
        routine: str | Path,
        start: date | str,
        days: int = 1,
        seed: int = 0,
        sensors: Iterable[str] | None = None,
        diary: str | Path | None = None,
        progress: Callable[[float], object] | None = None,
    ) -> Iterator[Day]:
        """Simulate days of a routine file, and yield each day once it is complete.

        A day has `date`, `events`, `activities` and `people`, with times in µs since its midnight.
        At the end, the home is as before.

        Parameters
        ----------
        routine
            The routine file.
        start
            The date of the first day.
        days
            The number of days.
        seed
            The seed of all random draws.
        sensors
            Names or patterns such as "PIR*"; by default all sensors.
        diary
            A CSV file of activities with times, which replace the activities of the routine.
        progress
            Called with the progress, 0 to 1. An exception that it raises ends the run.

        Raises
        ------
        AngenError
            If an argument is invalid.
        """
        found = self._simulated(sensors)
        plan = Plan.read(Path(routine), Path(diary) if diary is not None else None)
        household = household_of(found, plan, start, seed)
        dates = household.start, days, str(diary)
        for text in check_covers(plan.diary, plan.first, plan.routine.persons, *dates):
            warnings.warn(text, stacklevel=2)

        def report(number: int, step: Progress) -> None:
            if progress is not None:
                progress((number + step.share) / days)

        for day in run_days(household, range(days), report):
            _warn_of_notes(household)
            yield day

    def add_resident(
        self,
        sort: str,
        name: str = "",
        at: Sequence[float] = (0.0, 0.0, 0.0),
        yaw: float = 0.0,
        walking_frame: bool = False,
    ) -> str:
        """Add a resident, and return the name of its object.

        Parameters
        ----------
        sort
            ADULT, OLDER_ADULT, CHILD or CAT.
        name
            The name of the object; Blender adds a number if another object has the name.
        at
            The position (x, y, z) in metres.
        yaw
            The direction in which the resident looks, in rad; 0 is +x.
        walking_frame
            Whether the resident has a walking frame.

        Raises
        ------
        AngenError
            If an argument is invalid.
        """
        self.all_sensors()
        if sort not in SORTS:
            raise AngenError(f"sort '{sort}' is unknown: choose one of {', '.join(SORTS)}")
        point = np.asarray(at, float)
        if point.shape != (3,) or not np.isfinite(point).all():
            raise AngenError(f"at={at!r} is not a point: give x, y and z in metres")
        place = Vector((point / unit_scale(bpy.context.scene)).tolist())
        has_frame = walking_frame and sort != Sort.CAT.value
        rig = add_resident(bpy.context, Sort(sort), place, yaw, has_frame)
        if name:
            rig.name = name
        return str(rig.name)

    def pose(
        self,
        resident: str,
        posture: str,
        at: Sequence[float],
        yaw: float = 0.0,
        floor: float = 0.0,
        side: int = 0,
    ) -> None:
        """Put a resident into a posture at a point, without keyframes.

        Parameters
        ----------
        resident
            The name of the resident's object.
        posture
            standing, sitting or lying.
        at
            The point (x, y, z) in metres: on the floor, on the seat, or on what bears a lying
            person.
        yaw
            Where the resident looks, or where the head of a lying one points, in rad; 0 is +x.
        floor
            The height of the floor in metres, for the feet of a sitting person.
        side
            Whether a person lies on the back (0), the left (1) or the right side (−1).

        Raises
        ------
        AngenError
            If an argument is invalid.
        """
        self.all_sensors()
        rig = bpy.data.objects.get(resident)
        if rig is None or not is_resident(rig):
            names = [one.name for one in residents_in(bpy.context.scene)]
            raise AngenError(f"no resident is called '{resident}': {hint(resident, names)}")
        if posture not in (STANDING, SITTING, LYING):
            raise AngenError(f"posture '{posture}' is unknown: choose standing, sitting or lying")
        values = np.array([*at, yaw, floor], float)
        if values.shape != (5,) or not np.isfinite(values).all():
            raise AngenError(f"at={at!r}, yaw={yaw!r}, floor={floor!r} is no place of a resident")
        show_pose(rig, posed(build_of(rig), posture, at, yaw, floor, side))
        bpy.context.view_layer.update()

    def mark(self, object: str, use: str, **settings: Any) -> None:
        """Mark the object of this name with what residents do there, such as SIT, LIE or DOOR.

        `settings` are the settings in the panel Resident's Place, such as `room="kitchen"`. A
        setting that is left out is guessed. Where one is an object, give its name. Raise
        `AngenError` if an argument is invalid.
        """
        self.all_sensors()
        obj = bpy.data.objects.get(object)
        names = [one.name for one in objects_of(bpy.context.view_layer)]
        if obj is None or obj.name not in names:
            raise AngenError(f"the home has no object '{object}'; {hint(object, names)}")
        if use not in LABELS:
            raise AngenError(f"use '{use}' is unknown: choose one of {', '.join(LABELS)}")
        group = obj.angen_place
        known = [p.identifier for p in group.bl_rna.properties if p.identifier not in NO_SETTINGS]
        for key in settings:
            if key not in known:
                raise AngenError(
                    f"the property '{key}' of a mark is unknown: choose one of {', '.join(known)}"
                )
        bpy.context.view_layer.update()
        # Setting `use` guesses the other settings.
        group.use = use
        for key, value in settings.items():
            with explained(
                f"'{object}': {key}", TypeError, ValueError, InputError, raised=AngenError
            ):
                if group.bl_rna.properties[key].type == "POINTER" and isinstance(value, str):
                    value = named_block("Object", value)
                setattr(group, key, value)

    def places(self) -> dict[str, Place]:
        """Return the places of residents by name, with `use`, `room`, `at`, `yaw` and `target`.

        `room_guessed` is True if the room was guessed from sensors nearby. Doors are left out, and
        so are lamps without a place to stand. Raise `AngenError` if no place can be read.
        """
        self.all_sensors()
        found = read_places(bpy.context.scene, evaluated_depsgraph())
        if found.problems:
            raise AngenError(found.problems[0])
        return dict(found.places)

    def live(
        self,
        routine: str | Path,
        start: date | str = "2026-03-02",
        between: tuple[str, str] | None = None,
        seed: int = 0,
        sensors: Iterable[str] | None = None,
    ) -> Day:
        """Simulate one day, or a part of it, by a routine.

        Parameters
        ----------
        routine
            The path or the text of the routine.
        start
            The date of the day.
        between
            The part of the day for which sensors are simulated, such as ("19:00", "19:05").
        seed
            The seed of all random draws.
        sensors
            Names or patterns such as "PIR*"; by default all sensors.

        Raises
        ------
        AngenError
            If an argument is invalid.
        """
        found = self._simulated(sensors)
        text = isinstance(routine, str) and "\n" in routine
        plan = Plan.from_text(str(routine), "routine") if text else Plan.read(Path(routine))
        household = household_of(found, plan, start, seed)
        span = _seconds(between) if between is not None else None
        [day] = run_days(household, [0], between=span)
        _warn_of_notes(household)
        return day
