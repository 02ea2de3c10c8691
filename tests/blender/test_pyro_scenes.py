# SPDX-License-Identifier: GPL-3.0-or-later
"""What a pyroelectric detector makes of the warmth in a scene, and what users are told of it."""

import math

import numpy as np
import pytest

ZERO = 273.15


def detector(world, **settings):
    """One that looks along +Y, 1.2 m up."""
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
    events = addon_part("sensor_logic.log").events(recording)
    changes = [event for event in events if event.field == "moved"][1:]
    assert [event.value for event in changes][:2] == [True, False]
    for event in changes:
        update = (event.frame - 1) / 24
        assert update - 0.15 < event.time < update
    assert changes[1].time - changes[0].time >= 1.0
    track = recording.tracks["detector"]
    assert (np.diff(np.array(track.times)) >= 0.0).all()
    # Explained at the time that the log has, and still unknown just before.
    world.bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    for time, frame in ((changes[0].time, changes[0].frame), (changes[0].time - 0.001, 1.0)):
        told = command("explain", "--sensor", "detector", "--time", f"{time:.6f}")[1]
        assert told.startswith(f"detector, frame {frame:g} ("), told
    # A file keeps the times.
    writer = addon_part("sensor_logic.recording.file")
    read = writer.from_bytes(writer.to_bytes(recording, {}))[0].tracks["detector"]
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


def test_in_a_scene_it_says_what_it_says_alone(world, addon_part):
    """The whole way through Blender against the model with a box in closed form."""
    detector(world, zone_rays=24)
    man(world, 28.0, 0.9)
    found = signals(world)
    model = addon_part("sensor_logic.model")
    pir = addon_part("sensor_logic.kinds.pir.range_scan")
    sensing = addon_part("sensor_logic.kinds.pir.pyroelectric").PyroelectricDetector()
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
    """Window glass lets no warmth through."""
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


def test_both_models_side_by_side(world):
    """Two sensors in one place: the range scan notices the cold trolley too."""
    pyro = detector(world)
    scan = world.pir("scan", vertical_fov=math.radians(90), sweep="ALL", rays=60)
    scan.location, scan.rotation_euler = pyro.location, pyro.rotation_euler
    trolley = man(world, 20.0)
    recording = world.run()
    assert any(world.series(recording, "scan", "moved"))
    assert not any(world.series(recording, "detector", "moved"))
    assert all(math.isnan(s) for s in world.series(recording, "scan", "signal"))
    world.warm(trolley, 30.0)
    recording = world.run()
    assert any(world.series(recording, "detector", "moved"))


def test_a_lens_written_in_a_text(world, addon_part):
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
    error = addon_part("angen_addon.scene.sensors").AngenError
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


def test_nothing_warm_is_told(world, addon_part):
    warmth = addon_part("angen_addon.advice.warmth")
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
    for name in ("Person skin", "Person shirt"):
        body.data.materials.append(bpy.data.materials.new(name))
    bpy.context.view_layer.objects.active = rig
    for obj in world.scene.objects:
        obj.select_set(obj == rig)
    assert bpy.ops.angen.warmth_set(sort="PERSON") == {"FINISHED"}
    assert [o.angen_warmth.use_temperature for o in (body, hat, other)] == [True, True, False]
    assert body.angen_warmth.temperature == pytest.approx(28.0)
    skin, shirt = body.data.materials
    assert skin.angen_warmth.temperature == pytest.approx(33.0)
    assert skin.angen_warmth.use_temperature and not shirt.angen_warmth.use_temperature


def test_a_lens_as_text(world, addon_part):
    obj = detector(world, lens="CURTAIN")
    world.bpy.context.view_layer.objects.active = obj
    assert world.bpy.ops.angen.lens_table() == {"FINISHED"}
    text = obj.angen_sensor.pir.lens_table
    assert text.as_string().startswith("azimuth,elevation,width,height,polarity,gain\n")
    read = addon_part("sensor_logic.kinds.pir.lenses").read_table
    assert len(read(text.as_string())) == 16
    man(world)
    of_text = signals(world)
    obj.angen_sensor.pir.lens_table = None
    np.testing.assert_allclose(signals(world), of_text, atol=0.02)


def test_a_setting_of_warmth_reaches_live_values(world):
    """Set while the playhead stands, it counts at the next frame."""
    detector(world)
    body = world.box((0.45, 0.3, 1.7), (0.3, 3, 0.85), "body")
    scene = world.scene
    for frame in range(1, 10):
        scene.frame_set(frame)
    settings = world.bpy.data.objects["detector"].angen_sensor
    assert settings.value == 0.0
    world.warm(body, 35.0)
    world.update()
    for frame in range(10, 20):
        scene.frame_set(frame)
    # A change of settings starts the detector anew: what is warm now always was.
    assert settings.value == pytest.approx(0.0, abs=1e-6)
    body.location.x = -0.3
    world.update()
    assert body.angen_warmth.use_temperature
