# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the sample of the light sensor, light.blend: six sensors with closed forms.

python sample_blends/build_light.py [--out FILE] [--picture FILE]
blender -b -P sample_blends/build_light.py -- [--out FILE] [--picture FILE]

Four stand in black boxes under one lamp each, one lies in a white ball, and one on a mast under sun
and sky.
"""

import os
import sys
from math import cos, pi, radians, sin
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

FPS, LAST_FRAME, RATE = 24, 97, 4.0
# So many that the interreflected light in the ball is within 2 %; a lamp alone needs a few.
SAMPLES = 8192
SPACING, HALF, HIGH, WALL = 1.6, 0.7, 1.6, 0.04
# Height of each lamp above its sensor.
ABOVE = 1.25
POINT_W, SPOT_W, SPOT_ANGLE, AREA_W, AREA_SIZE = 12.0, 30.0, radians(70), 4.0, 0.5
GLOW, GLOW_SIZE = 3.0, 0.4
BALL_RADIUS, BALL_RINGS, BALL_REFLECTS, BALL_W = 0.7, 48, 0.8, 3.0
SUN, SUN_HEIGHT, SKY = 2.0, radians(40), 0.5
MAST = 2.2
PICTURE_FRAME = 49


def material(name: str, kind: str, value: float, strength: float = 0.0):
    """Return a diffuse material of one reflectance, or a glowing one of a radiance [W/(m² sr)]."""
    made = bpy.data.materials.new(name)
    made.diffuse_color = (value, value, value, 1.0)
    if not made.node_tree:
        made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    shader = nodes.new(f"Shader{kind}")
    shader.inputs["Color"].default_value = (value, value, value, 1.0)
    if strength:
        shader.inputs["Strength"].default_value = strength
    output = nodes.new("ShaderNodeOutputMaterial")
    made.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return made


def shaped(name: str, verts: list, faces: list, of, at: tuple[float, ...]):
    """Add a mesh object of one material."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(verts, [], faces)
    mesh.materials.append(of)
    return place(name, mesh, "Exhibits", at)


def add_sensor(name: str, at: tuple[float, ...]) -> None:
    """Add a light sensor whose face looks up; readings in lux."""
    shape = MeshBuilder("sensor body")
    shape.cylinder((0, 0, 0), 0.05, 0.02, 32)
    shape.cylinder((0, 0, -0.002), 0.02, 0.002, 24, "sensor lens")
    sensor = place(f"Light sensor {name}", shape, "Sensors", at)
    # A sensor senses along its own −Z.
    sensor.rotation_euler = (pi, 0.0, 0.0)
    sensor.angen_sensor.kind = "LIGHT"
    sensor.angen_sensor.update_rate = RATE
    sensor.angen_sensor.light.method = "ILLUMINANCE"
    sensor.angen_sensor.light.samples = SAMPLES


def add_lamp(name: str, kind: str, at: tuple[float, ...], **settings):
    """Add a lamp that shines down."""
    data = bpy.data.lights.new(f"Lamp {name}", kind)
    for key, value in settings.items():
        setattr(data, key, value)
    return place(data.name, data, "Exhibits", at)


def add_box(name: str, x: float, black) -> None:
    """Add a closed black box; the camera looks through its front and its lid."""
    h, t = HALF, WALL
    walls = {
        "": (((-h - t, -h - t, -t), (h + t, h + t, 0)), ((-h - t, h, 0), (h + t, h + t, HIGH)),
             ((-h - t, -h, 0), (-h, h, HIGH)), ((h, -h, 0), (h + t, h, HIGH))),
        " front": (((-h - t, -h - t, 0), (h + t, -h, HIGH)),
                   ((-h - t, -h - t, HIGH), (h + t, h + t, HIGH + t))),
    }  # fmt: skip
    for part, slabs in walls.items():
        shape = MeshBuilder("sensor dark")
        for lo, hi in slabs:
            shape.box(lo, hi, 0.0)
        obj = place(f"Box {name}{part}", shape, "Exhibits", (x, 0.0, 0.0))
        obj.data.materials.clear()
        obj.data.materials.append(black)
        if part:
            obj.visible_camera = False
            obj.display_type = "WIRE"


def add_ball(x: float) -> None:
    """Add a white hollow ball with a lamp in its centre; the sensor lies at its bottom."""
    rows = [pi * i / BALL_RINGS for i in range(1, BALL_RINGS)]
    n = 2 * BALL_RINGS
    points = [(0.0, 0.0, BALL_RADIUS)]
    points += [
        (BALL_RADIUS * sin(a) * cos(2 * pi * i / n), BALL_RADIUS * sin(a) * sin(2 * pi * i / n),
         BALL_RADIUS * cos(a))
        for a in rows for i in range(n)
    ]  # fmt: skip
    points.append((0.0, 0.0, -BALL_RADIUS))
    last, end = len(points) - 1, 1 + (len(rows) - 1) * n
    faces = [(0, 1 + i, 1 + (i + 1) % n) for i in range(n)]
    for row in range(len(rows) - 1):
        a, b = 1 + row * n, 1 + (row + 1) * n
        faces += [(a + i, b + i, b + (i + 1) % n, a + (i + 1) % n) for i in range(n)]
    faces += [(end + i, last, end + (i + 1) % n) for i in range(n)]
    white = material("White 80 %", "NodeBsdfDiffuse", BALL_REFLECTS)
    shaped("Ball", points, faces, white, (x, 0.0, BALL_RADIUS))
    add_lamp("ball", "POINT", (x, 0.0, BALL_RADIUS), energy=BALL_W, shadow_soft_size=0.0)
    # A chord above the bottom: inside the facets.
    add_sensor("ball", (x, 0.0, 0.01))


def add_exhibits() -> None:
    """Add the six sensors from left to right, as their labels say."""
    black = material("Black", "NodeBsdfDiffuse", 0.0)
    names = ("point", "spot", "area", "glowing plate", "white ball", "sun and sky")
    places = {name: (i - (len(names) - 1) / 2) * SPACING for i, name in enumerate(names)}
    for name in names[:4]:
        add_box(name, places[name], black)
        add_sensor(name, (places[name], 0.0, 0.0))
    lamp = add_lamp("point", "POINT", (places["point"], 0, ABOVE), shadow_soft_size=0.0)
    for frame, share in ((1, 0.0), (49, 1.0), (97, 0.0)):
        lamp.data.energy = share * POINT_W
        lamp.data.keyframe_insert("energy", frame=frame)
    for point in lamp.data.animation_data.action.fcurves[0].keyframe_points:
        point.interpolation = "LINEAR"
    add_lamp("spot", "SPOT", (places["spot"], 0, ABOVE), energy=SPOT_W, shadow_soft_size=0.0,
             spot_size=SPOT_ANGLE)  # fmt: skip
    add_lamp("area", "AREA", (places["area"], 0, ABOVE), energy=AREA_W, size=AREA_SIZE)
    h = GLOW_SIZE / 2
    glowing = material("Glowing", "NodeEmission", 1.0, GLOW)
    shaped("Glowing plate", [(-h, -h, 0), (-h, h, 0), (h, h, 0), (h, -h, 0)], [(0, 1, 2, 3)],
           glowing, (places["glowing plate"], 0.0, ABOVE))  # fmt: skip
    add_ball(places["white ball"])
    x = places["sun and sky"]
    mast = MeshBuilder("steel")
    mast.cylinder((0, 0, 0), 0.02, MAST - 0.02, 16)
    place("Mast", mast, "Exhibits", (x, 0.0, 0.0))
    add_sensor("sun and sky", (x, 0.0, MAST))
    sun = add_lamp("sun", "SUN", (x, -2.0, 4.0), energy=SUN, angle=0.0)
    sun.rotation_euler = (pi / 2 - SUN_HEIGHT, 0.0, radians(25))
    for name, x in places.items():
        curve = bpy.data.curves.new(f"Label {name}", "FONT")
        curve.body, curve.size, curve.align_x = name, 0.17, "CENTER"
        label = place(curve.name, curve, "Exhibits", (x, -1.0, 0.005))
        label.rotation_euler = (radians(50), 0.0, 0.0)
        curve.materials.append(material(f"Label {name}", "NodeBsdfDiffuse", 0.02))
        label.angen_ignored = True


def add_surroundings() -> None:
    """Add ground, sky and camera."""
    floor = MeshBuilder("concrete")
    floor.box((-7, -3, -0.2), (7, 4, -WALL - 0.001), 0.0)
    place("Ground", floor, "Exhibits")
    world = bpy.data.worlds.new("Sky")
    if not world.node_tree:
        world.use_nodes = True
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    background.inputs["Strength"].default_value = SKY
    bpy.context.scene.world = world
    data = bpy.data.cameras.new("Camera")
    data.lens = 38.0
    camera = place("Camera", data, "Exhibits", (0.0, -10.6, 4.2))
    way = Vector((0.0, 0.0, 0.85)) - camera.location
    camera.rotation_euler = way.to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = camera


def build() -> bpy.types.Scene:
    """Fill an empty file."""
    scene = bpy.context.scene
    scene.name = "Light"
    scene.frame_start, scene.frame_end, scene.render.fps = 1, LAST_FRAME, FPS
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = 1280, 640
    for path in ("Sensors", "Exhibits"):
        collection(path)
    add_exhibits()
    add_surroundings()
    scene.frame_set(1)
    return scene


def set_up(scene: bpy.types.Scene) -> None:
    """Set up the picture of all six, in the middle of the story."""
    scene.cycles.samples, scene.cycles.use_denoising = 48, True
    scene.render.resolution_percentage = 60
    scene.frame_set(PICTURE_FRAME)


if __name__ == "__main__":
    leave_hard(make(HERE / "light.blend", build, set_up))
