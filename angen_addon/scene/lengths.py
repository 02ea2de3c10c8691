# SPDX-License-Identifier: GPL-3.0-or-later
"""Groups of properties, of which some hold lengths in metres, in scenes whose unit is another.

Blender takes what a property of lengths holds for Blender units, and shows and reads it times the
scene's unit scale. So each such property has a second one beside it, which stands for the same
length in Blender units; panels draw that where the scene's unit is not the metre. It stores
nothing: keyframes, drivers, presets and files have the metres.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import FloatProperty
from bpy.types import PropertyGroup

from ...sensor_logic.parameters import READING
from ...sensor_logic.wording import METRES, Lengths
from .sensors import unit_scale

# The scene's units: what lengths are shown in.

# By Blender's names of the units that a scene can be set to.
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
# Units that Blender shows in a field, converts, and reads, by the subtype of the property.
SUBTYPES = {"m": "DISTANCE", "rad": "ANGLE", "s": "TIME_ABSOLUTE"}


def with_unit(label: str, unit: str, scene: Any = None) -> str:
    """A label with the unit of what stands beside it, unless Blender shows that in the field; in a
    scene without units it shows degrees alone."""
    shown = ("rad",) if scene is not None and scene.unit_settings.system == "NONE" else SUBTYPES
    return label if unit in ("", READING, *shown) else f"{label} ({unit})"


def lengths_of(scene: Any) -> Lengths:
    """The unit in which the scene shows lengths; metres if its settings name none."""
    settings = scene.unit_settings
    if settings.system == "NONE":
        return METRES
    adaptive = UNITS["FEET"] if settings.system == "IMPERIAL" else METRES
    return UNITS.get(settings.length_unit, adaptive)


OVERRIDABLE = {"LIBRARY_OVERRIDABLE"}
SUFFIX = "_in_units"


def in_units(name: str) -> str:
    """The name of the property beside the one that holds metres."""
    return name + SUFFIX


def property_group(name: str, properties: dict[str, Any], **common: Any) -> type:
    """A class of properties, all with the arguments in `common`; each length has its second one."""
    annotations = {}
    for key, prop in properties.items():
        facts = {**common, **prop.keywords}
        annotations[key] = prop.function(**facts)
        if facts.get("subtype") == SUBTYPES["m"]:
            tip, precision = facts["description"], facts.get("precision", 3)
            annotations[in_units(key)] = length_in_units(key, facts["name"], tip, precision)
    return type(name, (PropertyGroup,), {"__annotations__": annotations})


def length_in_units(name: str, label: str, tip: str, precision: int = 3) -> Any:
    """The bpy property that stands in Blender units for `name`, which holds metres. It cannot be
    animated: what it stands for can."""

    def read(owner: Any) -> float:
        return float(getattr(owner, name)) / _metres()

    def write(owner: Any, length: float) -> None:
        setattr(owner, name, length * _metres())

    return FloatProperty(
        name=label,
        description=tip,
        subtype="DISTANCE",
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
