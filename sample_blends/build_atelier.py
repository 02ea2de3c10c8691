# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the sample atelier.blend from nothing: an open studio with a bath, in which an older couple
lives with a cat. It stands turned out of the axes; two of its doors slide.

python sample_blends/build_atelier.py [--out FILE]
blender -b -P sample_blends/build_atelier.py -- [--out FILE]
"""

import argparse
import os
import sys
from math import radians
from pathlib import Path

# Blender notes the home folder of whoever builds the file in the file's file browser.
os.environ["HOME"] = os.sep

import bpy
from mathutils import Matrix

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from angen_addon.commands.leaving import leave_hard  # noqa: E402
from angen_addon.process.standalone import load_extension  # noqa: E402

# Who lives there: the sort, where they stand (m), the yaw (degrees) that they look along, and
# whether with a walking frame.
RESIDENTS = {
    "Karin": ("OLDER_ADULT", (4.0, 5.3), 90.0, False),
    "Olle": ("OLDER_ADULT", (6.4, 2.4), 180.0, True),
    "Missan": ("CAT", (1.0, 0.5), 40.0, False),
}
# How the home stands (degrees, m).
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
    add_residents()
    furniture.turn(YAW, AT)
    devices.fit_doors()
    devices.add_sun()
    scene.cursor.matrix = Matrix()
    scene.render.engine = "CYCLES"
    return scene


def add_residents() -> None:
    """The couple and the cat."""
    cursor = bpy.context.scene.cursor
    for name, (sort, (x, y), yaw, frame) in RESIDENTS.items():
        cursor.matrix = Matrix.Translation((x, y, 0.0)) @ Matrix.Rotation(radians(yaw), 4, "Z")
        bpy.ops.angen.resident_add(sort=sort, walking_frame=frame)
        bpy.context.object.name = name


def main() -> int:
    """The command line; returns the exit status."""
    argv = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(prog="build_atelier.py")
    parser.add_argument("--out", type=Path, default=HERE / "atelier.blend")
    out = parser.parse_args(argv).out.resolve()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    extension = load_extension()
    extension.register()
    try:
        scene = build()
        bpy.ops.wm.save_as_mainfile(filepath=str(out), compress=True, relative_remap=True)
    finally:
        # Blender 4.2 as a Python module crashes at exit with the extension still registered.
        extension.unregister()
    print(f"{out.name}: {len(scene.objects)} objects, {out.stat().st_size / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    leave_hard(main())
