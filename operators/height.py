# SPDX-License-Identifier: GPL-3.0-or-later
"""The height of a sensor above the floor while it is being placed, and typed heights."""

from __future__ import annotations

import re
from typing import Any

import bpy
from bpy.types import Event
from mathutils import Vector

from ..angen_addon.scene.sensors import unit_scale
from ..angen_addon.scene.units import lengths_of
from .surface import PASSED, SurfacePoint, first_surface

UP = Vector((0.0, 0.0, 1.0))
# A surface rises if a step along it goes up by at least this share.
RISES = 0.5
# A surface whose normal points up by more than this share counts as a floor.
CARRIES = 0.5
# A typed length: numbers, each with or without a unit.
LENGTH = re.compile(r"-?((\d+\.?\d*|\.\d+)(mm|cm|m|ft|in|'|\")?)+")
NUMBER = re.compile(r"-?(\d+\.?\d*|\.\d+)")
TYPED = set("0123456789.-mcftin'\"")
ENDS = {"RET", "NUMPAD_ENTER"}


def below(scene: Any, depsgraph: Any, place: Vector, on: SurfacePoint) -> SurfacePoint | None:
    """The floor below a place on a surface. Neither the object of that surface counts as a floor,
    nor anything as steep as a leaning wall."""
    carrier = on.object if on.normal.z > CARRIES else None
    off = UP * (1e-3 / unit_scale(scene))
    start = place
    for _ in range(PASSED):
        met = first_surface(scene, depsgraph, start - off, -UP, passes=lambda o: o == carrier)
        if met is None or met.normal.z > CARRIES:
            return met
        start = met.point
    return None


def height_text(scene: Any, place: Vector, floor: SurfacePoint | None) -> str:
    """A text for the height of a place, and its height above the floor."""
    scale, lengths = unit_scale(scene), lengths_of(scene)
    height = f"Z {lengths.text(place.z * scale)}"
    if floor is None:
        return height
    above = lengths.text((place.z - floor.point.z) * scale)
    return f"{height}, {above} above '{floor.object.name}'"


def raised(point: Vector, normal: Vector, way: float) -> Vector | None:
    """The point `way` higher on a surface with this normal; None where the surface is level."""
    along = UP - normal * normal.z
    if along.length < RISES:
        return None
    return point + along * (way / along.length_squared)


class TypedLength:
    """Collects a length from typed keys."""

    def __init__(self) -> None:
        self.text = ""

    def take(self, event: Event) -> bool:
        """Adds a pressed key, and returns whether it is part of a length; letters are, after a
        number."""
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
        """The length in m, or None; a number alone is in the scene's unit."""
        if not LENGTH.fullmatch(self.text):
            return None
        number = NUMBER.fullmatch(self.text)
        if number is not None:
            return float(number.group()) * lengths_of(scene).metres
        system = "IMPERIAL" if scene.unit_settings.system == "IMPERIAL" else "METRIC"
        return float(bpy.utils.units.to_value(system, "LENGTH", self.text))
