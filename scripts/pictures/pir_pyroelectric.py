# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for docs/pir.md's picture: the panel of a pyroelectric detector.

    blender --addons bl_ext.user_default.angen_sensors sample_blends/angen.blend \\
        --python scripts/pictures/pir_pyroelectric.py

It prints READY when the window shows it.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.append(str(Path(__file__).parent))
import window

FRAME = 1000
SENSOR = "PIR living room"


def steps() -> Iterator[None]:
    areas = window.areas()
    space = areas["VIEW_3D"].spaces[0]
    window.select("Person rig")
    bpy.ops.angen.warmth_set(sort="PERSON")
    sensor = window.select(SENSOR)
    sensor.angen_sensor.update_rate = 24.0
    sensor.angen_sensor.pir.model = "PYROELECTRIC"
    sensor.angen_sensor.pir.lens = "HC_SR501"
    sensor.angen_sensor.pir.range_max = 7.0
    window.through_camera(space, "Camera living")
    space.shading.color_type = "MATERIAL"
    space.overlay.show_floor = False
    areas["PROPERTIES"].spaces[0].context = "PHYSICS"
    # The outliner gives its room to the properties.
    yield
    window.play_up_to(FRAME)
    yield
    window.redraw()
    yield
    yield


window.show(steps())
