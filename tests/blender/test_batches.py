# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames that are kept and sensed many at once read to the bit what frame by frame reads."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import skipping, stage
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import simulate
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays import frames
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording
from tiers import mostly_slow


@pytest.fixture
def read(world, monkeypatch):
    """What a run reads whose batches have so many frames, in a scene of what moves alone or not."""

    def run(most, alone=False):
        monkeypatch.setattr(frames, "MOST_FRAMES", most)
        monkeypatch.setattr(stage, "TELL_EVERY", 1e9)
        least = 0 if alone else 10**9
        monkeypatch.setattr(skipping, "LEAST_OBJECTS", least)
        return world.run().tracks

    return run


def sensors_about(world, **settings):
    """A scan that takes its tilts in turn, one with all at once, one that feels warmth, a distance
    sensor and two switches, of different rates, about the origin."""
    fan = {"rays": 24, "vertical_fov": 0.6, "vertical_step": 0.2, "range_max": 4.0}
    placed = [
        world.pir("turns", update_rate=10.0, **fan),
        world.pir("all", update_rate=24.0, sweep="ALL", **fan),
        world.sensor("PIR", "warm", model="PYROELECTRIC", update_rate=24.0, zone_rays=4),
        world.sensor("DISTANCE", "far", update_rate=7.0),
        world.switch("beam", update_rate=3.0, range_max=4.0, threshold=2.0, aperture_rays=3),
        world.switch("swept", update_rate=2.0, range_max=4.0, threshold=2.0, swept=True),
    ]
    for i, sensor in enumerate(placed):
        sensor.location = (0.1 * i - 0.2, -2.0, 0.1)
        sensor.rotation_euler = (np.pi / 2, 0.0, 0.0)
    return placed


def body(world, name="body", at=(0, 0, 0)):
    obj = world.box((0.6, 0.5, 0.9), at, name)
    obj.angen_warmth.use_temperature, obj.angen_warmth.temperature = True, 33.0
    return obj


def walks(world, obj, far=1.5):
    world.key(obj, "location", {1: (-far, 0, 0), 30: (far, 0.4, 0), 48: (0, 0, 0)}, "LINEAR")


def goes_by(world):
    walks(world, body(world))


def is_mirrored_and_turned(world):
    obj = body(world)
    obj.scale = (-1.0, 0.7, 1.2)
    world.key(obj, "rotation_euler", {1: (0, 0, 0), 48: (1.0, 2.0, 6.0)}, "LINEAR")


def bends(world):
    obj = body(world)
    obj.shape_key_add(name="Basis")
    for vertex, point in zip(obj.data.vertices, obj.shape_key_add(name="wide").data, strict=True):
        point.co = vertex.co * 1.8
    for frame, value in ((1, 0.0), (20, 1.0), (40, 0.2)):
        key = obj.data.shape_keys.key_blocks["wide"]
        key.value = value
        key.keyframe_insert("value", frame=frame)
    walks(world, obj)


def goes_by_a_strip(world, hides=False):
    """The keys as a strip of the NLA, perhaps with some that hide it."""
    obj = body(world)
    walks(world, obj)
    if hides:
        world.key(obj, "hide_viewport", {1: False, 22: True, 26: False}, "CONSTANT")
    data = obj.animation_data
    action, slot = data.action, getattr(data, "action_slot", None)
    data.action = None
    strip = data.nla_tracks.new().strips.new("strip", 1, action)
    if slot is not None:
        strip.action_slot = slot


def is_hidden_by_a_strip(world):
    goes_by_a_strip(world, hides=True)


def gets_more_faces(world):
    obj = body(world)
    array = obj.modifiers.new("array", "ARRAY")
    array.relative_offset_displace[0] = 1.4
    world.key(obj, 'modifiers["array"].count', {1: 1, 12: 3, 30: 2}, "CONSTANT")


def comes_and_goes(world):
    one, two = body(world, "one"), body(world, "two", (0.9, 0.4, 0))
    walks(world, one)
    world.key(one, "hide_viewport", {1: False, 9: True, 22: False}, "CONSTANT")
    world.key(two, "hide_viewport", {1: True, 9: False, 22: True}, "CONSTANT")


def comes_with_what_hangs_on_it(world):
    """Hidden at first, moved and turned while nobody sees it; its child comes later and goes
    earlier, and what it bends by stays hidden."""
    one, child = body(world, "one"), body(world, "child")
    cage = world.link("cage", bpy.data.lattices.new("cage"), (0, 0, 0))
    one.modifiers.new("cage", "LATTICE").object = cage
    world.key(cage, "scale", {1: (1, 1, 1), 30: (2, 1, 1.5)}, "LINEAR")
    walks(world, one)
    world.key(one, "rotation_euler", {1: (0, 0, 0), 12: (0, 0, 2.0), 48: (0, 0, 2.0)}, "LINEAR")
    child.parent, child.location = one, (0.4, -0.6, 0.2)
    world.key(one, "hide_viewport", {1: True, 7: False, 40: True}, "CONSTANT")
    world.key(child, "hide_viewport", {1: True, 11: False, 31: True, 33: False}, "CONSTANT")
    world.key(cage, "hide_viewport", {1: True}, "CONSTANT")


def is_instanced(world):
    inner = bpy.data.collections.new("inner")
    inner.objects.link(bpy.data.objects.new("seat", body(world, "seat", (0, 9, 0)).data))
    holder = world.link("holder", None, (0, 0, 0))
    holder.instance_type, holder.instance_collection = "COLLECTION", inner
    walks(world, holder)


def carries_the_sensors(world):
    walks(world, body(world))
    cart = world.link("cart", None, (0, 0, 0))
    world.key(cart, "location", {1: (0, 0, 0), 40: (0.5, 0.3, 0)}, "LINEAR")
    for name in ("turns", "beam"):
        bpy.data.objects[name].parent = cart


def changes_what_sensors_are(world):
    walks(world, body(world))
    pir = bpy.data.objects["turns"]
    world.key(pir, "angen_sensor.enabled", {1: True, 14: False, 26: True}, "CONSTANT")
    world.key(bpy.data.objects["all"], "angen_sensor.pir.range_max", {1: 4.0, 40: 1.5}, "LINEAR")


def begins_late(world):
    walks(world, body(world))
    world.box((4, 0.1, 3), (0, 1.0, 0), "wall")
    late = body(world, "late", (0.5, 0.2, 0))
    world.key(late, "location", {33: (0.5, 0.2, 0), 40: (0.5, 0.2, 2.5)}, "CONSTANT")


def is_of_letters(world):
    curve = bpy.data.curves.new("letters", "FONT")
    curve.body, curve.extrude = "HHH", 0.2
    letters = world.link("letters", curve, (0, 0, 0))
    letters.rotation_euler = (np.pi / 2, 0.0, 0.0)
    walks(world, letters)


SCENES = (
    goes_by, goes_by_a_strip, is_hidden_by_a_strip,
    is_mirrored_and_turned, bends, gets_more_faces, comes_and_goes,
    comes_with_what_hangs_on_it, is_instanced,
    carries_the_sensors, changes_what_sensors_are, begins_late,
    is_of_letters,
)  # fmt: skip


@pytest.mark.parametrize(
    "scene",
    mostly_slow(
        SCENES,
        goes_by, bends, is_instanced, changes_what_sensors_are, begins_late,
    ),
)  # fmt: skip
@pytest.mark.parametrize(("substeps", "stretch"), mostly_slow([(1, 100), (3, 50)], (3, 50)))
def test_batches_of_any_size_read_the_same(world, read, scene, substeps, stretch):
    world.scene.frame_end = 48
    world.scene.angen_substeps = substeps
    world.scene.render.frame_map_new = stretch
    sensors_about(world)
    scene(world)
    one = read(1)
    moved = sum(sum(one[name].active) for name in ("turns", "all", "warm"))
    assert moved > 3, "nothing that could be read otherwise"
    for most in (2, 5, 256):
        assert read(most) == one
    # What looks at the scene as a whole is not taken out of it.
    before = len(bpy.data.scenes)
    for most in (1, 5, 256):
        assert read(most, alone=True) == one
    assert len(bpy.data.scenes) == before


def test_what_moves_is_looked_at_alone_where_nothing_else_can_matter(world, monkeypatch):
    """The user's scene is evaluated at the first frames only; a driver keeps it in use."""
    sensors_about(world)
    goes_by(world)
    for i in range(25):
        world.box((0.1, 0.1, 0.1), (i, 5, 0), f"still {i}")
    seen = []

    def note(scene, _):
        seen.append(scene == world.scene)

    def evaluated():
        seen.clear()
        bpy.app.handlers.frame_change_post.append(note)
        sensors = world.sensors()
        for obj in world.scene.objects:
            # As where the file was just opened: Blender names all of it at the next frame.
            obj.update_tag()
        try:
            list(simulate(world.scene, sensors, 1, 48, Recording()))
        finally:
            bpy.app.handlers.frame_change_post.remove(note)
        return sum(seen)

    monkeypatch.setattr("bl_ext.user_default.angen_sensors.angen_addon.runtime.handlers."
                        "others_follow_frames", lambda: False)  # fmt: skip
    assert evaluated() < 12
    world.scene.objects["still 3"].driver_add("location", 2).driver.expression = "1.0"
    assert evaluated() > 40


def test_a_run_that_is_left_keeps_what_it_looked_at(world, monkeypatch):
    sensors_about(world)
    goes_by(world)
    whole = world.run().tracks["all"]
    monkeypatch.setattr(frames, "MOST_FRAMES", 7)
    recording = Recording()
    run = simulate(world.scene, world.sensors(), 1, 48, recording)
    for _ in range(3):
        next(run)
    run.close()
    track = recording.tracks["all"]
    assert 7 < len(track) < 48 and recording.frame_end == track.frames[len(track) - 1]
    assert list(track.active) == list(whole.active)[: len(track)]


def steps_on_a_pad(world):
    """Somebody steps on a pad, waits and hops to a slab on another one, below which a drawer is
    drawn; a third pad is far away, as is a cat that walks all the time."""
    for name, at in (("pad", (0, 0, 0.01)), ("far", (7, 0, 0.01)), ("slab's", (0, 2, 0.01))):
        world.sensor("PRESSURE", name, world.box((0.5, 0.5, 0.02), at, name), update_rate=6.0)
    world.box((9, 9, 1), (0, 0, -0.5), "floor")
    world.box((0.4, 0.4, 0.1), (0, 2, 0.07), "slab").angen_load.mass = 5.0
    person = body(world, "person", (-3, 0, 0.45))
    person.angen_load.mass = 60.0
    at = {1: (-3, 0, 0.45), 9: (0, 0, 0.47), 25: (0, 0, 0.47), 27: (0, 0, 0.8), 29: (0, 2, 0.57)}
    world.key(person, "location", at, "LINEAR")
    cat = {1: (-3, 5, 0), 48: (3, 5, 0)}
    world.key(body(world, "cat"), "location", cat, "LINEAR")
    drawer = world.box((0.2, 0.2, 0.02), (0, 2, -0.2), "drawer")
    world.key(drawer, "location", {36: (0, 2, -0.2), 44: (1, 2, -0.2)}, "LINEAR")


@pytest.mark.parametrize("substeps", mostly_slow([1, 3], 1))
def test_pads_read_the_same_where_what_they_cannot_feel_is_left_out(
    world, read, monkeypatch, substeps
):
    world.scene.frame_end, world.scene.angen_substeps = 48, substeps
    sensors_about(world)
    steps_on_a_pad(world)
    plain = read_plain(world, monkeypatch)
    found = np.array(plain["pad"].columns["force_n"])
    assert found.max() > 500.0 and found[0] == found[-1] == 0.0
    for most, alone in ((1, False), (5, False), (256, False), (256, True)):
        assert read(most, alone) == plain


def read_plain(world, monkeypatch):
    """With each frame looked at by itself, and nothing left out."""
    with monkeypatch.context() as patch:
        patch.setattr(stage, "_weights_stay", lambda _: False)
        return world.run().tracks
