# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for docs/pir.md's picture: the panel of a pyroelectric detector.

    blender --addons bl_ext.user_default.angen_sensors sample_blends/angen.blend \\
        --python scripts/pictures/pir_pyroelectric.py

It prints READY when the window shows it.
"""

from collections.abc import Iterator

import bpy

FRAME = 1000
SENSOR = "PIR living room"


def steps() -> Iterator[None]:
    """One step a tick, so that Blender draws in between."""
    bpy.context.preferences.view.show_splash = False
    window = bpy.context.window_manager.windows[0]
    areas = {area.type: area for area in window.screen.areas}
    space = areas["VIEW_3D"].spaces[0]
    sensor = bpy.data.objects[SENSOR]
    bpy.ops.object.select_all(action="DESELECT")
    rig = bpy.data.objects["Person rig"]
    bpy.context.view_layer.objects.active = rig
    rig.select_set(True)
    bpy.ops.angen.warmth_set(sort="PERSON")
    rig.select_set(False)
    bpy.context.view_layer.objects.active = sensor
    sensor.select_set(True)
    sensor.angen_sensor.update_rate = 24.0
    sensor.angen_sensor.pir.model = "PYROELECTRIC"
    sensor.angen_sensor.pir.lens = "HC_SR501"
    sensor.angen_sensor.pir.range_max = 7.0
    bpy.context.scene.camera = bpy.data.objects["Camera living"]
    space.region_3d.view_perspective = "CAMERA"
    space.region_3d.view_camera_zoom = 12
    space.shading.color_type = "MATERIAL"
    space.overlay.show_floor = False
    areas["PROPERTIES"].spaces[0].context = "PHYSICS"
    # The outliner gives its room to the properties.
    yield
    for frame in range(FRAME - 30, FRAME + 1):
        bpy.context.scene.frame_set(frame)
    yield
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
