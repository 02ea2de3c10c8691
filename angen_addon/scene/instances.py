# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects within collection instances: which there are, where each is, and what belongs to whom.

A holder is an object that instances a collection; holders are listed from the outermost in. What is
in an instance is told from its original by its path: the session uid of the object, then those of
its holders from the innermost out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from mathutils import Matrix

from ...sensor_logic.kinds import NO_KIND

# What tells a sensor in this session: the session uid of its object, or its path.
Uid = int | tuple[int, ...]
Holders = tuple[Any, ...]
# Blender marks the unused levels of `persistent_id` with the largest integer.
UNUSED_LEVEL = 2**31 - 1


def is_sensor(obj: Any) -> bool:
    """Whether an object, or None, is a sensor."""
    return obj is not None and obj.angen_sensor.kind != NO_KIND


def uid_of(obj: Any, holders: Holders) -> Uid:
    """An identifier of an object, or of its place in an instance, that no other object has."""
    if not holders:
        return int(obj.session_uid)
    return (obj.session_uid, *(holder.session_uid for holder in reversed(holders)))


def is_holder(obj: Any) -> bool:
    return obj.instance_type == "COLLECTION" and obj.instance_collection is not None


def matrix_of(obj: Any, holders: Holders, depsgraph: Any) -> Matrix:
    """The matrix in the world of an object of an instance, as Blender evaluates it."""
    return within(obj.evaluated_get(depsgraph).matrix_world, holders, depsgraph)


def within(matrix: Matrix, holders: Holders, depsgraph: Any) -> Matrix:
    """The matrix in the world of what has this one in an instanced collection."""
    for holder in reversed(holders):
        evaluated = holder.evaluated_get(depsgraph)
        offset = Matrix.Translation(-evaluated.instance_collection.instance_offset)
        matrix = evaluated.matrix_world @ offset @ matrix
    return matrix


class SensorFinder:
    """Finds what of interest there is in instanced collections, each of which it looks into
    once. It is kept for one search: many instances share a collection."""

    def __init__(self) -> None:
        self._known: dict[Any, tuple[list[Any], list[Any]]] = {}

    def sensors_in(self, holder: Any) -> Iterator[tuple[Any, Holders]]:
        """The objects in a holder's collection that are sensors, each with its holders."""
        yield from self._walk((holder,))

    def _walk(self, holders: Holders) -> Iterator[tuple[Any, Holders]]:
        sensors, inner = self._look(holders[-1].instance_collection)
        for obj in sensors:
            yield obj, holders
        for holder in inner:
            # Blender does not let a collection hold itself, but a damaged file may.
            if holder not in holders:
                yield from self._walk((*holders, holder))

    def _look(self, collection: Any) -> tuple[list[Any], list[Any]]:
        """The sensors of a collection, and the holders in it."""
        if collection not in self._known:
            shown = shown_in(collection)
            self._known[collection] = (
                [obj for obj in shown if is_sensor(obj)],
                [obj for obj in shown if is_holder(obj)],
            )
        return self._known[collection]


def shown_in(collection: Any) -> list[Any]:
    """The objects that an instance of a collection shows, those of its child collections too."""
    return list(dict.fromkeys(_shown(collection)))


def _shown(collection: Any) -> Iterator[Any]:
    if collection.hide_viewport:
        return
    yield from collection.objects
    for child in collection.children:
        yield from _shown(child)


def shown_objects(view_layer: Any) -> Iterator[Any]:
    """The objects that the viewport shows, in the order of the view layer."""
    for obj in view_layer.objects:
        if obj.visible_get(view_layer=view_layer):
            yield obj


def with_instanced(view_layer: Any) -> Iterator[tuple[Any, Any]]:
    """The objects of a view layer, and once each those that collection instances in it show; with
    the object of the view layer that each is, or is in."""
    looked: set[Any] = set()
    for obj in view_layer.objects:
        if obj is not None:
            yield obj, obj
            yield from ((part, obj) for part in _instanced(obj, looked))


def _instanced(obj: Any, looked: set[Any]) -> Iterator[Any]:
    if is_holder(obj) and obj.instance_collection not in looked:
        looked.add(obj.instance_collection)
        for part in shown_in(obj.instance_collection):
            yield part
            yield from _instanced(part, looked)


def parts_of_instances(holders: Iterable[Any]) -> Iterator[int]:
    """The session uids of objects that instance others, and of all in the collections that they
    instance, however deep."""
    looked: set[Any] = set()
    left = list(holders)
    while left:
        holder = left.pop()
        yield holder.session_uid
        if is_holder(holder) and holder.instance_collection not in looked:
            looked.add(holder.instance_collection)
            left += holder.instance_collection.all_objects


def housed_by(obj: Any) -> Any:
    """The sensor that an object is the housing of, or None: it hangs on a sensor that has no faces
    of its own, such as an empty."""
    if obj is None or is_sensor(obj):
        return None
    owner = next((above for above in chain(obj.parent) if is_sensor(above)), None)
    if owner is None or owner.type not in {"EMPTY", "MESH"}:
        return None
    return owner if owner.type == "EMPTY" or not owner.data.polygons else None


def stands_for(obj: Any) -> Any:
    """The sensor that an object is the housing of; else the object itself, which may be None."""
    return housed_by(obj) or obj


class Paths:
    """Which sensors within instances own surfaces, during one look at the scene's instances."""

    def __init__(self) -> None:
        # Of each collection its objects, each with the sensors that it hangs on or is.
        self._contents: dict[Any, list[tuple[Any, list[Any]]]] = {}

    def owners(self, instance: Any) -> frozenset[Uid]:
        """The paths of the sensors that a depsgraph's instance is, or hangs on, in its
        collection; the same of the holders within the outermost one."""
        indices = [i for i in instance.persistent_id if i != UNUSED_LEVEL]
        holders: list[Any] = [instance.parent.original]
        found: set[Uid] = set()
        for number in reversed(indices):
            collection = holders[-1].instance_collection
            if collection is None:
                # Of points or particles: these have no sensors.
                break
            contents = self._all_objects(collection)
            if number >= len(contents):
                break
            part, sensors = contents[number]
            found |= {uid_of(obj, tuple(holders)) for obj in sensors}
            holders.append(part)
        return frozenset(found)

    def _all_objects(self, collection: Any) -> list[tuple[Any, list[Any]]]:
        """The objects of a collection in the order in which `persistent_id` counts them."""
        if collection not in self._contents:
            self._contents[collection] = [
                (obj, [owner for owner in chain(obj) if is_sensor(owner)])
                for obj in collection.all_objects
            ]
        return self._contents[collection]


def chain(obj: Any) -> Iterator[Any]:
    """The object, its parent, and so on."""
    seen = set()
    while obj is not None and obj.session_uid not in seen:
        seen.add(obj.session_uid)
        yield obj
        obj = obj.parent
