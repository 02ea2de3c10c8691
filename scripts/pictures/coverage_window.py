# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the picture of a coverage map and a proposal in the sample home.

    blender --factory-startup --addons bl_ext.user_default.angen_sensors \\
        sample_blends/angen.blend --python scripts/pictures/coverage_window.py

READY is printed when the window shows it.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

sys.path.append(str(Path(__file__).parent))
import window


def steps() -> Iterator[None]:
    scene = bpy.context.scene
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space: Any = view.spaces[0]
    window.without_ceilings()
    window.only_panels("coverage", "coverage_place")
    window.plain(space)
    space.shading.light = "FLAT"
    scene.angen_overlay.show = False
    window.view_from(space, (6.6, 4.0, 0.0), 16.0, 18.0)
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
