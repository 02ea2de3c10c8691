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

from .sensors import unit_scale
from .units import SUBTYPES

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
