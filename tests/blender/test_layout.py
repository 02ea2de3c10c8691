# SPDX-License-Identifier: GPL-3.0-or-later
"""Layouts in a home: `list --json` gives the same sensors again, a wrong one changes nothing."""

import json
import re
import runpy
from math import pi, radians
from pathlib import Path

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import run_command as run
from bl_ext.user_default.angen_sensors.angen_addon.layout.apply import apply_layout
from bl_ext.user_default.angen_sensors.angen_addon.layout.describe import describe
from mathutils import Quaternion, Vector

DOCS = Path(__file__).resolve().parents[2] / "docs" / "layouts.md"


@pytest.fixture
def listed(world):
    """Return the output of `list --json` of the scene."""

    def run():
        return json.loads(json.dumps([describe(s) for s in world.sensors()], allow_nan=False))

    return run


@pytest.fixture
def apply(tmp_path):
    """Apply a layout, given as text or as data for JSON."""

    def run(layout, remove=False):
        path = tmp_path / "home.json"
        path.write_text(layout if isinstance(layout, str) else json.dumps(layout, indent=1))
        return apply_layout(path, remove)

    return run


@pytest.fixture
def error(addon_part):
    return addon_part("sensor_logic.layout.entries").InputError


@pytest.fixture(params=[1.0, 0.01])
def home(request, world):
    """Add a door with its switch on the frame, a detector on a wall, and two pads.

    One pad of 40 × 50 cm is below a box of 2 kg; the other measures only that box.
    """
    world.scene.unit_settings.scale_length = metres = request.param
    u = 1 / metres
    frame = world.link("Frame", None, (u, 2 * u, 0.3 * u))
    frame.rotation_euler = (0.3, 0.2, 1.0)
    leaf = world.box((0.1 * u, 0.1 * u, 0.01 * u), name="leaf")
    leaf.parent = frame
    world.key(leaf, "location", {1: (0, 0, -0.02 * u), 13: (u, 0, -0.02 * u)}, "CONSTANT")
    switch = world.switch("Switch.door.001")
    switch.parent = frame
    bpy.ops.angen.sensor_add(kind="PIR", preset="HAA53_SCAN")
    pir = bpy.context.object
    pir.name, pir.location = "PIR hall", (0, u / 3, 2.2 * u)
    pir.rotation_euler = (radians(80), 0, radians(30))
    pir.angen_sensor.update_rate = 24.0
    pir.angen_sensor.pir.hold_time, pir.angen_sensor.pir.warm_up_time = 0.1, 0.0
    pir.angen_sensor.room = "hall"
    walker = world.box((0.4 * u, 0.4 * u, 1.7 * u), name="walker")
    world.key(walker, "location", {1: (0, 4 * u, u), 48: (3 * u, 2 * u, u)})
    turned = world.pir("turned")
    turned.rotation_mode, turned.rotation_quaternion = "QUATERNION", Quaternion((1, 2, 3), 1.1)
    turned.location = (u, -u, u / 7)
    load = world.box((0.1 * u, 0.1 * u, 0.1 * u), at=(5 * u, 0, 0.07 * u), name="load")
    load.angen_load.mass = 2.0
    pad = world.box((0.4 * u, 0.5 * u, 0.02 * u), at=(5 * u, 0, 0.01 * u), name="pad")
    world.sensor("PRESSURE", "pad", pad, partner_object=load, update_rate=24.0, threshold=1.0)
    world.collection = bpy.data.collections.new("Pads")
    world.scene.collection.children.link(world.collection)
    world.scene.collection.objects.unlink(pad)
    world.collection.objects.link(pad)
    world.update()
    return world


def delete_all(world):
    """Delete sensors and their housings, as a user does."""
    for sensor in world.sensors():
        bpy.data.objects.remove(sensor.object)
    assert not world.sensors()


def clear_all(apply):
    assert len(apply([], remove=True).removed) == 4


@pytest.mark.parametrize("without_sensors", ["deleted", "removed"])
def test_a_list_gives_the_same_sensors_and_events_again(home, listed, apply, without_sensors):
    before, log = listed(), home.log(home.run())
    assert {row[2] for row in log if row[5] == "1"} == {s["name"] for s in before} - {"turned"}
    delete_all(home) if without_sensors == "deleted" else clear_all(apply)
    applied = apply(before)
    assert len(applied.added) + len(applied.changed) == 4
    assert listed() == before
    assert home.log(home.run()) == log


def test_a_list_applied_to_its_own_home_changes_nothing(home, listed, apply):
    before = listed()
    places = {obj.name: obj.matrix_world.copy() for obj in bpy.data.objects}
    applied = apply({"$schema": "layout.schema.json", "sensors": before}, remove=True)
    assert len(applied.unchanged) == 4 and applied[:2] == ([], [])
    assert {obj.name: obj.matrix_world for obj in bpy.data.objects} == places
    assert listed() == before


def test_furniture_that_is_a_sensor_stays_when_it_is_removed(home, apply):
    names = set(bpy.data.objects.keys())
    applied = apply([], remove=True)
    assert applied.cleared == ["pad"]
    assert names - set(bpy.data.objects.keys()) == {"PIR hall", "Switch.door.001", "turned"}


def test_a_layout_switches_off_the_sensors_that_it_lacks(home, apply, listed):
    layout = {"others_enabled": False, "sensors": [{"name": "PIR hall"}]}
    applied = apply(layout)
    assert sorted(applied.changed) == ["Switch.door.001", "pad", "turned"]
    assert applied.unchanged == ["PIR hall"]
    assert [one["name"] for one in listed() if one["enabled"]] == ["PIR hall"]
    assert apply(layout).changed == []
    apply({"others_enabled": True, "sensors": [{"name": "pad"}]})
    assert [one["name"] for one in listed() if not one["enabled"]] == ["pad"]


def test_sensors_are_added_changed_and_removed(world, listed, apply):
    world.scene.unit_settings.scale_length = 0.01
    door = world.link("Door", None, (100, 0, 0))
    door.rotation_euler.z, door.scale = pi / 2, (3, 3, 3)
    world.switch("old")
    world.pir("gone")
    layout = [
        {"name": "old", "enabled": False, "location": [0, 0, 1.5], "collection": "Switches"},
        {
            "name": "new", "kind": "PIR", "room": "hall", "preset": "HC_SR501",
            "relative_to": "Door", "location": [0.5, 0, 2], "look": [1, 0, 0], "parent": "Door",
            "parameters": {"hold_time": 4},
        },
        {"name": "Door", "kind": "OPTICAL_SWITCH"},
    ]  # fmt: skip
    applied = apply(layout, remove=True)
    assert applied == (["new"], ["old", "Door"], [], ["gone"], [], [], [], "")
    told = {sensor["name"]: sensor for sensor in listed()}
    assert told["old"]["location"] == [0, 0, 1.5] and not told["old"]["enabled"]
    assert told["old"]["collection"] == "Switches"
    new = told["new"]
    assert new["location"] == [1, 0.5, 2] and new["parent"] == "Door"
    assert new["parameters"]["hold_time"] == 4 and new["parameters"]["range_max"] == 5
    # Its −Z axis was along the door's X.
    assert (bpy.data.objects["new"].matrix_world.to_3x3().col[2] + Vector((0, 1, 0))).length < 1e-6
    door.location.x = 200
    world.update()
    assert {s["name"]: s["location"] for s in listed()}["new"] == [2, 0.5, 2]


def new(**values):
    return [{"name": "new", "kind": "PIR", "location": [0, 0, 0], **values}]


WRONG = [
    ([{"name": "Swich"}], "needs a kind; did you mean Switch"),
    ([{"name": "new", "kind": "PIR"}], "needs a location"),
    (new(name="x" * 300), "bytes"),
    (new(relative_to="Wal"), "relative_to: no object is called 'Wal'; did you mean wall"),
    (new(parent="Wal"), "parent: no object is called 'Wal'"),
    (new(parent="new"), "a parent of itself"),
    (new(name="wall", location=[9, 9, 9]), "exists at another place and is not a sensor"),
    (new(name="hidden"), "not in the view layer"),
    (new(collection="away"), "its collection is not in the view layer"),
    (new(library="//flat.blend"), "is linked from //flat.blend"),
    (new(name="Flat/PIR"), "the instance has no such sensor; did you mean Flat/inner"),
    (new(update_rate=0), "must be above 0"),
    (new(parameters={"range_max": -1}), "range_max is -1 m: it must be"),
    (new(parameters={"range_min": 9, "range_max": 8}), "range_m"),
    ([{"name": "pad", "parameters": {"partner_object": "Lod"}}], "no object is called 'Lod'"),
    ([{"name": "pad", "bounds": [[0, 0, 0], [1, 1, 1]]}], "bounds"),
    ([{"name": "Switch", "parameters": {"threshold": 9}}], "range_max"),
    ([{"name": "keyed", "location": [1, 1, 1]}], "is animated or constrained (location)"),
    ([{"name": "keyed", "enabled": False}], "enabled is animated"),
    ([{"name": "Flat/inner", "room": "hall"}], "it is in the instance 'Flat'"),
    ([{"name": "pad", "room": "hall"}, *new(parent="none")], "'new': parent"),
]


@pytest.fixture
def crowded(world):
    """Add sensors of many sorts that may disturb a layout."""
    world.switch("Switch")
    world.wall(3.0)
    world.sensor("PRESSURE", "pad", world.box((1, 1, 0.1), name="pad"))
    keyed = world.pir("keyed")
    world.key(keyed, "location", {1: (0, 0, 0), 9: (1, 0, 0)})
    world.key(keyed, "angen_sensor.enabled", {1: True})
    away = bpy.data.collections.new("away")
    world.scene.collection.children.link(away)
    away.objects.link(bpy.data.objects.new("hidden", None))
    inner = world.switch("inner")
    flat = world.aside("flat", inner)
    world.instance("Flat", flat)
    bpy.context.view_layer.layer_collection.children["away"].exclude = True
    world.update()
    return world


@pytest.mark.parametrize(("layout", "told"), WRONG)
def test_what_is_wrong_is_told_and_nothing_changes(crowded, listed, apply, error, layout, told):
    before, objects = listed(), sorted(bpy.data.objects.keys())
    with pytest.raises(error, match=r"home\.json, line \d+: '") as found:
        apply(layout)
    assert told in str(found.value) and "\n" not in str(found.value)
    assert listed() == before and sorted(bpy.data.objects.keys()) == objects
    assert "away" in bpy.data.collections and len(bpy.data.meshes) == 2


def test_sensors_that_hang_on_each_other_stand_where_the_layout_says(world, listed, apply):
    layout = [
        {"name": "a", "kind": "PIR", "location": [1, 0, 0], "rotation": [0, 0, 1], "parent": "b"},
        {"name": "b", "kind": "PIR", "location": [0, 1, 0], "rotation": [1, 0, 0]},
    ]
    apply(layout)
    found = listed()
    assert [s["location"] for s in found] == [[1, 0, 0], [0, 1, 0]]
    # Only the parent is moved: its child stays at its place in the layout.
    found[1]["location"] = [5, 5, 5]
    assert apply(found).changed == ["b"]
    assert listed() == found


@pytest.fixture
def linked(world, tmp_path):
    """Link or override a file's collection with a switch "Door"."""
    devices = world.aside("devices", world.switch("Door"))
    path = world.save_library(tmp_path / "library.blend", devices)

    def bring(override):
        made = world.bring(path)
        if override:
            assert world.override(made) is not None

    return bring


def test_a_linked_sensor_is_left_alone_or_refused(linked, listed, apply, error):
    linked(override=False)
    before = listed()
    assert apply(before).unchanged == ["Door"]
    with pytest.raises(error, match=r"line 1: 'Door': it is linked from .*library\.blend"):
        apply('[{"name": "Door", "room": "hall"}]')
    with pytest.raises(error, match="--remove cannot delete 'Door'"):
        apply([], remove=True)
    assert listed() == before


def test_an_override_is_changed_but_not_deleted(linked, listed, apply, error):
    linked(override=True)
    (before,) = listed()
    apply([{"name": "Door", "room": "hall", "parameters": {"range_max": 0.3}}])
    (after,) = listed()
    assert (after["room"], after["parameters"]["range_max"]) == ("hall", 0.3)
    with pytest.raises(error, match='"enabled": false'):
        apply([], remove=True)
    assert listed() == [after] != [before]


def test_import_in_the_window_is_one_undo_step(world, listed, tmp_path):
    path = tmp_path / "home.json"
    path.write_text(json.dumps(new()))
    bpy.ops.ed.undo_push(message="before")
    assert bpy.ops.angen.import_layout("EXEC_DEFAULT", True, filepath=str(path)) == {"FINISHED"}
    assert [s["name"] for s in listed()] == ["new"]
    bpy.ops.ed.undo()
    assert listed() == []
    path.write_text(json.dumps(new(name="")))
    with pytest.raises(RuntimeError, match=r"home\.json, line 1: '': name must be"):
        bpy.ops.angen.import_layout(filepath=str(path))


def test_what_the_window_exports_another_home_imports(world, listed, tmp_path):
    obj = world.pir(range_max=3.0)
    obj.location = (1, 2, 2.5)
    world.switch(threshold=0.2)
    world.update()
    before, path = listed(), tmp_path / "home.json"
    assert bpy.ops.angen.export_layout(filepath=str(path)) == {"FINISHED"}
    assert json.loads(path.read_text(encoding="utf-8")) == before
    for sensor in world.sensors():
        bpy.data.objects.remove(sensor.object)
    world.update()
    assert not bpy.ops.angen.export_layout.poll()
    assert bpy.ops.angen.import_layout(filepath=str(path)) == {"FINISHED"}
    assert listed() == before
    bpy.ops.object.select_all(action="DESELECT")
    with pytest.raises(RuntimeError, match="No sensor is selected"):
        bpy.ops.angen.export_layout(filepath=str(path), selected_only=True)
    with pytest.raises(RuntimeError, match="nowhere"):
        bpy.ops.angen.export_layout(filepath=str(tmp_path / "nowhere" / "home.json"))


def test_a_layout_is_exported_from_the_file_menu_beside_the_home(world, listed, tmp_path):
    appended = [f.__name__ for f in bpy.types.TOPBAR_MT_file_export.draw._draw_funcs]
    assert "draw_in_export_menu" in appended
    world.pir("PIR left")
    world.pir("PIR right").select_set(True)
    bpy.data.objects["PIR left"].select_set(False)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    bpy.ops.angen.export_layout(filepath="//chosen.json", selected_only=True)
    found = json.loads((tmp_path / "chosen.json").read_text(encoding="utf-8"))
    assert [sensor["name"] for sensor in found] == ["PIR right"]
    with pytest.raises(RuntimeError, match=tmp_path.name):
        bpy.ops.angen.export_layout(filepath=str(tmp_path))


@pytest.fixture
def kitchen(world):
    """Add a fridge with a door that swings."""
    world.box((0.6, 0.6, 1.8), (2, 2, 0.9), "Fridge")
    door = world.box((0.6, 0.05, 1.8), (0.3, -0.025, 0.9), "Fridge door")
    door.location = (1.7, 1.7, 0)
    world.update()
    return world


def test_the_examples_of_the_docs_are_layouts(kitchen, world, listed, apply):
    example, with_parts = re.findall(
        r"```json\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL
    )
    world.link("Frame bathroom", None, (1, 2, 0))
    apply(example)
    found = {s["name"]: s for s in listed()}
    assert [s["kind"] for s in found.values()] == ["PIR", "PRESSURE", "OPTICAL_SWITCH"]
    assert found["Switch bathroom"]["location"] == [1.4, 2.0, 2.0]
    assert found["Pressure armchair"]["bounds"] == [[-0.2, -0.25, 0], [0.2, 0.25, 0.01]]
    assert apply(with_parts).marked == ["Fridge door"]
    magnet = bpy.data.objects["Magnet fridge"]
    assert tuple(magnet.matrix_world.translation) == pytest.approx((2.25, 1.75, 1.7))


def test_the_command_saves_a_copy_or_nothing(world, tmp_path, capsys):
    home, layout, saved = (tmp_path / name for name in ("a.blend", "l.json", "b.blend"))
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    cases = [
        (new(kind="PIRR"), saved, 2, "l.json, line 4: 'new': kind 'PIRR' is unknown"),
        (new(), layout, 2, "is the layout itself"),
        (new(), home, 2, "is the open file itself"),
        (new(), saved, 0, "l.json: 1 added, 0 changed, 0 as they were"),
    ]
    for given, target, status, told in cases:
        layout.write_text(json.dumps(given, indent=1))
        assert run(["apply", str(layout), "--save", str(target)]) == status
        assert told in capsys.readouterr().err
        assert saved.exists() == (status == 0)
    bpy.ops.wm.open_mainfile(filepath=str(saved))
    assert [s.name for s in world.sensors()] == ["new"]


def test_a_contact_that_its_magnet_never_closes_is_told(kitchen, tmp_path, capsys):
    home, layout, saved = (tmp_path / name for name in ("a.blend", "l.json", "b.blend"))
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    told = (
        "'Contact fridge': its magnet 'Magnet fridge' comes no nearer than 0.0300 m, and it closes "
        "at 0.015 m: it is always open"
    )
    words = ["apply", str(layout), "--save", str(saved)]
    for far, is_told in (((2.2, 1.73, 1.7), True), ((2.2, 1.71, 1.7), False)):
        layout.write_text(json.dumps([fridge_contact(location=far)]))
        assert run(words) == 0
        assert (told in capsys.readouterr().err) is is_told
        assert bpy.ops.angen.import_layout(filepath=str(layout)) == {"FINISHED"}
        assert (told in capsys.readouterr().out) is is_told


def test_others_that_cannot_be_switched_are_told_with_the_line(world, home, apply, error):
    world.key(bpy.data.objects["turned"], "angen_sensor.enabled", {1: True, 9: False}, "CONSTANT")
    with pytest.raises(error, match=r"home.json, line 2: 'turned': enabled is animated"):
        apply('{\n"others_enabled": false,\n"sensors": [{"name": "pad"}]}')
    assert all(obj.angen_sensor.enabled for obj in bpy.data.objects if obj.name == "PIR hall")


def test_what_blender_does_not_do_is_taken_back(crowded, listed, apply, error):
    """A parent of zero scale allows no place for its child."""
    crowded.link("point", None).scale = (0, 0, 0)
    before, objects = listed(), sorted(bpy.data.objects.keys())
    layout = [
        {"name": "pad", "room": "hall", "collection": "made", "location": [1, 1, 1]},
        {"name": "Switch", "enabled": False, "parent": "point", "location": [1, 1, 1]},
        *new(parent="point"),
    ]
    with pytest.raises(error, match="line 12: 'Switch': Blender did not set its place"):
        apply(layout)
    assert listed() == before and sorted(bpy.data.objects.keys()) == objects
    assert "made" not in bpy.data.collections and bpy.data.objects["Switch"].parent is None


# What sensors need besides themselves

NARROW = ["azimuth,elevation,width,height,polarity", "0,0,4,4,1", "5,0,4,4,-1"]


def fridge_contact(**values):
    magnet = {"relative_to": "Fridge door", "location": [0.5, 0, 1.7], "parent": "Fridge door"}
    return {
        "name": "Contact fridge", "kind": "CONTACT", "location": [2.2, 1.71, 1.7],
        "parameters": {"magnet": "Magnet fridge"}, "empties": {"Magnet fridge": magnet}, **values,
    }  # fmt: skip


def narrow(**values):
    return {
        "name": "PIR fridge", "kind": "PIR", "location": [2, 1, 2.3], "preset": "HC_SR501",
        "parameters": {"lens_table": "Narrow"}, "texts": {"Narrow": NARROW}, **values,
    }  # fmt: skip


MARKED = {"Fridge door": {"use": "DOOR", "angle": 1.8, "motion": "LEFT", "room": "kitchen"}}


def test_a_layout_makes_magnets_lens_tables_and_marks_and_removes_them(
    kitchen, apply, listed, tmp_path
):
    objects, texts = set(bpy.data.objects.keys()), set(bpy.data.texts.keys())
    layout = {"sensors": [fridge_contact(), narrow()], "marks": MARKED}
    applied = apply(layout)
    assert applied.text == "2 added, 0 changed, 0 as they were; 1 object marked"
    magnet = bpy.data.objects["Magnet fridge"]
    assert magnet.parent.name == "Fridge door" and magnet.type == "EMPTY"
    assert tuple(magnet.matrix_world.translation) == pytest.approx((2.2, 1.7, 1.7))
    assert bpy.data.objects["Contact fridge"].angen_sensor.contact.magnet == magnet
    lens = bpy.data.objects["PIR fridge"].angen_sensor.pir.lens_table
    assert lens.as_string().splitlines() == NARROW
    mark = bpy.data.objects["Fridge door"].angen_place
    assert (mark.use, mark.motion, mark.room) == ("DOOR", "LEFT", "kitchen")
    assert mark.angle == pytest.approx(1.8)
    # Twice changes nothing, and what is exported makes the same in a home without it.
    again = apply(layout)
    assert again.text == "0 added, 0 changed, 2 as they were"
    before, path = listed(), tmp_path / "out.json"
    assert bpy.ops.angen.export_layout(filepath=str(path)) == {"FINISHED"}
    exported = json.loads(path.read_text(encoding="utf-8"))
    assert exported["sensors"] == before and set(exported["marks"]) == {"Fridge door"}
    cleared = apply({"sensors": [], "marks": {}}, remove=True)
    assert cleared.removed == ["Contact fridge", "PIR fridge"]
    assert cleared.unmarked == ["Fridge door"] and mark.use == "NONE"
    assert set(bpy.data.objects.keys()) == objects and set(bpy.data.texts.keys()) == texts
    apply(exported)
    assert listed() == before
    assert bpy.ops.angen.export_layout(filepath=str(path)) == {"FINISHED"}
    assert json.loads(path.read_text(encoding="utf-8")) == exported
    assert apply(exported).text == "0 added, 0 changed, 2 as they were"
    assert bpy.ops.angen.export_layout(filepath=str(path), marks=False) == {"FINISHED"}
    assert json.loads(path.read_text(encoding="utf-8")) == before


def test_the_magnet_of_a_layout_opens_its_contact(kitchen, apply):
    apply([fridge_contact()])
    door = bpy.data.objects["Fridge door"]
    kitchen.key(door, "rotation_euler", {1: (0, 0, 0), 13: (0, 0, -1)}, "CONSTANT")
    log = kitchen.log(kitchen.run())
    assert [row[5] for row in log] == ["0", "1"]


def test_a_changed_magnet_or_table_changes_its_sensor(kitchen, apply):
    apply([fridge_contact(), narrow()])
    moved = fridge_contact(empties={"Magnet fridge": {"location": [2, 1.7, 1.5], "parent": None}})
    assert apply([moved]).changed == ["Contact fridge"]
    magnet = bpy.data.objects["Magnet fridge"]
    assert magnet.parent is None
    assert tuple(magnet.location) == pytest.approx((2, 1.7, 1.5))
    assert apply([narrow(texts={"Narrow": NARROW[:2]})]).changed == ["PIR fridge"]
    assert bpy.data.texts["Narrow"].as_string().splitlines() == NARROW[:2]
    assert len(bpy.data.texts) == 1


def test_what_something_else_uses_stays_when_its_sensor_is_removed(kitchen, apply):
    apply([fridge_contact(), fridge_contact(name="Second"), narrow()])
    kitchen.pir("PIR", model="PYROELECTRIC", lens_table=bpy.data.texts["Narrow"])
    applied = apply([{"name": "Second"}, {"name": "PIR"}], remove=True)
    assert sorted(applied.removed) == ["Contact fridge", "PIR fridge"]
    assert "Magnet fridge" in bpy.data.objects and "Narrow" in bpy.data.texts
    bpy.data.objects["Magnet fridge"].angen_place.use = "USE"
    apply([], remove=True)
    assert "Magnet fridge" in bpy.data.objects and "Narrow" not in bpy.data.texts


@pytest.mark.parametrize(
    ("layout", "told"),
    [
        ([fridge_contact(empties={})], "no object is called 'Magnet fridge'"),
        (
            [fridge_contact(empties={"Magnet fridge": {"location": [0, 0, 0], "parent": "Frige"}})],
            "'Magnet fridge': parent: no object is called 'Frige'; did you mean Fridge",
        ),
        (
            [fridge_contact(empties={"Magnet fridge": {"parent": "Fridge"}})],
            "there is no empty of this name yet",
        ),
        (
            [fridge_contact(empties={"Fridge": {}}, parameters={"magnet": "Fridge"})],
            "is not an empty",
        ),
        ([narrow(texts={"Narow": NARROW})], "no text is called 'Narrow'; did you mean Narow"),
        (
            [narrow(texts={"Narrow": ["0,0"]}, parameters={"lens_table": "Narrow",
              "model": "PYROELECTRIC"})],
            "lens table",
        ),
        ([narrow(), narrow(name="Two", texts={"Narrow": ["x"]})], "twice, in two ways"),
        ({"sensors": [], "marks": {"Frigde": {"use": "DOOR"}}}, "did you mean Fridge"),
        ({"sensors": [], "marks": {"Fridge": {"use": "DOR"}}}, "did you mean DOOR"),
        ({"sensors": [], "marks": {"Fridge": {"use": "DOOR", "angel": 1}}}, "did you mean angle"),
        ({"sensors": [], "marks": {"Fridge": {"use": "DOOR", "angle": 4}}}, "it must be 0 to 3.14"),
        ({"sensors": [], "marks": {"Fridge": {"angle": 1}}}, "not marked: give a use"),
        ({"sensors": [], "marks": {"Fridge": {"use": "LAMP", "switch": "Fride"}}}, "Fridge"),
        ({"sensors": [], "marks": {"Fridge": {"use": "LAMP", "switch": []}}}, "names no object"),
    ],
)  # fmt: skip
def test_a_wrong_magnet_table_or_mark_is_told_and_nothing_changes(
    kitchen, apply, listed, error, layout, told
):
    objects = sorted(bpy.data.objects.keys())
    with pytest.raises(error, match=r"home\.json, line \d+: '") as found:
        apply(layout)
    assert told in str(found.value) and "\n" not in str(found.value)
    assert sorted(bpy.data.objects.keys()) == objects and not bpy.data.texts and not listed()
    assert all(obj.angen_place.use == "NONE" for obj in bpy.data.objects)


def test_an_error_after_a_mark_takes_it_back(kitchen, apply, listed, error):
    """A parent of zero scale allows no place for its child."""
    kitchen.link("point", None).scale = (0, 0, 0)
    wrong = {**new()[0], "parent": "point", "location": [1, 1, 1]}
    with pytest.raises(error, match="Blender did not set its place"):
        apply({"sensors": [fridge_contact(), narrow(), wrong], "marks": MARKED})
    assert not listed() and not bpy.data.texts and "Magnet fridge" not in bpy.data.objects


def test_a_sensor_and_an_empty_of_the_layout_can_be_marked(kitchen, apply, error, listed):
    switch = {"name": "Lamp switch", "kind": "PIR", "location": [0.2, 0.2, 1.1]}
    marks = {
        "Magnet fridge": {"use": "USE", "room": "kitchen"},
        "Lamp switch": {"use": "LAMP", "switch": "Magnet fridge"},
    }
    layout = {"sensors": [fridge_contact(), switch], "marks": marks}
    assert apply(layout).marked == ["Magnet fridge", "Lamp switch"]
    mark = bpy.data.objects["Lamp switch"].angen_place
    assert (mark.use, mark.switch.name) == ("LAMP", "Magnet fridge")
    assert apply(layout).marked == []
    # A wrong mark takes back the new sensors, too.
    before = listed()
    wrong = {"sensors": [{**switch, "name": "Other"}], "marks": {"Other": {"use": "LAMB"}}}
    with pytest.raises(error, match="did you mean LAMP"):
        apply(wrong)
    assert listed() == before and "Other" not in bpy.data.objects


def test_the_schema_of_marks_is_that_of_blender(world):
    made = runpy.run_path(str(DOCS.parents[1] / "scripts" / "layout_schema.py"))["MARK"]
    mark = bpy.types.Object.bl_rna.properties["angen_place"].fixed_type
    known = {p.identifier: p for p in mark.properties if not p.identifier.endswith("_in_units")}
    assert [name for name in known if name not in ("rna_type", "name")] == list(made)
    for name, facts in made.items():
        prop = known[name]
        if "enum" in facts:
            assert sorted(facts["enum"]) == sorted(prop.enum_items.keys())
        if "minimum" in facts:
            assert facts["minimum"] == prop.hard_min
        if "maximum" in facts:
            assert facts["maximum"] == pytest.approx(prop.hard_max)
