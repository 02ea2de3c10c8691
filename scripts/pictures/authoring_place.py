# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the picture of placing a motion detector in the sample home.

    blender --addons bl_ext.user_default.angen_sensors sample_blends/angen.blend \\
        --python scripts/pictures/authoring_place.py

It prints READY when the detector hangs under the mouse, on a wall of the living room.
"""

from collections.abc import Iterator

import bpy

FRAME = 1130
CAMERA = "Camera living"
# Of the view, from its lower left corner: a free piece of wall.
MOUSE = (0.33, 0.73)


def steps() -> Iterator[None]:
    """One step a tick, so that Blender draws in between."""
    window = bpy.context.window_manager.windows[0]
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    space = area.spaces[0]
    region = next(region for region in area.regions if region.type == "WINDOW")
    bpy.context.scene.camera = bpy.data.objects[CAMERA]
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_zoom = 12
    space.shading.color_type = "MATERIAL"
    space.shading.show_cavity = True
    space.overlay.show_floor = False
    space.overlay.show_bones = False
    space.show_region_ui = False
    # Played, so that the sensors have readings.
    for frame in range(FRAME - 30, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    yield
    x, y = (int(region.x + MOUSE[0] * region.width), int(region.y + MOUSE[1] * region.height))
    window.cursor_warp(x, y)
    yield
    with bpy.context.temp_override(
        window=window, area=area, region=region, space_data=space, region_data=space.region_3d
    ):
        bpy.ops.angen.sensor_place("INVOKE_DEFAULT", kind="PIR", preset="HAA53")
    yield
    window.cursor_warp(x + 3, y)
    yield
    yield
    print("READY", flush=True)


FINISHED = object()
_steps = steps()


def tick() -> float | None:
    return None if next(_steps, FINISHED) is FINISHED else 0.6


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(tick, first_interval=1.5)
