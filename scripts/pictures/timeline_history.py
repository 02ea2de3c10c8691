# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the picture of the sensors' history and an explanation.

    blender --addons bl_ext.user_default.angen_sensors sample_blends/angen.blend \\
        --python scripts/pictures/timeline_history.py

It prints READY when the timeline shows the first half minute of the home, simulated.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.append(str(Path(__file__).parent))
import window

FRAMES = 1, 700
SENSOR = "PIR hall"
EVENT = 71
CAMERA = "Camera living"
# Share of the window's height that the timeline gets.
TIMELINE = 0.45


def steps() -> Iterator[None]:
    main = bpy.context.window_manager.windows[0]
    scene = bpy.context.scene
    areas = window.areas()
    # A higher timeline in place of the low one at the bottom.
    with bpy.context.temp_override(window=main, area=areas["DOPESHEET_EDITOR"]):
        bpy.ops.screen.area_close()
    yield
    with bpy.context.temp_override(window=main, area=areas["VIEW_3D"]):
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=TIMELINE)
    yield
    views = [area for area in main.screen.areas if area.type == "VIEW_3D"]
    timeline, view = sorted(views, key=lambda area: area.y)
    timeline.ui_type = "TIMELINE"
    yield
    timeline.spaces.active.show_region_ui = False
    window.only_panels("events")
    yield
    for obj in bpy.data.objects:
        if obj.angen_sensor.kind == "LIGHT":
            obj.angen_sensor.light.samples = 4
    scene.frame_end = FRAMES[1]
    yield
    window.select(SENSOR)
    yield
    bpy.ops.angen.simulate("EXEC_DEFAULT")
    scene.frame_set(EVENT)
    bpy.ops.angen.explain()
    space = view.spaces[0]
    space.show_region_ui = True
    space.shading.color_type = "MATERIAL"
    yield
    for area in (view, timeline):
        region = window.region_of(area)
        with bpy.context.temp_override(window=main, area=area, region=region):
            if area is view:
                scene.camera = bpy.data.objects[CAMERA]
                space.region_3d.view_perspective = "CAMERA"
            else:
                bpy.ops.action.view_all()
    yield
    window.open_sidebar(view)
    yield
    yield


window.show(steps(), 0.3)
