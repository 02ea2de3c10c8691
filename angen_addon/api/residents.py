# SPDX-License-Identifier: GPL-3.0-or-later
"""Residents, their places and a stretch of a day, for scripts."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ...sensor_logic.days.rows import Day
from ...sensor_logic.error import AngenError
from ...sensor_logic.residents.body.build import Sort
from ...sensor_logic.residents.places import Place
from ...sensor_logic.routine.times import time_of_day
from ..days.run import Plan
from ..residents import adding
from ..residents.places.marks import LABELS
from ..residents.places.read import read_places
from ..runtime.time_base import evaluated_depsgraph
from ..scene.sensors import Sensor, unit_scale
from .days import household_of

SORTS = [sort.value for sort in Sort]


def add_resident(sort: str, name: str, at: Sequence[float], yaw: float, walking_frame: bool) -> str:
    """See `Home.add_resident`."""
    if sort not in SORTS:
        raise AngenError(f"sort '{sort}' is unknown; there are {', '.join(SORTS)}")
    point = np.asarray(at, float)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise AngenError(f"at={at!r} is not a point: give x, y and z in metres")
    place = Vector((point / unit_scale(bpy.context.scene)).tolist())
    has_frame = walking_frame and sort != Sort.CAT.value
    rig = adding.add_resident(bpy.context, Sort(sort), place, yaw, has_frame)
    if name:
        rig.name = name
    return str(rig.name)


def mark(name: str, use: str, settings: dict[str, Any]) -> None:
    """See `Home.mark`."""
    obj = bpy.data.objects.get(name)
    if obj is None or obj.name not in bpy.context.view_layer.objects:
        raise AngenError(f"the home has no object '{name}'")
    if use not in LABELS:
        raise AngenError(f"use '{use}' is unknown; there are {', '.join(LABELS)}")
    group = obj.angen_place
    known = [p.identifier for p in group.bl_rna.properties if p.identifier not in NO_SETTINGS]
    for key in settings:
        if key not in known:
            raise AngenError(f"a mark has no '{key}'; there are {', '.join(known)}")
    bpy.context.view_layer.update()
    # Guesses what the settings do not say.
    group.use = use
    for key, value in settings.items():
        if key == "switch" and isinstance(value, str):
            value = bpy.data.objects.get(value)
        try:
            setattr(group, key, value)
        except (TypeError, ValueError) as error:
            raise AngenError(f"'{name}': {key}: {error}") from None


NO_SETTINGS = ("rna_type", "name", "use")


def places() -> dict[str, Place]:
    """See `Home.places`."""
    found = read_places(bpy.context.scene, evaluated_depsgraph())
    if found.problems:
        raise AngenError(found.problems[0])
    return dict(found.places)


def live(
    sensors: Sequence[Sensor],
    routine: str | Path,
    start: date | str,
    between: tuple[str, str] | None,
    seed: int,
) -> Day:
    """See `Home.live`."""
    text = isinstance(routine, str) and "\n" in routine
    plan = Plan.of(str(routine), "routine") if text else Plan.read(Path(routine))
    household = household_of(sensors, plan, start, seed)
    span = _seconds(between) if between is not None else None
    with household.keyed() as keys:
        run = household.run(0, keys, span)
        while True:
            try:
                next(run)
            except StopIteration as end:
                day: Day = end.value
                return day


def _seconds(between: tuple[str, str]) -> tuple[float, float]:
    try:
        begin, end = (time_of_day(one) for one in between)
    except (TypeError, ValueError):
        begin = end = 0.0
    if not begin < end:
        raise AngenError(f"between={between!r} is no stretch of a day such as ('19:00', '19:05')")
    return begin, end
