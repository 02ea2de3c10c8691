# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the sample home, angen.blend, from an empty file, and record its sensors' readings.

python sample_blends/build_angen.py [--out FILE] [--digest]
blender -b -P sample_blends/build_angen.py -- [--out FILE] [--digest]
"""

import argparse
import hashlib
import os
import sys
from datetime import date
from math import radians
from pathlib import Path

# Blender stores the user's home folder in the file's file browser.
os.environ["HOME"] = os.sep

import bpy
import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from angen_home import (  # noqa: E402
    architecture,
    bedroom,
    devices,
    hall,
    kitchen,
    lighting,
    living_room,
    marks,
    meshes,
    openings,
    plan,
    wet_rooms,
    workroom,
)
from angen_sensors.residents.blender.keys import KeyedStretch  # noqa: E402
from angen_sensors.residents.blender.run import HouseholdDays, Plan  # noqa: E402
from angen_sensors.sensor_logic.logs.error import InputError  # noqa: E402

from angen_addon.process.console import leave_hard  # noqa: E402
from angen_addon.process.standalone import load_extension  # noqa: E402

# The collections in the order of the outliner.
COLLECTIONS = (
    "Home/Walls", "Home/Floors", "Home/Ceiling", "Home/Windows", "Home/Doors",
    "Home/Furniture/Living room", "Home/Furniture/Kitchen", "Home/Furniture/Bedroom",
    "Home/Furniture/Workroom", "Home/Furniture/Bathroom", "Home/Furniture/Closet",
    "Home/Furniture/Hall", "Home/Furniture/Balcony", "Lights", "Lights/Portals", "Cameras",
    "People",
    "Sensors/Motion detectors", "Sensors/Door switches", "Sensors/Light sensors",
    "Sensors/Pressure sensors",
)  # fmt: skip

# The routine's part in the animation: so many frames of a day, from a second of the day on.
EVENING, COMES_HOME, FRAMES = date(2026, 3, 2), 21.5 * 3600.0, 4120


def build() -> bpy.types.Scene:
    """Fill an empty file with the home, all doors closed."""
    scene = bpy.context.scene
    scene.name = "Ängen"
    for path in COLLECTIONS:
        meshes.collection(path)
    architecture.add_building()
    openings.add_doors()
    openings.add_windows()
    openings.add_balcony_glazing()
    living_room.add_living_room()
    kitchen.add_kitchen()
    bedroom.add_bedroom()
    workroom.add_workroom()
    wet_rooms.add_wet_rooms()
    hall.add_hall()
    hall.add_balcony()
    lighting.add_lighting()
    devices.add_sensors()
    return scene


def add_story(scene: bpy.types.Scene) -> None:
    """Add the resident, and the first minutes of an evening of her routine as keyframes.

    Raises
    ------
    InputError
        The routine cannot be acted in the home.
    """
    devices.add_person()
    devices.add_masses()
    marks.add_marks()
    # Örebro in winter time: the sun of a day follows date and hour.
    site = scene.angen_site
    site.latitude, site.longitude, site.utc_offset = radians(59.27), radians(15.21), 1.0
    household = HouseholdDays(scene, [], Plan.read(HERE / "story.toml"), EVENING, seed=0)
    keys = KeyedStretch(household.residents, household.places, plan.FPS, COMES_HOME)
    keys.show(household.acted(0), COMES_HOME, COMES_HOME + (FRAMES - 1) / plan.FPS)
    scene.frame_end = FRAMES
    scene.frame_set(1)


def arrange_views() -> None:
    """Set every 3D view of the file to the camera and the home's colours, with bones hidden."""
    for screen in bpy.data.screens:
        for area in screen.areas:
            if area.type != "VIEW_3D":
                continue
            space = area.spaces.active
            space.region_3d.view_perspective = "CAMERA"
            space.region_3d.view_camera_zoom = 5.0
            space.region_3d.view_camera_offset = (0.0, 0.0)
            space.overlay.show_bones = False
            space.shading.color_type = "MATERIAL"
            space.show_region_ui = True
            space.clip_start = 0.05


def arrange_timelines() -> None:
    """Set every editor of keys of the file to show all frames."""
    window = bpy.context.window_manager.windows[0]
    for screen in bpy.data.screens:
        for area in screen.areas:
            if area.type == "DOPESHEET_EDITOR":
                region = next(r for r in area.regions if r.type == "WINDOW")
                with bpy.context.temp_override(
                    window=window, screen=screen, area=area, region=region
                ):
                    bpy.ops.action.view_all()


def record_and_save(out: Path) -> None:
    """Save the file with a recording, so that it shows readings when it is opened."""
    arrange_views()
    arrange_timelines()
    bpy.ops.angen.simulate()
    bpy.ops.wm.save_as_mainfile(filepath=str(out), compress=True, relative_remap=True)


def triangles(scene: bpy.types.Scene) -> int:
    """Return the number of triangles of all objects, with each instance counted."""
    return sum(
        sum(len(p.vertices) - 2 for p in obj.data.polygons)
        for obj in scene.objects
        if obj.type == "MESH"
    )


def digest(scene: bpy.types.Scene) -> str:
    """Return a hash of names, matrices and vertices: the same for the same scene."""
    h = hashlib.sha256()
    for obj in sorted(scene.objects, key=lambda o: o.name):
        h.update(obj.name.encode())
        h.update(np.round(np.array(obj.matrix_world), 6).tobytes())
        if obj.type == "MESH":
            co = np.empty(3 * len(obj.data.vertices), np.float32)
            obj.data.vertices.foreach_get("co", co)
            h.update(np.round(co, 6).tobytes())
    return h.hexdigest()[:16]


def main() -> int:
    """Run the command line; return the exit status."""
    argv = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    parser = argparse.ArgumentParser(prog="build_angen.py")
    parser.add_argument("--out", type=Path, default=HERE / "angen.blend")
    parser.add_argument("--digest", action="store_true", help="print a hash of the scene")
    arguments = parser.parse_args(argv)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    extension = load_extension()
    extension.register()
    try:
        return make(arguments.out.resolve(), arguments.digest)
    finally:
        # Blender 4.2 as a Python module crashes at exit with the extension still registered.
        extension.unregister()


def make(out: Path, with_digest: bool) -> int:
    """Build, record and save the home; return 1 if the story is wrong."""
    scene = build()
    try:
        add_story(scene)
    except InputError as error:
        print(error, file=sys.stderr)
        return 1
    record_and_save(out)
    size = out.stat().st_size / 1e6
    print(f"{out.name}: {len(scene.objects)} objects, {triangles(scene)} triangles, {size:.2f} MB")
    if with_digest:
        print(f"digest {digest(scene)}")
    return 0


if __name__ == "__main__":
    leave_hard(main())
