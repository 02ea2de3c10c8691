# SPDX-License-Identifier: GPL-3.0-or-later
"""Examines the home for causes of nonsensical readings."""

from __future__ import annotations

import bpy
from bpy.types import Context, Operator

from ..angen_addon.doctor.command import count, findings
from ..angen_addon.runtime import state
from .polls import is_idle


class ANGEN_OT_doctor(Operator):
    bl_idname = "angen.doctor"
    bl_label = "Examine Home"
    bl_description = (
        "Look for what makes sensors read nonsense: scale, missing faces, doors without hinges, "
        "lamps, sensors inside walls, missing files; each with the way to mend it"
    )
    bl_options = {"REGISTER"}

    poll = classmethod(is_idle)

    def execute(self, context: Context) -> set[str]:
        found = state.CACHE.findings = tuple(findings())
        self.report({"WARNING" if found else "INFO"}, count(list(found)).capitalize())
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_doctor,))
