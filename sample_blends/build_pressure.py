# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the sample of the pressure sensor, pressure.blend, from an empty file.

python sample_blends/build_pressure.py [--out FILE] [--picture FILE]
blender -b -P sample_blends/build_pressure.py -- [--out FILE] [--picture FILE]

It has a table on four pads with a weight that moves over it, a stack of boxes, and a box that is
dropped. Lengths are in metres and multiples of 1/128 m, which the meshes hold exactly.
"""

import os
import sys
from pathlib import Path

# Blender stores the user's home folder in the file's file browser.
os.environ["HOME"] = os.sep

import bpy
from mathutils import Vector

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]

from angen_home.meshes import MeshBuilder, collection, place  # noqa: E402
from sample_file import make  # noqa: E402

from angen_addon.process.console import leave_hard  # noqa: E402

FPS, LAST_FRAME = 24, 240
G = 1.0 / 128.0
PAD_HEIGHT = G
# The table: half width and depth of its top, the axes of its legs, and kilograms.
TOP, TOP_THICK = (64 * G, 48 * G), 4 * G
LEG_AT, LEG_WIDE, LEG_HIGH = (56 * G, 40 * G), 6 * G, 56 * G
TABLE_KG, WEIGHT_KG = 12.0, 8.0
LEGS = {"front left": (-1, -1), "front right": (1, -1), "back left": (-1, 1), "back right": (1, 1)}
# The weight's places by frame: over each leg in turn, on the diagonal over the table's centre.
PATH = ((1, "front left"), (13, "front left"), (85, "front right"), (157, "back left"),
        (229, "back right"), (240, "back right"))  # fmt: skip
STACK_AT, STACK_KG = (-132 * G, 0.0), (4.0, 2.0, 1.0)
DROP_AT, DROP_KG, DROP_HEIGHT, RELEASE = (132 * G, 0.0), 2.0, 64 * G, 25
BOUNCE = 0.6
PICTURE_FRAME = 28


def box(lo: tuple[float, ...], hi: tuple[float, ...], material: str, bevel: float = 0.004):
    """Return a box as a builder, from its low to its high corner."""
    built = MeshBuilder(material)
    built.box(lo, hi, bevel)
    return built


def about(half: tuple[float, ...], material: str, bevel: float = 0.004):
    """Return a box about the origin."""
    return box(tuple(-h for h in half), half, material, bevel)


def rigid(obj: bpy.types.Object, kind: str, mass: float = 1.0, shape: str = "BOX"):
    """Make an object a rigid body."""
    bpy.context.scene.rigidbody_world.collection.objects.link(obj)
    body = obj.rigid_body
    body.type, body.collision_shape, body.mass = kind, shape, mass
    return body


def still(body) -> None:
    """Let the physics engine deactivate a body until something hits it; else it creeps (mm)."""
    body.use_deactivation = body.use_start_deactivated = True


def add_pad(name: str, at: tuple[float, float], half: float):
    """Add a pad on the floor, which senses at every frame, with its rigid body."""
    shape = about((half, half, PAD_HEIGHT / 2), "sensor dark", 0.002)
    pad = place(name, shape, "Sensors", (*at, PAD_HEIGHT / 2))
    pad.angen_sensor.kind = "PRESSURE"
    pad.angen_sensor.update_rate = FPS
    return rigid(pad, "PASSIVE")


def add_table() -> None:
    """Add the table in the centre, its parts one rigid body, and a pad under each leg."""
    for name, (sx, sy) in LEGS.items():
        add_pad(f"Pad {name}", (sx * LEG_AT[0], sy * LEG_AT[1]), 8 * G)
    # The origin is the centre of mass; the apron is decoration.
    height = PAD_HEIGHT + LEG_HIGH
    apron = MeshBuilder("oak")
    x, y, low = LEG_AT[0], LEG_AT[1], -8 * G
    for s in (-1, 1):
        apron.box((-x, s * y - G, low), (x, s * y + G, 0.0), 0.003)
        apron.box((s * x - G, -y, low), (s * x + G, y, 0.0), 0.003, "oak y")
    table = place("Table", apron, "Table", (0.0, 0.0, height))
    still(rigid(table, "ACTIVE", TABLE_KG, "COMPOUND"))
    top = about((*TOP, TOP_THICK / 2), "oak", 0.006)
    parts = [place("Table top", top, "Table", (0.0, 0.0, TOP_THICK / 2), parent=table)]
    leg = about((LEG_WIDE / 2, LEG_WIDE / 2, LEG_HIGH / 2), "oak z").build("Table leg")
    for name, (sx, sy) in LEGS.items():
        at = (sx * LEG_AT[0], sy * LEG_AT[1], -LEG_HIGH / 2)
        parts.append(place(f"Leg {name}", leg, "Table", at, parent=table))
    for part in parts:
        rigid(part, "ACTIVE")
    add_weight(height + TOP_THICK)


def add_weight(height: float) -> None:
    """Add an animated weight: it has a mass, and no physics that could make it rattle."""
    shape = MeshBuilder("brass")
    shape.lathe([(0, 0), (0.054, 0), (0.06, 0.006), (0.06, 0.125), (0.05, 0.137), (0.02, 0.143),
                 (0.018, 0.165), (0.033, 0.178), (0.033, 0.196), (0.022, 0.204), (0, 0.204)],
                segments=48)  # fmt: skip
    weight = place("Weight", shape, "Table")
    weight.angen_load.mass = WEIGHT_KG
    for frame, leg in PATH:
        weight.location = (*(s * a for s, a in zip(LEGS[leg], LEG_AT, strict=True)), height)
        weight.keyframe_insert("location", frame=frame)
    set_linear(weight)


def set_linear(obj: bpy.types.Object) -> None:
    """Set straight lines between an object's keyframes."""
    for curve in obj.animation_data.action.fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def add_stack() -> None:
    """Add three boxes on a pad, each lighter and smaller than the one below."""
    add_pad("Pad stack", STACK_AT, 20 * G)
    z = PAD_HEIGHT
    materials = ("oak", "fabric rust", "fabric mustard")
    for mass, half, material in zip(STACK_KG, (16 * G, 13 * G, 10 * G), materials, strict=True):
        shape = about((half, half, half), material)
        stacked = place(f"Box {mass:g} kg", shape, "Stack", (*STACK_AT, z + half))
        still(rigid(stacked, "ACTIVE", mass))
        z += 2 * half


def add_drop() -> None:
    """Add a box that is held over a pad, let go after a second, and bounces."""
    add_pad("Pad drop", DROP_AT, 20 * G).restitution = BOUNCE
    half = 13 * G
    at = (*DROP_AT, PAD_HEIGHT + half + DROP_HEIGHT)
    dropped = place("Dropped box 2 kg", about((half,) * 3, "fabric grey blue"), "Drop", at)
    body = rigid(dropped, "ACTIVE", DROP_KG)
    body.restitution, body.linear_damping = BOUNCE, 0.0
    for frame, held in ((1, True), (RELEASE, False)):
        body.kinematic = held
        dropped.keyframe_insert("rigid_body.kinematic", frame=frame)
    # Else Blender lets the box go a frame late in one of some 700 runs.
    dropped.keyframe_insert("location", frame=1)


def add_surroundings() -> None:
    """Add floor, wall, labels, light and camera."""
    # The physics engine's boxes are about their object's origin.
    floor = about((4.0, 3.0, 8 * G), "concrete", 0.0)
    rigid(place("Floor", floor, "Surroundings", (0.0, 0.0, -8 * G)), "PASSIVE")
    place("Wall", box((-4, 1.5, 0), (4, 1.625, 3), "paint warm", 0), "Surroundings")
    for x, text in ((STACK_AT[0], "stack"), (0.0, "four legs"), (DROP_AT[0], "drop")):
        curve = bpy.data.curves.new(text, "FONT")
        curve.body, curve.size, curve.align_x = text, 0.11, "CENTER"
        label = place(f"Label {text}", curve, "Surroundings", (x, -0.66, 0.002))
        curve.materials.append(bpy.data.materials["sensor dark"])
        label.angen_ignored = True
    lights = ((330.0, (-2.4, -1.9, 2.6), 0.8, (1.0, 0.93, 0.84)),
              (60.0, (2.8, -1.6, 2.2), 1.2, (0.84, 0.92, 1.0)))  # fmt: skip
    for index, (watts, at, size, colour) in enumerate(lights):
        lamp = bpy.data.lights.new(f"Light {index + 1}", "AREA")
        lamp.energy, lamp.size, lamp.color = watts, size, colour
        look(place(lamp.name, lamp, "Surroundings", at), (0.0, 0.0, 0.2))
    camera = bpy.data.cameras.new("Camera")
    camera.lens = 40.0
    seen = place("Camera", camera, "Surroundings", (0.0, -3.2, 1.75))
    look(seen, (0.0, 0.0, 0.31))
    bpy.context.scene.camera = seen
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.2, 0.215, 0.235, 1.0)
    bpy.context.scene.world = world


def look(obj: bpy.types.Object, at: tuple[float, float, float]) -> None:
    """Turn a light or camera towards a point."""
    way = Vector(at) - obj.location
    obj.rotation_euler = way.to_track_quat("-Z", "Y").to_euler()


def build() -> bpy.types.Scene:
    """Fill an empty file with the three exhibits."""
    scene = bpy.context.scene
    scene.name = "Pressure"
    scene.frame_start, scene.frame_end, scene.render.fps = 1, LAST_FRAME, FPS
    scene.render.resolution_x, scene.render.resolution_y = 1280, 720
    for path in ("Sensors", "Table", "Stack", "Drop", "Surroundings"):
        collection(path)
    bpy.ops.rigidbody.world_add()
    world = scene.rigidbody_world
    world.collection = bpy.data.collections.new("RigidBodyWorld")
    world.point_cache.frame_start, world.point_cache.frame_end = 1, LAST_FRAME + 1
    add_table()
    add_stack()
    add_drop()
    add_surroundings()
    scene.frame_set(1)
    return scene


def set_up(scene: bpy.types.Scene) -> None:
    """Set up the picture of the box in mid-air and the weight on its way."""
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 32, True
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    for frame in range(1, PICTURE_FRAME + 1):
        scene.frame_set(frame)


if __name__ == "__main__":
    leave_hard(make(HERE / "pressure.blend", build, set_up))
