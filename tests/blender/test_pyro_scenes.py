# SPDX-License-Identifier: GPL-3.0-or-later
"""The warmth that a pyroelectric detector senses in a scene, its readings, and its messages."""

import math

import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.advice import warmth
from bl_ext.user_default.angen_sensors.angen_addon.runtime.probes import Probes
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import AngenError as error
from bl_ext.user_default.angen_sensors.sensor_logic import model
from bl_ext.user_default.angen_sensors.sensor_logic.kind import WARMTH
from bl_ext.user_default.angen_sensors.sensor_logic.kinds.pir import range_scan as pir
from bl_ext.user_default.angen_sensors.sensor_logic.kinds.pir.lenses import read_table as read
from bl_ext.user_default.angen_sensors.sensor_logic.kinds.pir.pyroelectric import (
    PyroelectricDetector,
)
from bl_ext.user_default.angen_sensors.sensor_logic.recording import file

ZERO = 273.15


def detector(world, **settings):
    """Add a detector that faces +Y, 1.2 m up."""
    obj = world.pir("detector", model="PYROELECTRIC", **settings)
    obj.location, obj.rotation_euler = (0, 0, 1.2), (math.pi / 2, 0, 0)
    return obj


def man(world, value=28.0, emissivity=0.95):
    body = world.box((0.45, 0.3, 1.7), (-2, 3, 0.85), "man")
    world.warm(body, value, emissivity)
    world.key(body, "location", {1: (-2, 3, 0.85), 24: (-2, 3, 0.85), 120: (2, 3, 0.85)})
    world.scene.frame_end = 216
    return body


def signals(world, name="detector"):
    return np.array(world.series(world.run(), name, "signal"))


def test_a_walker_is_noticed_and_then_forgotten(world, each_caster):
    detector(world)
    man(world)
    recording = world.run()
    moved = world.series(recording, "detector", "moved")
    assert not any(moved[:24]) and any(moved[24:120]) and not any(moved[180:])
    assert abs(world.series(recording, "detector", "signal")[-1]) < 0.3
    assert all(math.isnan(angle) for angle in world.series(recording, "detector", "angle_rad"))


def test_events_of_a_wireless_detector_have_the_time_of_their_messages(
    world, addon_part, command, tmp_path
):
    times = {"hold_time": 1.125, "blanking_time": 0.5625, "message_delay": 0.015}
    detector(world, update_rate=10.0, **times)
    man(world)
    recording = world.run()
    events = addon_part("sensor_logic.recording.events").events(recording)
    changes = [event for event in events if event.field == "moved"][1:]
    assert [event.value for event in changes][:2] == [True, False]
    for event in changes:
        update = (event.frame - 1) / 24
        assert update - 0.15 < event.time < update
    assert changes[1].time - changes[0].time >= 1.0
    track = recording.tracks["detector"]
    assert (np.diff(np.array(track.times)) >= 0.0).all()
    # Explained at the time in the log, and still unknown just before.
    world.bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    for time, frame in ((changes[0].time, changes[0].frame), (changes[0].time - 0.001, 1.0)):
        told = command("explain", "--sensor", "detector", "--time", f"{time:.6f}")[1]
        assert told.startswith(f"detector, frame {frame:g} ("), told
    # A file keeps the times.
    read = file.from_bytes(file.to_bytes(recording, {}))[0].tracks["detector"]
    assert (read.times, read.frames, read.active) == (track.times, track.frames, track.active)


def test_both_casters_and_each_unit_scale_say_the_same(world):
    detector(world)
    body = man(world)
    fast = signals(world)
    world.scene.angen_ray_caster = "SCENE"
    np.testing.assert_allclose(signals(world), fast, atol=1e-9)
    world.scene.angen_ray_caster = "FAST"
    # The same world in centimetres.
    world.scene.unit_settings.scale_length = 0.01
    body.data.transform(__import__("mathutils").Matrix.Scale(100, 4))
    world.bpy.data.objects["detector"].location *= 100
    body.animation_data_clear()
    across = {1: (-200, 300, 85), 24: (-200, 300, 85), 120: (200, 300, 85)}
    world.key(body, "location", across)
    np.testing.assert_allclose(signals(world), fast, atol=0.02)


def test_in_a_scene_it_says_what_it_says_alone(world):
    """The way through Blender agrees with the model and a box in closed form."""
    detector(world, zone_rays=24)
    man(world, 28.0, 0.9)
    found = signals(world)
    sensing = PyroelectricDetector()
    parameters = pir.PirParameters(model="PYROELECTRIC", zone_rays=24)
    pose = model.Pose(np.array([0, 0, 1.2]), np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))
    expected = []
    for frame in range(1, 217):
        x = -2 + 4 * min(max((frame - 24) / 96, 0), 1)
        lo, hi = np.array([x - 0.225, 2.85, 0]), np.array([x + 0.225, 3.15, 1.7])

        def warmth(bundle, origins, directions, length, lo=lo, hi=hi):
            one, two = (lo - origins) / directions, (hi - origins) / directions
            hit = np.minimum(one, two).max(axis=1) <= np.maximum(one, two).min(axis=1)
            hit &= np.maximum(one, two).min(axis=1) > 0
            kelvin = np.where(hit, 28.0, 20.0) + ZERO
            return model.Emission(kelvin, np.where(hit, 0.9, 0.95), 20.0 + ZERO)

        update = model.Update(frame, (frame - 1) / 24, pose, {"warmth": warmth})
        expected.append(sensing.update(parameters, update).value)
    assert np.abs(expected).max() > 1.0
    # A ray at the very edge may be in or out by rounding.
    np.testing.assert_allclose(found, expected, atol=0.05)


def test_a_man_as_warm_as_the_room_is_not_felt(world):
    detector(world)
    man(world, 20.0, 0.7)
    assert np.abs(signals(world)).max() < 1e-6


def test_glass_hides_the_man(world):
    """Window glass is opaque to thermal radiation."""
    detector(world)
    man(world)
    assert np.abs(signals(world)).max() > 1.0
    pane = world.box((8, 0.01, 4), (0, 2, 1), "pane")
    glass = world.bpy.data.materials.new("glass")
    glass.use_nodes = True
    shader = glass.node_tree.nodes.get("Principled BSDF")
    shader.inputs["Transmission Weight"].default_value = 1.0
    pane.data.materials.append(glass)
    assert np.abs(signals(world)).max() < 1e-9


def test_a_door_at_the_rooms_temperature_is_no_movement(world):
    detector(world)
    door = world.box((0.9, 0.04, 2.0), (0, 3, 1.0), "door")
    world.key(door, "rotation_euler", {1: (0, 0, 0), 48: (0, 0, 1.5)})
    assert np.abs(signals(world)).max() < 1e-9
    world.warm(door, 30.0)
    assert np.abs(signals(world)).max() > 1.0, "a warm one is"


def test_a_lens_written_in_a_text(world):
    obj = detector(world)
    body = man(world)
    text = world.bpy.data.texts.new("my lens")
    # Of the table's four zones two see only the sky.
    text.write(
        "azimuth,elevation,width,height,polarity\n0,0,4,20,+\n5,0,4,20,-\n0,80,4,4,+\n5,80,4,4,-"
    )
    obj.angen_sensor.pir.lens_table = text
    assert np.abs(signals(world)).max() > 1.0
    text.clear()
    text.write("0,0,4,20,+\n0,0,none,20,-\n")
    with pytest.raises(error, match="'detector': row 2 of the lens table: width is 'none'"):
        world.run()
    assert body.name == "man"


def test_ambient_that_rises_shortens_the_range(world):
    detector(world)
    man(world, 30.0)
    found = []
    for room in (15.0, 25.0, 29.0, 30.0):
        world.scene.angen_ambient_temperature = room
        found.append(np.abs(signals(world)).max())
    assert found == sorted(found, reverse=True) and found[-1] < 1e-9


def test_nothing_warm_is_told(world):
    detector(world)
    body = man(world)
    view_layer = world.bpy.context.view_layer
    world.update()
    assert warmth.nothing_warm(view_layer) is None
    body.angen_warmth.use_temperature = False
    told = warmth.nothing_warm(view_layer)
    assert told.problem.startswith("Nothing in the scene has a temperature: ")
    collection = world.bpy.data.collections.new("heaters")
    world.scene.collection.children.link(collection)
    collection.objects.link(body)
    world.update()
    world.warm(collection, 50.0)
    assert warmth.nothing_warm(view_layer) is None
    body.angen_ignored = True
    assert warmth.nothing_warm(view_layer) is not None


def test_a_person_in_one_click(world):
    bpy = world.bpy
    rig = world.link("rig", bpy.data.armatures.new("rig"))
    body, hat = world.box((0.4, 0.3, 1.7), name="person"), world.box((0.3, 0.3, 0.1), name="hat")
    body.modifiers.new("Armature", "ARMATURE").object = rig
    hat.parent = rig
    other = world.box((1, 1, 1), (5, 0, 0), "other")
    for name in ("Person skin", "Person shirt", "Person hair"):
        body.data.materials.append(bpy.data.materials.new(name))
    bpy.context.view_layer.objects.active = rig
    for obj in world.scene.objects:
        obj.select_set(obj == rig)
    assert bpy.ops.angen.warmth_set(sort="PERSON") == {"FINISHED"}
    assert [o.angen_warmth.use_temperature for o in (body, hat, other)] == [True, True, False]
    assert body.angen_warmth.temperature == pytest.approx(33.5)
    assert body.angen_warmth.insulation == pytest.approx(1.0)
    skin, shirt, hair = (material.angen_warmth for material in body.data.materials)
    assert skin.temperature == hair.temperature == pytest.approx(33.5)
    assert (skin.insulation, hair.insulation) == (0.0, 0.5)
    assert skin.use_temperature and not shirt.use_temperature


def test_a_lens_as_text(world):
    obj = detector(world, lens="CURTAIN")
    world.bpy.context.view_layer.objects.active = obj
    assert world.bpy.ops.angen.lens_table() == {"FINISHED"}
    text = obj.angen_sensor.pir.lens_table
    assert text.as_string().startswith("azimuth,elevation,width,height,polarity,gain\n")
    assert len(read(text.as_string())) == 16
    man(world)
    of_text = signals(world)
    obj.angen_sensor.pir.lens_table = None
    np.testing.assert_allclose(signals(world), of_text, atol=0.02)


# The warmth of the surfaces that a pyroelectric detector's rays hit


SIGHT = 50.0


@pytest.fixture
def probe(world):
    """Return the emission along directions (n, 3) from a place, as the detector gets it."""

    class Probe:
        def __init__(self):
            self.probes = Probes(world.scene)

        def __call__(self, place, directions, sensor=0, bundle=0):
            depsgraph = world.update()
            self.probes.look(depsgraph)
            directions = np.array(directions, float).reshape(-1, 3)
            directions /= np.linalg.norm(directions, axis=1)[:, None]
            origins = np.tile(np.array(place, float), (len(directions), 1))
            length = np.full(len(directions), SIGHT)
            rays = origins, directions, length
            return self.probes.surfaces[WARMTH].see(sensor, bundle, rays)[0]

    return Probe()


def celsius(seen):
    return (seen.temperature - ZERO).tolist()


AHEAD = [(0, 1, 0)]


@pytest.fixture
def target(world):
    return world.box((1, 1, 1), (0, 3, 0), "target")


def test_what_has_no_temperature_is_as_warm_as_the_room(world, probe, target):
    world.scene.angen_ambient_temperature = 22.5
    seen = probe((0, 0, 0), [(0, 1, 0), (0, -1, 0)])
    assert celsius(seen) == pytest.approx([22.5, 22.5])
    assert seen.ambient == pytest.approx(22.5 + ZERO)


def test_object_collection_and_material(world, probe, target):
    bpy = world.bpy
    outer, inner = (bpy.data.collections.new(name) for name in ("outer", "inner"))
    world.scene.collection.children.link(outer)
    outer.children.link(inner)
    world.scene.collection.objects.unlink(target)
    inner.objects.link(target)
    world.warm(outer, 40.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([40.0])
    world.warm(inner, 45.0, 0.5)
    seen = probe((0, 0, 0), AHEAD)
    assert celsius(seen) == pytest.approx([45.0]) and seen.emissivity == pytest.approx([0.5])
    world.warm(target, 50.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([50.0])
    material = bpy.data.materials.new("hot")
    target.data.materials.append(material)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([50.0])
    world.warm(material, 60.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([60.0])
    material.angen_warmth.use_temperature = False
    target.angen_warmth.use_temperature = False
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([45.0])


@pytest.mark.parametrize(("ambient", "clothes"), [(20.0, 26.1), (27.0, 29.9), (33.5, 33.5)])
def test_clothes_are_between_skin_and_room(world, probe, target, ambient, clothes):
    world.warm(target, 33.5)
    target.angen_warmth.insulation = 1.0
    world.scene.angen_ambient_temperature = ambient
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([clothes], abs=0.05)
    target.angen_warmth.insulation = 0.0
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([33.5])


def test_clothes_follow_an_animated_room_and_animated_clothes(world, probe, target):
    world.warm(target, 33.5)
    world.key(world.scene, "angen_ambient_temperature", {1: 15.0, 11: 30.0})
    world.key(target, "angen_warmth.insulation", {11: 1.0, 21: 0.0})
    seen = []
    for frame in (1, 11, 21):
        world.scene.frame_set(frame)
        seen += celsius(probe((0, 0, 0), AHEAD))
    assert seen == pytest.approx([23.4, 31.6, 33.5], abs=0.05)


def checkered(world, name="checkered"):
    """Add a wall of 4 × 4 quads, 2 m wide, across +Y at y = 3, of four materials at 30 … 33 °C.

    The fourth material has no temperature. The column of a quad gives its material.
    """
    points = [(x / 2 - 1, 0, z / 2 - 1) for z in range(5) for x in range(5)]
    faces = [
        (5 * z + x, 5 * z + x + 1, 5 * z + x + 6, 5 * z + x + 5) for z in range(4) for x in range(4)
    ]
    obj = world.link(name, world.mesh(points, faces, name), (0, 3, 0))
    for i in range(4):
        material = world.bpy.data.materials.new(f"{name} {i}")
        obj.data.materials.append(material)
        if i < 3:
            world.warm(material, 30.0 + i)
    obj.data.polygons.foreach_set("material_index", [i % 4 for i in range(16)])
    return obj


COLUMNS = [(x, 3, z) for z in (-0.75, -0.2, 0.3, 0.8) for x in (-0.75, -0.25, 0.25, 0.75)]
EXPECTED = [30.0, 31.0, 32.0, 20.0] * 4


@pytest.mark.parametrize("place", [0.0, 1000.0])
def test_each_face_has_the_temperature_of_its_material(world, probe, place):
    """Also where the tree is built of triangles, as for meshes far from their origin."""
    obj = checkered(world)
    for vertex in obj.data.vertices:
        vertex.co.x += place
    obj.location.x = -place
    assert celsius(probe((0, 0, 0), COLUMNS)) == pytest.approx(EXPECTED)
    world.warm(obj, 25.0)
    assert celsius(probe((0, 0, 0), COLUMNS)) == pytest.approx([30.0, 31.0, 32.0, 25.0] * 4)


def test_faces_of_what_moves_turns_and_is_subdivided(world, probe):
    obj = checkered(world)
    probe((0, 0, 0), COLUMNS)
    obj.location.x = 0.5
    # Each column has the material of its neighbour; the last ray passes beside the wall.
    moved = [(x + 0.5, 3, z) for x, _, z in COLUMNS]
    assert celsius(probe((0, 0, 0), moved)) == pytest.approx(EXPECTED)
    obj.location.x, obj.rotation_euler = 0, (0, math.pi, 0)
    turned = [20.0, 32.0, 31.0, 30.0] * 4
    assert celsius(probe((0, 0, 0), COLUMNS)) == pytest.approx(turned)
    obj.modifiers.new("finer", "SUBSURF").levels = 2
    obj.modifiers["finer"].subdivision_type = "SIMPLE"
    assert celsius(probe((0, 0, 0), COLUMNS)) == pytest.approx(turned)


def test_faces_agree_with_blenders_own_ray_cast(world, probe):
    """A sphere of random materials, hit from all sides."""
    bpy = world.bpy
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=1.0)
    ball = bpy.context.object
    chance = np.random.default_rng(3)
    for i in range(6):
        material = bpy.data.materials.new(f"m{i}")
        world.warm(material, 20.0 + 5 * i)
        ball.data.materials.append(material)
    ball.data.polygons.foreach_set("material_index", chance.integers(0, 6, len(ball.data.polygons)))
    depsgraph = world.update()
    origins = chance.normal(size=(200, 3))
    origins *= 5 / np.linalg.norm(origins, axis=1)[:, None]
    for origin in origins:
        way = -origin / 5 + chance.uniform(-0.1, 0.1, 3)
        hit, _, _, face, _, _ = world.scene.ray_cast(depsgraph, origin.tolist(), way.tolist())
        expected = 20.0 + 5 * ball.data.polygons[face].material_index if hit else 20.0
        assert celsius(probe(origin, [way])) == pytest.approx([expected])


def test_slots_that_belong_to_the_object(world, probe, target):
    mine, of_data = (world.bpy.data.materials.new(name) for name in ("mine", "of data"))
    world.warm(mine, 41.0)
    world.warm(of_data, 42.0)
    target.data.materials.append(of_data)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([42.0])
    target.material_slots[0].link = "OBJECT"
    target.material_slots[0].material = mine
    target.update_tag()
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([41.0])


def test_a_kettle_that_heats_up(world, probe, target):
    world.warm(target, 20.0)
    world.key(target, "angen_warmth.temperature", {1: 20.0, 41: 100.0})
    found = []
    for frame in (1, 11, 21, 41):
        world.scene.frame_set(frame)
        found += celsius(probe((0, 0, 0), AHEAD))
    assert found == pytest.approx([20, 40, 60, 100], abs=0.1)


def test_the_sensors_own_housing_is_not_seen(world, probe, target):
    housing = world.box((0.1, 0.1, 0.1), (0, 0.2, 0), "housing")
    world.warm(housing, 60.0)
    world.warm(target, 30.0)
    assert celsius(probe((0, 0, 0), AHEAD)) == pytest.approx([60.0])
    assert celsius(probe((0, 0, 0), AHEAD, sensor=housing.session_uid)) == pytest.approx([30.0])
