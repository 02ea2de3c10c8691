# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the sensors of a scene, and read their evaluated parameters, poses and rooms."""

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
from ...sensor_logic.kind import Kind
from ...sensor_logic.kinds import KINDS
from ...sensor_logic.logs.error import AngenError, InputError, explained
from ...sensor_logic.logs.fields import Field
from ...sensor_logic.logs.wording import METRES, Lengths, hint
from ...sensor_logic.model import Pose, pose_from_matrix
from ...sensor_logic.parameters import Parameters, specs
from .animation import is_animated, motion_paths
from .instances import (
    Holders,
    SensorFinder,
    Uid,
    is_holder,
    is_sensor,
    matrix_of,
    objects_of,
    uid_of,
)

# The place of an object, such as a magnet, a switch or the mark of a place.
#
# Blender does not evaluate objects that viewports do not show, unless something depends on them.
# Their evaluated matrix is then from an earlier frame, or the identity.


class NotPlaced(AngenError):
    """Raised if the world matrix of an object is unknown.

    `problem` names the object and the reason, and `mend` is the remedy.
    """

    def __init__(self, problem: str, mend: str) -> None:
        super().__init__(f"{problem}: {mend}")
        self.problem, self.mend = problem, mend


def is_placed(obj: Any, depsgraph: Any) -> bool:
    """Return whether Blender evaluates an object, so that its evaluated matrix is valid."""
    if obj.visible_get(view_layer=depsgraph.view_layer):
        return True
    evaluated = obj.evaluated_get(depsgraph)
    # A pointer to an object brings it into the depsgraph without its evaluation, and keyframes that
    # hide it keep it listed.
    if not evaluated.is_evaluated:
        return False
    if evaluated.hide_viewport and is_animated(obj, "hide_viewport"):
        return False
    return any(listed == evaluated for listed in depsgraph.ids)


def placed_matrix(obj: Any, depsgraph: Any, instanced: bool = False) -> Matrix:
    """Return the evaluated world matrix of an object.

    If Blender does not evaluate the object, its matrix is computed from its parents. That fails if
    anything else, such as a constraint, moves the object.

    Parameters
    ----------
    obj
        The object.
    depsgraph
        The evaluated depsgraph.
    instanced
        Whether the object is in a collection that is instanced.

    Raises
    ------
    NotPlaced
        If the matrix is unknown.
    """
    gone = not (instanced or is_placed(obj, depsgraph))
    if gone and obj not in depsgraph.view_layer.objects.values():
        raise NotPlaced(
            f"'{obj.name}' is in no collection of this view layer, so it has no position",
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


# The custom property with the room, in files from before the sensor had a field for it.
CUSTOM = "room"


def room_of(obj: Any) -> str:
    """Return the room in an object's sensor settings; empty if none is set."""
    return str(obj.angen_sensor.room or obj.get(CUSTOM, ""))


def noted_room(obj: Any) -> str:
    """Return the room set on a place or sensor; empty if none is set."""
    return str(obj.angen_place.room) or room_of(obj)


def assigned_room(obj: Any, known: Iterable[str]) -> str:
    """Return the room set on a sensor or place, or else the room of a collection that holds it.

    The result is empty without any room. `known` are the room names that a collection may have.
    """
    return noted_room(obj) or room_of_collections(obj, known)


def room_of_collections(obj: Any, known: Iterable[str]) -> str:
    """Return the room after which a collection around the object is named; empty if there is none.

    Only names in `known` count. Of nested collections, the innermost counts.
    """
    rooms = {room.lower(): room for room in known if room}
    inside = list(obj.users_collection)
    while inside:
        found = [rooms[c.name.lower()] for c in inside if c.name.lower() in rooms]
        if found:
            return found[0]
        inside = [c for c in bpy.data.collections if any(one.name in c.children for one in inside)]
    return ""


def known_rooms(_owner: Any, _context: Any, typed: str) -> list[str]:
    """Return suggestions for the field Room: the rooms in the file that contain the typed text."""
    rooms = {room for obj in bpy.data.objects for room in (room_of(obj), noted_room(obj))} - {""}
    return sorted((room for room in rooms if typed.lower() in room.lower()), key=str.lower)


@dataclass(frozen=True)
class Sensor:
    """A sensor: an object, or an object in a collection instance.

    All objects are originals. Do not store a `Sensor` across undo.

    Attributes
    ----------
    name
        The name of the sensor.
    kind
        The kind of sensor.
    object
        The object of the sensor.
    holders
        The objects that instance the sensor's collections, from the outermost inwards; empty for a
        sensor that is in no instance.
    """

    name: str
    kind: Kind
    object: Any
    holders: Holders = ()
    # For runs with several settings of one sensor: the hidden object with the settings, the name
    # of the sensor whose random numbers are drawn, and the number of the settings, from 1.
    settings_of: Any = None
    stands_for: str = ""
    variant: int = 0

    @property
    def uid(self) -> Uid:
        """The identifier of the sensor in this session."""
        return uid_of(self.object, self.holders)

    @property
    def name_now(self) -> str:
        """The present name, after the names of the objects that instance the sensor."""
        return "/".join(part.name for part in (*self.holders, self.object))

    @property
    def handle(self) -> Any:
        """The object to select for the sensor: its own, or the outermost that instances it."""
        return self.holders[0] if self.holders else self.object

    def world_matrix(self, depsgraph: Any) -> Any:
        """Return the evaluated world matrix."""
        return matrix_of(self.object, self.holders, depsgraph)

    @property
    def settings(self) -> Any:
        """The settings in the original object."""
        return self.settings_in(self.object)

    def settings_in(self, obj: Any) -> Any:
        """Return the settings at the present frame; `obj` is the sensor's evaluated object."""
        return (obj if self.settings_of is None else self.settings_of).angen_sensor

    @property
    def room(self) -> str:
        """The room set on the sensor, or else on an object that instances it; or empty."""
        return next(filter(None, map(room_of, (self.object, *reversed(self.holders)))), "")

    @property
    def parameters(self) -> Any:
        """The property group with the parameters of the sensor's kind."""
        return self.parameters_in(self.object)

    def parameters_in(self, obj: Any) -> Any:
        """Return the parameters at the present frame; `obj` is the sensor's evaluated object."""
        return getattr(self.settings_in(obj), self.kind.attribute)

    @property
    def reading(self) -> Field:
        """The field that the sensor's property `value` shows."""
        return self.kind.reading(self.parameters)

    @property
    def selected(self) -> bool:
        """Whether the object `handle` is selected."""
        return bool(self.handle.select_get())

    @property
    def library(self) -> str:
        """The path of the library that the object is linked from; empty for a local object."""
        return self.object.library.filepath if self.object.library else ""


def all_sensors(view_layer: Any) -> list[Sensor]:
    """Return the sensors of a view layer, sorted by name, with those in collection instances.

    Sensors in excluded collections are not part of a view layer.
    """
    found = []
    finder = SensorFinder()
    for obj in objects_of(view_layer):
        if is_sensor(obj):
            found.append(sensor_of(obj))
        if is_holder(obj):
            found += [sensor_of(*place) for place in finder.sensors_in(obj)]
    return sorted(found, key=lambda sensor: (sensor.name, sensor.library))


def sensor_of(obj: Any, holders: Holders = ()) -> Sensor:
    """Return the sensor of an object.

    For a sensor in a collection instance, `holders` are the objects that instance its collections,
    from the outermost inwards.
    """
    sensor = Sensor("", KINDS[obj.angen_sensor.kind], obj, holders)
    return replace(sensor, name=sensor.name_now)


def chosen(sensors: list[Sensor], choice: SensorChoice) -> list[Sensor]:
    """Return the sensors that a choice selects. Raise `InputError` for unknown names."""
    names = set(choice.of({sensor.name: sensor.kind.identifier for sensor in sensors}))
    return [sensor for sensor in sensors if sensor.name in names]


def simulated(sensors: Iterable[Sensor]) -> list[Sensor]:
    """Return the sensors that a run simulates: those that are switched on at any frame."""
    return [
        s for s in sensors if s.settings.enabled or is_animated(s.object, "angen_sensor.enabled")
    ]


def check_names(sensors: list[Sensor]) -> None:
    """Raise `AngenError` if two sensors have the same name, as a linked and a local one can."""
    for name, count in Counter(sensor.name for sensor in sensors).items():
        if count > 1:
            origins = [s.library or "this file" for s in sensors if s.name == name]
            raise AngenError(
                f"{count} sensors are called '{name}' (from {', '.join(origins)}): rename one, so "
                "that each name in the log means one sensor"
            )


def check(sensor: Sensor, lengths: Lengths = METRES) -> None:
    """Raise `AngenError` if the settings of a sensor are invalid.

    `lengths` is the unit of lengths in the message.
    """
    rate = decimal(sensor.settings.update_rate)
    if not 0.0 < rate < float("inf"):
        raise AngenError(f"'{sensor.name}': update_rate is {rate:g} Hz: it must be above 0")
    read_parameters(sensor, sensor.settings, lengths)


def read_parameters(sensor: Sensor, settings: Any, lengths: Lengths = METRES) -> Any:
    """Return the checked parameters of a sensor.

    Parameters
    ----------
    sensor
        The sensor.
    settings
        The settings of its object, original or evaluated.
    lengths
        The unit of lengths in error messages.

    Raises
    ------
    AngenError
        If the parameters are invalid.
    """
    group = getattr(settings, sensor.kind.attribute)
    read, pointers = _parameter_reader(sensor.kind.identifier)
    values = read(group)
    for index, pointer in pointers:
        if values[index] is not None:
            # Store the name in place of the object, which is invalid after undo.
            named = pointed_at(values[index], pointer)
            values = (*values[:index], named, *values[index + 1 :])
    parameters, sound = _checked(sensor.kind.identifier, values)
    if not sound:
        raise AngenError(f"'{sensor.name}': {parameters.problems(lengths)[0]}")
    return parameters


# One a kind, until Blender ends; without it 4 µs more an update.
@cache
def _parameter_reader(kind: str) -> tuple[Callable[[Any], tuple[Any, ...]], list[tuple[int, str]]]:
    """Return a function that reads all parameters of a kind, and the list of its pointers.

    A pointer is the index of a parameter that refers to a datablock, and the datablock's type.
    """
    known = specs(KINDS[kind].parameters)
    pointers = [(i, spec.pointer) for i, spec in enumerate(known.values()) if spec.pointer]
    if len(known) > 1:
        return attrgetter(*known), pointers
    # Of a single name, attrgetter makes no tuple.
    return lambda group: tuple(getattr(group, name) for name in known), pointers


def pointed_at(value: Any, kind: str) -> str:
    """Return the text that stands for a datablock among a sensor's parameters.

    It is the content of a text datablock, and the name of any other.
    """
    return str(value.as_string() if kind == "Text" else value.name_full)


# The list in `bpy.data` of each type of datablock that a parameter can name.
COLLECTIONS = {"Object": "objects", "Collection": "collections", "Text": "texts"}


def named_block(kind: str, name: str, others: Iterable[str] = ()) -> Any:
    """Return the datablock of a type, such as Object, with this name.

    Raise `InputError` if there is none. Its hint has names of the file's datablocks and `others`.
    """
    among = getattr(bpy.data, COLLECTIONS[kind])
    found = among.get(name)
    if found is None:
        known = hint(name, [*among.keys(), *others])
        raise InputError(f"no {kind.lower()} is called '{name}'; {known}")
    return found


def report_steps(sensor: Sensor) -> dict[str, float]:
    """Return, by field, the smallest change that gives a row in the event log."""
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
    """Return a single-precision value as the user typed it: Blender stores 0.05 as 0.0500000007."""
    return float(f"{value:.7g}")


def is_evaluated(sensor: Sensor, depsgraph: Any) -> bool:
    """Return whether Blender evaluates the sensor's object, so that its world matrix is valid."""
    # In an instance, Blender also evaluates objects that it does not show.
    inner = (sensor.object, *sensor.holders[1:]) if sensor.holders else ()
    return not any(part.hide_viewport for part in inner) and is_placed(sensor.handle, depsgraph)


def check_evaluated(sensor: Sensor, depsgraph: Any) -> None:
    """Raise `AngenError` if Blender does not evaluate the sensor's object."""
    if not is_evaluated(sensor, depsgraph):
        raise AngenError(
            f"'{sensor.name}': it is disabled in viewports, so Blender does not place it: "
            "enable it there (monitor icon), or switch the sensor off"
        )


def read_pose(sensor: Sensor, matrix: Any, unit_scale: float) -> Pose:
    """Return the pose of a sensor in metres, from its world matrix.

    Raise `AngenError` if the matrix gives no pose.
    """
    with explained(f"'{sensor.name}'", ValueError, raised=AngenError):
        return pose_from_matrix(matrix, unit_scale)


def unit_scale(scene: Any) -> float:
    """Return the length of a Blender unit in metres."""
    settings = scene.unit_settings
    return 1.0 if settings.system == "NONE" else decimal(settings.scale_length)
