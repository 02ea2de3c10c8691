# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the sample atelier.blend from an empty file: a studio with a couple and a cat.

python sample_blends/build_atelier.py [--out FILE]
blender -b -P sample_blends/build_atelier.py -- [--out FILE]

The studio is open, has a bath, and stands turned out of the axes; two of its doors slide.
"""

import os
import sys
from math import radians
from pathlib import Path

# Blender stores the user's home folder in the file's file browser.
os.environ["HOME"] = os.sep

import bpy
from mathutils import Matrix

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from sample_file import make  # noqa: E402

from angen_addon.process.console import leave_hard  # noqa: E402

# The residents: body, place (m), the yaw (degrees) that they face, and whether they use a walking
# frame.
RESIDENTS = {
    "Karin": ("OLDER_ADULT", (4.0, 5.3), 90.0, False),
    "Olle": ("OLDER_ADULT", (6.4, 2.4), 180.0, True),
    "Missan": ("CAT", (1.0, 0.5), 40.0, False),
}
# The rooms of the places that residents use: only the bath has its own walls.
ROOMS = {
    "sleeping": "Bed of Karin, Bed of Olle, Bookshelf, Chest drawer, Lamp sleeping",
    "kitchen": "Cat bowl, Chair east, Chair south, Chair west, Cupboard door 1, Cupboard door 2, "
    "Cupboard door 3, Cupboard door 4, Fridge, Fridge door, Kettle, Kitchen tap, Lamp kitchen, "
    "Lamp table, Stove, Worktop",
    "living": "Armchair, Coffee table, Curtain east, Curtain west, Fig tree, Reading lamp, "
    "Sofa north, Sofa south, Television, Window place",
    "entrance": "Coat hooks, Desk, Desk chair, Lamp entrance, Shoe bench, Wardrobe, "
    "Wardrobe door left, Wardrobe door right",
}
# Turn (degrees) and position (m) of the home.
YAW, AT = 27.0, (12.0, -5.0, 0.0)


def build() -> bpy.types.Scene:
    """Fill an empty file with the home."""
    from atelier_home import devices, furniture, shell

    scene = bpy.context.scene
    scene.name = "Atelier"
    scene.render.fps, scene.frame_end = 10, 600
    shell.add_shell()
    shell.add_doors()
    furniture.add_sleeping()
    furniture.add_kitchen()
    furniture.add_living()
    furniture.add_entry()
    furniture.add_bath()
    devices.add_lamps()
    devices.add_sensors()
    for room, names in ROOMS.items():
        for name in names.split(", "):
            bpy.data.objects[name].angen_place.room = room
    add_residents()
    furniture.turn(YAW, AT)
    devices.fit_doors()
    devices.add_sun()
    scene.cursor.matrix = Matrix()
    scene.render.engine = "CYCLES"
    return scene


def add_residents() -> None:
    """Add the couple and the cat."""
    cursor = bpy.context.scene.cursor
    for name, (sort, (x, y), yaw, frame) in RESIDENTS.items():
        cursor.matrix = Matrix.Translation((x, y, 0.0)) @ Matrix.Rotation(radians(yaw), 4, "Z")
        bpy.ops.angen.resident_add(sort=sort, walking_frame=frame)
        bpy.context.object.name = name


if __name__ == "__main__":
    leave_hard(make(HERE / "atelier.blend", build))
