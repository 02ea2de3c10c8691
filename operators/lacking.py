# SPDX-License-Identifier: GPL-3.0-or-later
"""Search again for missing libraries and files, and for drivers that Blender disabled."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator

from ..angen_addon.advice import lacking


class ANGEN_OT_look_for_lacking(Operator):
    bl_idname = "angen.look_for_lacking"
    bl_label = "Look Again"
    bl_description = (
        "Look again for missing libraries and files, and for drivers that Blender blocked"
    )

    def execute(self, context: Context) -> set[str]:
        lacking.look(context.view_layer)
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_look_for_lacking,))
