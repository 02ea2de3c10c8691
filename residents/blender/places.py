# SPDX-License-Identifier: GPL-3.0-or-later
"""Read the places, doors, lamps and floors of a home from its marked objects."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Any, TypeVar

import bpy
import numpy as np

from ...angen_addon.scene.home.evaluated_home import EvaluatedHome
from ...angen_addon.scene.sensors import assigned_room, is_placed
from ...sensor_logic.logs.error import AngenError, InputError
from ...sensor_logic.logs.wording import named
from ...sensor_logic.model import Array
from ...sensor_logic.progress import Doing, Work, finished, part_of, saying
from ..acting.places import DOOR, INSIDE, LAMP, MOVED, STAND, Door, LampPlace, Place, Places
from .lamps import lamp_of
from .marks import NONE, MarkedObject, door_of, marked
from .standing import AROUND_M, REACH_M, place_of, storey_index, walkable_home, walkable_storeys

T = TypeVar("T")


def read_places(scene: Any, depsgraph: Any) -> Places:
    """Return the places of the evaluated scene; raise `AngenError` if none can be read."""
    return read_marks(depsgraph).places


def read_marks(depsgraph: Any) -> HomeMarks:
    """Return the marked objects of the evaluated scene; raise `AngenError` if none can be read."""
    return finished(read_marks_in_steps(depsgraph))


def read_marks_in_steps(depsgraph: Any) -> Work[HomeMarks]:
    """Read the marked objects as `read_marks` does; yield the progress."""
    marks = HomeMarks()
    yield from marks.read_in_steps(depsgraph)
    return marks


class HomeMarks:
    """The marked objects of a home and its storeys; `read_in_steps` finds them."""

    def read_in_steps(self, depsgraph: Any) -> Work[None]:
        """Read the marked objects; yield the progress.

        Raise `AngenError` if none can be read.
        """
        objects = marked(depsgraph.view_layer)
        if not objects:
            inside = [o.name for o in bpy.data.objects if o.angen_place.use != NONE]
            if inside:
                raise InputError(
                    f"the marks of {named(inside)} are in instances, in unticked collections or in "
                    "another scene: make instances real (Ctrl+A) or a library override of them, or "
                    "tick the collections"
                )
            raise InputError(
                "nothing is marked: choose what residents do with an object in the panel "
                "Resident's Place (Physics tab, or the sidebar's tab Sensors)"
            )
        self.home = EvaluatedHome(depsgraph)
        self.problems: list[str] = []
        leaves = [obj for obj in objects if obj.angen_place.use == DOOR]
        self.marked = yield from saying(
            Doing(0.0), self._read(partial(MarkedObject, self.home), objects)
        )
        known = [obj for obj in objects if obj.name in self.marked]
        anchors = finished(self._read(self._floor_point, known))
        if not anchors:
            raise InputError(self.problems[0])
        self.marked = {name: self.marked[name] for name in anchors}
        objects = [marked.obj for marked in self.marked.values()]
        points = np.array([*anchors.values()])
        # Lamps without a switch are left out, because they hang at any height.
        furniture = np.array([obj.angen_place.use in INSIDE for obj in objects])
        unanchored = furniture | [
            obj.angen_place.use == LAMP and not obj.angen_place.switch for obj in objects
        ]
        stood = ~unanchored | unanchored.all()
        # The floor is known near marks: parts of furniture count where no other mark is.
        apart = np.linalg.norm(points[:, None, :2] - points[stood, :2], axis=2).min(axis=1)
        stood |= furniture & (apart > AROUND_M)
        rows = [t.rows for t in self.marked.values() if t.obj.angen_place.use != STAND]
        rows = np.concatenate([np.empty(0, np.intp), *rows])
        names = [name for name, counts in zip(self.marked, stood, strict=True) if counts]
        walk = walkable_home(self.home, leaves)
        reading = walkable_storeys(self.home, walk, points[stood], names, rows)
        self.grounds = yield from part_of(reading, 0.02, 0.85)
        heights = [ground.storey.height for ground in self.grounds]
        self.numbers = {
            obj.name: storey_index(heights, float(point[2]))
            for obj, point in zip(objects, points, strict=True)
        }
        doors = finished(
            self._read(self._read_door, [o for o in objects if o.angen_place.use in MOVED])
        )
        self._add_doorways(doors.values())
        lamps = {o.name: self._lamp(o) for o in objects if o.angen_place.use == LAMP}
        used = [o for o in objects if self._needs_standing_point(o, lamps)]
        places = yield from part_of(self._read(self._place, used), 0.85, 1.0)
        storeys = tuple(ground.storey for ground in self.grounds)
        self.places = Places(places, doors, lamps, storeys, tuple(self.problems))

    def _read(self, read: Callable[[Any], T], objects: list[Any]) -> Work[dict[str, T]]:
        """Return the results of `read(object)` by the object's name; yield the progress.

        An `AngenError` becomes one of the `problems`.
        """
        found = {}
        for number, obj in enumerate(objects):
            yield Doing(number / len(objects))
            try:
                found[obj.name] = read(obj)
            except AngenError as error:
                why = str(error).removeprefix(f"'{obj.name}' ")
                self.problems.append(f"'{obj.name}': {why}")
        return found

    def _add_doorways(self, doors: Iterable[Door]) -> None:
        """Add the lines of shut doors to the storeys, so that nobody stands on these lines."""
        lines = [(door.storey, door.line(door.closed)) for door in doors if door.use == DOOR]
        self.grounds = [
            replace(ground, doorways=np.concatenate([np.empty((0, 2)), *shut]))
            for number, ground in enumerate(self.grounds)
            for shut in [[line for storey, line in lines if storey == number]]
        ]

    def _needs_standing_point(self, obj: Any, lamps: dict[str, LampPlace]) -> bool:
        """Return whether residents stand at a certain point to use a marked object.

        For doors, and for lamps out of reach, this is False.
        """
        if obj.angen_place.use != LAMP:
            return bool(obj.angen_place.use != DOOR)
        ground = self.grounds[self.numbers[obj.name]]
        return float(lamps[obj.name].at[2]) <= ground.storey.height + REACH_M

    def _floor_point(self, obj: Any) -> Array:
        """Return the point (3,) from which the floor below a marked object is searched for, m."""
        mark = obj.angen_place
        if mark.use == LAMP and mark.switch is not None:
            return MarkedObject(self.home, mark.switch).at
        return self.marked[obj.name].middle

    def _read_door(self, obj: Any) -> Door:
        if not is_placed(obj, self.home.depsgraph):
            raise InputError(
                "it is disabled in viewports, so sensors do not notice the leaf: enable it there "
                "(monitor icon in the Outliner), or set its Use to None"
            )
        number = self.numbers[obj.name]
        storey = self.grounds[number].storey
        room = assigned_room(obj, storey.rooms) or storey.room_at(self.marked[obj.name].middle)
        return door_of(self.home, obj, storey.height, room, number)

    def _lamp(self, obj: Any) -> LampPlace:
        switch = obj.angen_place.switch
        at: Array = (
            MarkedObject(self.home, switch).middle if switch else self.marked[obj.name].middle
        )
        return LampPlace(obj.name, lamp_of(obj).name, at)

    def _place(self, obj: Any) -> Place:
        switch = obj.angen_place.switch if obj.angen_place.use == LAMP else None
        number = self.numbers[obj.name]
        hand = MarkedObject(self.home, switch) if switch else None
        return place_of(self.marked[obj.name], self.grounds[number], number, hand)
