# SPDX-License-Identifier: GPL-3.0-or-later
"""Helpers of the scripts that set up Blender's window for a picture."""

import math
from collections.abc import Iterator
from typing import Any

import bpy
from mathutils import Euler


def areas() -> dict[str, Any]:
    """Return the window's areas by their type."""
    return {area.type: area for area in bpy.context.window_manager.windows[0].screen.areas}


def region_of(area: Any, kind: str = "WINDOW") -> Any:
    return next(region for region in area.regions if region.type == kind)


def select(name: str) -> Any:
    """Select a single object, and make it the active one."""
    for obj in list(bpy.context.view_layer.objects.selected):
        obj.select_set(False)
    obj = bpy.data.objects[name]
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    return obj


def plain(space: Any) -> None:
    """Show materials and the sidebar, without floor, bones, cursor and gizmos."""
    space.shading.color_type = "MATERIAL"
    space.shading.show_cavity = True
    space.show_gizmo, space.show_region_ui = False, True
    overlay = space.overlay
    overlay.show_floor = overlay.show_bones = overlay.show_cursor = False
    overlay.show_relationship_lines = False


def view_from(
    space: Any, middle: tuple[float, float, float], distance: float, tilt: float, turn: float = 0.0
) -> None:
    """Look at `middle` from a distance (m), tilted from above and turned (degrees)."""
    region = space.region_3d
    region.view_perspective = "PERSP"
    region.view_location, region.view_distance = middle, distance
    region.view_rotation = Euler((math.radians(tilt), 0.0, math.radians(turn))).to_quaternion()


def through_camera(space: Any, name: str) -> None:
    """Look through a camera."""
    bpy.context.scene.camera = bpy.data.objects[name]
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_zoom = 12


def lens(space: Any) -> None:
    """Lets the view come close to small things."""
    space.clip_start = 0.005


def without_ceilings() -> None:
    """Hide the ceilings."""
    for obj in bpy.data.objects:
        if "eiling" in obj.name:
            obj.hide_set(True)


def only_panels(*names: str) -> None:
    """Open these panels, and remove the extension's other panels from the sidebar."""
    panels = [
        panel
        for panel in bpy.types.Panel.__subclasses__()
        if panel.__name__.startswith("ANGEN_PT_")
        and panel.bl_space_type == "VIEW_3D"
        and hasattr(bpy.types, panel.__name__)
    ]
    # Subpanels before their parents.
    for panel in sorted(panels, key=lambda panel: not hasattr(panel, "bl_parent_id")):
        bpy.utils.unregister_class(panel)
    known = {panel.__name__: panel for panel in panels}
    for name in names:
        panel = known[f"ANGEN_PT_{name}"]
        panel.bl_options = set()
        bpy.utils.register_class(panel)


def play_up_to(frame: int) -> None:
    """Play the 30 frames before a frame, so that sensors have frames to compare with."""
    for number in range(frame - 30, frame + 1):
        bpy.context.scene.frame_set(number)


def open_sidebar(view: Any) -> None:
    region_of(view, "UI").active_panel_category = "Sensors"
    redraw()


def close(*types: str) -> None:
    """Close areas; their neighbours get the space."""
    main = bpy.context.window_manager.windows[0]
    for kind in types:
        with bpy.context.temp_override(window=main, area=areas()[kind]):
            bpy.ops.screen.area_close()


def redraw() -> None:
    for area in areas().values():
        area.tag_redraw()


def show(steps: Iterator[None], every: float = 0.5) -> None:
    """Run one step per timer tick, so that Blender draws in between; then print READY."""

    def tick() -> float | None:
        for _ in steps:
            return every
        print("READY", flush=True)
        return None

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(tick, first_interval=1.5)
