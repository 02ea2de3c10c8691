# SPDX-License-Identifier: GPL-3.0-or-later
"""Find objects in collection instances: their world matrices, and the sensors that own them.

A *holder* is an object that instances a collection. Holders are listed from the outermost inwards.
The *path* of an object in an instance is a tuple of session uids. The uid of the object comes
first, then the uids of its holders from the innermost outwards.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any

from mathutils import Matrix

from ...sensor_logic.kinds import NO_KIND
from .marks import HOUSING_MARK

# The identifier of a sensor in this session: the session uid of its object, or its path.
Uid = int | tuple[int, ...]
Holders = tuple[Any, ...]
# Names of housings' meshes in files of before HOUSING_MARK, such as "Motion detector housing".
UNMARKED_HOUSING = re.compile(r" housing(\.\d+)?$")
# Blender marks the unused levels of `persistent_id` with the largest integer.
UNUSED_LEVEL = 2**31 - 1


def is_sensor(obj: Any) -> bool:
    """Return whether an object is a sensor; False for None."""
    return obj is not None and obj.angen_sensor.kind != NO_KIND


def uid_of(obj: Any, holders: Holders) -> Uid:
    """Return the identifier of an object: its session uid, or in a collection instance its path.

    `holders` are the objects that instance its collections, from the outermost inwards.
    """
    if not holders:
        return int(obj.session_uid)
    return (obj.session_uid, *(holder.session_uid for holder in reversed(holders)))


def is_holder(obj: Any) -> bool:
    """Return whether an object instances a collection."""
    return obj.instance_type == "COLLECTION" and obj.instance_collection is not None


def matrix_of(obj: Any, holders: Holders, depsgraph: Any) -> Matrix:
    """Return the evaluated world matrix of an object in a collection instance.

    `holders` are the objects that instance its collections, from the outermost inwards.
    """
    return within(obj.evaluated_get(depsgraph).matrix_world, holders, depsgraph)


def within(matrix: Matrix, holders: Holders, depsgraph: Any) -> Matrix:
    """Return the world matrix of an object in a collection instance.

    `matrix` is its matrix in the collection. `holders` are the objects that instance its
    collections, from the outermost inwards.
    """
    for holder in reversed(holders):
        evaluated = holder.evaluated_get(depsgraph)
        offset = Matrix.Translation(-evaluated.instance_collection.instance_offset)
        matrix = evaluated.matrix_world @ offset @ matrix
    return matrix


class SensorFinder:
    """Finds sensors in instanced collections, and searches each collection only once.

    Make a new finder for each search, since collections may change.
    """

    def __init__(self) -> None:
        self._known: dict[Any, tuple[list[Any], list[Any]]] = {}

    def sensors_in(self, holder: Any) -> Iterator[tuple[Any, Holders]]:
        """Yield pairs of a sensor in a holder's collection, and the holders that instance it.

        A holder is an object that instances a collection. The holders are listed from the outermost
        inwards.
        """
        yield from self._walk((holder,))

    def _walk(self, holders: Holders) -> Iterator[tuple[Any, Holders]]:
        sensors, inner = self._sensors_and_holders(holders[-1].instance_collection)
        for obj in sensors:
            yield obj, holders
        for holder in inner:
            # Blender does not let a collection hold itself, but a damaged file may.
            if holder not in holders:
                yield from self._walk((*holders, holder))

    def _sensors_and_holders(self, collection: Any) -> tuple[list[Any], list[Any]]:
        if collection not in self._known:
            shown = shown_in(collection)
            self._known[collection] = (
                [obj for obj in shown if is_sensor(obj)],
                [obj for obj in shown if is_holder(obj)],
            )
        return self._known[collection]


def shown_in(collection: Any) -> list[Any]:
    """Return the objects that an instance of a collection shows, child collections included."""
    return list(dict.fromkeys(_shown(collection)))


def _shown(collection: Any) -> Iterator[Any]:
    if collection.hide_viewport:
        return
    yield from collection.objects
    for child in collection.children:
        yield from _shown(child)


def objects_of(view_layer: Any) -> Iterator[Any]:
    """Yield the objects of a view layer, also those that a script has just added."""
    # Blender lists objects that scripts link only after it has looked: reading the active object
    # makes it look, without an evaluation.
    _ = view_layer.objects.active
    for obj in view_layer.objects:
        # A view layer has gaps just after a script removed objects.
        if obj is not None:
            yield obj


def shown_objects(view_layer: Any) -> Iterator[Any]:
    """Yield the objects that the viewport shows, in the order of the view layer."""
    for obj in objects_of(view_layer):
        if obj.visible_get(view_layer=view_layer):
            yield obj


def with_instanced(view_layer: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the objects of a view layer and of its collection instances, each once.

    Yields
    ------
    tuple
        The object; and the object of the view layer that shows it: itself, or a holder.
    """
    looked: set[Any] = set()
    for obj in objects_of(view_layer):
        yield obj, obj
        yield from ((part, obj) for part in _instanced(obj, looked))


def _instanced(obj: Any, looked: set[Any]) -> Iterator[Any]:
    if is_holder(obj) and obj.instance_collection not in looked:
        looked.add(obj.instance_collection)
        for part in shown_in(obj.instance_collection):
            yield part
            yield from _instanced(part, looked)


def parts_of_instances(holders: Iterable[Any]) -> Iterator[int]:
    """Yield the session uids of the objects `holders`, and of all objects that they instance.

    Nested instances are included.
    """
    looked: set[Any] = set()
    left = list(holders)
    while left:
        holder = left.pop()
        yield holder.session_uid
        if is_holder(holder) and holder.instance_collection not in looked:
            looked.add(holder.instance_collection)
            left += holder.instance_collection.all_objects


def housed_by(obj: Any) -> Any:
    """Return the sensor whose housing (visible body) an object is; None for any other object.

    A housing is a child, at any depth, of a sensor object without faces, such as an empty.
    """
    if obj is None or is_sensor(obj):
        return None
    owner = next((above for above in chain(obj.parent) if is_sensor(above)), None)
    if owner is None or owner.type not in {"EMPTY", "MESH"}:
        return None
    return owner if owner.type == "EMPTY" or not owner.data.polygons else None


def is_housing(obj: Any) -> bool:
    """Return whether an object is a housing that all sensors see through.

    It is a sensor with the mesh that Add Sensor made, or a child of a sensor without faces. Another
    mesh that is a sensor, such as a door, is none; nor is one whose sensor has a solid housing.
    """
    if is_sensor(obj):
        return not obj.angen_sensor.housing_solid and obj.type == "MESH" and _is_made(obj.data)
    sensor = housed_by(obj)
    return sensor is not None and not sensor.angen_sensor.housing_solid


def has_housing(sensor: Any) -> bool:
    """Return whether an object that is a sensor has a housing, solid or not."""
    return (sensor.type == "MESH" and _is_made(sensor.data)) or any(
        part.type == "MESH" and housed_by(part) == sensor for part in sensor.children_recursive
    )


def _is_made(mesh: Any) -> bool:
    """Return whether the extension has made a mesh as a housing."""
    return HOUSING_MARK in mesh or UNMARKED_HOUSING.search(mesh.name) is not None


def stands_for(obj: Any) -> Any:
    """Return the sensor whose housing (visible body) an object is, or else the object itself."""
    return housed_by(obj) or obj


class Paths:
    """Finds the sensors to which instances belong.

    Make a new object for each pass over `depsgraph.object_instances`.
    """

    def __init__(self) -> None:
        # The objects of each collection, each with the sensors that it is or hangs on.
        self._contents: dict[Any, list[tuple[Any, list[Any]]]] = {}

    def owners(self, instance: Any) -> frozenset[Uid]:
        """Return the identifiers of the sensors to which an instance belongs.

        It belongs to a sensor if the sensor is its object or a parent of its object. The same goes
        for the objects that instance its collections, except for the outermost.
        """
        indices = [i for i in instance.persistent_id if i != UNUSED_LEVEL]
        holders: list[Any] = [instance.parent.original]
        found: set[Uid] = set()
        for number in reversed(indices):
            collection = holders[-1].instance_collection
            if collection is None:
                # The instances of points or particles contain no sensors.
                break
            contents = self._all_objects(collection)
            if number >= len(contents):
                break
            part, sensors = contents[number]
            found |= {uid_of(obj, tuple(holders)) for obj in sensors}
            holders.append(part)
        return frozenset(found)

    def _all_objects(self, collection: Any) -> list[tuple[Any, list[Any]]]:
        """Return the objects of a collection in the order in which `persistent_id` counts them.

        Each is in a pair with a list of the sensors among the object and its parents.
        """
        if collection not in self._contents:
            self._contents[collection] = [
                (obj, [owner for owner in chain(obj) if is_sensor(owner)])
                for obj in collection.all_objects
            ]
        return self._contents[collection]


def chain(obj: Any) -> Iterator[Any]:
    """Yield an object, its parent, and so on up to the topmost parent."""
    seen = set()
    while obj is not None and obj.session_uid not in seen:
        seen.add(obj.session_uid)
        yield obj
        obj = obj.parent
