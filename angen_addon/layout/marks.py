# SPDX-License-Identifier: GPL-3.0-or-later
"""Read and set the marks of objects, which say what residents do there, as plain data.

The residents define the properties of a mark. Here they are read from Blender, so that a layout has
the same names, choices and limits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import bpy

from ...sensor_logic.layout.entries import LayoutEntry
from ...sensor_logic.logs.error import InputError
from ...sensor_logic.logs.wording import hint
from ..scene.instances import objects_of
from ..scene.lengths import SUFFIX
from ..scene.sensors import decimal
from .measured import shortest

NO_USE = "NONE"
# The JSON of each type of property, for error messages.
WORDS = {"BOOLEAN": "true or false", "FLOAT": "a number", "STRING": "a text", "ENUM": "a text"}


def marks_of(view_layer: Any) -> dict[str, dict[str, Any]]:
    """Return the mark of each marked object of a view layer, by the object's name."""
    found = [o for o in objects_of(view_layer) if o.angen_place.use != NO_USE and not o.library]
    return {obj.name: _values(obj) for obj in sorted(found, key=lambda obj: obj.name)}


def _values(obj: Any) -> dict[str, Any]:
    """Return the properties of an object's mark, without those that no mark is guessed to have.

    A new mark guesses its numbers. So they are all there, and restore it.
    """
    mark = obj.angen_place
    properties = _properties(obj)
    found = {name: _plain(getattr(mark, name), properties[name]) for name in properties}
    return {
        name: value
        for name, value in found.items()
        if properties[name].type == "FLOAT" or (value and value != _default(properties[name]))
    }


def _properties(obj: Any) -> dict[str, Any]:
    """Return the RNA properties (`bpy.types.Property`) of an object's mark, by identifier."""
    known = obj.angen_place.bl_rna.properties
    stored = [p for p in known if not p.identifier.endswith(SUFFIX)]
    return {p.identifier: p for p in stored if p.identifier not in ("rna_type", "name")}


def _default(prop: Any) -> Any:
    return None if prop.type == "POINTER" else prop.default


def _plain(value: Any, prop: Any) -> Any:
    if prop.type == "FLOAT":
        return shortest(value) if prop.subtype == "ANGLE" else decimal(value)
    return value.name if prop.type == "POINTER" and value else value


@dataclass
class MarkChange:
    """The properties of an object's mark that a layout changes, by name."""

    entry: LayoutEntry
    obj: Any
    values: dict[str, Any]

    @property
    def name(self) -> str:
        """The name of the marked object."""
        return self.entry.name

    def make(self, rollback: ExitStack) -> None:
        """Set the properties; `rollback` restores them."""
        properties = _properties(self.obj)
        before = {name: getattr(self.obj.angen_place, name) for name in properties}
        rollback.callback(_set, self.obj, before)
        found = {
            name: bpy.data.objects[value] if value and properties[name].type == "POINTER" else value
            for name, value in self.values.items()
        }
        _set(self.obj, found)


def _set(obj: Any, values: Mapping[str, Any]) -> None:
    """Set properties of a mark: its use first, because a new use guesses the others."""
    for name in sorted(values, key=lambda name: name != "use"):
        setattr(obj.angen_place, name, values[name])


def remove_mark(obj: Any) -> str:
    """Remove an object's mark; return the object's name."""
    obj.angen_place.use = NO_USE
    return str(obj.name)


def unlisted(listed: Sequence[LayoutEntry], view_layer: Any) -> list[Any]:
    """Return the marked objects that are not in a layout, except those that cannot be changed."""
    names = {entry.name for entry in listed}
    return [
        bpy.data.objects[name]
        for name in marks_of(view_layer)
        if name not in names and bpy.data.objects[name].is_editable
    ]


def mark_changes(entries: Sequence[LayoutEntry], view_layer: Any) -> list[MarkChange]:
    """Return the changes of the marks in a layout, without marks that stay as they are.

    Raise `InputError` if an entry is wrong.
    """
    changes = [_change(entry, view_layer) for entry in entries]
    return [change for change in changes if change.values]


def _change(entry: LayoutEntry, view_layer: Any) -> MarkChange:
    obj = view_layer.objects.get(entry.name)
    if obj is None:
        raise entry.error(f"no object has this name: {hint(entry.name, view_layer.objects.keys())}")
    if not hasattr(obj, "angen_place"):
        raise InputError(f"{entry.where()}: marks need the residents, which are not installed")
    properties, given = _properties(obj), dict(entry.values)
    del given["name"]
    for name, value in given.items():
        if name not in properties:
            raise entry.error(f"'{name}' is unknown: {hint(name, properties)}", name)
        if problem := _problem(value, properties[name]):
            raise entry.error(f"{name} {problem}", name)
    if given.get("use", obj.angen_place.use) == NO_USE and given.keys() - {"use"}:
        raise entry.error('it is not marked: give a use, such as "use": "DOOR"')
    now = {name: _plain(getattr(obj.angen_place, name), properties[name]) for name in properties}
    # A new use guesses the numbers, so that all given values are set then.
    is_new = given.get("use", now["use"]) != now["use"]
    values = {n: v for n, v in given.items() if is_new or not _is_same(v, now[n], properties[n])}
    if values and not obj.is_editable:
        raise entry.error("it is linked: mark it in its own file, or make a library override of it")
    return MarkChange(entry, obj, values)


def _is_same(value: Any, now: Any, prop: Any) -> bool:
    return bool(decimal(value) == decimal(now) if prop.type == "FLOAT" else value == now)


def _problem(value: Any, prop: Any) -> str:
    """Return why a value is not valid for a property; "" if it is valid."""
    if prop.type == "POINTER":
        if value is None or (isinstance(value, str) and value in bpy.data.objects):
            return ""
        return f"names no object: {hint(str(value), bpy.data.objects.keys())}"
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    sound = {"BOOLEAN": isinstance(value, bool), "FLOAT": number}
    if not sound.get(prop.type, isinstance(value, str)):
        return f"must be {WORDS[prop.type]}"
    if prop.type == "ENUM" and not prop.enum_items.get(value):
        return f"is '{value}': {hint(value, prop.enum_items.keys())}"
    if prop.type == "FLOAT" and not prop.hard_min <= value <= prop.hard_max * (1 + 1e-6):
        return f"is {value:g}: it must be {prop.hard_min:g} to {prop.hard_max:g}"
    return ""
