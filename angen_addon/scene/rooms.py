# SPDX-License-Identifier: GPL-3.0-or-later
"""The room that a sensor hangs in, or that an object marks."""

from __future__ import annotations

from typing import Any

import bpy

# Of files that were saved before the sensor had a field for it: a custom property of the object.
CUSTOM = "room"


def room_of(obj: Any) -> str:
    """The room noted on an object; empty where none is."""
    return str(obj.angen_sensor.room or obj.get(CUSTOM, ""))


def known_rooms(_owner: Any, _context: Any, typed: str) -> list[str]:
    """Suggestions for the field: the rooms that are used anywhere in the file."""
    rooms = {room_of(obj) for obj in bpy.data.objects} - {""}
    return sorted((room for room in rooms if typed.lower() in room.lower()), key=str.lower)
