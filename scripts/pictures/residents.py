# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for docs/residents.md's picture: all sorts, and the panel of one.

    blender --addons bl_ext.user_default.angen_sensors --python scripts/pictures/residents.py

It prints READY when the window shows it.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.append(str(Path(__file__).parent))
import window

PLACES = (("ADULT", 1.3, 0.3), ("CHILD", 2.2, 0.0), ("CAT", 2.9, -0.5), ("OLDER_ADULT", 0.2, 0.0))


def steps() -> Iterator[None]:
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    cursor = bpy.context.scene.cursor
    for sort, x, y in PLACES:
        cursor.location, cursor.rotation_euler = (x, y, 0.0), (0.0, 0.0, -0.5)
        bpy.ops.angen.resident_add(sort=sort, walking_frame=sort == "OLDER_ADULT")
    space = window.areas()["VIEW_3D"].spaces[0]
    window.plain(space)
    window.view_from(space, (1.8, 0.0, 0.8), 4.4, 69.0)
    yield
    window.open_sidebar(window.areas()["VIEW_3D"])
    yield
    yield


window.show(steps())
