# SPDX-License-Identifier: GPL-3.0-or-later
"""The room that a sensor hangs in, or that an object marks."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy

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
