# SPDX-License-Identifier: GPL-3.0-or-later
"""What of the sensors the viewport draws: settings of the scene."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, PointerProperty
from bpy.types import Context, PropertyGroup, Scene

from ...scene.lengths import property_group


def redraw_views() -> None:
    """Asks Blender to draw every 3D view again."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


def _changed(self: PropertyGroup, context: Context) -> None:
    redraw_views()


SETTINGS = property_group(
    "AngenOverlay",
    {
        "show": BoolProperty(
            name="Show Sensors",
            description="Draw sensors in the viewport: what they see and what they read. "
            "Off: costs nothing",
            default=True,
        ),
        "which": EnumProperty(
            name="Fields Of",
            description="Whose fields of view are drawn",
            items=[
                ("ALL", "All", "Those of all sensors that the viewport shows", 0),
                ("SELECTED", "Selected", "Those of the selected sensors", 1),
            ],
        ),
        "fields": BoolProperty(
            name="Fields of View",
            description="Draw what each sensor sees: its own rays, to where they end",
            default=True,
        ),
        "handles": BoolProperty(
            name="Handles",
            description="Show handles of the active sensor to drag: its range, its field of view, "
            "the size of a pad. They are gizmos, and hidden with all others",
            default=True,
        ),
        "names": BoolProperty(
            name="Names", description="Write each sensor's name beside it", default=True
        ),
        "values": BoolProperty(
            name="Readings", description="Write what each sensor reads beside it", default=True
        ),
    },
    options=set(),
    update=_changed,
)


def register() -> None:
    bpy.utils.register_class(SETTINGS)
    Scene.angen_overlay = PointerProperty(type=SETTINGS)


def unregister() -> None:
    del Scene.angen_overlay
    bpy.utils.unregister_class(SETTINGS)
