# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of properties with lengths in metres, for scenes with any unit.

Blender takes a length property as Blender units, and shows it times the scene's unit scale. So each
length in metres has a second property for the same length in Blender units. If the scene's unit is
not the metre, panels draw the second one. It stores nothing: keyframes, drivers, presets and files
have the metres.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import FloatProperty
from bpy.types import PropertyGroup

from ...sensor_logic.logs.wording import METRES, Lengths
from ...sensor_logic.parameters import READING
from ..translations.dictionary import CONTEXT
from .sensors import unit_scale

# By the identifiers of a scene's length unit in Blender.
UNITS = {
    "KILOMETERS": Lengths("km", 1000.0),
    "METERS": METRES,
    "CENTIMETERS": Lengths("cm", 0.01),
    "MILLIMETERS": Lengths("mm", 0.001),
    "MICROMETERS": Lengths("µm", 1e-6),
    "MILES": Lengths("mi", 1609.344),
    "FEET": Lengths("ft", 0.3048),
    "INCHES": Lengths("in", 0.0254),
    "THOU": Lengths("thou", 2.54e-5),
}
# Units that Blender shows and converts in a field, with the subtype of the property.
SUBTYPES = {"m": "DISTANCE", "rad": "ANGLE", "s": "TIME_ABSOLUTE"}
SPEED = "m/s"


def with_unit(label: str, unit: str, scene: Any = None) -> str:
    """Return a label with its unit, or without one if Blender shows the unit in the field.

    In a scene without units, Blender shows only the unit of angles.
    """
    is_plain = scene is not None and scene.unit_settings.system == "NONE"
    shown = ("rad",) if is_plain else (*SUBTYPES, SPEED)
    return label if unit in ("", READING, *shown) else f"{label} ({unit})"


def lengths_of(scene: Any) -> Lengths:
    """Return the unit in which the scene shows lengths; metres if its settings name none."""
    settings = scene.unit_settings
    if settings.system == "NONE":
        return METRES
    adaptive = UNITS["FEET"] if settings.system == "IMPERIAL" else METRES
    return UNITS.get(settings.length_unit, adaptive)


OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}
SUFFIX = "_in_units"


def in_units(name: str) -> str:
    """Return the name of the property in Blender units that goes with `name`, which has metres."""
    return name + SUFFIX


def property_group(name: str, properties: dict[str, Any], **common: Any) -> type:
    """Return a property group class. Each property gets the arguments `common` too.

    Each length also gets a second property, in Blender units.
    """
    annotations = {}
    for key, prop in properties.items():
        facts = {"translation_context": CONTEXT, **common, **prop.keywords}
        annotations[key] = prop.function(**facts)
        if facts.get("subtype") == SUBTYPES["m"]:
            tip, precision = facts["description"], facts.get("precision", 3)
            annotations[in_units(key)] = length_in_units(key, facts["name"], tip, precision)
    return type(name, (PropertyGroup,), {"__annotations__": annotations})


def length_in_units(
    name: str, label: str, tip: str, precision: int = 3, unit: str = "LENGTH"
) -> Any:
    """Return a bpy property in Blender units for the property `name`, which stores metres.

    It cannot be animated, but the property in metres can. With the `unit` VELOCITY, it is a speed.
    """

    def read(owner: Any) -> float:
        return float(getattr(owner, name)) / _metres()

    def write(owner: Any, length: float) -> None:
        setattr(owner, name, length * _metres())

    return FloatProperty(
        name=label,
        description=tip,
        translation_context=CONTEXT,
        unit=unit,
        min=0.0,
        precision=precision,
        step=1,
        options={"SKIP_SAVE"},
        override=OVERRIDABLE,
        get=read,
        set=write,
    )


def _metres() -> float:
    scene = bpy.context.scene
    return unit_scale(scene) if scene is not None else 1.0
