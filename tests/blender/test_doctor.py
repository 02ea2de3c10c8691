# SPDX-License-Identifier: GPL-3.0-or-later
"""The doctor finds nothing in a good home, and in a home with one mistake only that mistake."""

import json
from math import radians
from pathlib import Path

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon import doctor
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import (
    run_command as command,
)
from bl_ext.user_default.angen_sensors.angen_addon.doctor import CHECKS
from bl_ext.user_default.angen_sensors.operators import doctor as button
from pressure_scenes import CORNERS, FACES

SAMPLE = Path(__file__).parents[2] / "sample_blends" / "angen.blend"


@pytest.fixture
def home(world, physics):
    """Add a room of 4 × 3 × 2.5 m with one sensor of each kind, a lamp, a door and a person."""
    world.box((4, 3, 2.5), (0, 0, 1.25), "Room")
    for number in range(4):
        world.box((0.5, 0.4, 0.7), (-1.5 + number, 1.2, 0.36), f"Chair {number}")
    leaf = world.mesh(
        [(x, y, z) for x in (0, 0.9) for y in (-0.02, 0.02) for z in (0, 2.0)],
        [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
    )
    door = world.link("Door", leaf, (-0.5, -1.4, 0.01))
    world.key(door, "rotation_euler", {1: (0, 0, 0), 24: (0, 0, radians(80))})
    # Directed along the door's upper edge at it, from the wall beside it.
    switch = world.switch("Switch", range_max=0.3)
    switch.location, switch.rotation_euler = (0.3, -1.25, 1.9), (radians(90), 0, radians(180))
    pir = world.sensor("PIR", "Detector", model="PYROELECTRIC", update_rate=24.0)
    pir.location, pir.rotation_euler = (1.9, 0, 2.0), (radians(90), 0, radians(90))
    light = world.sensor("LIGHT", "Light", method="ILLUMINANCE", engine="CYCLES")
    light.location = (0, 0, 2.0)
    lamp = world.link("Lamp", bpy.data.lights.new("Lamp", "POINT"), (1, 1, 2.2))
    lamp.data.energy = 2.0
    physics.pad("Mat", (0.3, 0.3, 0.005), (0, 0, 0.005))
    person = world.box((0.4, 0.3, 1.7), (0, 0, 0.86), "Person")
    world.key(person, "location", {1: (0, 0, 0.86), 48: (1, 0, 0.86)})
    person.angen_load.mass = 70.0
    person.angen_warmth.use_temperature, person.angen_warmth.temperature = True, 30.0
    world.update()
    return world


@pytest.fixture
def examine(world):
    def found():
        depsgraph = world.update()
        return doctor.examine(bpy.context.scene, bpy.context.view_layer, depsgraph)

    return found


def test_nothing_is_wrong_with_a_good_home(home, examine):
    assert examine() == []


def test_nothing_is_wrong_with_the_sample(examine):
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLE))
    assert examine() == []


def too_large():
    for obj in bpy.context.scene.objects:
        if obj.parent is None:
            obj.location *= 100
            obj.scale *= 100
            obj.animation_data_clear()


def bare():
    mesh = bpy.data.objects["Chair 1"].data
    edges = [tuple(edge.vertices) for edge in mesh.edges]
    points = [vertex.co[:] for vertex in mesh.vertices]
    mesh.clear_geometry()
    mesh.from_pydata(points, edges, [])


def no_ceiling():
    import bmesh

    mesh = bpy.data.objects["Room"].data
    made = bmesh.new()
    made.from_mesh(mesh)
    top = [face for face in made.faces if face.calc_center_median().z > 1.2]
    bmesh.ops.delete(made, geom=top, context="FACES")
    made.to_mesh(mesh)
    made.free()


def still():
    for name in ("Person", "Door"):
        bpy.data.objects[name].animation_data_clear()


def middle():
    door = bpy.data.objects["Door"]
    for vertex in door.data.vertices:
        vertex.co.x -= 0.45
    door.animation_data_clear()
    door.location.x += 0.45
    door.keyframe_insert("rotation_euler", frame=1)
    door.rotation_euler.z = 1.0
    door.keyframe_insert("rotation_euler", frame=24)
    bpy.context.scene.frame_set(1)


def shut():
    bpy.data.objects["Door"].animation_data_clear()
    bpy.data.objects["Door"].rotation_euler.z = 0.0


def walled_in():
    wall = bpy.data.objects["Chair 1"]
    wall.location, wall.scale = bpy.data.objects["Detector"].location, (0.2, 2, 1)


def against():
    switch = bpy.data.objects["Switch"]
    switch.angen_sensor.optical_switch.range_min = 0.2
    switch.angen_sensor.optical_switch.threshold = 0.25
    screen = bpy.data.objects["Chair 1"]
    screen.location, screen.scale = switch.location, (0.2, 0.05, 0.2)
    screen.location.y -= 0.1


def turned_round():
    """Turn the detector to the wall on which it is mounted, 20 cm away."""
    detector = bpy.data.objects["Detector"]
    detector.location.x, detector.rotation_euler.z = 1.8, radians(-90)


def slit():
    """Add two boards before the detector, 6 mm apart, one above the other."""
    bpy.data.objects["Detector"].angen_sensor.pir.model = "RANGE_SCAN"
    for name, z in (("Board", 1.847), ("Upper board", 2.153)):
        bpy.ops.mesh.primitive_cube_add(size=1, location=(1.0, 0, z))
        bpy.context.object.scale, bpy.context.object.name = (0.02, 1, 0.3), name


def thick_glass():
    chair = bpy.data.objects["Chair 1"]
    glass = bpy.data.materials.new("Crystal")
    glass.use_nodes = True
    principled = glass.node_tree.nodes["Principled BSDF"]
    principled.inputs["Transmission Weight"].default_value = 1.0
    principled.inputs["Roughness"].default_value = 0.0
    chair.data.materials.clear()
    chair.data.materials.append(glass)


def twins():
    made = bpy.data.collections.new("flat")
    sensor = bpy.data.objects["Switch"].copy()
    made.objects.link(sensor)
    holder = bpy.data.objects.new("A", None)
    holder.instance_type, holder.instance_collection = "COLLECTION", made
    bpy.context.scene.collection.objects.link(holder)
    sensor.name = "Door switch"
    bpy.data.objects["Switch"].name = "A/Door switch"


def background():
    other = bpy.data.scenes.new("Street")
    house = bpy.data.objects["Chair 1"].copy()
    house.name = "House"
    other.collection.objects.link(house)
    bpy.context.scene.background_set = other


def setting(name, path, value):
    """Return a function that sets a property of an object, as a user's mistake does."""

    def spoil():
        owner, _, key = path.rpartition(".")
        obj = bpy.data.objects[name]
        setattr(obj.path_resolve(owner) if owner else obj, key, value)

    return spoil


def under_a_chair():
    """Put the pad below a chair with legs, which has no mass."""
    chair, mat = bpy.data.objects["Chair 1"], bpy.data.objects["Mat"]
    mat.location.xy = chair.location.xy
    legs = [(x, y) for x in (-0.2, 0.2) for y in (-0.15, 0.15)]
    parts = [((0.25, 0.2, 0.02), (0.0, 0.0, 0.1))]
    parts += [((0.02, 0.02, 0.22), (x, y, -0.13)) for x, y in legs]
    points = [c + CORNERS[i] * h for half, c in parts for i in range(8) for h in [np.array(half)]]
    faces = [tuple(8 * part + i for i in face) for part in range(5) for face in FACES.tolist()]
    mesh = bpy.data.meshes.new("stool")
    mesh.from_pydata([tuple(point) for point in points], [], faces)
    chair.data = mesh


flat = setting("Chair 1", "scale", (1.0, 1.0, 0.0))
beam_of_nothing = setting("Switch", "angen_sensor.optical_switch.threshold", 0.001)
no_magnet = setting("Switch", "angen_sensor.kind", "CONTACT")


def far_magnet():
    """Make the switch a contact, and its magnet miss it by 30 mm where the door is shut."""
    door, contact = bpy.data.objects["Door"], bpy.data.objects["Switch"]
    magnet = bpy.data.objects.new("Magnet", None)
    bpy.context.scene.collection.objects.link(magnet)
    magnet.parent = door
    magnet.location = (0.8, 0.03, 1.9)
    contact.angen_sensor.kind = "CONTACT"
    contact.angen_sensor.contact.magnet = magnet
    contact.location, contact.rotation_euler = (0.3, -1.4, 1.91), (0.0, 0.0, 0.0)


plugless = setting("Switch", "angen_sensor.kind", "APPLIANCE")
hidden = setting("Chair 1", "hide_viewport", True)
cold = setting("Person", "angen_warmth.use_temperature", False)
sixty_watts, dark = setting("Lamp", "data.energy", 60.0), setting("Lamp", "data.energy", 0.0)
weightless = setting("Person", "angen_load.mass", 0.0)
in_the_air = setting("Mat", "location", (0.0, 0.0, 0.6))
BAD = {
    "flattened": (flat, "Objects whose scale is 0 along an axis, so that rays and light pass "
                        "through them: 'Chair 1'", "Ctrl+A"),
    "background": (background, "of the background set 'Street': 'House'", "Clear Background Set"),
    "unreachable": (beam_of_nothing, "'Switch': the threshold (0.001 m) is not", "Raise"),
    "names_none": (no_magnet, "'Switch' has no magnet", "Choose its Magnet"),
    "magnets": (far_magnet, "'Switch': its magnet 'Magnet' comes no nearer than 0.0300 m, and it "
                            "closes at 0.015 m", "Move the magnet to the contact"),
    "watches": (plugless, "'Switch' watches no object", "Choose what it Watches"),
    "hidden": (hidden, "'Chair 1'", "Show them"),
    "no_faces": (bare, "'Chair 1'", "Fill the edges with faces"),
    "holes": (no_ceiling, "The room of 'Detector', 'Light' is open above", "a ceiling"),
    "doors": (middle, "origin is not at the hinge: 'Door'", "Set Origin"),
    "still_doors": (shut, "'Door'", "Insert keyframes of the leaf's rotation"),
    "inside": (walled_in, "'Detector' is inside the object 'Chair 1'", "Move it out"),
    "too_near": (against, "looks into 'Chair 1', which is nearer than its parameter Range min of "
                          "20 cm", "turn"),
    "facing": (turned_round, "'Detector' faces 'Room' at 20 cm", "Turn it round"),
    "warmth": (cold, "Nothing in the scene has a temperature", "Set Usual, Person"),
    "watts": (sixty_watts, "'Lamp' shines with 60 W of light, 40,980 lm", "lumens divided by 683"),
    "slits": (slit, "'Detector' sees through a slit between 'Board' and 'Upper board'", "overlap"),
    "glass": (thick_glass, "through the glass 'Crystal' of 'Chair 1'", "Make it a flat pane"),
    "dark": (dark, "lights 'Light'", "Add a lamp"),
    "pads": (weightless, "'Mat': nothing in this scene has a weight", "give an animated person"),
    "pads_in_air": (in_the_air, "'Mat' hangs in the air", "Lower the pad onto the floor"),
    "pads_not_valid": (under_a_chair, "'Chair 1' stands on 'Mat' with some of its parts and has no "
                                      "mass", "Give 'Chair 1' a mass"),
    "names": (twins, "2 sensors are called 'A/Door switch'", "Rename one"),
}  # fmt: skip


@pytest.mark.parametrize("check", BAD)
def test_a_mistake_is_named_with_the_way_to_mend_it(home, examine, check):
    spoil, words, mend = BAD[check]
    spoil()
    found = examine()
    assert {finding.check for finding in found} == {check}
    assert words in found[0].text and mend in found[0].mend


@pytest.mark.parametrize("kind", ["DISTANCE", "PRESENCE_RADAR", "THERMAL_ARRAY", "LIGHT"])
def test_all_kinds_that_look_are_found_before_a_wall(home, examine, kind):
    sensor = home.sensor(kind, "Sensor")
    if kind == "LIGHT":
        sensor.angen_sensor.light.method = "ILLUMINANCE"
    sensor.location = (1, -1.3, 1.6)

    def found(turn):
        sensor.rotation_euler = (radians(90), 0, turn)
        return [f.text for f in examine() if f.check == "facing"]

    assert found(radians(180)) == ["'Sensor' faces 'Room' at 20 cm, and sees little else"]
    assert found(0.0) == []
    assert found(radians(90)) == [], "a wall beside it"


def test_a_near_object_that_moves_is_what_the_sensor_is_for(home, examine):
    lid = home.box((0.4, 0.4, 0.02), (1, 0, 1.0), "Lid")
    sensor = home.sensor("DISTANCE", "Sensor")
    sensor.location = (1, 0, 1.2)
    assert "facing" in {f.check for f in examine()}
    home.key(lid, "rotation_euler", {1: (0, 0, 0), 24: (1, 0, 0)})
    assert "facing" not in {f.check for f in examine()}
    lid.animation_data_clear()
    sensor.angen_sensor.distance.range_max = 0.3
    assert "facing" not in {f.check for f in examine()}, "a sensor of near things"


def test_what_was_flattened_is_met_once_its_scale_is_applied(world, examine):
    screen = world.wall(0.1)
    switch = world.switch()
    screen.scale.z = 0.0
    world.update()
    assert world.range(switch) == pytest.approx(0.5)
    assert "flattened" in {finding.check for finding in examine()}
    with bpy.context.temp_override(active_object=screen, selected_editable_objects=[screen]):
        bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    assert world.range(switch) == pytest.approx(0.1, abs=2e-5)
    assert "flattened" not in {finding.check for finding in examine()}
    world.key(screen, "scale", {1: (1, 1, 0), 9: (1, 1, 1)})
    world.scene.frame_set(1)
    assert "flattened" not in {finding.check for finding in examine()}, "shrunk away on purpose"


def test_where_nothing_moves_the_doors_do_not_either(home, examine):
    still()
    found = {finding.check: finding for finding in examine()}
    assert set(found) == {"movement", "still_doors"}
    assert "'Detector', 'Switch' will publish only their first reading" in found["movement"].text


def test_a_home_in_centimetres_is_told_with_its_unit_scale(home, examine):
    too_large()
    found = {finding.check: finding for finding in examine()}
    assert "The home is too large: 400 m from end to end" in found["scale"].text
    assert "set Unit Scale to 0.01" in found["scale"].mend
    home.scene.unit_settings.scale_length = 0.01
    assert "scale" not in {finding.check for finding in examine()}


def test_a_bare_home_in_centimetres_is_told_so_too(world, examine):
    room = world.box((800, 800, 250), name="Room")
    world.sensor("PIR", "Detector")
    (found,) = [finding for finding in examine() if finding.check == "scale"]
    assert "drawn in centimetres, set Unit Scale to 0.01" in found.mend
    for scale, told in ((10.0, "millimetres, set Unit Scale to 0.001"), (0.6, "inches")):
        room.scale = (scale, scale, scale)
        if told == "inches":
            for number in range(3):
                world.box((40, 20, 30), at=(50 * number, 0, 0), name="Chair")
        (found,) = [finding for finding in examine() if finding.check == "scale"]
        assert told in found.mend


def test_a_tiny_home_is_never_to_be_scaled_by_one(world, examine):
    world.box((1.2, 1.2, 1.2), name="Room")
    world.sensor("PIR", "Detector")
    (found,) = [finding for finding in examine() if finding.check == "scale"]
    assert "Unit Scale to 10 " in found.mend and "up 10 times" in found.mend


def test_a_short_rigid_body_cache_is_told(home, physics, examine):
    physics.body("Crate", (0.1, 0.1, 0.1), (0, 1, 1), 5.0)
    home.scene.rigidbody_world.point_cache.frame_end = 20
    found = [finding for finding in examine() if "ends at frame 20" in finding.text]
    assert [finding.check for finding in found] == ["physics"]
    assert found[0].mend.startswith("Set its end")


def test_a_body_that_may_be_let_go_late_is_told(home, physics, examine):
    crate = physics.body("Crate", (0.1, 0.1, 0.1), (0, 1, 1), 5.0)
    for frame, held in ((1, True), (10, False)):
        crate.rigid_body.kinematic = held
        crate.keyframe_insert("rigid_body.kinematic", frame=frame)
    (finding,) = [one for one in examine() if "a frame late" in one.text]
    assert finding.check == "physics" and "'Crate'" in finding.text
    crate.keyframe_insert("location", frame=1)
    assert not [one for one in examine() if "a frame late" in one.text]


def test_an_active_mesh_is_told_with_its_margin(home, physics, examine):
    crate = physics.body("Crate", (0.1, 0.1, 0.1), (0, 1, 1), 5.0, shape="MESH")
    (finding,) = [one for one in examine() if one.check == "margins"]
    assert "bounce on pads because of their collision margin (up to 40 mm): 'Crate'" in finding.text
    crate.rigid_body.collision_shape = "CONVEX_HULL"
    assert "margins" not in {one.check for one in examine()}


def test_a_lamp_that_is_keyed_is_told_though_it_is_off_now(home, examine):
    lamp = bpy.data.objects["Lamp"].data
    for frame, power in ((1, 0.0), (30, 75.0)):
        lamp.energy = power
        lamp.keyframe_insert("energy", frame=frame)
    home.scene.frame_set(1)
    (finding,) = examine()
    assert "'Lamp' shines with 75 W of light" in finding.text


def test_every_check_has_a_bad_home():
    tested = {*BAD, "scale", "movement", "physics", "files", "eevee", "unplaced", "margins"}
    tested |= {"units", "coarse", "idle_keys", "rooms", "residents", "lamps"}
    assert set(CHECKS) == tested


def test_the_command_tells_and_ends_with_its_status(home, tmp_path, capsys):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    capsys.readouterr()
    assert command(["doctor"]) == 0
    assert capsys.readouterr() == ("", "angen: no problem was found\n")
    sixty_watts()
    assert command(["doctor"]) == 1
    out, told = capsys.readouterr()
    assert out.startswith("watts: 'Lamp' shines") and "1 problem found" in told
    assert command(["doctor", "--json"]) == 1
    (finding,) = json.loads(capsys.readouterr().out)
    assert set(finding) == {"check", "text", "mend", "objects"} and finding["check"] == "watts"


def test_a_home_without_sensors_is_examined_too(world, tmp_path, capsys):
    world.box((4, 3, 2.5), name="Room")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    assert command(["doctor"]) == 0


def test_the_button_keeps_what_it_found_until_another_file(home):
    dark()
    assert bpy.ops.angen.doctor() == {"FINISHED"}
    assert [finding.check for finding in button.found] == ["dark"]
    bpy.ops.wm.read_homefile(use_empty=True)
    assert button.found is None


def test_nothing_is_wrong_with_a_good_home_in_an_instance(home, examine):
    made = bpy.data.collections.new("flat")
    for obj in list(home.scene.collection.objects):
        home.scene.collection.objects.unlink(obj)
        made.objects.link(obj)
    for number in range(2):
        home.instance(f"Flat {number}", made, (20 * number, 0, 0))
    assert examine() == []
    bpy.data.objects["Door"].animation_data_clear()
    (finding,) = examine()
    assert (finding.check, finding.text) == (
        "still_doors",
        "Doors with a switch on them that are not animated: 'Door'",
    )


def test_a_magnet_that_keyframes_bring_near_closes_its_contact(home, examine):
    far_magnet()
    magnet, door = bpy.data.objects["Magnet"], bpy.data.objects["Door"]
    magnet.location.y = 0.005
    for frame in (1, 24):
        bpy.context.scene.frame_set(frame)
        assert examine() == []
    # Shut between two keyframes alone.
    home.key(door, "rotation_euler", {1: (0, 0, radians(-80)), 24: (0, 0, radians(80))})
    assert examine() == []
    # A driver can bring it anywhere.
    magnet.location.z = 1.8
    assert [finding.check for finding in examine()] == ["magnets"]
    magnet.driver_add("location", 0)
    assert "magnets" not in {finding.check for finding in examine()}


def test_residents_that_live_by_a_routine_move(lived_home, examine):
    checks = {"movement", "still_doors"}
    assert not checks & {finding.check for finding in examine()}
    for obj in bpy.data.objects:
        obj.angen_place.use = "NONE"
    # Without places no resident can live in the home.
    assert checks <= {finding.check for finding in examine()}


def mute_track():
    for name in ("Person", "Door"):
        data = bpy.data.objects[name].animation_data
        action, data.action = data.action, None
        track = data.nla_tracks.new()
        track.strips.new("walk", 1, action)
        track.mute = True


def mute_curves():
    from_action = bpy.data.objects["Person"].animation_data
    for layer in from_action.action.layers:
        for curve in layer.strips[0].channelbags[0].fcurves:
            curve.mute = True


def lose_slot():
    bpy.data.objects["Person"].animation_data.action_slot = None


@pytest.mark.parametrize(
    ("spoil", "text"),
    [
        (mute_track, "Muted tracks or strips of the NLA do not play: 'Door', 'Person'"),
        (mute_curves, "Muted F-curves do not play: 'Person'"),
        (lose_slot, "An action without a slot does not play: 'Person'"),
    ],
)
@pytest.mark.skipif(bpy.app.version < (4, 4), reason="actions have no slots")
def test_keys_that_do_not_play_are_named(home, examine, spoil, text):
    spoil()
    found = {finding.check: finding for finding in examine()}
    assert found["idle_keys"].text == text
    assert set(found["idle_keys"].objects) <= {"Door", "Person"}
    # Nothing else moves if both tracks are muted.
    assert ("movement" in found) == (spoil is mute_track)


@pytest.mark.parametrize("kind", ["MESH_SEQUENCE_CACHE", "WAVE", "BUILD", "TRANSFORM_CACHE"])
def test_what_moves_without_keys_counts_as_movement(home, examine, kind):
    for name in ("Person", "Door"):
        bpy.data.objects[name].animation_data_clear()
    assert "movement" in {finding.check for finding in examine()}
    person = bpy.data.objects["Person"]
    if kind == "TRANSFORM_CACHE":
        person.constraints.new(kind)
    else:
        person.modifiers.new("moves", kind)
    assert "movement" not in {finding.check for finding in examine()}


def test_a_click_on_a_finding_selects_its_objects(home):
    bpy.data.objects["Chair 1"].hide_viewport = True
    bpy.data.objects["Lamp"].data.energy = 0
    bpy.context.view_layer.update()
    bpy.ops.angen.doctor()
    from_cache = [one.objects for one in button.found]
    index = from_cache.index(("Light",))
    bpy.ops.angen.doctor_select(index=index)
    assert [obj.name for obj in bpy.context.selected_objects] == ["Light"]
    assert bpy.context.object.name == "Light"
