# SPDX-License-Identifier: GPL-3.0-or-later
"""Panel Simulation: simulate, export, bake (tab "Sensors" of the 3D view's sidebar)."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
from bpy.types import Context, Panel, Scene, UILayout

from ..angen_addon.advice import lacking
from ..angen_addon.advice.sensing import background_sets
from ..angen_addon.appearance.panel_parts import (
    ClosedSidebar,
    Sidebar,
    draw_lines,
    draw_progress,
    draw_property,
)
from ..angen_addon.recording.followed_scene import THIS_BLENDER, version_text
from ..angen_addon.recording.results import RESULTS
from ..angen_addon.runtime.edits import EDITS
from ..angen_addon.runtime.running import is_running
from ..angen_addon.scene.sensors import Sensor, simulated
from ..operators.export_options import draw_start
from ..sensor_logic.kind import LIGHT
from ..sensor_logic.logs.wording import capital, plural

SHOWN_LACKS = 3


class ANGEN_PT_simulation(Sidebar, Panel):
    bl_label = "Simulation"

    def draw(self, context: Context) -> None:
        layout, scene = self.layout, context.scene
        layout.operator_context = "INVOKE_DEFAULT"
        draw_lacking(layout)
        for found in background_sets(scene):
            draw_lines(layout, found.text, "ERROR")
        draw_frames(layout, scene)
        sensors = EDITS.sensors(context.view_layer)
        row = layout.row(align=True)
        row.operator("angen.simulate", icon="PLAY")
        if any(s.kind.requires(LIGHT) and s.settings.enabled for s in sensors):
            row.operator("angen.simulate", text="Without Light").without_light = True
        draw_recording(layout, scene, sensors)
        draw_start(layout, scene)
        row = layout.row(align=True)
        row.operator("angen.export_events", text="Events")
        row.operator("angen.export_samples", text="Samples")
        row.operator("angen.export_report", text="Report")
        layout.operator("angen.export_format", text="Other Tools: Home Assistant …", icon="EXPORT")
        row = layout.row(align=True)
        row.operator("angen.bake_keyframes", text="Bake", icon="KEYFRAME_HLT")
        row.operator("angen.unbake_keyframes", icon="KEYFRAME")
        layout.operator("angen.clear_recording", icon="TRASH")
        layout.prop(scene, "angen_live")


class ANGEN_PT_simulation_settings(ClosedSidebar, Panel):
    bl_label = "Settings"
    bl_parent_id = "ANGEN_PT_simulation"

    def draw(self, context: Context) -> None:
        layout, scene = self.layout, context.scene
        layout.use_property_split = True
        column = layout.column()
        column.prop(scene, "angen_substeps")
        column.prop(scene, "angen_seed")
        column.prop(scene, "angen_ray_caster")
        # A heading of its own, because the full names would be cut.
        column = layout.column()
        column.label(text="Light")
        draw_property(column, scene, scene, "angen_luminous_efficacy", "Lamps", "lm/W")
        column.prop(scene, "angen_light_reference", text="Reference")


def draw_frames(layout: UILayout, scene: Scene) -> None:
    """Draw the range of frames to simulate: the preview range if it is set, else the scene's range.

    The scene's first frame cannot be edited here, because it is the time t = 0.
    """
    row = layout.row(align=True)
    if scene.use_preview_range:
        row.prop(scene, "use_preview_range", text="", icon="PREVIEW_RANGE", toggle=True)
        row.prop(scene, "frame_preview_start", text="Start")
        row.prop(scene, "frame_preview_end", text="End")
    else:
        text = f"All Frames, {scene.frame_start} to {scene.frame_end}"
        row.prop(scene, "use_preview_range", text=text, icon="PREVIEW_RANGE", toggle=True)


def draw_lacking(layout: UILayout) -> None:
    """Draw warnings of missing files and data, without which readings are wrong."""
    lacks = lacking.found
    if not lacks:
        return
    for text in lacks[:SHOWN_LACKS]:
        draw_lines(layout, capital(text), "ERROR")
    if len(lacks) > SHOWN_LACKS:
        layout.label(text=f"and {len(lacks) - SHOWN_LACKS} more: see `angen list`")
    row = layout.row(align=True)
    row.operator("file.find_missing_files", text="Find Files", icon="VIEWZOOM")
    row.operator("wm.revert_mainfile", text="Reload Trusted").use_scripts = True
    row.operator("angen.look_for_lacking", text="", icon="FILE_REFRESH")


def draw_recording(layout: UILayout, scene: Scene, sensors: Sequence[Sensor]) -> None:
    """Draw whether there is a recording, whether it is stale, and whether one is kept aside."""
    kept = RESULTS.kept(scene)
    values = "live values" if scene.angen_live else "no values, as Live is off"
    if is_running():
        draw_progress(layout, "angen.simulate")
    elif kept is None:
        if sensors:
            layout.label(text=f"Not recorded: {values}", icon="INFO")
    elif kept.stale:
        now = "Values are live" if scene.angen_live else "Live is off: no values are shown"
        text = f"Recording is stale, {kept.stale}. {now}. Simulate again, or undo"
        draw_lines(layout, text, "ERROR")
    else:
        recording = kept.recording
        text = f"Recorded: frames {recording.frame_start} to {recording.frame_end}"
        layout.label(text=text, icon="CHECKMARK")
        left_out = [s for s in simulated(sensors) if recording.track_of(s.uid) is None]
        if left_out and all(s.kind.requires(LIGHT) for s in left_out):
            layout.label(text="Light sensors are not recorded", icon="INFO")
        elif left_out:
            layout.label(text=f"{plural(len(left_out), 'sensor')} not recorded", icon="INFO")
        if kept.made_in != THIS_BLENDER:
            text = f"Made in Blender {version_text(kept.made_in)}: simulate again to be sure"
            draw_lines(layout, text, "INFO")
        if not recording.covers(scene.frame_current + scene.frame_subframe):
            layout.label(text=f"This frame is not recorded: {values}", icon="INFO")
    aside = RESULTS.kept_aside(scene)
    if aside is not None:
        begin, end = aside.recording.frame_start, aside.recording.frame_end
        layout.label(text=f"Kept aside: frames {begin} to {end}", icon="INFO")
    if RESULTS.notice:
        draw_lines(layout, RESULTS.notice, "ERROR")


register, unregister = bpy.utils.register_classes_factory(
    (ANGEN_PT_simulation, ANGEN_PT_simulation_settings)
)
