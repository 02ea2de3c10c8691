# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the sensor whose sign is below the mouse.

Blender reports the position of the mouse only to gizmos. The gizmo of this module is invisible and
never hit. Clicks therefore go to Blender and to `operators/sign_select.py`.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.types import Context, Gizmo, GizmoGroup

from ...scene.sensors import Sensor
from . import refresh
from .labels import nearest, sign_at

# Pixels at an interface scale of 1.
REACH = 11.0


class ANGEN_GT_hover(Gizmo):
    """An invisible gizmo that gets the position of the mouse."""

    bl_idname = "ANGEN_GT_hover"

    def draw(self, context: Context) -> None:
        pass

    def test_select(self, context: Context, location: Any) -> int:
        note_hovered(context, location)
        return -1


class ANGEN_GGT_hover(GizmoGroup):
    """The group of the invisible gizmo that gets the position of the mouse."""

    bl_idname = "ANGEN_GGT_hover"
    bl_label = "Sensor under the Mouse"
    bl_space_type = "VIEW_3D"
    bl_region_type = "WINDOW"
    bl_options = {"PERSISTENT"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return is_drawn(context)

    def setup(self, context: Context) -> None:
        self.gizmos.new(ANGEN_GT_hover.bl_idname)


def is_drawn(context: Context) -> bool:
    """Return whether the 3D view shows sensors."""
    return bool(context.scene.angen_overlay.show and context.space_data.overlay.show_overlays)


def sensor_at(context: Context, place: Any) -> Sensor | None:
    """Return the sensor whose sign or label is at `place`, in pixels of the region, or None."""
    drawn = refresh.overlay
    if drawn is None or context.region is None or not is_drawn(context):
        return None
    board = drawn.boards.get(context.region.as_pointer())
    reach = REACH * context.preferences.system.ui_scale
    uid = sign_at(board, place, reach) if board is not None else None
    return next((seen.sensor for seen in drawn.seen if seen.uid == uid), None)


def note_hovered(context: Context, location: Any) -> None:
    """Store the sensor whose sign is at `location` (pixels), so that its label is shown in full."""
    drawn = refresh.overlay
    if drawn is None or context.region is None:
        return
    board = drawn.boards.get(context.region.as_pointer())
    reach = REACH * context.preferences.system.ui_scale
    found = nearest(board.markers if board is not None else {}, location, reach)
    if found != drawn.hovered:
        drawn.hovered = found
        context.region.tag_redraw()


register, unregister = bpy.utils.register_classes_factory((ANGEN_GT_hover, ANGEN_GGT_hover))
