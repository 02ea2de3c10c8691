# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps with their fixtures, sun, sky, cameras and the render settings."""

from math import radians

import bpy
from mathutils import Vector

from . import plan
from .architecture import CEILING_Z
from .common import shade
from .meshes import MeshBuilder, collection, place

WARM = (1.0, 0.84, 0.66)
# Radiant power of each lamp, W.
POWER = {
    "Lamp living room": 45.0,
    "Lamp kitchen": 36.0,
    "Lamp bedroom": 27.0,
    "Lamp workroom": 27.0,
    "Lamp bathroom": 20.0,
    "Lamp hall": 27.0,
    "Lamp entry": 22.0,
    "Lamp closet": 5.0,
    "Lamp balcony": 6.0,
    "Floor lamp": 18.0,
    "Desk lamp bedroom": 4.0,
    "Window lamp workroom": 4.0,
    "Night light bathroom": 2.0,
    "Bedside lamp": 4.0,
}
# Length (m) of the line that shows the direction of an area lamp in the viewport. Blender's default
# of 40 would cross the whole home; the light itself is not cut off.
AXIS = 0.3
CAMERAS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float], float]] = {
    # name: place, target, focal length in mm
    "Camera overview": ((9.2, -3.2, 18.8), (6.0, 4.75, 0.0), 35.5),
    "Camera living": ((5.9, 3.35, 1.75), (9.2, 5.7, 0.95), 20.0),
    "Camera kitchen": ((3.3, 3.42, 1.75), (1.1, 5.2, 1.05), 19.0),
    "Camera hall": ((4.9, 2.1, 1.75), (4.75, 7.5, 1.05), 19.0),
}
# So high that its frame does not lie across the overview.
PLAN_CAMERA = ("Camera floor plan", (6.0, 4.95, 40.0), 19.6)


def _light(name: str, at: tuple[float, float, float], radius: float) -> bpy.types.Object:
    data = bpy.data.lights.new(name, "POINT")
    data.energy = POWER[name]
    data.color = WARM
    data.shadow_soft_size = radius
    obj = bpy.data.objects.new(name, data)
    obj.location = at
    collection("Lights").objects.link(obj)
    return obj


def _panel(
    name: str, at: tuple[float, float, float], diameter: float, turn: tuple[float, float, float]
) -> bpy.types.Object:
    """Return a lamp on a ceiling or wall: a disk that shines away from it, down without a turn.

    Light paths find a disk far sooner than the small bright spot that a point lamp makes on its
    wall.
    """
    lamp = _light(name, at, 0.0)
    lamp.data.type = "AREA"
    lamp.data.shape, lamp.data.size = "DISK", diameter
    lamp.data.cutoff_distance = AXIS
    lamp.rotation_euler = turn
    return lamp


def _fixture(lamp: bpy.types.Object, builder: MeshBuilder) -> bpy.types.Object:
    """Return a lamp's body, built about the lamp's light and parented to it."""
    return place(f"{lamp.name} fixture", builder, "Lights", parent=lamp)


def _pendant(at: tuple[float, float, float]) -> MeshBuilder:
    b = MeshBuilder("black metal")
    up = CEILING_Z - at[2]
    b.rod((0, 0, 0.19), (0, 0, up), 0.004, 6)
    b.cylinder((0, 0, up - 0.03), 0.05, 0.03, 16)
    b.cylinder((0, 0, 0.1), 0.025, 0.1, 12)
    shade(b, (0, 0, -0.1), 0.26, 0.08, 0.26)
    return b


def _wall_lamp() -> MeshBuilder:
    """Return a lamp 0.21 wide, its plate on a wall 0.28 behind it (y = −0.28)."""
    b = MeshBuilder("brass")
    b.box((-0.05, -0.29, -0.07), (0.05, -0.27, 0.07), 0.006)
    b.tube([(0, -0.27, 0), (0, -0.16, -0.02), (0, -0.13, -0.06)], 0.009, 8)
    b.tube([(0, -0.13, -0.08), (0, 0.0, -0.08)], 0.009, 8)
    b.cylinder((0, 0, -0.09), 0.03, 0.03, 12)
    shade(b, (0, 0, -0.09), 0.105, 0.075, 0.18)
    return b


def _ceiling_lamp(z: float, radius: float) -> MeshBuilder:
    b = MeshBuilder("white paint")
    top = CEILING_Z - z
    b.cylinder((0, 0, top - 0.02), radius, 0.02, 24)
    r = radius * 0.95
    b.lathe([(0, top - 0.16), (r * 0.6, top - 0.145), (r * 0.92, top - 0.09), (r, top - 0.02)],
            segments=24, material="lamp glass")  # fmt: skip
    return b


def _bar_lamp() -> MeshBuilder:
    """Return a tube over the mirror, whose wall lies at y = −0.06."""
    b = MeshBuilder("chrome")
    b.box((-0.25, -0.06, -0.02), (0.25, -0.045, 0.02), 0.004)
    for x in (-0.27, 0.27):
        b.tube([(x - 0.01, 0, 0), (x + 0.01, 0, 0)], 0.027, 16)
    for x in (-0.26, 0.26):
        b.tube([(x, -0.05, 0), (x, 0, 0)], 0.008, 8)
    b.tube([(-0.26, 0, 0), (0.26, 0, 0)], 0.024, 16, "lamp glass")
    return b


def _floor_lamp(height: float) -> MeshBuilder:
    b = MeshBuilder("black metal")
    b.cylinder((0, 0, -height), 0.15, 0.02, 24)
    b.rod((0, 0, -height + 0.02), (0, 0, 0.02), 0.01, 8)
    shade(b, (0, 0, -0.16), 0.17, 0.13, 0.3)
    return b


def add_lamps() -> None:
    """Add one lamp per room at the plan's places, and the small lamps on furniture."""
    for name, at in plan.LAMPS.items():
        if name == "Lamp living room":
            _fixture(_light(name, at, 0.05), _pendant(at))
        elif name in ("Lamp kitchen", "Lamp bedroom", "Lamp workroom"):
            _fixture(_light(name, at, 0.04), _wall_lamp())
        elif name == "Lamp bathroom":
            bar = _panel(name, at, 0.5, (radians(90), 0, 0))
            bar.data.shape, bar.data.size_y = "RECTANGLE", 0.05
            fixture = _fixture(bar, _bar_lamp())
            fixture.rotation_euler.x = radians(-90)
        elif name == "Lamp balcony":
            lamp = _light(name, at, 0.03)
            b = MeshBuilder("black metal")
            b.box((-0.085, -0.06, -0.09), (-0.07, 0.06, 0.09), 0.004)
            b.box((-0.07, -0.05, 0.07), (0.05, 0.05, 0.085), 0.004)
            b.cylinder((0, 0, -0.08), 0.045, 0.15, 16, "lamp glass")
            _fixture(lamp, b)
        else:
            radius = 0.1 if name == "Lamp closet" else 0.2
            low = (at[0], at[1], CEILING_Z - 0.09)
            _fixture(_panel(name, low, 1.6 * radius, (0, 0, 0)), _ceiling_lamp(low[2], radius))
    box = plan.FURNITURE["Floor lamp"]
    z = box.z1 - 0.16
    at = ((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, z)
    _fixture(_light("Floor lamp", at, 0.04), _floor_lamp(z - plan.FLOOR_Z))
    # These stand inside shades that the rooms' modules build.
    _light("Desk lamp bedroom", (0.4, 2.6, 0.74 + 0.37), 0.03)
    _light("Window lamp workroom", (-0.13, 8.05, plan.WINDOW_SILL + 0.522), 0.03)
    # Its wall is at y = −0.05 after the turn of its lamp, so it is built lying on its back.
    b = MeshBuilder("white plastic")
    b.box((-0.03, -0.04, 0.04), (0.03, 0.04, 0.05), 0.004)
    b.cushion((-0.025, -0.035, -0.015), (0.025, 0.035, 0.04), 0.012, 0.0, "lamp glass", 2)
    night = _panel("Night light bathroom", (5.75, 1.55, 0.42), 0.04, (radians(90), 0, radians(180)))
    _fixture(night, b)
    b = MeshBuilder("brass")
    b.box((0.09, -0.04, -0.06), (0.1, 0.04, 0.06), 0.003)
    b.tube([(0.09, 0, 0), (0.0, 0, -0.05)], 0.007, 8)
    shade(b, (0, 0, -0.06), 0.08, 0.055, 0.13)
    _fixture(_light("Bedside lamp", (3.4, 1.62, 1.2), 0.03), b)


def add_daylight() -> None:
    """Add a low morning sun from the south-east, and a sky that is a plain gradient."""
    data = bpy.data.lights.new("Sun", "SUN")
    data.energy = 3.0
    data.color = (1.0, 0.9, 0.76)
    data.angle = radians(1.0)
    sun = bpy.data.objects.new("Sun", data)
    sun.location = (18.0, -4.0, 9.0)
    sun.rotation_euler = (radians(66.0), 0.0, radians(72.0))
    collection("Lights").objects.link(sun)
    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    coordinate = tree.nodes.new("ShaderNodeTexCoord")
    split = tree.nodes.new("ShaderNodeSeparateXYZ")
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    wide = tree.nodes.new("ShaderNodeMapRange")
    background = tree.nodes.new("ShaderNodeBackground")
    output = tree.nodes.new("ShaderNodeOutputWorld")
    wide.inputs["From Min"].default_value = -1.0
    elements = ramp.color_ramp.elements
    elements[0].position, elements[0].color = 0.49, (0.24, 0.25, 0.24, 1)
    elements[1].position, elements[1].color = 1.0, (0.2, 0.38, 0.72, 1)
    elements.new(0.505).color = (0.86, 0.88, 0.88, 1)
    elements.new(0.62).color = (0.52, 0.69, 0.9, 1)
    background.inputs["Strength"].default_value = 3.0
    for a, b in (
        (coordinate.outputs["Generated"], split.inputs[0]), (split.outputs["Z"], wide.inputs[0]),
        (wide.outputs[0], ramp.inputs[0]), (ramp.outputs[0], background.inputs[0]),
        (background.outputs[0], output.inputs[0]),
    ):  # fmt: skip
        tree.links.new(a, b)
    bpy.context.scene.world = world


def add_portals() -> None:
    """Add a portal at each window, which tells Cycles where the sky comes in."""
    for window in plan.WINDOWS:
        data = bpy.data.lights.new(f"Portal {window.name}", "AREA")
        data.shape = "RECTANGLE"
        data.size = plan.WINDOW_HEAD - plan.WINDOW_SILL
        data.size_y = window.y1 - window.y0
        data.cutoff_distance = AXIS
        data.cycles.is_portal = True
        portal = bpy.data.objects.new(data.name, data)
        # A click on the window should not select it.
        portal.hide_select = True
        middle = (window.y0 + window.y1) / 2, (plan.WINDOW_SILL + plan.WINDOW_HEAD) / 2
        portal.location = ((window.x0 + window.x1) / 2, *middle)
        portal.rotation_euler.y = radians(-90.0 * window.inside)
        collection("Lights/Portals").objects.link(portal)


def add_cameras() -> None:
    """Add four views and a plan; the overview is the scene's camera."""
    scene = bpy.context.scene
    for name, (at, target, lens) in CAMERAS.items():
        data = bpy.data.cameras.new(name)
        data.lens = lens
        data.clip_start = 0.05
        camera = bpy.data.objects.new(name, data)
        camera.location = at
        way = Vector(target) - Vector(at)
        camera.rotation_euler = way.to_track_quat("-Z", "Y").to_euler()
        collection("Cameras").objects.link(camera)
        if name == "Camera overview":
            scene.camera = camera
    name, at, scale = PLAN_CAMERA
    data = bpy.data.cameras.new(name)
    data.type = "ORTHO"
    data.ortho_scale = scale
    camera = bpy.data.objects.new(name, data)
    camera.location = at
    collection("Cameras").objects.link(camera)


def set_rendering() -> None:
    """Set units, time base, engine and view transform."""
    scene = bpy.context.scene
    scene.unit_settings.system = "METRIC"
    scene.unit_settings.scale_length = 1.0
    scene.render.fps, scene.render.fps_base = plan.FPS, 1.0
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 64
    scene.cycles.use_denoising = False
    scene.cycles.max_bounces = 16
    scene.cycles.diffuse_bounces = 8
    scene.cycles.transparent_max_bounces = 16
    scene.cycles.sample_clamp_indirect = 8.0
    scene.angen_light_reference = 32768
    scene.render.filepath = "//"
    scene.render.resolution_x, scene.render.resolution_y = 1920, 1080
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.view_settings.exposure = 1.1
    scene.frame_start, scene.frame_current = 1, 1


def add_lighting() -> None:
    """Add all objects of this module."""
    add_lamps()
    add_daylight()
    add_portals()
    add_cameras()
    set_rendering()
