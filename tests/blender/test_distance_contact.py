# SPDX-License-Identifier: GPL-3.0-or-later
"""Distance sensors and door contacts in scenes of known measure."""

import math

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.view.readings import reading_text

ops = bpy.ops.angen


def coloured(world, name, *colours):
    """Add a wall of strips from left to right, each of another grey (its reflectance)."""
    n = len(colours)
    points = [(x / n * 8 - 4, y, 0) for x in range(n + 1) for y in (-4, 4)]
    faces = [(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1) for i in range(n)]
    wall = world.link(name, world.mesh(points, faces))
    for number, grey in enumerate(colours):
        material = bpy.data.materials.new(f"{name} {number}")
        material.use_nodes = True
        shader = material.node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (grey, grey, grey, 1.0)
        wall.data.materials.append(material)
        wall.data.polygons[number].material_index = number
    return wall


def ranger(world, name="tof", preset="VL53L1X", **settings):
    ops.sensor_add(kind="DISTANCE", preset=preset)
    made = bpy.context.object
    made.data, made.name, made.matrix_world.translation = made.data, name, (0, 0, 0)
    made.angen_sensor.update_rate = 24.0
    quiet = dict.fromkeys(("noise_sigma", "noise_growth", "offset_sigma", "offset_growth"), 0.0)
    quiet["resolution"] = 0.0
    for key, value in {**quiet, **settings}.items():
        setattr(made.angen_sensor.distance, key, value)
    return made


def contact(world, name, magnet=None, **settings):
    given = {"close_distance": 0.015, "open_distance": 0.02, "magnet": magnet, **settings}
    return world.sensor("CONTACT", name, update_rate=24.0, **given)


@pytest.mark.parametrize("scale", [1.0, 0.01])
@pytest.mark.parametrize(("grey", "farthest"), [(0.88, 3.6), (0.17, 1.7)])
def test_how_far_a_material_is_seen(world, each_caster, scale, grey, farthest):
    world.scene.unit_settings.scale_length = scale
    wall = coloured(world, "wall", grey)
    wall.scale = (1 / scale,) * 3
    sensor = ranger(world, rays=1)
    places = {1: farthest * 0.99, 10: farthest * 1.01, 20: 0.5, 30: 0.01}
    world.key(wall, "location", {f: (0, 0, -d / scale) for f, d in places.items()}, "CONSTANT")
    found = world.series(world.run(), sensor.name, "distance_m")
    assert [found[f - 1] for f in places] == pytest.approx(
        [farthest * 0.99, 3.6, 0.5, 0.04], abs=1e-5
    ), "nothing reads the range max, what is too near the range min"


def test_each_face_reflects_as_its_own_material(world):
    """Black on the left, white on the right, at a distance at which black is not seen."""
    coloured(world, "wall", 0.02, 0.88).location = (0, 0, -2.0)
    ranger(world, zones_across=2, rays=3)
    first = world.series(world.run(1, 2), "tof", "zones_m")[0]
    left, right = first.split(";")
    assert left == "" and float(right) == pytest.approx(2.0, rel=0.01)


def test_a_colour_that_changes_is_seen_live_and_voids_the_recording(world):
    wall = coloured(world, "wall", 0.88)
    wall.location = (0, 0, -2.0)
    sensor = ranger(world, rays=1)
    assert ops.simulate() == {"FINISHED"} and ops.export_events.poll()
    shader = wall.data.materials[0].node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.02, 0.02, 0.02, 1.0)
    world.update()
    assert not ops.export_events.poll()
    world.scene.frame_set(5)
    assert sensor.angen_sensor.value == pytest.approx(3.6)


def test_explain_names_what_is_near(world):
    box = world.box((0.4, 0.4, 0.4), (0, 0, -1.2), name="Person")
    world.wall(3.0, size=20.0)
    ranger(world, preset="VL53L5CX", target="FIXED", threshold=1.5)
    world.key(box, "location", {1: (9, 0, -1.2), 10: (0.1, 0.1, -1.2)}, "CONSTANT")
    recording = world.run(1, 12)
    (sensor,) = world.sensors()
    near = explain(world.scene, sensor, recording, 10)
    assert near.headline.startswith("Near: 'Person', 1.0") and not near.doubt
    assert dict(near.facts)["Zones with a hit"].endswith("of 64")
    clear = explain(world.scene, sensor, recording, 3)
    assert clear.headline.startswith("Clear: 'wall', 3.0")


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_a_door_is_told_open_at_the_angle_of_the_chord(world, scale):
    """The magnet is 0.8 m from the hinge: 20 mm away at 1.4325°, and 15 mm at 1.0743°."""
    world.scene.unit_settings.scale_length = scale
    leaf = world.link("leaf", None)
    magnet = world.link("magnet", None, (0.8 / scale, 0, 0))
    magnet.parent = leaf
    made = contact(world, "contact", magnet)
    made.location = (0.8 / scale, 0, 0)
    # A hundredth of a degree per frame: open and shut again.
    world.scene.frame_end = 401
    shut, wide = (0, 0, 0), (0, 0, math.radians(2.0))
    world.key(leaf, "rotation_euler", {1: shut, 201: wide, 401: shut}, "LINEAR")
    recording = world.run()
    rows = [(float(row[1]), row[5]) for row in world.log(recording)]
    assert rows == [(1.0, "0"), (145.0, "1"), (294.0, "0")]
    way = world.series(recording, "contact", "distance_m")
    assert way[200] == pytest.approx(1.6 * math.sin(math.radians(1.0)), abs=1e-6)


def test_a_contact_without_a_magnet_is_open_and_says_so(world):
    contact(world, "bare")
    recording = world.run(1, 2)
    assert world.series(recording, "bare", "open") == [True, True]
    (sensor,) = world.sensors()
    found = explain(world.scene, sensor, recording, 1)
    assert "no magnet" in found.headline
    world.scene.frame_set(2)
    assert reading_text(sensor, world.scene).text == "Open, –"


def test_in_an_instance_the_magnet_is_that_of_the_instance(world):
    magnet = world.link("magnet", None, (0.01, 0, 0))
    made = contact(world, "Door", magnet)
    world.key(magnet, "location", {1: (0.01, 0, 0), 10: (1, 0, 0)}, "CONSTANT")
    flat = world.aside("flat", magnet, made)
    for name, at in (("A", (0, 0, 0)), ("B", (10, 0, 0))):
        holder = world.instance(name, flat, at)
        holder.rotation_euler.z = at[0]
    recording = world.run(1, 12)
    for name in ("A/Door", "B/Door"):
        assert world.series(recording, name, "distance_m")[0] == pytest.approx(0.01, abs=1e-6)
        assert world.series(recording, name, "open") == [False] * 9 + [True] * 3
