# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene settings of coverage maps and proposals."""

from __future__ import annotations

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)  # fmt: skip
from bpy.types import Scene

from ...sensor_logic.coverage.motions import HIGHEST, MOTIONS, Motion
from ..scene.lengths import property_group
from ..scene.sensors import decimal
from .maps import LARGEST_CELL, SMALLEST_CELL


def _group() -> type:
    motions = [(m.identifier, m.label, m.tip, i) for i, m in enumerate(MOTIONS.values())]
    properties = {
        "motion": EnumProperty(
            name="Motion", description="Motion that is tested in each cell", items=motions
        ),
        "height": FloatProperty(
            name="Height",
            description="Height of the motion above the floor: of the top of a walker, or of the "
            "middle of a chest or arm. 0: the usual height of the motion",
            min=0.0,
            max=HIGHEST,
            subtype="DISTANCE",
        ),
        "cell": FloatProperty(
            name="Cell",
            description="Length of the side of a cell. Half the length takes four times as long",
            default=0.25,
            min=SMALLEST_CELL,
            max=LARGEST_CELL,
            subtype="DISTANCE",
        ),
        "selected": BoolProperty(
            name="Selected Only",
            description="Map only the selected motion detectors, instead of all",
        ),
        "rooms": StringProperty(
            name="Rooms", description="Names of rooms, separated by commas. Empty: all rooms"
        ),
        "count": IntProperty(
            name="Detectors",
            description="Number of motion detectors to place",
            default=1,
            min=1,
            max=100,
        ),
        "mounting": EnumProperty(
            name="Mounting",
            description="Surfaces to mount the detectors on",
            items=[
                ("WALL", "Walls", "On walls, at the mounting height", 0),
                ("CEILING", "Ceilings", "Below ceilings, looking down", 1),
                ("BOTH", "Both", "On walls or below ceilings", 2),
            ],
        ),
        "mounting_height": FloatProperty(
            name="On Walls At",
            description="Height of detectors on walls, above the floor",
            default=2.3,
            min=0.1,
            max=10.0,
            subtype="DISTANCE",
        ),
        "beside": BoolProperty(
            name="Keep Others",
            description="Count only the floor that the present motion detectors do not cover",
        ),
    }
    return property_group("AngenCoverageSettings", properties, options=set())


def motion_of(identifier: str, height: float) -> Motion:
    """Return the motion with this identifier, for a body of `height` m; 0 means the usual height.

    Raise `AngenError` if the motion is impossible at this height.
    """
    motion = MOTIONS[identifier]
    if height == 0.0:
        return motion
    return motion.at_height(decimal(height))


def room_names(text: str) -> tuple[str, ...]:
    """Return the names in a comma-separated text."""
    return tuple(name for name in (part.strip() for part in text.split(",")) if name)


# The class exists from register() to unregister() only. Blender 4.2 as a Python module crashes at
# exit if a property with Python functions still exists.
_groups: list[type] = []


def register() -> None:
    _groups.append(_group())
    bpy.utils.register_class(_groups[0])
    Scene.angen_coverage = PointerProperty(type=_groups[0])


def unregister() -> None:
    del Scene.angen_coverage
    cls = _groups.pop()
    bpy.utils.unregister_class(cls)
    cls.__annotations__.clear()
