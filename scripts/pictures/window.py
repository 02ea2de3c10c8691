# SPDX-License-Identifier: GPL-3.0-or-later
"""What scripts that set up Blender's window for a picture have in common."""

import math
from collections.abc import Iterable, Iterator
from typing import Any

import bpy
from mathutils import Euler


def areas() -> dict[str, Any]:
    """The window's areas by their type."""
    return {area.type: area for area in bpy.context.window_manager.windows[0].screen.areas}


def region_of(area: Any, kind: str = "WINDOW") -> Any:
    return next(region for region in area.regions if region.type == kind)


def select(name: str) -> Any:
    """Makes an object the active one, and the only one that is selected."""
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    obj = bpy.data.objects[name]
    obj.select_set(True)
    bpy.context.view_layer.objects.active = obj
    return obj


def plain(space: Any) -> None:
    """A 3D view without what Blender draws beside the home."""
    space.shading.color_type = "MATERIAL"
    space.shading.show_cavity = True
    space.overlay.show_floor = space.overlay.show_bones = False


def through_camera(space: Any, name: str) -> None:
    bpy.context.scene.camera = bpy.data.objects[name]
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_zoom = 12


def from_above(space: Any) -> None:
    """The home from above, without its ceilings."""
    for obj in bpy.data.objects:
        if "eiling" in obj.name:
            obj.hide_set(True)
    region = space.region_3d
    region.view_perspective = "PERSP"
    region.view_location = (4.6, 4.3, 0.0)
    region.view_distance = 13.0
    region.view_rotation = Euler((math.radians(18.0), 0.0, 0.0)).to_quaternion()


def one_panel(name: str, others: Iterable[str]) -> None:
    """Opens a panel, and takes the others away that would push it down."""
    for other in others:
        panel = getattr(bpy.types, f"ANGEN_PT_{other}", None)
        if panel is not None:
            bpy.utils.unregister_class(panel)
    panel = getattr(bpy.types, f"ANGEN_PT_{name}")
    bpy.utils.unregister_class(panel)
    panel.bl_options = set()
    bpy.utils.register_class(panel)


def play_up_to(frame: int) -> None:
    """Plays 30 frames, so that sensors have something to compare with."""
    for number in range(frame - 30, frame + 1):
        bpy.context.scene.frame_set(number)


def open_sidebar(view: Any) -> None:
    region_of(view, "UI").active_panel_category = "Sensors"
    redraw()


def redraw() -> None:
    for area in areas().values():
        area.tag_redraw()


def show(steps: Iterator[None], every: float = 0.5) -> None:
    """Does one step a tick, so that Blender draws in between; then prints READY."""

    def tick() -> float | None:
        for _ in steps:
            return every
        print("READY", flush=True)
        return None

    bpy.context.preferences.view.show_splash = False
    bpy.app.timers.register(tick, first_interval=1.5)
