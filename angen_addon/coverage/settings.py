# SPDX-License-Identifier: GPL-3.0-or-later
"""What coverage maps and proposals are made of: settings of the scene."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty
from bpy.props import StringProperty as Text
from bpy.types import Scene

from ...sensor_logic.coverage.motions import HIGHEST, MOTIONS, Motion
from ..scene.lengths import property_group
from ..scene.sensors import decimal
from .maps import LARGEST_CELL, SMALLEST_CELL


def _group() -> type:
    motions = [(m.identifier, m.label, m.tip, i) for i, m in enumerate(MOTIONS.values())]
    properties = {
        "motion": EnumProperty(name="Motion", description="What moves in each cell", items=motions),
        "height": FloatProperty(
            name="Height",
            description="Above the floor: the top of what walks, the middle of a chest or an arm. "
            "0: as the motion has it",
            min=0.0,
            max=HIGHEST,
            subtype="DISTANCE",
        ),
        "cell": FloatProperty(
            name="Cell",
            description="Side of a cell. Half of it takes four times as long",
            default=0.25,
            min=SMALLEST_CELL,
            max=LARGEST_CELL,
            subtype="DISTANCE",
        ),
        "selected": BoolProperty(
            name="Selected Only", description="Only the selected motion detectors, instead of all"
        ),
        "rooms": Text(name="Rooms", description="Names of rooms, with commas between; empty: all"),
        "count": IntProperty(
            name="Detectors",
            description="How many motion detectors to place",
            default=1,
            min=1,
            max=100,
        ),
        "mounting": EnumProperty(
            name="Mounting",
            description="Where they may hang",
            items=[
                ("WALL", "Walls", "On walls, at the mounting height", 0),
                ("CEILING", "Ceilings", "Under ceilings, looking down", 1),
                ("BOTH", "Both", "On walls or under ceilings", 2),
            ],
        ),
        "mounting_height": FloatProperty(
            name="On Walls At",
            description="Above the floor, on walls",
            default=2.3,
            min=0.1,
            max=10.0,
            subtype="DISTANCE",
        ),
        "beside": BoolProperty(
            name="Keep Others",
            description="Count only what the motion detectors of the scene do not cover",
        ),
    }
    return property_group("AngenCoverageSettings", properties, options=set())


def motion_of(identifier: str, height: float) -> Motion:
    """The motion, at a height (m) where that is not 0. Raises AngenError."""
    motion = MOTIONS[identifier]
    if height == 0.0:
        return motion
    return motion.at_height(decimal(height))


def room_names(text: str) -> tuple[str, ...]:
    """Names between commas."""
    return tuple(name for name in (part.strip() for part in text.split(",")) if name)


# Alive from register() to unregister() only: Blender 4.2 as a Python module crashes at exit where
# a property with functions of ours is still around.
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
