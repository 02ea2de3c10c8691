# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the picture of placing a motion detector in the sample home.

    blender --addons bl_ext.user_default.angen_sensors sample_blends/angen.blend \\
        --python scripts/pictures/authoring_place.py

It prints READY when the detector hangs under the mouse, on a wall of the living room.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.append(str(Path(__file__).parent))
import window

FRAME = 1130
CAMERA = "Camera living"
# Of the view, from its lower left corner: a free piece of wall.
MOUSE = (0.33, 0.73)


def steps() -> Iterator[None]:
    main = bpy.context.window_manager.windows[0]
    area = window.areas()["VIEW_3D"]
    space = area.spaces[0]
    region = window.region_of(area)
    window.through_camera(space, CAMERA)
    window.plain(space)
    space.show_region_ui = False
    window.play_up_to(FRAME)
    yield
    x, y = (int(region.x + MOUSE[0] * region.width), int(region.y + MOUSE[1] * region.height))
    main.cursor_warp(x, y)
    yield
    with bpy.context.temp_override(
        window=main, area=area, region=region, space_data=space, region_data=space.region_3d
    ):
        bpy.ops.angen.sensor_place("INVOKE_DEFAULT", kind="PIR", preset="HAA53_SCAN")
    yield
    main.cursor_warp(x + 3, y)
    yield
    yield


window.show(steps(), 0.6)
