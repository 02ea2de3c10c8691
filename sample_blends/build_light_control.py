# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the sample of a light control, light_control.blend, from an empty file.

python sample_blends/build_light_control.py [--out FILE] [--picture FILE]
blender -b -P sample_blends/build_light_control.py -- [--out FILE] [--picture FILE]

A person walks into a dark room. A motion detector switches the lamp on, by a driver on its
`active`, and a light sensor measures it. If the person stands still for longer than the detector's
hold time, the lamp goes off.
"""

import os
import sys
from math import ceil
from pathlib import Path

# Blender stores the user's home folder in the file's file browser.
os.environ["HOME"] = os.sep

import bpy
import numpy as np
from mathutils import Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from angen_home.devices import add_person  # noqa: E402
from angen_home.meshes import MeshBuilder, collection, place  # noqa: E402
from angen_home.plan import FLOOR_Z, FPS  # noqa: E402
from angen_sensors.residents.acting.places import Places  # noqa: E402
from angen_sensors.residents.acting.timeline import (  # noqa: E402
    Acted,
    Clip,
    Timeline,
)
from angen_sensors.residents.blender.keys import KeyedStretch  # noqa: E402
from angen_sensors.residents.body.gait import Stance, Walk, footsteps, standing  # noqa: E402
from sample_file import make  # noqa: E402

from angen_addon.process.console import leave_hard  # noqa: E402

# The inside of the room (m), from x = y = 0; its door is in the wall x = 0, behind it a corridor.
WIDE, DEEP, HIGH, WALL = 5.0, 4.0, 2.5, 0.12
DOOR_LOW, DOOR_HIGH, DOOR_TOP = 1.55, 2.45, 2.1
CORRIDOR = 2.6
# The places where the person waits and goes, the seconds of each stop, and the speed (m/s).
OUTSIDE, INSIDE = (-1.9, 2.0), (2.9, 2.0)
WAIT_OUTSIDE, STAND_INSIDE, AFTERWARDS = 2.0, 8.0, 6.0
SPEED = 1.1
HOLD = 4.0
LAMP_W, LIT_LUX = 20.0, 30.0
LAMP_AT = (2.5, 2.0, 2.15)
PIR, LIGHT, LAMP = "PIR room", "Light sensor room", "Lamp"
PICTURE_FRAME = 200


def add_room() -> None:
    """Add floor and walls; no ceiling, so that the camera looks in."""
    b = MeshBuilder("paint warm")
    low = FLOOR_Z - 0.1
    b.box((-CORRIDOR, -WALL, low), (WIDE + WALL, DEEP + WALL, FLOOR_Z), 0.0, "oak floor")
    top = FLOOR_Z + HIGH
    b.box((-CORRIDOR, DEEP, FLOOR_Z), (WIDE + WALL, DEEP + WALL, top), 0.0)
    b.box((WIDE, 0.0, FLOOR_Z), (WIDE + WALL, DEEP, top), 0.0)
    b.box((-WALL, 0.0, FLOOR_Z), (0.0, DOOR_LOW, top), 0.0)
    b.box((-WALL, DOOR_HIGH, FLOOR_Z), (0.0, DEEP, top), 0.0)
    b.box((-WALL, DOOR_LOW, FLOOR_Z + DOOR_TOP), (0.0, DOOR_HIGH, top), 0.0)
    place("Room", b, "Room")
    # The camera looks through the wall between it and the room.
    front = MeshBuilder("paint warm")
    front.box((-WALL, -WALL, FLOOR_Z), (WIDE + WALL, 0.0, top), 0.0)
    wall = place("Front wall", front, "Room")
    wall.visible_camera = False
    wall.display_type = "WIRE"


def add_sensor(kind: str, name: str, at: tuple[float, float, float], to: tuple[float, ...]):
    """Add a sensor in its housing at a place, directed to another place."""
    sensor = bpy.data.objects.new(name, None)
    sensor.empty_display_size = 0.05
    sensor.location = at
    way = Vector(to) - Vector(at)
    sensor.rotation_euler = way.to_track_quat("-Z", "Y").to_euler()
    collection("Sensors").objects.link(sensor)
    sensor.angen_sensor.kind = kind
    housing = MeshBuilder("sensor body")
    housing.box((-0.035, -0.05, 0.012), (0.035, 0.05, 0.06), 0.008)
    housing.cylinder((0, 0, 0.002), 0.022, 0.012, 24, "sensor lens")
    place(f"{name} housing", housing, "Sensors", parent=sensor)
    return sensor


def add_sensors():
    """Add the detector in the corner, level, and the light sensor in the centre of the far wall."""
    z = FLOOR_Z + 2.2
    pir = add_sensor("PIR", PIR, (WIDE - 0.1, 0.1, z), (0.0, DEEP, z))
    pir.angen_sensor.pir.sweep = "ALL"
    pir.angen_sensor.pir.hold_time = HOLD
    light = add_sensor("LIGHT", LIGHT, (WIDE - 0.1, 2.0, 1.4), (0.0, 2.0, 1.4))
    light.angen_sensor.update_rate = 2.0
    light.angen_sensor.light.method = "ILLUMINANCE"
    light.angen_sensor.light.threshold = LIT_LUX
    return pir


def add_lamp(pir: bpy.types.Object) -> None:
    """Add a pendant that has the power of its bulb while the detector's output is on."""
    data = bpy.data.lights.new(LAMP, "POINT")
    data.shadow_soft_size = 0.05
    data.color = (1.0, 0.83, 0.66)
    place(LAMP, data, "Room", LAMP_AT)
    cord = MeshBuilder("black metal")
    cord.tube([(0, 0, 0.06), (0, 0, FLOOR_Z + HIGH - LAMP_AT[2])], 0.006, 8)
    place("Lamp cord", cord, "Room", LAMP_AT)
    driver = data.driver_add("energy").driver
    # Blender evaluates so simple an expression without Python: no script needs permission.
    driver.type, driver.expression = "SCRIPTED", f"{LAMP_W:g} * on"
    variable = driver.variables.new()
    variable.name = "on"
    variable.targets[0].id = pir
    variable.targets[0].data_path = "angen_sensor.active"


def add_story(scene: bpy.types.Scene) -> None:
    """Add the person, who walks through the room."""
    line = walk_through()
    scene.render.fps, scene.frame_end = FPS, ceil(line.duration * FPS)
    keys = KeyedStretch({"person": add_person()}, Places({}, {}, {}), FPS)
    keys.show(Acted({"person": line}), 0.0, line.duration)


def walk_through() -> Timeline:
    """Return the timeline of a walk in, to the centre, and out again."""
    line = Timeline()
    clips = line.clips
    stand = Stance.at(*OUTSIDE, 0.0)

    def wait(seconds: float) -> None:
        start, pose = line.duration if clips else 0.0, standing(stand, FLOOR_Z)
        clips.append(Clip(start, start + seconds, lambda t: pose, still=True))

    def walk(to: tuple[float, float]) -> Stance:
        path = np.linspace(stand.centre, to, 60)
        walking = Walk(footsteps(stand, path, None), SPEED, FLOOR_Z)
        clips.append(Clip(line.duration, line.duration + walking.duration, walking.pose))
        return walking.end

    wait(WAIT_OUTSIDE)
    stand = walk(INSIDE)
    wait(STAND_INSIDE)
    stand = walk(OUTSIDE)
    wait(AFTERWARDS)
    return line


def add_surroundings() -> None:
    """Add night, and a camera that looks in from above."""
    world = bpy.data.worlds.new("Night")
    world.use_nodes = True
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (0.35, 0.5, 1.0, 1.0)
    background.inputs["Strength"].default_value = 0.006
    bpy.context.scene.world = world
    data = bpy.data.cameras.new("Camera")
    data.lens = 30.0
    camera = place("Camera", data, "Room", (2.3, -4.6, 5.6))
    way = Vector((1.9, 2.1, 0.6)) - camera.location
    camera.rotation_euler = way.to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = camera


def build() -> bpy.types.Scene:
    """Fill an empty file."""
    scene = bpy.context.scene
    scene.name = "Light control"
    scene.render.engine = "CYCLES"
    scene.view_settings.exposure = 2.0
    scene.render.resolution_x, scene.render.resolution_y = 1280, 720
    for path in ("Sensors", "Room", "People"):
        collection(path)
    add_room()
    add_lamp(add_sensors())
    add_story(scene)
    add_surroundings()
    scene.frame_set(1)
    return scene


def set_up(scene: bpy.types.Scene) -> None:
    """Set up the picture of the person in the lit room."""
    # The driver's value needs the readings of the frames before.
    bpy.ops.angen.simulate(frame_end=PICTURE_FRAME)
    scene.frame_set(PICTURE_FRAME)
    scene.cycles.samples, scene.cycles.use_denoising = 32, True
    scene.render.resolution_percentage = 75
    # Otherwise the picture would contain its author, place and date.
    for name in (n for n in dir(scene.render) if n.startswith("use_stamp_")):
        setattr(scene.render, name, False)
    scene.render.image_settings.file_format = "JPEG"


if __name__ == "__main__":
    leave_hard(make(HERE / "light_control.blend", build, set_up))
