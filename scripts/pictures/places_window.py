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


def steps() -> Iterator[None]:
    main = bpy.context.window_manager.windows[0]
    view = window.areas()["VIEW_3D"]
    space: Any = view.spaces[0]
    window.without_ceilings()
    window.view_from(space, (4.6, 4.3, 0.0), 13.0, 18.0)
    window.only_panels("places")
    window.plain(space)
    space.shading.light = "FLAT"
    bpy.context.scene.angen_overlay.show = False
    inside = window.region_of(view)
    with bpy.context.temp_override(window=main, area=view, region=inside):
        window.select("Door kitchen")
        bpy.data.objects["Door bedroom"].angen_place.use = "NONE"
        bpy.ops.angen.places_check()
    yield
    window.open_sidebar(view)
    yield
    yield
    yield


window.show(steps())
