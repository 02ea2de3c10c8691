# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel that lists the mistakes which Examine Home found, each with its remedy (sidebar)."""

from __future__ import annotations

import bpy
from bpy.types import Context, Panel

from ..angen_addon.appearance.panel_parts import ClosedSidebar, draw_lines
from ..operators import doctor

MOST = 8


class ANGEN_PT_doctor(ClosedSidebar, Panel):
    bl_label = "Doctor"
    help_page = "your_own_home"

    def draw(self, context: Context) -> None:
        layout = self.layout
        layout.operator("angen.doctor", icon="VIEWZOOM")
        found = doctor.found
        if found is None:
            return
        if not found:
            layout.label(text="No problem found", icon="CHECKMARK")
        for index, finding in enumerate(found[:MOST]):
            select = ("angen.doctor_select", index) if finding.objects else None
            box = draw_lines(layout, finding.text, "ERROR", select)
            draw_lines(box, finding.mend, "TOOL_SETTINGS")
        if len(found) > MOST:
            layout.label(text=f"and {len(found) - MOST} more", icon="BLANK1")
        if found:
            layout.label(text="After changes, press Examine Home again", icon="INFO")


register, unregister = bpy.utils.register_classes_factory((ANGEN_PT_doctor,))
