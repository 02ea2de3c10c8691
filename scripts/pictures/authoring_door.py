# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets up Blender's window for the picture of two doors that one step fitted with their switches.

    blender --addons bl_ext.user_default.angen_sensors --python scripts/pictures/authoring_door.py

It prints READY when the view shows the upper corners: one door closed, the other open by 20°, and
what their switches read.
"""

import math
import sys
from collections.abc import Iterator
from pathlib import Path

import bpy

sys.path.append(str(Path(__file__).parent))
import window

WIDTH, HEIGHT, THICK = 0.9, 2.0, 0.04
# Their free edges face each other: where the hinge is, and the leaf's way from it.
DOORS = {"closed door": (0.0, 1), "open door": (2.1, -1)}
BOX_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(
    name: str, low: tuple, high: tuple, color: tuple, at: tuple = (0, 0, 0)
) -> bpy.types.Object:
    """A box from `low` to `high` about its origin `at` (m)."""
    mesh = bpy.data.meshes.new(name)
    corners = [
        (x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])
    ]
    mesh.from_pydata(corners, [], BOX_FACES)
    obj = bpy.data.objects.new(name, mesh)
    obj.location, obj.color = at, color
    bpy.context.scene.collection.objects.link(obj)
    return obj


def build() -> None:
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    grey, wood = (0.75, 0.75, 0.72, 1), (0.55, 0.33, 0.16, 1)
    top = HEIGHT + 0.005
    wall = box("Wall over doors", (-0.6, 0, top), (2.7, 0.2, 2.6), grey)
    for number, (a, b) in enumerate(((-0.6, -0.005), (0.905, 1.195), (2.105, 2.7))):
        box(f"Wall {number}", (a, 0, 0), (b, 0.2, top), grey)
    for name, (hinge, way) in DOORS.items():
        low, high = sorted((0.0, way * WIDTH))
        leaf = box(name, (low, 0, 0), (high, THICK, HEIGHT), wood, (hinge, 0, 0))
        bpy.context.view_layer.update()
        for obj in bpy.context.selected_objects:
            obj.select_set(False)
        wall.select_set(True)
        leaf.select_set(True)
        bpy.context.view_layer.objects.active = leaf
        bpy.ops.angen.door_fit()
        bpy.context.object.color = (0.1, 0.1, 0.1, 1)
        bpy.data.objects[f"Flag {name}"].color = (0.9, 0.2, 0.05, 1)
    bpy.data.objects["open door"].rotation_euler.z = math.radians(20)


def steps() -> Iterator[None]:
    area = window.areas()["VIEW_3D"]
    space = area.spaces[0]
    build()
    yield
    window.view_from(space, (1.08, -0.1, 1.98), 0.85, 70.0, -6.0)
    window.plain(space)
    space.shading.color_type = "OBJECT"
    space.overlay.show_axis_x = space.overlay.show_axis_y = False
    space.show_region_ui = False
    yield
    for frame in (1, 2, 30):
        bpy.context.scene.frame_set(frame)
    area.tag_redraw()
    yield
    yield


window.show(steps(), 0.6)
