# SPDX-License-Identifier: GPL-3.0-or-later
"""Copy the active sensor's settings to the selected sensors of the same kind."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Operator

from ..angen_addon.scene.instances import is_sensor, stands_for
from ..angen_addon.translations.interface import translated
from ..sensor_logic.kind import Kind
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.logs.wording import listed, plural
from ..sensor_logic.parameters import specs
from .polls import cancelled, needs

RATE = "update_rate"
SHOWN = 3


def suggested_parameters(self: Any, context: Context, text: str) -> list[tuple[str, str]]:
    """Return name and label of the parameters that contain the text typed so far."""
    found = [(RATE, "Update rate")]
    source = stands_for(context.object)
    if is_sensor(source):
        kind = KINDS[source.angen_sensor.kind]
        found += [(name, spec.label) for name, spec in specs(kind.parameters).items()]
    return [pair for pair in found if text.lower() in " ".join(pair).lower()]


class ANGEN_OT_copy_to_selected(Operator):
    bl_idname = "angen.copy_to_selected"
    bl_label = "Copy Settings to Selected"
    bl_description = (
        "Give the selected sensors of the same kind the parameters and the update rate of the "
        "active one. To copy one parameter, hold Alt while editing it, or use Copy to Selected in "
        "its menu"
    )
    bl_options = {"REGISTER", "UNDO"}

    parameter: StringProperty(
        name="Parameter",
        description="Name of the parameter to copy. Empty: all parameters and the update rate",
        search=suggested_parameters,
        search_options={"SUGGESTION"},
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(
            cls,
            is_sensor(stands_for(context.object)),
            "Select the sensor to copy from, so that it is active",
        ) and needs(
            cls,
            any(stands_for(o) != stands_for(context.object) for o in context.selected_objects),
            "Select the sensors to copy to, then the sensor to copy from, which becomes the "
            "active one",
        )

    def execute(self, context: Context) -> set[str]:
        source = stands_for(context.object)
        kind = KINDS[source.angen_sensor.kind]
        names = [RATE, *specs(kind.parameters)]
        if self.parameter:
            if self.parameter not in names:
                return cancelled(
                    self,
                    f"A '{kind.label}' has no parameter '{self.parameter}': it has "
                    f"{', '.join(names)}",
                )
            names = [self.parameter]
        done, left_out = 0, []
        for obj in dict.fromkeys(map(stands_for, context.selected_objects)):
            if obj == source:
                continue
            reason = _why_not(obj, kind)
            if reason:
                left_out.append(f"'{obj.name}' ({translated(reason)})")
                continue
            for name in names:
                setattr(_owner(obj, kind, name), name, getattr(_owner(source, kind, name), name))
            if not self.parameter:
                obj.angen_sensor.preset = source.angen_sensor.preset
            done += 1
        what = f"{len(names)} settings" if len(names) > 1 else names[0]
        report = f"Copied {what} from '{source.name}' to {plural(done, 'sensor')}"
        if left_out:
            report += f". Left out: {listed(left_out, SHOWN)}"
        self.report({"INFO" if done else "ERROR"}, translated(report))
        return {"FINISHED" if done else "CANCELLED"}


def _owner(obj: Any, kind: Kind, name: str) -> Any:
    return obj.angen_sensor if name == RATE else getattr(obj.angen_sensor, kind.attribute)


def _why_not(obj: Any, kind: Kind) -> str:
    """Return why an object cannot get the settings of the active sensor; empty if it can."""
    if not is_sensor(obj):
        return "not a sensor"
    if obj.angen_sensor.kind != kind.identifier:
        return f"another kind: {KINDS[obj.angen_sensor.kind].label}"
    if not obj.is_editable:
        return "linked: make it local or a library override"
    return ""


register, unregister = bpy.utils.register_classes_factory((ANGEN_OT_copy_to_selected,))
