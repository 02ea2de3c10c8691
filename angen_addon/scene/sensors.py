# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the sensors of a scene and reads them, evaluated, at the present frame: their parameters,
poses and rooms."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from operator import attrgetter
from typing import Any

import bpy
from mathutils import Matrix

from ...sensor_logic.choice import SensorChoice
from ...sensor_logic.error import AngenError, explained
from ...sensor_logic.kind import Field, Kind
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.model import Pose, pose_from_matrix
from ...sensor_logic.parameters import Parameters, specs
from ...sensor_logic.wording import METRES, Lengths
from .animation import is_animated, motion_paths
from .instances import Holders, SensorFinder, Uid, is_holder, is_sensor, matrix_of, uid_of

# Where an object is that something names: a magnet, a switch, the mark of a place.
#
# Blender does not evaluate what viewports do not show, unless something else depends on it: its
# evaluated matrix is then that of an earlier frame, or the identity.


class NotPlaced(AngenError):
    """Nothing tells where an object is; `problem` names it with the reason, `mend` is the way
    out."""

    def __init__(self, problem: str, mend: str) -> None:
        super().__init__(f"{problem}: {mend}")
        self.problem, self.mend = problem, mend


def is_placed(obj: Any, depsgraph: Any) -> bool:
    """Return whether Blender evaluates the place of an object."""
    if obj.visible_get(view_layer=depsgraph.view_layer):
        return True
    evaluated = obj.evaluated_get(depsgraph)
    # A pointer to an object brings it into the depsgraph without its evaluation, and keys that
    # hide it keep it listed.
    if not evaluated.is_evaluated:
        return False
    if evaluated.hide_viewport and is_animated(obj, "hide_viewport"):
        return False
    return any(listed == evaluated for listed in depsgraph.ids)


def placed_matrix(obj: Any, depsgraph: Any, instanced: bool = False) -> Matrix:
    """Return the matrix in the world of an object, as Blender evaluates it.

    Where Blender does not, its parents give it, unless something else moves the object.
    `instanced`: it is in a collection that is instanced. Raises NotPlaced.
    """
    gone = not (instanced or is_placed(obj, depsgraph))
    if gone and obj not in depsgraph.view_layer.objects.values():
        raise NotPlaced(
            f"'{obj.name}' is in no collection of this view layer, so it has no place",
            "tick its collection in the Outliner, or choose another object",
        )
    return _matrix(obj, depsgraph)


def _matrix(obj: Any, depsgraph: Any) -> Matrix:
    if is_placed(obj, depsgraph):
        return obj.evaluated_get(depsgraph).matrix_world
    parent = obj.parent
    held = parent is not None and (obj.parent_type != "OBJECT" or parent.type == "CURVE")
    if held or motion_paths(obj):
        raise NotPlaced(
            f"'{obj.name}' moves and is disabled in viewports, so Blender does not place it",
            "enable it there (monitor icon)",
        )
    above = _matrix(parent, depsgraph) if parent is not None else Matrix()
    return above @ obj.matrix_parent_inverse @ obj.matrix_basis


# The room that a sensor hangs in, or that an object marks.

# Of files that were saved before the sensor had a field for it: a custom property of the object.
CUSTOM = "room"


def room_of(obj: Any) -> str:
    """The room noted on an object; empty where none is."""
    return str(obj.angen_sensor.room or obj.get(CUSTOM, ""))


def noted_room(obj: Any) -> str:
    """The room of a marked object: set on its mark, or noted on it; empty where neither is."""
    return str(obj.angen_place.room) or room_of(obj)


def set_room(obj: Any, known: Iterable[str]) -> str:
    """The room that the user gave a marked object, or a collection around it; empty: none."""
    return noted_room(obj) or room_of_collections(obj, known)


def room_of_collections(obj: Any, known: Iterable[str]) -> str:
    """The known room that a collection with the object in it is named after, or empty; the
    innermost collection counts."""
    rooms = {room.lower(): room for room in known if room}
    inside = list(obj.users_collection)
    while inside:
        found = [rooms[c.name.lower()] for c in inside if c.name.lower() in rooms]
        if found:
            return found[0]
        inside = [c for c in bpy.data.collections if any(one.name in c.children for one in inside)]
    return ""


def known_rooms(_owner: Any, _context: Any, typed: str) -> list[str]:
    """Suggestions for the field: the rooms that are used anywhere in the file."""
    rooms = {room for obj in bpy.data.objects for room in (room_of(obj), noted_room(obj))} - {""}
    return sorted((room for room in rooms if typed.lower() in room.lower()), key=str.lower)


@dataclass(frozen=True)
class Sensor:
    """An object that is a sensor, or stands for one in a collection instance, which then has the
    `holders` that instance it, the outermost first. All are originals; not to be kept across
    undo."""

    name: str
    kind: Kind
    object: Any
    holders: Holders = ()
    # Where a run senses with several settings of one sensor: the object that has these, which no
    # scene shows; the sensor's own name, by which it draws random numbers; their number, from 1.
    settings_of: Any = None
    stands_for: str = ""
    variant: int = 0

    @property
    def uid(self) -> Uid:
        return uid_of(self.object, self.holders)

    @property
    def name_now(self) -> str:
        """Its present name; in an instance with the names of the instances that hold it."""
        return "/".join(part.name for part in (*self.holders, self.object))

    @property
    def handle(self) -> Any:
        """The object that a user selects for it: itself, or the outermost instance."""
        return self.holders[0] if self.holders else self.object

    def world_matrix(self, depsgraph: Any) -> Any:
        """Its evaluated world matrix."""
        return matrix_of(self.object, self.holders, depsgraph)

    @property
    def settings(self) -> Any:
        return self.settings_in(self.object)

    def settings_in(self, obj: Any) -> Any:
        """The sensor's settings in its evaluated object `obj`, so with keys and drivers applied."""
        return (obj if self.settings_of is None else self.settings_of).angen_sensor

    @property
    def room(self) -> str:
        """The room that the user gave the sensor, or else an instance that holds it; empty if
        neither has one."""
        return next(filter(None, map(room_of, (self.object, *reversed(self.holders)))), "")

    @property
    def parameters(self) -> Any:
        """The property group with its kind's parameters."""
        return self.parameters_in(self.object)

    def parameters_in(self, obj: Any) -> Any:
        """The same of its object as it is evaluated."""
        return getattr(self.settings_in(obj), self.kind.attribute)

    @property
    def reading(self) -> Field:
        """The field that the output `value` shows, with its unit."""
        return self.kind.reading(self.parameters)

    @property
    def selected(self) -> bool:
        return bool(self.handle.select_get())

    @property
    def library(self) -> str:
        return self.object.library.filepath if self.object.library else ""


def all_sensors(view_layer: Any) -> list[Sensor]:
    """The sensors of a view layer by name, with those in collection instances; those in excluded
    collections are not in it."""
    found = []
    finder = SensorFinder()
    for obj in view_layer.objects:
        if obj is None:
            # Just after a script removed objects there are gaps.
            continue
        if is_sensor(obj):
            found.append(sensor_of(obj))
        if is_holder(obj):
            found += [sensor_of(*place) for place in finder.sensors_in(obj)]
    return sorted(found, key=lambda sensor: (sensor.name, sensor.library))


def sensor_of(obj: Any, holders: Holders = ()) -> Sensor:
    """An object that is a sensor, perhaps within a collection instance."""
    sensor = Sensor("", KINDS[obj.angen_sensor.kind], obj, holders)
    return replace(sensor, name=sensor.name_now)


def chosen(sensors: list[Sensor], choice: SensorChoice) -> list[Sensor]:
    """The sensors that a choice takes. Raises InputError."""
    names = set(choice.of({sensor.name: sensor.kind.identifier for sensor in sensors}))
    return [sensor for sensor in sensors if sensor.name in names]


def simulated(sensors: Iterable[Sensor]) -> list[Sensor]:
    """The sensors that a run simulates: switched on, or perhaps so at another frame."""
    return [
        s for s in sensors if s.settings.enabled or is_animated(s.object, "angen_sensor.enabled")
    ]


def check_names(sensors: list[Sensor]) -> None:
    """Raises AngenError where two sensors share a name, as a linked and a local one can."""
    for name, count in Counter(sensor.name for sensor in sensors).items():
        if count > 1:
            origins = [s.library or "this file" for s in sensors if s.name == name]
            raise AngenError(
                f"{count} sensors are called '{name}' (from {', '.join(origins)}): "
                "rename one, so that the log can tell them apart"
            )


def check(sensor: Sensor, lengths: Lengths = METRES) -> None:
    """Raises AngenError where the sensor's settings make no sense; it tells `lengths` so."""
    rate = decimal(sensor.settings.update_rate)
    if not 0.0 < rate < float("inf"):
        raise AngenError(f"'{sensor.name}': update_rate is {rate:g} Hz: it must be above 0")
    read_parameters(sensor, sensor.settings, lengths)


def read_parameters(sensor: Sensor, settings: Any, lengths: Lengths = METRES) -> Any:
    """The parameters in `settings` (evaluated or not) of a sensor, checked. Raises AngenError."""
    group = getattr(settings, sensor.kind.attribute)
    read, pointers = _reader(sensor.kind.identifier)
    values = read(group)
    for index, pointer in pointers:
        if values[index] is not None:
            # Objects are named, not kept: they would not outlive undo.
            named = pointed_at(values[index], pointer)
            values = (*values[:index], named, *values[index + 1 :])
    parameters, sound = _checked(sensor.kind.identifier, values)
    if not sound:
        raise AngenError(f"'{sensor.name}': {parameters.problems(lengths)[0]}")
    return parameters


# One a kind, until Blender ends; without it 4 µs more an update.
@cache
def _reader(kind: str) -> tuple[Callable[[Any], tuple[Any, ...]], list[tuple[int, str]]]:
    """A function that reads all parameters of a kind in their order, and which of them are
    pointers, to what."""
    known = specs(KINDS[kind].parameters)
    pointers = [(i, spec.pointer) for i, spec in enumerate(known.values()) if spec.pointer]
    if len(known) > 1:
        return attrgetter(*known), pointers
    # Of a single name, attrgetter makes no tuple.
    return lambda group: tuple(getattr(group, name) for name in known), pointers


def pointed_at(value: Any, kind: str) -> str:
    """The value of a pointer parameter: a text's content, else the name."""
    return str(value.as_string() if kind == "Text" else value.name_full)


def report_steps(sensor: Sensor) -> dict[str, float]:
    """The smallest change of each field for which the event log gets a row."""
    parameters = read_parameters(sensor, sensor.settings)
    return {f.name: getattr(parameters, f.step) for f in sensor.kind.events if f.step}


# The last 1024 sets of values; without it 50 µs more an update.
@lru_cache(maxsize=1024)
def _checked(kind: str, values: tuple[Any, ...]) -> tuple[Parameters, bool]:
    made_of = KINDS[kind].parameters
    known = specs(made_of)
    exact = {
        name: decimal(value) if isinstance(value, float) and spec.unit != "rad" else value
        for (name, spec), value in zip(known.items(), values, strict=True)
    }
    parameters = made_of(**exact)
    return parameters, not parameters.problems()


def decimal(value: float) -> float:
    """The number that the user typed: Blender stores 0.05 as 0.0500000007."""
    return float(f"{value:.7g}")


def is_evaluated(sensor: Sensor, depsgraph: Any) -> bool:
    """Whether Blender evaluates the sensor, and so places it."""
    # In an instance Blender evaluates also what it does not show.
    inner = (sensor.object, *sensor.holders[1:]) if sensor.holders else ()
    return not any(part.hide_viewport for part in inner) and is_placed(sensor.handle, depsgraph)


def check_evaluated(sensor: Sensor, depsgraph: Any) -> None:
    """Raises AngenError where Blender does not evaluate the sensor: it has no place then."""
    if not is_evaluated(sensor, depsgraph):
        raise AngenError(
            f"'{sensor.name}': it is disabled in viewports, so Blender does not place it: "
            "enable it there (monitor icon), or switch the sensor off"
        )


def read_pose(sensor: Sensor, matrix: Any, unit_scale: float) -> Pose:
    """The pose, in metres, of a sensor with this world matrix. Raises AngenError."""
    with explained(f"'{sensor.name}'", ValueError, raised=AngenError):
        return pose_from_matrix(matrix, unit_scale)


def unit_scale(scene: Any) -> float:
    """Metres in a Blender unit."""
    settings = scene.unit_settings
    return 1.0 if settings.system == "NONE" else decimal(settings.scale_length)
