# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene settings of the sensors' history in the timeline."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, PointerProperty, StringProperty
from bpy.types import PropertyGroup, Scene


class AngenTimeline(PropertyGroup):
    """What the timeline shows of sensors."""

    show: BoolProperty(
        name="Sensor History",
        description="Show the recording of the sensors in the Timeline",
        default=True,
    )
    rows: EnumProperty(
        name="Rows",
        description="Sensors that have a row",
        items=[
            ("ALL", "All", "Every sensor, by room", 0),
            ("ROOM", "Room", "The sensors of the active sensor's room", 1),
            ("SELECTED", "Selected", "The selected sensors", 2),
        ],
    )
    names: BoolProperty(
        name="Names",
        description="Write each sensor's name on its row, if the row is high enough",
        default=True,
    )
    values: BoolProperty(
        name="Also Values",
        description="Also jump to and mark changes of measured values, not only changes of states",
    )
    # Names of the markers that were made for events, one on each line. Markers keep no custom data
    # (Blender 5.2). A marker that the user renames then belongs to the user.
    marked: StringProperty(options={"HIDDEN"})


def register() -> None:
    bpy.utils.register_class(AngenTimeline)
    Scene.angen_timeline = PointerProperty(type=AngenTimeline)


def unregister() -> None:
    del Scene.angen_timeline
    bpy.utils.unregister_class(AngenTimeline)
