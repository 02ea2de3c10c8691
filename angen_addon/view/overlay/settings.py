# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene settings that decide what 3D views draw of sensors."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, PointerProperty
from bpy.types import Context, PropertyGroup, Scene

from ...scene.lengths import property_group


def redraw_views() -> None:
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
            description="Draw in 3D views what sensors see and read. If off, it costs no time",
            default=True,
        ),
        "which": EnumProperty(
            name="Fields Of",
            description="Sensors whose fields of view are drawn",
            items=[
                ("ALL", "All", "All sensors that the viewport shows", 0),
                ("SELECTED", "Selected", "The selected sensors", 1),
            ],
        ),
        "fields": BoolProperty(
            name="Fields of View",
            description="Draw what each sensor sees: its rays, up to the surfaces that they hit",
            default=True,
        ),
        "handles": BoolProperty(
            name="Handles",
            description="Show handles to drag on the active sensor: its range, its field of view, "
            "the size of a pad. The Gizmos button of the view hides them too",
            default=True,
        ),
        "names": BoolProperty(
            name="Names", description="Write each sensor's name beside it", default=True
        ),
        "values": BoolProperty(
            name="Readings", description="Write each sensor's reading beside it", default=True
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
