# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording is fresh while its scene is unchanged, also through undo and redo.

It is stale, with a reason, exactly while the scene is another one.
"""

import csv
from importlib import import_module

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.scene.facts import facts_of
from panel_layout import drawn
from recorded_home import ADDON, columns, move, named, ops, recorded, results, save_and_load, stale


@pytest.fixture
def home(world):
    return recorded(world)


def with_value(owner, **values):
    """Return an edit that sets attributes of a datablock; `owner` is its path."""
    for name, value in values.items():
        setattr(owner, name, value)


def move_a_key(world):
    curves_of = import_module(f"{ADDON}.angen_addon.scene.animation").curves
    curves = curves_of(named("door"), {"location"})
    curves[0].keyframe_points[1].co.x = 20
    curves[0].update()
    named("door").animation_data.action.update_tag()


def move_a_vertex(world):
    mesh = named("shelf").data
    mesh.vertices[0].co.x += 1
    mesh.update()


def paint_a_weight(world):
    named("shelf").vertex_groups["top"].add([0], 0.9, "REPLACE")
    named("shelf").data.update()


def add_a_driver(world):
    named("shelf").driver_add("location", 2).driver.expression = "frame"


def add_a_collection(world):
    world.scene.collection.children.link(bpy.data.collections.new("inner"))


SETTINGS, SHOWN = "the scene's settings", "which objects are shown"
# The edit, and the name in the reason.
EDITS = {
    "move": (lambda w: move(named("shelf")), "'shelf'"),
    "move what is animated": (lambda w: move(named("door")), "'door'"),
    "move a key": (move_a_key, "'door'"),
    "parameter": (lambda w: with_value(switch().optical_switch, threshold=0.1), "'Front door'"),
    "rate": (lambda w: with_value(switch(), update_rate=2.0), "'Front door'"),
    "off": (lambda w: with_value(switch(), enabled=False), "'Front door'"),
    "ignored": (lambda w: with_value(named("shelf"), angen_ignored=True), "'shelf'"),
    "new modifier": (lambda w: named("shelf").modifiers.new("array", "ARRAY"), "'shelf'"),
    "substeps": (lambda w: with_value(w.scene, angen_substeps=2), SETTINGS),
    "seed": (lambda w: with_value(w.scene, angen_seed=5), SETTINGS),
    "mass": (lambda w: with_value(named("shelf").angen_load, mass=3.0), "'shelf'"),
    "frame rate": (lambda w: with_value(w.scene.render, fps=30), SETTINGS),
    "start frame": (lambda w: with_value(w.scene, frame_start=5), SETTINGS),
    "units": (lambda w: with_value(w.scene.unit_settings, scale_length=0.5), SETTINGS),
    "vertex": (move_a_vertex, ""),
    "modifier": (lambda w: with_value(named("shelf").modifiers["copies"], count=3), "'shelf'"),
    "modifier off": (
        lambda w: with_value(named("shelf").modifiers["copies"], show_viewport=False),
        "'shelf'",
    ),
    "node": (
        lambda w: with_value(bpy.data.node_groups["nodes"].nodes[0].inputs[0], default_value=0.5),
        "'nodes'",
    ),
    "texture": (lambda w: with_value(bpy.data.textures["bumps"], noise_scale=0.5), "'bumps'"),
    "shape key": (
        lambda w: with_value(named("shelf").data.shape_keys.key_blocks["wide"], value=0.5),
        "'Key'",
    ),
    "weight": (paint_a_weight, "'shelf'"),
    "hide": (lambda w: named("shelf").hide_set(True), SHOWN),
    "show": (lambda w: named("hidden").hide_set(False), SHOWN),
    "disable": (lambda w: with_value(named("shelf"), hide_viewport=True), "'shelf'"),
    "add": (lambda w: w.box((1, 1, 1), at=(5, 5, 5), name="new"), "'new' (new)"),
    "remove": (lambda w: bpy.data.objects.remove(named("shelf")), "'shelf' (gone)"),
    "unparent": (lambda w: with_value(named("lamp"), parent=None), "'lamp'"),
    "rename": (lambda w: with_value(named("shelf"), name="cupboard"), SHOWN),
    "driver": (add_a_driver, "'shelf'"),
    "collection": (add_a_collection, SHOWN),
}


def switch():
    return named("Front door").angen_sensor


def test_the_reason_names_an_object_that_joins_the_scene_after_it_was_made(home):
    """Blender first imports a dropped asset, and then places it in the scene."""
    made = bpy.data.objects.new("dropped", bpy.data.meshes.new("dropped"))
    home.update()
    # An edit of something else comes between.
    named("shelf").location.x += 1.0
    home.update()
    named("shelf").location.x -= 1.0
    home.update()
    home.scene.collection.objects.link(made)
    home.update()
    assert "'dropped' (new)" in stale() and SHOWN not in stale()
    bpy.data.objects.remove(made)
    home.update()
    assert stale() == ""


def test_the_reason_names_an_object_that_is_added_again_after_undo(home):
    bpy.ops.ed.undo_push(message="recorded")
    for _ in range(2):
        home.box((1, 1, 1), at=(5, 5, 5), name="new")
        home.update()
        assert "'new' (new)" in stale() and SHOWN not in stale()
        bpy.ops.ed.undo_push(message="add")
        bpy.ops.ed.undo()
        bpy.context.scene.frame_set(bpy.context.scene.frame_current)
        assert stale() == ""


@pytest.mark.parametrize("kind", ["box", "sensor"])
def test_what_is_added_and_deleted_again_leaves_it_fresh(home, kind):
    if kind == "box":
        added = home.box((1, 1, 1), at=(5, 5, 5), name="new")
    else:
        ops.sensor_add(kind="PIR")
        added = bpy.context.object
    home.update()
    assert stale() == f"changed since: '{added.name}' (new)", "its mesh came with it"
    bpy.data.objects.remove(added)
    home.update()
    assert stale() == ""


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_makes_it_stale_and_its_undo_fresh(home, name):
    before, (edit, words) = columns(), EDITS[name]
    edit(home)
    home.update()
    assert "changed since" in stale() and words in stale()
    for operator in (ops.export_events, ops.export_samples, ops.bake_keyframes):
        with pytest.raises(RuntimeError, match=r"stale.*Simulate again"):
            operator()
    bpy.ops.ed.undo_push(message="edit")
    bpy.ops.ed.undo()
    assert stale() == ""
    assert columns() == before
    track = results().recording(bpy.context.scene).track_of(named("Front door").session_uid)
    assert track is not None, "sensors are found after undo"
    if name == "move what is animated":
        return  # keys restore their values at any evaluation.
    bpy.ops.ed.redo()
    assert "changed since" in stale()


def move_and_come_back(world):
    where = named("shelf").location.copy()
    move(named("shelf"))
    world.update()
    assert stale()
    named("shelf").location = where


def look_into_edit_mode(world):
    bpy.context.view_layer.objects.active = named("shelf")
    bpy.ops.object.mode_set(mode="EDIT")
    world.update()
    assert stale()
    bpy.ops.object.mode_set(mode="OBJECT")


def go_through_frames(world):
    for frame in (20, 1, 13, 48):
        world.scene.frame_set(frame)


ACTS = {
    "select": lambda world: named("shelf").select_set(True),
    "recolour": lambda world: with_value(bpy.data.materials["paint"], diffuse_color=(1, 0, 0, 1)),
    "move the camera": lambda world: move(named("camera")),
    "move and come back": move_and_come_back,
    "look into edit mode": look_into_edit_mode,
    "last frame": lambda world: with_value(world.scene, frame_end=100),
    "brighten": lambda world: with_value(named("lamp").data, energy=1000),
    "go through frames": go_through_frames,
    "room": lambda world: with_value(switch(), room="hall"),
}


@pytest.mark.parametrize("act", ACTS.values(), ids=ACTS)
def test_what_moves_no_reading_keeps_it_fresh(home, act):
    before = columns()
    act(home)
    home.update()
    assert stale() == ""
    bpy.ops.ed.undo_push(message="act")
    bpy.ops.ed.undo()
    assert stale() == "" and columns() == before


@pytest.fixture
def two_doors(home):
    """Add a second switch, a housing and a driver that refer to the first one; record again."""
    housing = home.box((0.1, 0.1, 0.1), at=(0, 0, 0.1), name="housing")
    housing.parent = named("Front door")
    home.switch("Other door").location.x = 7
    home.switch("Off", enabled=False).location.x = 9
    target = named("shelf").driver_add("scale", 2).driver.variables.new().targets[0]
    target.id, target.data_path = named("Front door"), "angen_sensor.value"
    home.update()
    ops.simulate()
    assert stale() == ""
    return home


def events(path):
    ops.export_events(filepath=str(path))
    with open(path, newline="", encoding="utf-8") as file:
        return [{**row, "kind": row["sensor"]} for row in csv.DictReader(file)]


def rename(**names):
    """Give sensors other names, all at once."""
    found = {named(name.replace("_", " ")): new for name, new in names.items()}
    for number, obj in enumerate(found):
        obj.name = f"x{number}"
    for obj, name in found.items():
        obj.name = name
    bpy.context.view_layer.update()


RENAMED = {
    "one": {"Front_door": "Back door"},
    "a name that another had": {"Front_door": "Other door", "Other_door": "Front door"},
    "in turn": {"Front_door": "Other door", "Other_door": "Third"},
    "one that is off": {"Off": "Away"},
}


@pytest.mark.parametrize("names", RENAMED.values(), ids=RENAMED)
def test_a_renamed_sensor_keeps_its_recording_by_its_new_name(two_doors, tmp_path, names):
    """Nobody's recording is stale, also after saving."""
    before = {name: column[3] for name, column in columns().items()}
    log = events(tmp_path / "before.csv")
    new = {name.replace("_", " "): now for name, now in names.items()}
    wanted = {new.get(name, name): values for name, values in before.items()}
    rename(**names)
    for _ in range(2):
        bpy.context.scene.frame_set(7)
        assert stale() == ""
        assert {name: column[3] for name, column in columns().items()} == wanted
        found = events(tmp_path / "after.csv")
        key = [(row["time_s"], new.get(row["sensor"], row["sensor"]), row["value"]) for row in log]
        assert sorted((r["time_s"], r["sensor"], r["value"]) for r in found) == sorted(key)
        assert "not recorded" not in drawn("ANGEN_PT_simulation").text
        save_and_load(tmp_path / "a.blend")
    # The recording follows also the way back, and what else changes is told by the new name.
    rename(**{now.replace(" ", "_"): name.replace("_", " ") for name, now in names.items()})
    assert stale() == "" and {n: c[3] for n, c in columns().items()} == before
    rename(**names)
    assert stale() == ""
    first = next(iter(new.values()))
    with_value(named(first).angen_sensor, update_rate=2.0)
    bpy.context.scene.frame_set(8)
    assert stale() == f"changed since: '{first}'"


def test_a_renamed_sensor_is_not_simulated_again(two_doors):
    rename(Front_door="Back door")
    before = columns()
    ops.simulate()
    assert columns() == before and "Back door" in before
    bpy.ops.ed.undo_push(message="renamed")
    ops.clear_recording()
    ops.simulate()
    assert columns() == before and stale() == ""


def test_undo_of_a_new_name_gives_the_recording_the_former_name(two_doors):
    bpy.ops.ed.undo_push(message="recorded")
    rename(Front_door="Back door")
    bpy.ops.ed.undo_push(message="renamed")
    assert "Back door" in columns()
    bpy.ops.ed.undo()
    assert "Front door" in columns() and stale() == ""
    bpy.ops.ed.redo()
    assert "Back door" in columns() and stale() == ""


def test_a_renamed_sensor_in_an_instance_keeps_its_recording(world):
    inner = world.switch("inner", update_rate=24.0)
    world.instance("first", world.aside("part", inner), (5, 0, 0))
    world.update()
    ops.simulate()
    (name,) = columns()
    rename(first="second")
    assert list(columns()) == [name.replace("first", "second")] and stale() == ""


# Settings that only concern the display and the use of results.
OF_THE_VIEW = {
    "angen_coverage", "angen_day", "angen_live", "angen_overlay", "angen_recording",
    "angen_recording_aside", "angen_show_places", "angen_site", "angen_start", "angen_timeline",
    "angen_topic",
}  # fmt: skip


def scene_settings():
    return [p for p in bpy.types.Scene.bl_rna.properties if p.identifier.startswith("angen_")]


def change(scene, prop):
    """Set another value of a setting."""
    name, value = prop.identifier, getattr(scene, prop.identifier)
    if prop.type == "ENUM":
        value = next(item.identifier for item in prop.enum_items if item.identifier != value)
    elif prop.type == "BOOLEAN":
        value = not value
    else:
        value = value + 1 if prop.type in {"INT", "FLOAT"} else f"{value}x"
    setattr(scene, name, value)


def test_every_setting_of_the_scene_makes_it_stale_or_is_known_not_to(home):
    """A new setting that no list has fails here."""
    bpy.types.Scene.angen_brand_new = bpy.props.FloatProperty()
    try:
        looked_at = {prop.identifier for prop in scene_settings()} - OF_THE_VIEW
        assert {"angen_ambient_temperature", "angen_seed", "angen_brand_new"} <= looked_at
        for prop in scene_settings():
            name = prop.identifier
            if prop.type == "POINTER" or name.startswith("angen_recording"):
                assert name in OF_THE_VIEW, name
                continue
            home.scene.angen_live = True
            ops.simulate()
            assert stale() == "", name
            change(home.scene, prop)
            home.scene.frame_set(home.scene.frame_current + 1)
            assert stale() == (
                "" if name in OF_THE_VIEW else "changed since: the scene's settings"
            ), name
    finally:
        del bpy.types.Scene.angen_brand_new


SWITCHED = {
    "excluded": lambda layer, on: setattr(layer, "exclude", on),
    "eye": lambda layer, on: setattr(layer, "hide_viewport", on),
    "monitor": lambda layer, on: setattr(layer.collection, "hide_viewport", on),
}


@pytest.mark.parametrize("members", ["shelf", "door", "Front door", "lamp"])
@pytest.mark.parametrize("how", SWITCHED)
def test_a_collection_unticked_and_ticked_again_leaves_it_fresh(home, how, members):
    """Blender then reports all that is animated as moved."""
    made, strips = bpy.data.collections.new("part"), home.box((1, 1, 1), (0, 9, 0), "strips")
    home.scene.collection.children.link(made)
    home.scene.collection.objects.unlink(named(members))
    made.objects.link(named(members))
    home.key(strips, "location", {1: (0, 9, 0), 40: (0, 12, 0)})
    data = strips.animation_data
    data.nla_tracks.new().strips.new("strip", 1, data.action)
    data.action = None
    home.scene.render.frame_map_old, home.scene.render.frame_map_new = 100, 200
    home.scene.frame_set(13)
    ops.simulate()
    home.scene.frame_set(20, subframe=0.5)
    layer = bpy.context.view_layer.layer_collection.children["part"]
    for _ in range(2):
        SWITCHED[how](layer, True)
        home.update()
        assert stale()
        SWITCHED[how](layer, False)
        home.update()
        assert stale() == ""


@pytest.mark.parametrize("name", ["door", "flag"])
def test_something_animated_that_was_moved_and_moved_back_leaves_it_fresh(home, name):
    rig = home.rig("bone", (0, 0, 1), (0, 12, 0))
    rig.name = "flag"
    home.key(rig, 'pose.bones["bone"].location', {1: (0, 0, 0), 40: (0, 3, 0)})
    home.key(named("door"), "rotation_euler", {1: (0, 0, 0), 40: (0, 0, 1)})
    home.scene.frame_set(20)
    ops.simulate()
    part = named(name).pose.bones["bone"] if name == "flag" else named(name)
    where = part.location.copy()
    for _ in range(2):
        part.location.x += 0.5
        home.update()
        assert stale() == f"changed since: '{name}'"
        part.location = where
        home.update()
        assert stale() == ""


def test_something_animated_that_was_moved_is_back_at_the_next_frame(home):
    move(named("door"))
    home.update()
    assert stale()
    home.scene.frame_set(20)
    assert stale() == ""


def test_what_only_light_sensors_see_counts_where_there_is_one(home):
    home.sensor("LIGHT", "lux", method="ILLUMINANCE", samples=16, update_rate=1.0)
    home.scene.frame_end = 2
    home.update()
    ops.simulate()
    assert stale() == ""
    bpy.data.materials["paint"].diffuse_color = (1, 0, 0, 1)
    home.update()
    assert "'paint'" in stale()
    ops.simulate()
    named("lamp").data.energy = 1000
    home.update()
    assert "'lamp'" in stale()


def test_a_stale_recording_is_not_shown(home):
    home.scene.angen_live = False
    home.scene.frame_set(20)
    assert named("Front door").angen_sensor.active
    move(named("shelf"))
    home.update()
    home.scene.frame_set(5)
    assert named("Front door").angen_sensor.active, "live is off: the value stands"
    bpy.ops.ed.undo_push(message="move")
    bpy.ops.ed.undo()
    bpy.context.scene.frame_set(6)
    assert not named("Front door").angen_sensor.active


def test_exchanged_inputs_of_a_node_are_another_material(world):
    """Both have the same name."""
    material = bpy.data.materials.new("mixed")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    mix, clear = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeBsdfTransparent")
    plain = nodes["Principled BSDF"]
    told = []
    for first, second in ((1, 2), (2, 1)):
        links.clear()
        links.new(plain.outputs[0], mix.inputs[first])
        links.new(clear.outputs[0], mix.inputs[second])
        told.append(repr(facts_of(material)))
    assert told[0] != told[1]


BEFORE_A_FRAME = {
    "hidden": lambda world: named("shelf").hide_set(True),
    "disabled": lambda world: named("shelf").__setattr__("hide_viewport", True),
    "gone": lambda world: bpy.data.objects.remove(named("shelf")),
    "new": lambda world: world.link("more", bpy.data.meshes.new("more")),
    "gravity": lambda world: world.scene.__setattr__("gravity", (0, 0, 1)),
    "a property": lambda world: world.scene.__setitem__("angle", 3.0),
}


@pytest.mark.parametrize("change", BEFORE_A_FRAME.values(), ids=BEFORE_A_FRAME)
def test_what_a_script_changes_just_before_a_frame_makes_it_stale(home, change):
    """Blender reports no edit then: the change of frame finds it."""
    home.scene.frame_set(2)
    home.scene.frame_set(3)
    assert stale() == ""
    change(home)
    home.scene.frame_set(4)
    assert "changed since" in stale()


DURING_A_RUN = {
    "fps": lambda world: world.scene.render.__setattr__("fps", 60),
    "start": lambda world: world.scene.__setattr__("frame_start", 10),
    "seed": lambda world: world.scene.__setattr__("angen_seed", 9),
    "kind": lambda world: named("Front door").angen_sensor.__setattr__("kind", "PIR"),
    "place": lambda world: named("Front door").__setattr__("location", (3, 0, 0)),
}


@pytest.mark.parametrize("change", DURING_A_RUN.values(), ids=DURING_A_RUN)
def test_what_other_code_changes_amid_a_run_makes_it_stale(home, change):
    left = [change]

    def meddles(scene, _):
        if scene.frame_current == 20 and left:
            left.pop()(home)

    bpy.app.handlers.frame_change_post.append(meddles)
    try:
        bpy.ops.angen.simulate()
    finally:
        bpy.app.handlers.frame_change_post.remove(meddles)
    assert not left and "changed since" in stale()
    bpy.ops.angen.simulate()
    assert stale() == ""
