# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the pictures of what the viewport draws of the sensors.

    VIEW=motion blender --factory-startup --addons bl_ext.user_default.angen_sensors \\
        sample_blends/angen.blend --python scripts/pictures/overlay_window.py

VIEW is one of those listed below. READY is printed when the window shows it.
"""

import math
import os
from collections.abc import Iterator
from typing import Any

import bpy
from mathutils import Euler

# Frame, middle of the view (m), its distance (m), its tilt from above and its turn (degrees), the
# sensor that is active.
VIEWS: dict[str, tuple[int, tuple[float, float, float], float, float, float, str]] = {
    "motion": (1000, (7.9, 4.6, 0.8), 9.0, 52.0, -35.0, "PIR living room"),
    "home": (700, (5.0, 4.0, 0.0), 19.0, 30.0, 0.0, "PIR hall"),
    "door": (84, (5.0, 8.2, 2.15), 1.3, 80.0, 15.0, "Switch entrance"),
    "sofa": (1876, (8.7, 6.2, 0.75), 3.0, 62.0, -30.0, "Pressure sofa"),
    "light": (1500, (7.9, 4.6, 1.0), 9.0, 45.0, 25.0, "Light sensor living room"),
}
# Played before the picture is taken, so that detectors have something to compare with.
LEAD_IN = 30


def steps() -> Iterator[None]:
    """One step a tick, so that Blender draws in between."""
    frame, middle, distance, tilt, turn, name = VIEWS[os.environ.get("VIEW", "motion")]
    scene = bpy.context.scene
    window = bpy.context.window_manager.windows[0]
    areas = {area.type: area for area in window.screen.areas}
    view = areas["VIEW_3D"]
    space: Any = view.spaces[0]
    for obj in bpy.context.selected_objects:
        obj.select_set(False)
    sensor = bpy.data.objects[name]
    sensor.select_set(True)
    bpy.context.view_layer.objects.active = sensor
    space.shading.color_type = "MATERIAL"
    space.shading.show_cavity = True
    space.overlay.show_floor = False
    space.overlay.show_bones = False
    space.overlay.show_extras = False
    space.show_gizmo = False
    space.show_region_ui = True
    region = space.region_3d
    region.view_perspective = "PERSP"
    region.view_location = middle
    region.view_distance = distance
    region.view_rotation = Euler((math.radians(tilt), 0.0, math.radians(turn))).to_quaternion()
    settings = scene.angen_overlay
    settings.which = os.environ.get("WHICH", "ALL")
    yield
    for number in range(frame - LEAD_IN, frame + 1):
        scene.frame_set(number)
    yield
    sidebar = next(part for part in view.regions if part.type == "UI")
    sidebar.active_panel_category = "Sensors"
    for area in window.screen.areas:
        area.tag_redraw()
    yield
    yield
    yield
    print("READY", flush=True)


FINISHED = object()
_steps = steps()


def tick() -> float | None:
    return None if next(_steps, FINISHED) is FINISHED else 0.5


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(tick, first_interval=1.5)
