# SPDX-License-Identifier: GPL-3.0-or-later
"""A light scene reused from update to update gives the same bits as a new one.

It holds for all changes of the scene. A run that ends halfway leaves nothing behind.
"""

import math
import random

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import stage
from bl_ext.user_default.angen_sensors.angen_addon.runtime.live import known_live
from bl_ext.user_default.angen_sensors.angen_addon.runtime.running import is_running
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import simulate
from bl_ext.user_default.angen_sensors.sensor_logic.logs.error import AngenError
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording
from light_stage import facing, lamp, material, measure, nodes_instance, part, plate, request, sky
from tiers import mostly_slow


@pytest.fixture
def room(world):
    """Add all types of objects of a home, at rest; an animated empty passes through."""
    box = world.box((4, 4, 4), name="room")
    box.data.materials.append(material(0.5, name="paint"))
    lamp(world, "POINT", at=(0, 0, 1), shadow_soft_size=0.1)
    lamp(world, "AREA", at=(1, 0, 1.9), size=0.5)
    plate(world, 0.5, (1, 1, 0), (-1, 0, 0), material(glows=1.0, name="screen"), "screen")
    sky(world, 0.5)
    passing = world.link("passing", None)
    world.key(passing, "location", {1: (0, 0, 0), 48: (5, 0, 0)})
    world.update()
    return world


def curves(datablock, path):
    action = datablock.animation_data.action
    if hasattr(datablock.animation_data, "action_slot"):
        slot = datablock.animation_data.action_slot
        bags = [s.channelbag(slot) for la in action.layers for s in la.strips]
        found = [c for bag in bags if bag for c in bag.fcurves]
    else:
        found = list(action.fcurves)
    return [c for c in found if c.data_path == path]


def step(datablock, path, before, after, at=5, index=-1):
    """Set keys that change a property at one frame, and hold before and after."""
    owner, _, name = path.rpartition(".")
    struct = datablock.path_resolve(owner) if owner else datablock
    for frame, value in ((1, before), (at, after)):
        setattr(struct, name, value)
        struct.keyframe_insert(name, frame=frame)
    for curve in curves(datablock, path):
        for point in curve.keyframe_points:
            point.interpolation = "CONSTANT"


def background():
    world = bpy.context.scene.world
    return next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")


def shader(name, kind):
    return next(n for n in bpy.data.materials[name].node_tree.nodes if n.type == kind)


def objects(name):
    return bpy.data.objects[name]


STEPS = {
    "place": lambda: step(objects("screen"), "location", (1, 1, 0), (1, 0.5, 0)),
    "turn": lambda: step(objects("screen"), "rotation_euler", (0, 0, 0), (0, 0.5, 0)),
    "energy": lambda: step(objects("point").data, "energy", 1.0, 2.0),
    "colour": lambda: step(objects("point").data, "color", (1, 1, 1), (1, 0.5, 1)),
    "radius": lambda: step(objects("point").data, "shadow_soft_size", 0.1, 0.2),
    "size": lambda: step(objects("area").data, "size", 0.5, 0.6),
    "lamp's shadow": lambda: step(objects("point").data, "use_shadow", True, False),
    "hidden": lambda: step(objects("point"), "hide_viewport", False, True),
    "camera icon": lambda: step(objects("point"), "hide_render", False, True),
    "sky": lambda: step(
        bpy.context.scene.world.node_tree,
        background().inputs["Strength"].path_from_id("default_value"),
        0.5,
        0.6,
    ),
    "paint": lambda: step(
        bpy.data.materials["paint"].node_tree,
        shader("paint", "BSDF_DIFFUSE").inputs["Color"].path_from_id("default_value"),
        (0.5, 0.5, 0.5, 1),
        (0.4, 0.5, 0.5, 1),
    ),
    "glow": lambda: step(
        bpy.data.materials["screen"].node_tree,
        shader("screen", "EMISSION").inputs["Strength"].path_from_id("default_value"),
        1.0,
        2.0,
    ),
    "shadow rays": lambda: step(objects("screen"), "visible_shadow", True, False),
    "the view's far end": lambda: step(objects("screen"), "location", (1, 1, 0), (1, -1.5, 0)),
}


# Checks whether any input of the light has changed since the last check.

LAST = 10


class Watch:
    """Checks for changes at each frame, as a run does, with the extension's handlers."""

    def __init__(self):
        self.changes, self.state = part("light.changes").LightChanges(), None

    def at_frame(self, _scene, depsgraph):
        self.changes.note(depsgraph)

    def at_edit(self, _scene, depsgraph):
        self.changes.note(depsgraph, edited=True)

    def changed(self):
        layer, before = bpy.context.view_layer, self.state
        self.state = self.changes.look(layer, bpy.context.evaluated_depsgraph_get())
        return self.state != before

    def at(self, frame):
        bpy.context.scene.frame_set(frame)
        return self.changed()

    def after(self, edit):
        edit()
        bpy.context.view_layer.update()
        return self.changed()


@pytest.fixture
def watch():
    found = Watch()
    bpy.app.handlers.frame_change_post.append(found.at_frame)
    bpy.app.handlers.depsgraph_update_post.append(found.at_edit)
    yield found
    bpy.app.handlers.frame_change_post.remove(found.at_frame)
    bpy.app.handlers.depsgraph_update_post.remove(found.at_edit)


@pytest.mark.parametrize("what", STEPS)
def test_a_step_is_found_at_its_frame_and_at_no_other(room, watch, what):
    STEPS[what]()
    changed = [frame for frame in range(1, LAST + 1) if watch.at(frame)]
    assert changed == [1, 5]


def test_a_driver_is_found_when_its_value_changes(room, watch):
    source = room.link("source", None)
    step(source, "location", (0, 0, 0), (2, 0, 0), at=7)
    driver = objects("point").data.driver_add("energy").driver
    variable = driver.variables.new()
    variable.targets[0].id = source
    variable.targets[0].data_path = "location.x"
    driver.expression = f"1 + {variable.name}"
    assert [f for f in range(1, LAST + 1) if watch.at(f)] == [1, 7]


def test_a_person_that_stands_still_is_no_change(room, watch):
    """Blender evaluates an armature's mesh at every frame."""
    mesh = room.mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 1, 2)], "person")
    person = room.link("person", mesh, (0, 0, -1))
    armature = room.link("bones", bpy.data.armatures.new("bones"))
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("bone")
    bone.tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    person.vertex_groups.new(name="bone").add([0, 1, 2], 1.0, "REPLACE")
    person.modifiers.new("armature", "ARMATURE").object = armature
    step(armature, 'pose.bones["bone"].location', (0, 0, 0), (0.5, 0, 0), at=6)
    assert [f for f in range(1, LAST + 1) if watch.at(f)] == [1, 6]


def test_what_is_asked_is_part_of_it(room):
    changes = part("light.changes").LightChanges()
    layer, depsgraph = bpy.context.view_layer, room.update()
    one = changes.look(layer, depsgraph, asked="one")
    assert changes.look(layer, depsgraph, asked="one") == one
    two = changes.look(layer, depsgraph, asked="two")
    assert two != one
    changes.forget()
    assert changes.look(layer, depsgraph, asked="two") not in (one, two)


def new_mesh():
    objects("screen").data = objects("room").data


def new_link():
    tree = bpy.data.materials["paint"].node_tree
    colour = tree.nodes.new("ShaderNodeRGB")
    colour.outputs[0].default_value = (0, 1, 0, 1)
    tree.links.new(colour.outputs[0], shader("paint", "BSDF_DIFFUSE").inputs["Color"])


EDITS = {
    "energy": lambda: setattr(objects("point").data, "energy", 3.0),
    "type": lambda: setattr(objects("point").data, "type", "SPOT"),
    "place": lambda: setattr(objects("screen"), "location", (1, 0.4, 0)),
    "eye": lambda: objects("screen").hide_set(True),
    "removed": lambda: bpy.data.objects.remove(objects("screen")),
    "another mesh": new_mesh,
    "vertices": lambda: (
        setattr(objects("screen").data.vertices[0], "co", (3, 3, 3)),
        objects("screen").data.update(),
    ),
    "nodes": new_link,
    "another material": lambda: setattr(
        objects("screen").material_slots[0], "material", bpy.data.materials["paint"]
    ),
    "another world": lambda: setattr(bpy.context.scene, "world", None),
    "sky": lambda: setattr(background().inputs["Strength"], "default_value", 9.0),
    "ignored": lambda: setattr(objects("screen"), "angen_ignored", True),
    "seen by shadow rays": lambda: setattr(objects("screen"), "visible_shadow", False),
    "modifier": lambda: objects("screen").modifiers.new("thick", "SOLIDIFY"),
}
# Those that a look at the present frame finds.
FOUND_EDITS = EDITS | {
    "a new lamp": lambda: lamp(type("W", (), {"link": staticmethod(link)}), "SUN"),
}


def link(name, data, at):
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    return obj


@pytest.mark.parametrize("what", FOUND_EDITS)
def test_an_edit_is_found(room, watch, what):
    assert watch.at(1)
    assert not watch.at(1)
    assert watch.after(FOUND_EDITS[what])
    assert not watch.at(1)


def test_a_setting_within_a_node_is_found(room, watch):
    tree = bpy.data.materials["paint"].node_tree
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    tree.links.new(ramp.outputs[0], shader("paint", "BSDF_DIFFUSE").inputs["Color"])
    assert watch.at(1)
    assert watch.after(lambda: setattr(ramp.color_ramp, "interpolation", "CONSTANT"))


@pytest.mark.parametrize("seed", mostly_slow(range(6), 0, 1))
def test_no_change_of_the_light_is_ever_missed(room, watch, seed):
    """Random steps at random frames, with the light measured at each frame."""
    rng = random.Random(seed)
    ways = rng.sample(sorted(STEPS), 3)
    for way in ways:
        STEPS[way]()
    for owner in (*bpy.data.objects, *bpy.data.lights, *bpy.data.materials, *bpy.data.worlds):
        for animated in (owner, getattr(owner, "node_tree", None)):
            if animated is None or animated.animation_data is None or owner.name == "passing":
                continue
            paths = [way for way in (animated.animation_data.action,) if way]
            for curve in {c.data_path: c for p in paths for c in all_curves(animated)}.values():
                at = rng.randint(2, LAST)
                for other in curves(animated, curve.data_path):
                    other.keyframe_points[1].co.x = at
    asked = request("s", facing((0, 1, 0), (0.3, -1, 0)), samples=8)
    before, skipped = None, 0
    for frame in range(1, LAST + 1):
        changed = watch.at(frame)
        light = measure(asked)["s"].illuminance_lux
        assert changed or light == before, f"missed at frame {frame}: {ways}"
        skipped += not changed
        before = light
    assert skipped >= LAST - 4


def all_curves(datablock):
    data = datablock.animation_data
    if hasattr(data, "action_slot"):
        bags = [s.channelbag(data.action_slot) for la in data.action.layers for s in la.strips]
        return [c for bag in bags if bag for c in bag.fcurves]
    return list(data.action.fcurves)


FRAMES = (1, 4, 5, 6, 2, 5)


def two_and_a_meter():
    """Return three requests: among the lamps, at the screen through open air, and a lux meter."""
    return [
        request("a", facing((0, 1, 0), (0.3, -1, 0.2)), method="FOUR_WALL", samples=16),
        request("b", facing((1, 0, 0), (-0.7, 1, 0)), method="FOUR_WALL", samples=16, clip_end=1.9),
        request("c", facing((0, 1, 0), (0.3, -1, 0.2)), samples=16),
    ]


@pytest.fixture
def kept(room):
    scenes = part("light.cycles").CyclesLight()
    yield scenes
    scenes.close()


def both_at(frame, kept):
    """Return the readings at a frame with the reused scene and with a new one."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.frame_set(frame)
    with_kept = part("light.probe").measure(scene, layer, two_and_a_meter(), 1.0, kept)
    alone = measure(*two_and_a_meter())
    assert dict(with_kept) == alone, frame
    return tuple(s.luminance_percent or s.illuminance_lux for s in alone.values())


@pytest.mark.parametrize("what", mostly_slow(STEPS, "place", "energy", "sky"))
def test_each_change_of_the_scene_is_taken_over(room, kept, what):
    STEPS[what]()
    found = [both_at(frame, kept) for frame in FRAMES]
    assert found[0] == found[1] == found[4]
    assert found[2] == found[3] == found[5]


@pytest.mark.parametrize("what", EDITS)
def test_each_edit_is_measured_once_the_playhead_moved(room, what):
    room.scene.angen_light_reference = 0
    settings = {"method": "ILLUMINANCE", "engine": "CYCLES", "samples": 16, "update_rate": 24.0}
    meter = room.sensor("LIGHT", "meter", **settings)
    meter.location, meter.rotation_euler = (0.3, -1, 0.2), (math.pi / 2, 0, 0)
    shown = []
    for frame in (1, 2, 3):
        if frame == 3:
            EDITS[what]()
            room.update()
        room.scene.frame_set(frame)
        known_live().measure_waiting(room.scene, bpy.context.view_layer)
        shown.append(meter.angen_sensor.value)
    assert shown[0] == shown[1]
    again = room.series(room.run(3, 3), "meter", "illuminance_lux")
    assert shown[2:] == pytest.approx(again, rel=1e-6)
    unseen = {"vertices", "seen by shadow rays", "sky", "another world"}
    assert shown[1] != shown[2] or what in unseen


def test_drivers_people_and_sub_frames(room, kept):
    source = room.link("source", None)
    room.key(source, "location", {1: (0, 0, 0), 10: (9, 0, 0)})
    driver = objects("point").data.driver_add("energy").driver
    variable = driver.variables.new()
    variable.targets[0].id = source
    variable.targets[0].data_path = "location.x"
    driver.expression = f"1 + {variable.name}"
    walker = plate(room, 0.8, (0, 0, 0), (0, -1, 0), objects("room").data.materials[0], "walker")
    walker.shape_key_add(name="Basis")
    bent = walker.shape_key_add(name="bent")
    bent.data[0].co.z += 0.5
    room.key(walker.data.shape_keys, 'key_blocks["bent"].value', {1: 0.0, 8: 1.0})
    room.key(walker, "location", {1: (0, 0, 0), 8: (0.4, 0.8, 0)})
    found = [both_at(frame, kept) for frame in (1, 2, 5, 8, 3)]
    assert len(set(found)) == 5
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.frame_set(3, subframe=0.5)
    assert dict(part("light.probe").measure(scene, layer, two_and_a_meter(), 1.0, kept)) == measure(
        *two_and_a_meter()
    )


def test_things_added_removed_or_moved_by_physics_between(room, kept):
    before = both_at(1, kept)
    added = lamp(room, "POINT", at=(0.5, 0.5, 0.5), energy=30.0)
    assert both_at(1, kept) != before
    bpy.data.objects.remove(added)
    assert both_at(1, kept) == before
    with bpy.context.temp_override(object=objects("screen"), active_object=objects("screen")):
        bpy.ops.rigidbody.object_add()
    assert len({both_at(frame, kept) for frame in range(1, 13)}) > 1


# Ends of a run halfway (undo, redo, another file), and the memory that it keeps until then


# Not images: Blender adds an empty "Render Result" to files that it saves and undoes.
KINDS = (
    "scenes", "objects", "meshes", "materials", "lights", "cameras", "collections", "worlds",
    "actions", "node_groups",
)  # fmt: skip


@pytest.fixture
def each_frame_is_told(monkeypatch):
    """Report each frame, as for frames that take long."""
    monkeypatch.setattr(stage, "PROGRESS_INTERVAL", -1.0)


@pytest.fixture
def sensed_room(world, each_frame_is_told):
    """Add two light sensors with references; undo moves one of them back."""
    box = world.box((4, 4, 4), name="room")
    box.data.materials.append(material(0.7, name="paint"))
    data = lamp(world, "POINT", at=(0, 0, 1), shadow_soft_size=0.1).data
    for frame in (1, 48):
        data.energy = float(frame)
        data.keyframe_insert("energy", frame=frame)
    lamp(world, "SUN")
    plate(world, 0.8, (1, 1, 0), (-1, 0, 0), material(glows=0.2, name="screen"), "screen")
    world.key(bpy.data.objects["screen"], "location", {1: (1, 1, 0), 48: (-1, -1, 0)})
    sky(world, 0.5)
    settings = {"engine": "CYCLES", "samples": 16, "update_rate": 24.0}
    for name, method in (("lux", "ILLUMINANCE"), ("walls", "FOUR_WALL")):
        sensor = world.sensor("LIGHT", name, method=method, **settings)
        sensor.location = (0.3, -1, 0.2)
    world.scene.angen_light_reference = 64
    world.update()
    bpy.ops.ed.undo_push(message="built")
    bpy.context.scene.objects["room"].location.x = 0.25
    world.update()
    bpy.ops.ed.undo_push(message="moved")
    return world


def held():
    return {kind: sorted(d.name for d in getattr(bpy.data, kind)) for kind in KINDS}


def half_way(world):
    """Run a few frames, with light scenes kept; return the run and its recording."""
    recording = Recording()
    run = simulate(world.scene, world.sensors(), 1, 48, recording)
    while recording.frame_end < 3:
        next(run)
    assert len(bpy.data.scenes) == 2
    return run, recording


def test_what_takes_long_is_told_before_and_can_be_left(sensed_room):
    """Each picture is one step: the caller can stop between two, and no data stay."""
    before = held()
    doing = [
        progress.doing
        for progress in simulate(sensed_room.scene, sensed_room.sensors(), 1, 2, Recording())
    ]
    told = list(dict.fromkeys(doing))
    assert told[0] == "Cycles is loading the scene" and doing[-1] == ""
    assert any("reference of the light" in text for text in told)
    # Two methods, for each of which the first frame is traced and then the present one.
    assert doing.count("Cycles is loading the scene") == 1 and len(doing) > 6
    for steps in range(1, len(doing)):
        run = simulate(sensed_room.scene, sensed_room.sensors(), 1, 2, Recording())
        for _ in range(steps):
            next(run)
        run.close()
        assert held() == before and not is_running(), steps


def undo(_):
    bpy.ops.ed.undo()


def undo_and_redo(_):
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()


def undo_and_redo_of_a_step_made_amid(_):
    bpy.ops.ed.undo_push(message="amid")
    undo_and_redo(_)


def save_and_open(folder):
    path = str(folder / "half.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.ops.wm.open_mainfile(filepath=path)


ENDS = (undo, undo_and_redo, undo_and_redo_of_a_step_made_amid, save_and_open)


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("how", mostly_slow(["closed", "gone on with"], "gone on with"))
def test_nothing_is_left_of_a_run(sensed_room, ends, how, tmp_path):
    """The recording so far stays; continuing the run raises an error."""
    before = held()
    run, recording = half_way(sensed_room)
    ends(tmp_path)
    assert held() == before
    if how == "closed":
        run.close()
    else:
        with pytest.raises(AngenError, match="object or scene that it needs was removed"):
            list(run)
    assert held() == before
    assert len(recording.tracks["lux"]) == 3 and not is_running()
    sensed_room.update()
    assert len(sensed_room.run(1, 3).tracks["lux"]) == 3
    assert held() == before


def test_nothing_is_left_of_a_run_in_another_file(sensed_room):
    run, recording = half_way(sensed_room)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    before = held()
    with pytest.raises(AngenError, match="object or scene that it needs was removed"):
        list(run)
    assert held() == before
    assert len(recording.tracks["lux"]) == 3 and not is_running()


@pytest.mark.parametrize("way", ["collection", "nodes"])
def test_a_lamp_that_an_instance_shows_too_goes_off_in_both(world, way):
    made = lamp(world, "POINT", at=(0, 0, 2))
    world.key(made.data, "energy", {1: 10.0, 3: 10.0, 4: 0.0}, interpolation="CONSTANT")
    if way == "collection":
        shared = bpy.data.collections.new("lamps")
        shared.objects.link(made)
        world.instance("Copy", shared, (1, 0, 0))
    else:
        nodes_instance(world, made, (1, 0, 3))
    sensor = world.sensor("LIGHT", "light", method="ILLUMINANCE", samples=64, update_rate=24.0)
    sensor.matrix_world = facing((0, 0, 1)).tolist()
    world.scene.frame_end = 5
    found = world.series(world.run(), "light", "illuminance_lux")
    assert found[0] > 135.0 and found[3:] == [0.0, 0.0]
