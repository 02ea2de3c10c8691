# SPDX-License-Identifier: GPL-3.0-or-later
"""The person in the sample home: what a viewer of the film would notice if it were wrong."""

from importlib import import_module
from itertools import pairwise

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from sample_blends import build_angen  # noqa: E402
from sample_blends.angen_home import animate, director, paths, plan, stage  # noqa: E402
from sample_blends.angen_home import story as story_text  # noqa: E402
from sample_blends.angen_home.keys import needed  # noqa: E402

InputError = import_module("angen_sensors.sensor_logic.error").InputError
solve = import_module("angen_sensors.residents.body.solve").solve


@pytest.fixture(scope="module")
def film():
    """What is acted, the body's line, a time a frame and the solved bones of the whole story."""
    acted = director.direct()
    line = acted.bodies[director.PERSON]
    times = np.arange(int(line.duration * plan.FPS)) / plan.FPS
    return acted, line, times, solve(line.poses(times)).at


def test_nothing_jumps(film):
    *_, bones = film
    for bone, limit in (("pelvis", 1.5), ("head", 2.0), ("hand.L", 3.5), ("hand.R", 3.5)):
        speed = np.linalg.norm(np.diff(bones[bone], axis=0), axis=1) * plan.FPS
        assert speed.max() < limit, f"{bone} at frame {speed.argmax()}"


def test_doors_are_out_of_the_way(film):
    acted, _, times, bones = film
    for name in plan.DOORS:
        yaws = stage.leaf_yaw(acted, f"Door {name}", times[::3])
        for t, yaw, here in zip(times[::3], yaws, bones["pelvis"][::3, :2], strict=True):
            near = paths.leaf_clear(name, float(yaw), tuple(here))
            assert near > 0.25, f"door {name} at {t:.2f} s"


def test_walks_keep_clear_of_walls_and_furniture(film):
    _, line, *_ = film
    for clip in line.clips:
        if not hasattr(clip.pose, "__self__"):  # not a walk
            continue
        times = np.arange(clip.start, clip.end, 0.1)
        for t, (x, y) in zip(times, line.base(times).pelvis[:, :2], strict=True):
            for name, box in paths._SOLIDS:
                near = paths.distance_to_box((x, y), box)
                # One sits down where one stands close to the seat.
                least = 0.05 if name in ("Sofa", "Bed", "Toilet") else 0.20
                assert near > least, f"{name} at {t:.2f} s"


def test_the_story_lasts_two_to_three_minutes_and_ends_in_bed_with_doors_shut(film):
    acted, line, times, bones = film
    assert 120 <= line.duration <= 180
    for name, door in plan.DOORS.items():
        yaws = stage.leaf_yaw(acted, f"Door {name}", np.array([0.0, line.duration]))
        assert yaws == pytest.approx([door.closed_yaw] * 2)
    head, pelvis = bones["head"][-1], bones["pelvis"][-1]
    bed = plan.FURNITURE["Bed"]
    assert bed.x0 < pelvis[0] < bed.x1 and bed.y0 < pelvis[1] < bed.y1
    assert abs(head[2] - pelvis[2]) < 0.15
    wrists = bones["hand.R"][times > line.duration - 10]
    assert np.ptp(wrists, axis=0).max() < 0.02


IN = ["open Door entrance", "go entrance_handle_inside", "close Door entrance"]


@pytest.mark.parametrize(
    "story,words",
    [
        (["go moon"], ("step 1", "moon", "known: ")),
        (["open Door hatch"], ("step 1", "hatch", "Door kitchen")),
        (["go fridge"], ("step 1", "closed doors", "entrance")),
        (
            IN + ["open Door entrance", "open Door kitchen", "sit kitchen_seat"],
            ("step 6", "cannot sit", "sofa_seat", "shoe_bench"),
        ),
        (
            ["open Door entrance", "go workroom_window"],
            ("step 2", "closed doors: workroom", "open leaves", "the workroom's doorway"),
        ),
        (["switch Lamp hal on"], ("step 1", "Lamp hal", "Lamp hall")),
        (["switch Lamp hall on"], ("takes no time", "wait")),
        ([], ("takes no time",)),
        (["wait 1 s", "wait"], ("step 2", "say how long")),
        (["dance"], ("step 1", "no word")),
        (["leave"], ("step 1", "do not have this word", "look around")),
        (
            IN + ["open Door kitchen", "close Door kitchen"],
            ("step 5", "nobody goes through", "kitchen"),
        ),
        (IN[:2] + ["take Bottle"], ("step 3", "Fridge door")),
        (IN[:2] + ["take Bottel"], ("step 3", "Bottel", "Bottle")),
        (IN + ["open Fridge door"], ("step 4", "away", "1.2 m")),
        (IN + ["put Coat at coffee table"], ("step 4", "away", "1.2 m")),
        (["open Door entrance", "shift"], ("step 2", "does not sit")),
        (["put Bottle at coffee table"], ("step 1", "in the hands is: Coat")),
        (["open Door entrance", "sit coat_hook"], ("step 2", "seats: ")),
        (["open Door entrance", "open Door entrance"], ("step 2", "open already")),
    ],
)
def test_a_wrong_step_is_named(story, words):
    with pytest.raises((ValueError, InputError)) as error:
        director.direct("\n".join(story))
    for word in words:
        assert word in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("place", stage.SEATS)
def test_every_offered_seat_can_be_sat_on(place):
    room = {"toilet": "bathroom", "bed_edge": "bedroom"}.get(place)
    through = [f"open Door {room}"] if room else []
    acted = director.direct("\n".join([*IN, *through, f"sit {place}", "wait 1 s"]))
    assert acted.bodies[director.PERSON].duration > 10
    assert place in story_text.__doc__


def test_a_prop_that_does_not_exist_is_named(monkeypatch):
    monkeypatch.setitem(director.PROPS, "Bottel", "hand")
    with pytest.raises(ValueError, match="PROPS: there is no prop 'Bottel'; known: Bottle, Coat"):
        director.direct()


def test_a_wrong_story_is_one_line_and_status_1(monkeypatch, capsys, tmp_path):
    def wrong(_scene):
        raise ValueError("entry 1 of the story, nonsense")

    monkeypatch.setattr(build_angen, "build", lambda: bpy.context.scene)
    monkeypatch.setattr(build_angen.checks, "plan_problems", list)
    monkeypatch.setattr(build_angen.checks, "scene_problems", lambda _scene: [])
    monkeypatch.setattr(build_angen.animate, "add_person_and_story", wrong)
    out = tmp_path / "home.blend"
    assert build_angen.make(out, with_digest=False) == 1
    assert capsys.readouterr().err == "story: entry 1 of the story, nonsense\n"
    assert not out.exists()


def test_keys_miss_no_value_by_more_than_the_tolerance():
    values = np.sin(np.linspace(0, 20, 400)) + np.linspace(0, 1, 400) ** 3
    kept = needed(values, 0.01)
    back = np.interp(np.arange(400), kept, values[kept])
    assert np.abs(back - values).max() <= 0.01
    assert len(kept) < 100
    assert needed(np.ones(400), 0.01) == [0]
    assert all(b > a for a, b in pairwise(kept))


@pytest.fixture
def scene():
    """An empty file with a bare object for each that the story moves."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    for name in [*stage.CLOSED, "Coat", "Bottle"]:
        scene.collection.objects.link(bpy.data.objects.new(name, None))
    for name in plan.LAMPS:
        lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT"))
        scene.collection.objects.link(lamp)
    return scene


def test_the_keyframes_play_the_timeline(scene):
    acted = animate.add_person_and_story(scene)
    line = acted.bodies[director.PERSON]
    assert (scene.frame_start, scene.frame_end) == (1, int(np.ceil(line.duration * plan.FPS)))
    rig = bpy.data.objects["Person rig"]
    for frame in range(1, scene.frame_end, 83):
        scene.frame_set(frame)
        t = np.array([(frame - 1) / plan.FPS])
        at = solve(line.poses(t)).at
        for bone in ("head", "hand.L", "hand.R", "foot.L", "foot.R"):
            there = np.array(rig.matrix_world @ rig.pose.bones[bone].head)
            assert np.linalg.norm(there - at[bone][0]) < 0.006, f"{bone} at frame {frame}"
        for name in plan.DOORS:
            yaw = np.degrees(bpy.data.objects[f"Door {name}"].rotation_euler.z)
            if f"Door {name}" in acted.swings:
                told = stage.leaf_yaw(acted, f"Door {name}", t)[0]
                assert yaw == pytest.approx(told, abs=0.1)
