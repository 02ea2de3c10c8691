# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the README's picture of a sensor's panel.

    blender --addons bl_ext.user_default.angen_sensors sample_blends/angen.blend \\
        --python scripts/window_picture.py

It prints READY when the window shows the living room, the sidebar tab and the Physics tab.
"""

from collections.abc import Iterator

import bpy

FRAME = 1130
SENSOR = "PIR living room"
CAMERA = "Camera living"


def steps() -> Iterator[None]:
    """One step a tick, so that Blender draws in between."""
    bpy.context.preferences.view.show_splash = False
    window = bpy.context.window_manager.windows[0]
    areas = {area.type: area for area in window.screen.areas}
    view = areas["VIEW_3D"]
    space = view.spaces[0]
    sensor = bpy.data.objects[SENSOR]
    bpy.context.view_layer.objects.active = sensor
    sensor.select_set(True)
    bpy.context.scene.camera = bpy.data.objects[CAMERA]
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_zoom = 12
    space.shading.color_type = "MATERIAL"
    space.shading.show_cavity = True
    space.overlay.show_floor = False
    space.overlay.show_bones = False
    space.show_region_ui = True
    areas["PROPERTIES"].spaces[0].context = "PHYSICS"
    yield
    for frame in range(FRAME - 30, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    yield
    sidebar = next(region for region in view.regions if region.type == "UI")
    sidebar.active_panel_category = "Sensors"
    for area in window.screen.areas:
        area.tag_redraw()
    yield
    yield
    print("READY", flush=True)


FINISHED = object()
_steps = steps()


def tick() -> float | None:
    return None if next(_steps, FINISHED) is FINISHED else 0.5


bpy.app.timers.register(tick, first_interval=1.5)
bpy.context.preferences.view.show_splash = False
