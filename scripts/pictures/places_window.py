# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the picture of the sample home's places, one door unmarked.

    blender --factory-startup --addons bl_ext.user_default.angen_sensors \\
        sample_blends/angen.blend --python scripts/pictures/places_window.py

READY is printed when the window shows it.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

sys.path.append(str(Path(__file__).parent))
import window

# Closed in the picture, so that the tab shows the places alone.
OTHERS = (
    "table", "events", "simulation_settings", "simulation", "overlay", "active_sensor",
    "sidebar_weight", "sidebar_warmth", "coverage_place", "coverage", "doctor",
)  # fmt: skip


def steps() -> Iterator[None]:
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space: Any = view.spaces[0]
    window.from_above(space)
    window.one_panel("places", OTHERS)
    space.shading.color_type = "MATERIAL"
    space.shading.light = "FLAT"
    space.shading.show_cavity = True
    space.overlay.show_floor = space.overlay.show_bones = space.overlay.show_cursor = False
    space.overlay.show_relationship_lines = False
    space.show_gizmo = False
    space.show_region_ui = True
    bpy.context.scene.angen_overlay.show = False
    inside = window.region_of(view)
    with bpy.context.temp_override(window=main, area=view, region=inside):
        for obj in bpy.context.selected_objects:
            obj.select_set(False)
        door = bpy.data.objects["Door kitchen"]
        bpy.context.view_layer.objects.active = door
        door.select_set(True)
        bpy.data.objects["Door bedroom"].angen_place.use = "NONE"
        bpy.ops.angen.places_check()
    yield
    window.open_sidebar(view)
    yield
    yield
    yield


window.show(steps())
