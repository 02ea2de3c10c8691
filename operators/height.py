# SPDX-License-Identifier: GPL-3.0-or-later
"""How high a sensor that is being placed is above what lies below it, and a typed height."""

from __future__ import annotations

import re
from typing import Any

import bpy
from bpy.types import Event
from mathutils import Vector

from ..angen_addon.scene.sensors import unit_scale
from ..angen_addon.scene.units import lengths_of
from .surface import PASSED, Surface, first_surface

UP = Vector((0.0, 0.0, 1.0))
# A surface rises if this share of a step along it goes up.
RISES = 0.5
# What faces up by more than this share carries what is placed on it.
CARRIES = 0.5
# A length as it may be typed: numbers, each with a unit or without.
LENGTH = re.compile(r"-?((\d+\.?\d*|\.\d+)(mm|cm|m|ft|in|'|\")?)+")
NUMBER = re.compile(r"-?(\d+\.?\d*|\.\d+)")
TYPED = set("0123456789.-mcftin'\"")
ENDS = {"RET", "NUMPAD_ENTER"}


def below(scene: Any, depsgraph: Any, place: Vector, on: Surface) -> Surface | None:
    """The floor below a place on a surface: not what it lies on itself, whose underside is none,
    and nothing as steep as a wall that leans."""
    carrier = on.object if on.normal.z > CARRIES else None
    off = UP * (1e-3 / unit_scale(scene))
    start = place
    for _ in range(PASSED):
        met = first_surface(scene, depsgraph, start - off, -UP, passes=lambda o: o == carrier)
        if met is None or met.normal.z > CARRIES:
            return met
        start = met.point
    return None


def height_text(scene: Any, place: Vector, floor: Surface | None) -> str:
    """How high a place is, and how far above what lies below it."""
    scale, lengths = unit_scale(scene), lengths_of(scene)
    height = f"Z {lengths.text(place.z * scale)}"
    if floor is None:
        return height
    above = lengths.text((place.z - floor.point.z) * scale)
    return f"{height}, {above} above '{floor.object.name}'"


def raised(point: Vector, normal: Vector, way: float) -> Vector | None:
    """A point of a surface with this normal, `way` higher on it; None where it does not rise."""
    along = UP - normal * normal.z
    if along.length < RISES:
        return None
    return point + along * (way / along.length_squared)


class TypedLength:
    """A length as the user types it."""

    def __init__(self) -> None:
        self.text = ""

    def take(self, event: Event) -> bool:
        """Whether a key that was pressed is part of it. Letters are, once there is a number."""
        if event.type == "BACK_SPACE" and self.text:
            self.text = self.text[:-1]
            return True
        letter = "" if event.ctrl or event.alt else event.unicode.replace(",", ".")
        if event.type.startswith("NUMPAD_") and event.type[7:].isdigit():
            letter = event.type[7:]
        if len(letter) != 1 or letter not in TYPED or (letter.isalpha() and not self.text):
            return False
        self.text += letter
        return True

    def metres(self, scene: Any) -> float | None:
        """A number alone is in the unit that the scene shows; None as long as it is no length."""
        if not LENGTH.fullmatch(self.text):
            return None
        number = NUMBER.fullmatch(self.text)
        if number is not None:
            return float(number.group()) * lengths_of(scene).metres
        system = "IMPERIAL" if scene.unit_settings.system == "IMPERIAL" else "METRIC"
        return float(bpy.utils.units.to_value(system, "LENGTH", self.text))
