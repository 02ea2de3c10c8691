# SPDX-License-Identifier: GPL-3.0-or-later
"""The person in the sample home: what a viewer of the film would notice if it were wrong."""

from importlib import import_module
from itertools import pairwise

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from sample_blends import build_angen  # noqa: E402
from sample_blends.angen_home import animate, director, paths, plan  # noqa: E402
from sample_blends.angen_home import story as story_text  # noqa: E402
from sample_blends.angen_home.actions import (  # noqa: E402
    CloseDoor,
    LetDoorClose,
    Open,
    OpenDoor,
    Put,
    Sit,
    StandUp,
    Switch,
    Take,
    Wait,
    Walk,
)
from sample_blends.angen_home.keys import needed  # noqa: E402
from sample_blends.angen_home.story import START  # noqa: E402

solve = import_module("angen_sensors.sensor_logic.residents.body.solve").solve


@pytest.fixture(scope="module")
def film():
    """The timeline, a time a frame and the solved bones of the whole story."""
    line = director.direct()
    times = np.arange(int(line.duration * plan.FPS)) / plan.FPS
    return line, times, solve(line.body.poses(times)).at


def test_nothing_jumps(film):
    _, _, bones = film
    for bone, limit in (("pelvis", 1.5), ("head", 2.0), ("hand.L", 3.5), ("hand.R", 3.5)):
        speed = np.linalg.norm(np.diff(bones[bone], axis=0), axis=1) * plan.FPS
        assert speed.max() < limit, f"{bone} at frame {speed.argmax()}"


def test_doors_are_out_of_the_way(film):
    line, times, bones = film
    for name in plan.DOORS:
        yaws = line.door_yaw(name, times[::3])
        for t, yaw, here in zip(times[::3], yaws, bones["pelvis"][::3, :2], strict=True):
            near = paths.leaf_clear(name, float(yaw), tuple(here))
            assert near > 0.25, f"door {name} at {t:.2f} s"


def test_walks_keep_clear_of_walls_and_furniture(film):
    line, _, _ = film
    for clip in line.body.clips:
        if not hasattr(clip.pose, "__self__"):  # not a walk
            continue
        times = np.arange(clip.start, clip.end, 0.1)
        for t, (x, y) in zip(times, line.body.base(times).pelvis[:, :2], strict=True):
            for name, box in paths._SOLIDS:
                near = paths.distance_to_box((x, y), box)
                # One sits down where one stands close to the seat.
                least = 0.05 if name in ("Sofa", "Bed", "Toilet") else 0.20
                assert near > least, f"{name} at {t:.2f} s"


def test_the_story_lasts_two_to_three_minutes_and_ends_in_bed_with_doors_shut(film):
    line, times, bones = film
    assert 120 <= line.duration <= 180
    for name, door in plan.DOORS.items():
        yaws = line.door_yaw(name, np.array([0.0, line.duration]))
        assert yaws == pytest.approx([door.closed_yaw] * 2)
    head, pelvis = bones["head"][-1], bones["pelvis"][-1]
    bed = plan.FURNITURE["Bed"]
    assert bed.x0 < pelvis[0] < bed.x1 and bed.y0 < pelvis[1] < bed.y1
    assert abs(head[2] - pelvis[2]) < 0.15
    wrists = bones["hand.R"][times > line.duration - 10]
    assert np.ptp(wrists, axis=0).max() < 0.02


IN = [OpenDoor("entrance"), Walk("entrance_handle_inside"), CloseDoor("entrance")]


@pytest.mark.parametrize(
    "story,words",
    [
        ([Walk("moon")], ("entry 1", "moon", "sofa_seat")),
        ([OpenDoor("hatch")], ("entry 1", "hatch", "kitchen")),
        ([Walk("fridge")], ("entry 1", "closed doors", "entrance")),
        (
            IN + [OpenDoor("entrance"), OpenDoor("kitchen"), Sit("kitchen_seat")],
            ("entry 6", "cannot sit", "sofa_seat", "shoe_bench"),
        ),
        (
            [OpenDoor("entrance"), Walk("workroom_window")],
            ("entry 2", "closed doors: workroom", "open leaves", "the workroom's doorway"),
        ),
        ([Switch("Lamp hal", on=True)], ("entry 1", "Lamp hal", "Lamp hall")),
        ([Switch("Lamp hall", on=True)], ("takes no time", "Wait")),
        ([], ("takes no time",)),
        ([Wait(1.0), Wait(-1.0)], ("entry 2", "seconds")),
        ([StandUp], ("entry 1", "no action", "()")),
        (
            IN + [OpenDoor("workroom"), LetDoorClose("workroom")],
            ("entry 5", "nobody goes through", "workroom"),
        ),
        (IN[:2] + [Take("Bottle")], ("entry 3", "Fridge door")),
        (IN[:2] + [Take("Bottel")], ("entry 3", "Bottel", "Bottle")),
        (IN + [Open("Fridge door")], ("entry 4", "away", "1.2 m")),
        (IN + [Put("Coat", "coffee table")], ("entry 4", "away", "1.2 m")),
        ([OpenDoor("entrance"), StandUp()], ("entry 2", "does not sit")),
        ([Put("Bottle", "coffee table")], ("entry 1", "in the hands is: Coat")),
        ([OpenDoor("entrance"), Sit("coat_hook")], ("entry 2", "seats: ")),
    ],
)
def test_a_wrong_entry_is_named(story, words):
    with pytest.raises(ValueError) as error:
        director.direct(story, START)
    for word in words:
        assert word in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("place", director.SEATS)
def test_every_offered_seat_can_be_sat_on(place):
    room = {"toilet": "bathroom", "bed_edge": "bedroom"}.get(place)
    story = [*IN, *([OpenDoor(room)] if room else []), Sit(place), Wait(1.0), StandUp()]
    assert director.direct(story, START).duration > 10
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
def stage():
    """An empty file with a bare object for each that the story moves."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    for name in [*(f"Door {n}" for n in plan.DOORS), *director.HINGED, "Coat"]:
        scene.collection.objects.link(bpy.data.objects.new(name, None))
    for name in plan.LAMPS:
        lamp = bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT"))
        scene.collection.objects.link(lamp)
    return scene


def test_the_keyframes_play_the_timeline(stage):
    line = animate.add_person_and_story(stage)
    assert (stage.frame_start, stage.frame_end) == (1, int(np.ceil(line.duration * plan.FPS)))
    rig = bpy.data.objects["Person rig"]
    for frame in range(1, stage.frame_end, 83):
        stage.frame_set(frame)
        t = np.array([(frame - 1) / plan.FPS])
        at = solve(line.body.poses(t)).at
        for bone in ("head", "hand.L", "hand.R", "foot.L", "foot.R"):
            there = np.array(rig.matrix_world @ rig.pose.bones[bone].head)
            assert np.linalg.norm(there - at[bone][0]) < 0.006, f"{bone} at frame {frame}"
        for name in plan.DOORS:
            yaw = np.degrees(bpy.data.objects[f"Door {name}"].rotation_euler.z)
            if f"Door {name}" in line.swings:
                assert yaw == pytest.approx(line.door_yaw(name, t)[0], abs=0.1)
