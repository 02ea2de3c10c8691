# SPDX-License-Identifier: GPL-3.0-or-later
"""Map where motion detectors notice a person, with progress; Esc cancels."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import StringProperty
from bpy.types import Context, Operator
from bpy_extras.io_utils import ExportHelper

from ..angen_addon.coverage import shown
from ..angen_addon.coverage.command import picture
from ..angen_addon.coverage.maps import MAPPED, cover
from ..angen_addon.coverage.settings import motion_of, room_names
from ..angen_addon.output.output_files import write
from ..angen_addon.relative_path import ChosenFile
from ..angen_addon.scene.sensors import all_sensors, decimal
from ..angen_addon.translations.interface import translated
from ..sensor_logic.coverage.grid import CoverageMap, map_csv
from ..sensor_logic.logs.error import AngenError
from ..sensor_logic.logs.files import check_folder
from ..sensor_logic.logs.wording import plural
from ..sensor_logic.progress import Work, finished
from .long_work import LongWork
from .polls import can_read_scene, cancelled, needs


def has_detector(cls: Any, context: Context) -> bool:
    """Poll: whether the view layer has an enabled motion detector."""
    found = (o.angen_sensor for o in context.view_layer.objects)
    mapped = {kind.identifier for kind in MAPPED}
    return needs(
        cls,
        any(s.kind in mapped and s.enabled for s in found),
        "Add a motion detector first: Shift+A, Sensor",
    ) and can_read_scene(cls, context)


def begin_map(context: Context) -> Work[CoverageMap]:
    """Return the work that computes a coverage map with the scene's settings."""
    settings = context.scene.angen_coverage
    sensors = all_sensors(context.view_layer)
    chosen = [s for s in sensors if not settings.selected or s.selected]
    return cover(
        context.evaluated_depsgraph_get(),
        sensors,
        chosen,
        motion_of(settings.motion, settings.height),
        decimal(settings.cell),
        room_names(settings.rooms),
    )


class ANGEN_OT_coverage(LongWork, Operator):
    bl_idname = "angen.coverage"
    bl_label = "Map Coverage"
    bl_description = (
        "Map where the detectors notice the chosen motion, as the scene is now: walls, furniture "
        "and doors hide the floor behind them. Esc cancels"
    )
    bl_options = {"REGISTER", "UNDO"}

    poll = classmethod(has_detector)

    def _begin(self, context: Context) -> Work[CoverageMap]:
        return begin_map(context)

    def _finish(self, context: Context, result: CoverageMap) -> None:
        scene = context.scene
        shown.bring_back(scene)
        shown.show_map(scene, result)
        shown.keep(scene, result)
        whole = result.total()
        self.report(
            {"INFO"},
            translated(
                f"{result.motion.label}: {100 * whole.share:.1f} % of "
                f"{whole.cells * whole.area:.1f} m² of free floor is covered, "
                f"{whole.dead * whole.area:.1f} m² is not"
            ),
        )


class ANGEN_OT_coverage_clear(Operator):
    bl_idname = "angen.coverage_clear"
    bl_label = "Clear Coverage"
    bl_description = "Remove the coverage maps from the scene"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        return needs(
            cls, any(shown.is_map(obj) for obj in context.scene.objects), "There is no coverage map"
        )

    def execute(self, context: Context) -> set[str]:
        count = shown.remove(context.scene)
        shown.forget(context.scene)
        self.report({"INFO"}, translated(f"Removed {plural(count, 'coverage map')}"))
        return {"FINISHED"}


class ANGEN_OT_export_coverage(Operator, ChosenFile, ExportHelper):
    bl_idname = "angen.export_coverage"
    bl_label = "Export Coverage"
    bl_description = "Map the coverage again and write it: .svg for a picture, .csv for the cells"

    filename_ext = ".svg"
    check_extension = None
    filter_glob: StringProperty(default="*.svg;*.csv", options={"HIDDEN"})

    poll = classmethod(has_detector)

    def execute(self, context: Context) -> set[str]:
        path = self.path
        try:
            if path.suffix.lower() not in {".svg", ".csv"}:
                raise AngenError(f"Export: {path.name} must end in .svg or .csv")
            check_folder(path.parent, "Export")
            found = finished(begin_map(context))
            text = map_csv(found)
            if path.suffix.lower() == ".svg":
                depsgraph = context.evaluated_depsgraph_get()
                sensors = all_sensors(context.view_layer)
                text = picture(depsgraph, sensors, found, f"Coverage of {context.scene.name}")
            write({path: text})
        except AngenError as error:
            return cancelled(self, error)
        self.report({"INFO"}, translated(f"Written: {path}")[:200])
        return {"FINISHED"}


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_OT_coverage, ANGEN_OT_coverage_clear, ANGEN_OT_export_coverage)
)
