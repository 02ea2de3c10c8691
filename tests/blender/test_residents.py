# SPDX-License-Identifier: GPL-3.0-or-later
"""Residents in Blender: added from the menu, with size and weight, sensed, and keyed."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.residents.blender.keys import KeyedStretch
from bl_ext.user_default.angen_sensors.residents.blender.settings import build_of
from bl_ext.user_default.angen_sensors.sensor_logic.physics import insulated_share
from mathutils import Matrix, Vector
from tiers import mostly_slow

SORTS = ["OLDER_ADULT", "ADULT", "CHILD", "CAT"]


@pytest.fixture
def body(addon_part):
    return lambda name: addon_part(f"residents.body.{name}")


def vertices(obj):
    """Return the deformed mesh of an object in world space, (n, 3)."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    points = np.empty(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", points)
    evaluated.to_mesh_clear()
    matrix = np.array(obj.matrix_world)
    return points.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize("unit", mostly_slow([1.0, 0.01], 0.01))
@pytest.mark.parametrize("sort", mostly_slow(SORTS, "ADULT", "CAT"))
def test_a_resident_has_size_mass_and_warmth(world, sort, unit):
    world.scene.unit_settings.scale_length = unit
    world.scene.cursor.location = (2.0 / unit, 1.0 / unit, 0.0)
    assert bpy.ops.angen.resident_add(sort=sort) == {"FINISHED"}
    rig = bpy.context.object
    (mesh,) = [child for child in rig.children if child.type == "MESH"]
    stature = {"OLDER_ADULT": 1.65, "ADULT": 1.735, "CHILD": 1.22, "CAT": 0.25}[sort]
    assert rig.angen_resident.stature == pytest.approx(stature, rel=1e-3)
    points = vertices(mesh) * unit
    high = {"CAT": 0.325}.get(sort, stature)
    assert points[:, 2].max() == pytest.approx(high, rel=0.05)
    assert points[:, 2].min() == pytest.approx(0.0, abs=0.015)
    assert points[:, :2].mean(0) == pytest.approx([2.0, 1.0], abs=0.1)
    assert mesh.angen_load.mass == rig.angen_resident.mass > 0
    warmth = mesh.angen_warmth
    surface = 20.0 + (1.0 - insulated_share(warmth.insulation)) * (warmth.temperature - 20.0)
    assert surface == pytest.approx(27.0 if sort == "CAT" else 26.1, abs=0.1)
    for vertex in mesh.data.vertices:
        assert sum(g.weight for g in vertex.groups) == pytest.approx(1.0, abs=1e-3)
        assert len(vertex.groups) <= 4
    rig.angen_resident.stature = 1.5 * stature
    rig.angen_resident.mass = 33.0
    bpy.context.view_layer.update()
    assert np.ptp(vertices(mesh)[:, 2]) * unit == pytest.approx(1.5 * high, rel=0.06)
    assert mesh.angen_load.mass == 33.0


@pytest.mark.parametrize("unit", [1.0, 0.01])
def test_a_script_poses_a_resident(world, addon_part, unit):
    world.scene.unit_settings.scale_length = unit
    bpy.ops.angen.resident_add(sort="ADULT")
    rig = bpy.context.object
    (mesh,) = rig.children
    settings = addon_part("residents.blender.settings")

    def box(posture, *place, **more):
        settings.show_pose(rig, settings.posed(build_of(rig), posture, *place, **more))
        bpy.context.view_layer.update()
        points = vertices(mesh) * unit
        return points.min(0), points.max(0)

    low, high = box("standing", (1.0, 2.0, 0.0), 0.0)
    assert (low + high)[:2] / 2 == pytest.approx((1.0, 2.0), abs=0.1)
    assert high[2] == pytest.approx(1.73, abs=0.08)
    low, high = box("sitting", (1.0, 2.0, 0.45), 0.0)
    assert low[2] == pytest.approx(0.0, abs=0.03) and 1.1 < high[2] < 1.4
    for side in (0, 1, -1):
        low, high = box("lying", (1.0, 2.0, 0.1), 0.0, side=side)
        assert low[2] == pytest.approx(0.1, abs=0.08) and high[2] < 0.65
        assert 1.4 < high[0] - low[0] < 1.9 and high[0] > 1.6, "the head points along yaw"
    assert mesh.data.animation_data is None and rig.animation_data is None


def test_several_live_in_one_home_and_undo_takes_the_last_away(world):
    bpy.ops.ed.undo_push(message="before")
    for sort in ("ADULT", "ADULT", "OLDER_ADULT"):
        bpy.ops.angen.resident_add(sort=sort, walking_frame=sort == "OLDER_ADULT")
        bpy.ops.ed.undo_push(message="added")
    names = sorted(o.name for o in bpy.context.scene.objects if o.type == "ARMATURE")
    assert names == ["Adult", "Adult.001", "Older adult"]
    assert bpy.data.objects["Older adult"].angen_resident.walking_frame is not None
    bpy.ops.ed.undo()
    assert "Older adult" not in bpy.data.objects and "Adult.001" in bpy.data.objects


@pytest.fixture
def keyed(world, addon_part, body):
    """Return a home with two residents, a door, a lamp and a cup, and ten minutes acted in it."""
    for sort, frame in (("OLDER_ADULT", True), ("CAT", False)):
        bpy.ops.angen.resident_add(sort=sort, walking_frame=frame)
    rigs = {"Anna": bpy.data.objects["Older adult"], "Mimi": bpy.data.objects["Cat"]}
    door = world.box((0.9, 0.04, 2.0), (3.0, 0.0, 1.0), name="Door")
    cup = world.box((0.08, 0.08, 0.1), (0.4, 0.0, 0.9), name="Cup")
    lamp = world.link("Lamp", bpy.data.lights.new("Lamp", "POINT"), (0, 0, 2))
    lamp.data.energy = 40.0
    bpy.context.view_layer.update()
    moves, gait, timeline = (
        body("moves"),
        body("gait"),
        addon_part("residents.acting.timeline"),
    )
    acted, places = (addon_part(f"residents.acting.{n}") for n in ("timeline", "places"))
    bodies = {}
    for person, at in (("Anna", (0.0, 0.0)), ("Mimi", (1.0, 3.0))):
        build = build_of(rigs[person])
        line, now, stand = timeline.Timeline(), 0.0, gait.Stance.at(*at, 0.0, build)
        for _ in range(8):
            pose = moves.standing(stand, 0.0, build)
            line.clips.append(timeline.Clip(now, now + 30.0, lambda t, pose=pose: pose, still=True))
            there = stand.centre[0] + (2.0 if stand.centre[0] < at[0] + 1 else -2.0)
            path = np.linspace(stand.centre, (there, stand.centre[1]), 40)
            walk = moves.Walk(moves.footsteps(stand, path, None, build), build.speed, 0.0, build)
            line.clips.append(timeline.Clip(now + 30.0, now + 30.0 + walk.duration, walk.pose))
            stand, now = walk.end, line.clips[-1].end
        bodies[person] = line
    leaf = places.Door(
        "Door", places.DOOR, np.array([2.55, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]), 0.0, 1.5,
        np.eye(3), np.array([0, -0.02, -1]), np.array([0.9, 0.02, 1]), np.array([0.8, 0, 0]),
    )  # fmt: skip
    done = acted.Acted(
        bodies,
        {"Door": [acted.LeafSwing(40.0, 41.7, 0.0, 1.5, "Anna")]},
        [acted.Switch(0.0, "Lamp", False, ""), acted.Switch(50.0, "Lamp", True, "Anna")],
        {"Cup": [timeline.Hold(20.0, 1, person="Anna"),
                 timeline.Hold(60.0, None, np.array([1.0, 1.0, 0.7]))]},
    )  # fmt: skip
    return rigs, done, places.Places({}, {"Door": leaf}, {}), (door, cup, lamp)


def test_keys_play_what_was_acted_and_clear_gives_all_back(world, body, keyed):
    rigs, done, places, (door, cup, lamp) = keyed
    bpy.context.view_layer.update()
    before = [np.array(o.matrix_world) for o in bpy.data.objects]
    bent = [np.array(b.matrix) for b in rigs["Anna"].pose.bones]
    scene = world.scene
    scene.render.fps = 10
    keys = KeyedStretch(rigs, places)
    solve, palm = body("solve").solve, body("poses").palm
    for start, end in ((0.0, 100.0), (100.0, 200.0)):
        keys.show(done, start, end)
        for frame in range(round(1 + 10 * start), round(1 + 10 * end) + 1, 13):
            scene.frame_set(frame)
            t = np.array([(frame - 1) / 10])
            for person, rig in rigs.items():
                bones = solve(done.bodies[person].poses(t))
                for bone, at in bones.at.items():
                    there = rig.matrix_world @ rig.pose.bones[bone].head
                    assert np.linalg.norm(np.array(there) - at[0]) < 0.001, (person, bone, frame)
            if 20.5 < t[0] < 60.0:
                bones = solve(done.bodies["Anna"].poses(t))
                hand = palm(bones, 1, done.bodies["Anna"].poses(t).build.scale)[0]
                assert np.array(cup.matrix_world.translation) == pytest.approx(hand, abs=0.002)
            if t[0] > 60.4:
                assert np.array(cup.matrix_world.translation) == pytest.approx(
                    [1, 1, 0.75], abs=1e-4
                )
            corner = np.array(door.matrix_world)[:3, 3]
            if t[0] > 42.0:
                open_to = [2.55 + 0.45 * np.cos(1.5), 0.45 * np.sin(1.5), 1.0]
                assert corner == pytest.approx(open_to, abs=1e-4)
            assert lamp.data.energy == pytest.approx(40.0 if t[0] >= 50.0 else 0.0)
    keys.clear()
    bpy.context.view_layer.update()
    after = [np.array(o.matrix_world) for o in bpy.data.objects]
    assert np.allclose(before, after, atol=1e-6)
    assert np.allclose(bent, [np.array(b.matrix) for b in rigs["Anna"].pose.bones], atol=1e-6)
    assert not bpy.data.actions and lamp.data.energy == 40.0


@pytest.mark.parametrize("way", ["delta", "turned", "tilted"])
def test_a_leaf_and_a_cup_move_in_the_world_whatever_is_above_them(world, keyed, way):
    rigs, done, places, (door, cup, _lamp) = keyed
    for obj in (door, cup):
        if way == "delta":
            obj.delta_location, obj.delta_rotation_euler = (0.1, 0.2, 0.0), (0.0, 0.0, 0.3)
        else:
            empty = world.link(f"over {obj.name}", None, (1.0, 0.0, 0.5))
            empty.rotation_euler = (0.0, 0.0, 0.7) if way == "turned" else (1.5708, 0.0, 0.2)
            empty.scale = (2.0, 2.0, 2.0)
            obj.parent = empty
    world.update()
    before = {obj: obj.matrix_world.copy() for obj in (door, cup)}
    leaf = places.doors["Door"]
    keys = KeyedStretch(rigs, places)
    keys.show(done, 0.0, 100.0)
    for seconds, opening in ((30.0, 0.0), (45.0, 1.5)):
        world.scene.frame_set(1 + round(10 * seconds))
        there = Matrix(leaf.moved(opening).tolist()) @ before[door]
        assert np.allclose(door.matrix_world, there, atol=1e-4)
    world.scene.frame_set(1 + 700)
    low = min((cup.matrix_world @ Vector(corner)).z for corner in cup.bound_box)
    assert low == pytest.approx(0.7, abs=1e-3)
    keys.clear()
    world.update()
    for obj, matrix in before.items():
        assert np.allclose(obj.matrix_world, matrix, atol=1e-5)


def test_a_turn_that_is_taken_back_shows_between_no_two_frames(world, addon_part, body):
    bpy.ops.angen.resident_add(sort="OLDER_ADULT", walking_frame=True)
    rig = bpy.context.object
    build = build_of(rig)
    gait, timeline = body("gait"), addon_part("residents.acting.timeline")
    poses = [gait.standing(gait.Stance.at(1.0, 2.0, yaw, build), 0.0, build)
             for yaw in (1.0 + 4 * np.pi, 1.0)]  # fmt: skip
    line = timeline.Timeline([
        timeline.Clip(5.0 * k, 5.0 * k + 5.0, lambda t, pose=pose: pose, still=True)
        for k, pose in enumerate(poses)
    ])  # fmt: skip
    # A gesture without movement adds a key at each frame.
    line.gestures.append(timeline.Gesture(2.0, 8.0, 1.0, 1.0, lambda pose, _t, _w: pose))
    acted, places = (addon_part(f"residents.acting.{n}") for n in ("timeline", "places"))
    keys = KeyedStretch({"Anna": rig}, places.Places({}, {}, {}))
    keys.show(acted.Acted({"Anna": line}), 0.0, 10.0)
    frame = rig.angen_resident.walking_frame
    for number, subframe in ((11, 0.0), (50, 0.5), (51, 0.0), (51, 0.5), (90, 0.0)):
        world.scene.frame_set(number, subframe=subframe)
        for obj in (rig, frame):
            ahead = np.array(obj.matrix_world)[:2, 0] / obj.matrix_world.median_scale
            assert np.allclose(ahead, [np.cos(1.0), np.sin(1.0)], atol=1e-4), (number, subframe)


def test_who_is_away_is_not_there(world, addon_part, body):
    bpy.ops.angen.resident_add(sort="OLDER_ADULT", walking_frame=True)
    rig = bpy.context.object
    build = build_of(rig)
    gait, timeline = body("gait"), addon_part("residents.acting.timeline")
    pose = gait.standing(gait.Stance.at(0.0, 0.0, 0.0, build), 0.0, build)
    line = timeline.Timeline([
        timeline.Clip(10.0 * k, 10.0 * k + 10.0, lambda t: pose, still=True, away=k == 1)
        for k in range(3)
    ])  # fmt: skip
    acted, places = (addon_part(f"residents.acting.{n}") for n in ("timeline", "places"))
    keys = KeyedStretch({"Anna": rig}, places.Places({}, {}, {}))
    seen = {}
    for start in (0.0, 12.0):
        keys.show(acted.Acted({"Anna": line}), start, start + 12.0)
        for t in np.arange(start, start + 12.0, 1.5):
            world.scene.frame_set(round(1 + 10 * t))
            depsgraph = bpy.context.evaluated_depsgraph_get()
            seen[t] = {i.object.name for i in depsgraph.object_instances if i.object.type == "MESH"}
    for t, names in seen.items():
        expected = {"Older adult body", "Older adult walking frame"}
        assert names == (set() if 10.0 <= t < 20.0 else expected), t
    world.scene.frame_set(151)
    keys.clear()
    bpy.context.view_layer.update()
    assert not rig.children[0].hide_viewport and not rig.children[0].hide_render


def test_one_can_be_added_to_a_hidden_collection_and_outlives_its_body(world):
    hidden = bpy.data.collections.new("Hidden")
    world.scene.collection.children.link(hidden)
    hidden.hide_viewport = True
    layer = bpy.context.view_layer
    layer.active_layer_collection = layer.layer_collection.children["Hidden"]
    bpy.ops.angen.resident_add(sort="CAT")
    assert [o.name for o in hidden.objects] == ["Cat", "Cat body"]
    rig = bpy.data.objects["Cat"]
    bpy.data.objects.remove(bpy.data.objects["Cat body"])
    assert rig.angen_resident.mass == 0.0
    assert rig.angen_resident.stature == pytest.approx(0.25)
