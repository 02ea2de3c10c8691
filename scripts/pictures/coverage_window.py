# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the picture of a coverage map and a proposal in the sample home.

    blender --factory-startup --addons bl_ext.user_default.angen_sensors \\
        sample_blends/angen.blend --python scripts/pictures/coverage_window.py

READY is printed when the window shows it.
"""

import math
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy
from mathutils import Euler

sys.path.append(str(Path(__file__).parent))
import window

# Closed in the picture, so that the tab shows the coverage alone.
OTHERS = ("table", "events", "simulation", "overlay", "active_sensor", "sidebar_weight")


def steps() -> Iterator[None]:
    scene = bpy.context.scene
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space: Any = view.spaces[0]
    for obj in bpy.data.objects:
        # In a picture from above there is no ceiling.
        if "eiling" in obj.name:
            obj.hide_set(True)
    opened: list[Any] = []
    for name in OTHERS:
        panel = getattr(bpy.types, f"ANGEN_PT_{name}", None)
        if panel is not None:
            bpy.utils.unregister_class(panel)
    for panel in (bpy.types.ANGEN_PT_coverage_place, bpy.types.ANGEN_PT_coverage):
        bpy.utils.unregister_class(panel)
        panel.bl_options = set()
        opened.insert(0, panel)
    for panel in opened:
        bpy.utils.register_class(panel)
    space.shading.color_type = "MATERIAL"
    space.shading.light = "FLAT"
    space.shading.show_cavity = True
    space.overlay.show_floor = False
    space.overlay.show_bones = False
    space.overlay.show_extras = True
    space.show_gizmo = False
    space.show_region_ui = True
    scene.angen_overlay.show = False
    region = space.region_3d
    region.view_perspective = "PERSP"
    region.view_location = (6.6, 4.0, 0.0)
    region.view_distance = 16.0
    region.view_rotation = Euler((math.radians(18.0), 0.0, 0.0)).to_quaternion()
    settings = scene.angen_coverage
    inside = window.region_of(view)
    with bpy.context.temp_override(window=main, area=view, region=inside):
        bpy.context.view_layer.objects.active = bpy.data.objects["PIR bedroom"]
        settings.motion, settings.rooms, settings.count = "CAT", "bedroom, hall", 2
        bpy.ops.angen.place_propose("EXEC_DEFAULT")
        settings.rooms = ""
        bpy.ops.angen.coverage("EXEC_DEFAULT")
    yield
    window.open_sidebar(view)
    yield
    yield
    yield


window.show(steps())
