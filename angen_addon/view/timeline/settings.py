# SPDX-License-Identifier: GPL-3.0-or-later
"""What the timeline shows of the sensors: settings of the scene."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, PointerProperty, StringProperty
from bpy.types import PropertyGroup, Scene


class AngenTimeline(PropertyGroup):
    show: BoolProperty(
        name="Sensor History",
        description="Show what the sensors recorded in the Timeline and the Dope Sheet",
        default=True,
    )
    rows: EnumProperty(
        name="Rows",
        description="Which sensors have a row",
        items=[
            ("ALL", "All", "Every sensor, by room", 0),
            ("ROOM", "Room", "The sensors of the active sensor's room", 1),
            ("SELECTED", "Selected", "The selected sensors", 2),
        ],
    )
    names: BoolProperty(
        name="Names",
        description="Write each sensor's name on its row, where it is high enough",
        default=True,
    )
    values: BoolProperty(
        name="Also Values",
        description="Jump to changes of measured values too, and mark them: not only to those of "
        "states",
    )
    # Names of the markers that were made for events, a line each: markers keep no data of others
    # (Blender 5.2), and those that the user renames are the user's.
    marked: StringProperty(options={"HIDDEN"})


def register() -> None:
    bpy.utils.register_class(AngenTimeline)
    Scene.angen_timeline = PointerProperty(type=AngenTimeline)


def unregister() -> None:
    del Scene.angen_timeline
    bpy.utils.unregister_class(AngenTimeline)
