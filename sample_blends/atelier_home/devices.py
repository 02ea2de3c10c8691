# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps with their switches, the sun, and the sensors."""

from math import pi, radians

import bpy
from angen_home.meshes import MeshBuilder, collection, place
from mathutils import Euler, Matrix

from .shell import BATH_Y, HIGH, LONG

Vec = tuple[float, float, float]
# The place of each lamp, its power (W), and the place of its switch on the wall.
LAMPS: dict[str, tuple[Vec, float, Vec | None]] = {
    "Lamp table": ((4.3, 4.1, 1.75), 30.0, (6.49, 4.15, 1.1)),
    "Lamp entrance": ((8.2, 1.8, HIGH - 0.1), 20.0, (LONG - 0.01, 2.3, 1.1)),
    "Lamp kitchen": ((4.0, 5.7, HIGH - 0.1), 30.0, (5.75, 6.49, 1.1)),
    "Lamp bath": ((7.8, 5.3, HIGH - 0.1), 20.0, (7.2, BATH_Y + 0.01, 1.1)),
    "Lamp sleeping": ((1.3, 4.9, HIGH - 0.1), 20.0, (1.9, 6.49, 1.1)),
    "Reading lamp": ((2.6, 2.85, 1.5), 10.0, None),
}
# Detectors, level, in corners: room, place, and the yaw (degrees) along which they sense.
DETECTORS: dict[str, tuple[str, Vec, float]] = {
    "PIR living": ("living", (0.08, 0.08, 2.3), 45.0),
    "PIR sleeping": ("sleeping", (0.08, 6.42, 2.3), -45.0),
    "PIR kitchen": ("kitchen", (6.42, 6.42, 2.3), -135.0),
    "PIR entrance": ("entrance", (8.92, 0.08, 2.3), 135.0),
    "PIR bath": ("bath", (8.92, 4.28, 2.3), 135.0),
}
LIGHTS: dict[str, tuple[str, Vec]] = {
    "Light living": ("living", (2.2, 2.9, HIGH - 0.15)),
    "Light bath": ("bath", (7.6, 5.0, HIGH - 0.15)),
}
# Mats under the sheets of the beds: y of their centre.
MATS = {"Mat of Karin": 6.0, "Mat of Olle": 4.2}


def add_lamps() -> None:
    """Add lamps with marks: disks, or points where they stand free."""
    for name, (at, power, switch) in LAMPS.items():
        data = bpy.data.lights.new(name, "POINT" if at[2] < 2.0 else "AREA")
        data.energy, data.color = power, (1.0, 0.85, 0.68)
        if data.type == "AREA":
            data.shape, data.size, data.cutoff_distance = "DISK", 0.3, 0.3
        else:
            data.shadow_soft_size = 0.05
        lamp = bpy.data.objects.new(name, data)
        lamp.location = at
        collection("Atelier/Lamps").objects.link(lamp)
        lamp.angen_place.use = "LAMP"
        if switch is not None:
            empty = place(f"Switch of {name}", None, "Atelier/Places", switch)
            empty.empty_display_type, empty.empty_display_size = "CIRCLE", 0.06
            lamp.angen_place.switch = empty
    foot = MeshBuilder("black metal")
    foot.cylinder((0, 0, -1.5), 0.14, 0.02, 20)
    foot.rod((0, 0, -1.48), (0, 0, -0.1), 0.01, 8)
    place("Reading lamp foot", foot, "Atelier/Lamps", parent=bpy.data.objects["Reading lamp"])


def add_sun() -> None:
    """Add a sun and a plain sky, above Umeå."""
    scene = bpy.context.scene
    data = bpy.data.lights.new("Sun", "SUN")
    data.energy, data.angle = 3.0, radians(0.53)
    sun = bpy.data.objects.new("Sun", data)
    sun.location, sun.rotation_euler = (0.0, -6.0, 8.0), (radians(58.0), 0.0, radians(20.0))
    collection("Atelier/Lamps").objects.link(sun)
    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.45, 0.62, 0.9, 1.0)
    background.inputs["Strength"].default_value = 1.5
    scene.world = world
    site = getattr(scene, "angen_site", None)
    if site is not None:
        site.latitude, site.longitude = radians(63.83), radians(20.26)
        site.utc_offset = 1.0


def _add(kind: str, name: str, room: str, matrix: Matrix) -> bpy.types.Object:
    """Add a sensor."""
    bpy.context.scene.cursor.matrix = matrix
    bpy.ops.angen.sensor_add(kind=kind)
    sensor = bpy.context.object
    sensor.name, sensor.angen_sensor.room = name, room
    return sensor


def add_sensors() -> None:
    """Add detectors, light sensors, mats in the beds, and switches on the doors."""
    for name, (room, at, yaw) in DETECTORS.items():
        level = Euler((pi / 2, 0.0, radians(yaw - 90.0))).to_matrix().to_4x4()
        _add("PIR", name, room, Matrix.Translation(at) @ level)
    for name, (room, at) in LIGHTS.items():
        level = Euler((pi / 2, 0.0, 0.0)).to_matrix().to_4x4()
        sensor = _add("LIGHT", name, room, Matrix.Translation(at) @ level)
        sensor.angen_sensor.light.samples = 64
    for name, y in MATS.items():
        mat = MeshBuilder("sensor dark")
        mat.box((-0.4, -0.35, 0.0), (0.4, 0.35, 0.008), 0.0)
        pad = place(name, mat, "Sensors", (1.0, y, 0.545))
        pad.angen_sensor.kind, pad.angen_sensor.room = "PRESSURE", "sleeping"
        pad.angen_sensor.pressure.threshold = 100.0


def fit_doors() -> None:
    """Add a switch to each door by *Fit Door*."""
    for leaf, room in (("Front door", "entrance"), ("Bath door", "bath")):
        for obj in bpy.context.selected_objects:
            obj.select_set(False)
        door = bpy.data.objects[leaf]
        door.select_set(True)
        bpy.context.view_layer.objects.active = door
        bpy.ops.angen.door_fit(motion="SLIDING" if door.angen_place.motion == "SLIDING" else "AUTO")
        bpy.context.object.angen_sensor.room = room
