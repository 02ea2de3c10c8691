# SPDX-License-Identifier: GPL-3.0-or-later
"""A day in the window: its activities, a stretch of it as animation, and the way back."""

from __future__ import annotations

import json
import math
import re
from contextlib import closing
from datetime import datetime, timedelta
from inspect import signature
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.process.parser import parse
from bl_ext.user_default.angen_sensors.residents.blender.api import Home
from bl_ext.user_default.angen_sensors.residents.days.rows import hours_minutes
from lived_home import ROUTINE, content
from lived_home import rows as read_rows
from panel_layout import drawn

SECOND = timedelta(seconds=1)


def state(scene: Any) -> Any:
    rig, fan = bpy.data.objects["Adult"], bpy.data.objects["Fan"]
    parts = [bpy.data.objects["Door"], fan, rig, *rig.pose.bones]
    times = [scene.frame_start, scene.frame_end, scene.frame_current, scene.render.fps]
    placed = [np.array(part.matrix_basis).ravel() for part in parts]
    return np.concatenate([[bpy.data.lights["Lamp"].energy], times, *placed])


def state_of_home() -> Any:
    rig = bpy.data.objects["Adult"]
    parts = [bpy.data.objects["Door"], rig, *rig.pose.bones]
    placed = [np.array(part.matrix_basis).ravel() for part in parts]
    return np.concatenate([[bpy.data.lights["Lamp"].energy], *placed])


@pytest.fixture
def scene(lived_home: Path, world: Any) -> Any:
    """Return the scene of a home that has its own animation."""
    fan = world.box((0.1, 0.1, 0.1), (1, 1, 2), "Fan")
    world.key(fan, "location", {1: (1, 1, 2), 48: (1, 3, 2)})
    text = bpy.data.texts.new("week.toml")
    text.write(ROUTINE)
    world.scene.angen_day.text, world.scene.angen_day.seed = text, 1
    world.scene.frame_set(20)
    return world.scene


def test_a_stretch_is_shown_sensed_and_left_again(scene: Any, world: Any) -> None:
    asked, before, actions = scene.angen_day, state(scene), set(bpy.data.actions.keys())
    assert not bpy.ops.angen.day_leave.poll()
    assert bpy.ops.angen.day_read() == {"FINISHED"}
    assert [item.name for item in asked.done] == ["Sleep", "Sit", "Sleep"]
    assert "3 activities" in asked.told and np.allclose(state(scene), before, atol=1e-6)
    item = asked.done[1]
    assert bpy.ops.angen.day_show(index=1) == {"FINISHED"}
    assert scene.render.fps == 10
    assert scene.frame_start == pytest.approx(1 + 10 * (item.start - 2), abs=1)
    assert scene.frame_end == pytest.approx(1 + 10 * (item.end + 2), abs=1)
    # A seated resident sits on the seat, at 0.5 m beside the wall; the lamp is on; the fan rests.
    scene.frame_set(int(1 + 10 * (item.start + item.end) / 2))
    hips = bpy.data.objects["Adult"].matrix_world @ bpy.data.objects["Adult"].pose.bones[0].head
    assert np.allclose(hips[:2], (0.5, 0.5), atol=0.25)
    assert bpy.data.lights["Lamp"].energy == pytest.approx(40.0)
    assert bpy.data.objects["Fan"].location[1] == pytest.approx(1.0)
    # On the way there the detectors notice the resident.
    scene.frame_set(scene.frame_start)
    recording = world.run(scene.frame_start, scene.frame_start + 200)
    assert any(np.asarray(recording.tracks[n].active).any() for n in ("PIR left", "PIR right"))
    # From one stretch to the next, and back.
    assert bpy.ops.angen.day_show(index=2) == {"FINISHED"}
    assert bpy.ops.angen.day_leave() == {"FINISHED"}
    assert np.allclose(state(scene), before, atol=1e-6)
    assert set(bpy.data.actions.keys()) == actions


def test_what_the_resident_uses_is_in_use_while_it_is_used(
    scene: Any, addon_part: Any, capfd: Any
) -> None:
    followed = addon_part("residents.blender.followed_day")
    bpy.data.objects["Bed"].angen_use.in_use = True
    bpy.ops.angen.day_read()
    item = scene.angen_day.done[1]
    assert bpy.ops.angen.day_show(index=1) == {"FINISHED"}

    def used(name: str, time: float) -> bool:
        scene.frame_set(round(1 + 10 * time))
        evaluated = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get())
        assert evaluated.angen_use.in_use == bpy.data.objects[name].angen_use.in_use
        return evaluated.angen_use.in_use

    middle = (item.start + item.end) / 2
    assert [used("Seat", time) for time in (item.start, middle, item.end - 1)] == [
        False,
        True,
        True,
    ]
    assert used("Bed", item.start - 1) and not used("Bed", middle)
    assert not used("Lamp", item.start - 1) and used("Lamp", middle)
    # Only what is used has keys.
    assert bpy.data.objects["wall 0"].animation_data is None
    scene.frame_set(round(1 + 10 * middle))
    bpy.context.view_layer.update()
    stale = followed.why_stale(scene)
    assert not stale, stale
    bpy.ops.angen.day_leave()
    now = {name: bpy.data.objects[name].angen_use.in_use for name in ("Seat", "Bed", "Lamp")}
    assert now == {"Seat": False, "Bed": True, "Lamp": False}
    assert bpy.data.objects["Seat"].animation_data is None
    assert "Error" not in capfd.readouterr().err


def test_leaving_the_day_brings_the_homes_recording_back(scene: Any, addon_part: Any) -> None:
    """Also where the shown activity was simulated meanwhile."""
    results = addon_part("angen_addon.recording.results").RESULTS
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    home = results.recording(scene)
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    assert results.recording(scene) is None, "the shown activity moves what the recording has"
    first = scene.frame_start
    for number in range(6):
        begin = first + 20 * number
        assert bpy.ops.angen.simulate(frame_start=begin, frame_end=begin + 5) == {"FINISHED"}
    assert results.recording(scene) not in (None, home)
    bpy.ops.angen.day_leave()
    bpy.context.view_layer.update()
    scene.frame_set(20)
    assert results.recording(scene) is home


def simulated(addon_part: Any, scene: Any) -> Any:
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    return addon_part("angen_addon.recording.results").RESULTS.recording(scene)


def reopened(path: Path) -> Any:
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return bpy.context.scene


def readings(recording: Any) -> Any:
    return {name: (list(t.frames), list(t.value)) for name, t in recording.tracks.items()}


def test_what_is_animated_beside_objects_rests_too_and_plays_afterwards(
    scene: Any, world: Any, tmp_path: Path
) -> None:
    """Shape keys and nodes: a run of days holds them at the home's first frame, and so do views."""
    curtain = world.box((1.0, 0.05, 2.0), (4.5, 1.0, 1.0), "Curtain")
    curtain.shape_key_add(name="Basis")
    curtain.shape_key_add(name="Drawn")
    scene.world = bpy.data.worlds.new("Sky")
    scene.world.use_nodes = True

    def animated() -> list[tuple[Any, str]]:
        [node] = [n for n in bpy.data.worlds["Sky"].node_tree.nodes if n.type == "BACKGROUND"]
        key = bpy.data.objects["Curtain"].data.shape_keys.key_blocks["Drawn"]
        return [(key, "value"), (node.inputs["Strength"], "default_value")]

    def values() -> list[float]:
        return [float(getattr(*one)) for one in animated()]

    for owner, name in animated():
        for frame, value in ((1, 0.25), (40, 1.0)):
            setattr(owner, name, value)
            owner.keyframe_insert(name, frame=frame)
    scene.frame_set(20)
    before = values()
    assert min(before) > 0.5
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    scene.frame_set(scene.frame_start + 30)
    assert values() == pytest.approx([0.25, 0.25])
    scene = reopened(tmp_path / "shown.blend")
    bpy.ops.angen.day_leave()
    assert scene.frame_current == 20 and values() == pytest.approx(before)


@pytest.mark.parametrize("saved", ["the day", "its recording", "twice"])
def test_saving_a_shown_day_keeps_the_homes_recording_and_that_of_the_day(
    scene: Any, addon_part: Any, tmp_path: Path, saved: str
) -> None:
    results = addon_part("angen_addon.recording.results").RESULTS
    home, of_day = readings(simulated(addon_part, scene)), None
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    if saved != "the day":
        assert bpy.ops.angen.simulate(frame_end=scene.frame_start + 20) == {"FINISHED"}
        of_day = readings(results.recording(scene))
    for number in range(2 if saved == "twice" else 1):
        scene = reopened(tmp_path / f"shown{number}.blend")
    assert (results.recording(scene) is None) == (of_day is None)
    assert of_day is None or readings(results.recording(scene)) == of_day
    assert bpy.ops.angen.day_leave() == {"FINISHED"}
    scene.frame_set(20)
    assert readings(results.recording(scene)) == home
    # Saved and opened once more, the file has the home's recording alone.
    scene = reopened(tmp_path / "left.blend")
    scene.frame_set(20)
    assert readings(results.recording(scene)) == home


def test_the_homes_recording_is_kept_aside_and_not_called_stale(
    scene: Any, addon_part: Any
) -> None:
    simulated(addon_part, scene)
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    aside = "Kept aside: frames 1 to 48"
    for _ in range(2):
        told = drawn("ANGEN_PT_simulation").labels
        assert aside in told and not any("stale" in text for text in told)
        # Also beside the recording of the shown activity.
        assert bpy.ops.angen.simulate(frame_end=scene.frame_start + 20) == {"FINISHED"}
    assert bpy.ops.angen.clear_recording() == {"FINISHED"}
    assert aside in drawn("ANGEN_PT_simulation").labels
    bpy.ops.angen.day_leave()
    told = drawn("ANGEN_PT_simulation").labels
    assert "Recorded: frames 1 to 48" in told and aside not in told


def test_undo_and_redo_of_a_shown_day_keep_both_recordings(scene: Any, addon_part: Any) -> None:
    results = addon_part("angen_addon.recording.results").RESULTS
    home = simulated(addon_part, scene)
    bpy.ops.angen.day_read()
    bpy.ops.ed.undo_push(message="read")
    bpy.ops.angen.day_show(index=1)
    bpy.ops.ed.undo_push(message="shown")
    bpy.ops.angen.day_leave()
    bpy.ops.ed.undo_push(message="left")
    bpy.ops.ed.undo()
    assert bpy.context.scene.angen_day.before
    # Later recordings do not push out the home's.
    for number in range(6):
        begin = bpy.context.scene.frame_start + 20 * number
        bpy.ops.angen.simulate(frame_start=begin, frame_end=begin + 5)
    bpy.ops.angen.day_leave()
    bpy.context.scene.frame_set(20)
    assert results.recording(bpy.context.scene) is home


def test_without_a_recording_of_the_home_none_is_there_afterwards(
    scene: Any, addon_part: Any
) -> None:
    results = addon_part("angen_addon.recording.results").RESULTS
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    bpy.ops.angen.simulate(frame_end=scene.frame_start + 20)
    assert not any("aside" in text for text in drawn("ANGEN_PT_simulation").labels)
    bpy.ops.angen.day_leave()
    assert results.kept(scene) is None


def move(name: str) -> None:
    bpy.data.objects[name].location.x += 0.25


def edit(obj: Any, group: str, **values: Any) -> None:
    """Change settings as panels do, which tag the object."""
    for name, value in values.items():
        setattr(getattr(obj, group), name, value)
    obj.update_tag()


def reset(name: str, value: Any) -> None:
    setattr(bpy.context.scene.angen_day, name, value)


CHANGED = {
    "seed": (lambda: reset("seed", 5), "Seed"),
    "date": (lambda: reset("date", "2026-03-03"), "First Day"),
    "day": (lambda: reset("number", 2), "Day"),
    "routine": (lambda: bpy.data.texts["week.toml"].write("# more"), "Routine"),
    "no routine": (lambda: reset("text", None), "Routine"),
    "furniture": (lambda: move("Seat"), "'Seat'"),
    "place": (lambda: edit(bpy.data.objects["Bed"], "angen_place", use="NONE"), "'Bed'"),
    "wall": (
        lambda: bpy.data.objects.remove(bpy.data.objects["wall 3"]),
        "'wall 3' (gone)",
    ),
    "resident": (lambda: edit(bpy.data.objects["Adult"], "angen_resident", speed=0.5), "'Adult'"),
}


def list_lines() -> list[str]:
    return [text for text in drawn("ANGEN_PT_day").labels if "stale" in text]


@pytest.mark.parametrize("is_shown", [False, True], ids=["", "shown"])
@pytest.mark.parametrize("name", CHANGED)
def test_a_list_of_other_settings_or_of_another_home_is_stale(
    scene: Any, name: str, is_shown: bool
) -> None:
    """The panel says why, and a click shows no other day than the panel names."""
    bpy.ops.angen.day_read()
    if is_shown:
        bpy.ops.angen.day_show(index=1)
    bpy.context.view_layer.update()
    assert list_lines() == [] and bpy.ops.angen.day_show.poll()
    before = state(scene)
    make, what = CHANGED[name]
    make()
    bpy.context.view_layer.update()
    told = " ".join(drawn("ANGEN_PT_day").labels)
    assert f"The list is stale, changed since: {what}. Read Day again" in told
    for show, given in ((bpy.ops.angen.day_show, {"index": 2}), (bpy.ops.angen.day_go, {})):
        with pytest.raises(RuntimeError, match=f"stale, changed since: .*{what.split(' (')[0]}"):
            show(**given)
    if is_shown:
        bpy.ops.angen.day_leave()
        bpy.context.view_layer.update()
        assert what in " ".join(drawn("ANGEN_PT_day").labels)
    elif name != "wall":
        assert np.allclose(state(scene), before, atol=1e-6)


@pytest.mark.parametrize("is_shown", [False, True], ids=["", "shown"])
def test_what_does_not_change_the_day_leaves_the_list_fresh(
    scene: Any, world: Any, is_shown: bool
) -> None:
    bpy.ops.angen.day_read()
    if is_shown:
        bpy.ops.angen.day_show(index=1)
    world.pir("new").location = (1, 1, 2)
    bpy.data.objects["PIR left"].location.z += 0.1
    bpy.data.objects["PIR right"].name = "Hall"
    scene.angen_seed, scene.angen_day.time, scene.angen_day.out = 3, "08:00", "out"
    world.link("Camera", bpy.data.cameras.new("Camera"))
    bpy.data.lights["Lamp"].color = (1.0, 0.5, 0.5)
    bpy.ops.angen.simulate(frame_end=scene.frame_start + 5)
    scene.frame_set(scene.frame_start + 7)
    bpy.context.view_layer.update()
    assert list_lines() == []
    assert bpy.ops.angen.day_show(index=2) == {"FINISHED"}
    assert bpy.ops.angen.day_leave() == {"FINISHED"}
    bpy.context.view_layer.update()
    assert list_lines() == []


def test_a_change_taken_back_makes_the_list_fresh_again(scene: Any, tmp_path: Path) -> None:
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    scene.angen_day.seed = 5
    assert list_lines()
    scene.angen_day.seed = 1
    assert list_lines() == []
    move("Seat")
    bpy.context.view_layer.update()
    assert list_lines()
    # After saving, the list is stale still.
    scene = reopened(tmp_path / "moved.blend")
    bpy.context.view_layer.update()
    assert list_lines() and not bpy.ops.angen.day_show.poll()
    bpy.data.objects["Seat"].location.x -= 0.25
    bpy.context.view_layer.update()
    assert list_lines() == []
    assert bpy.ops.angen.day_show(index=2) == {"FINISHED"}
    # What was read anew is fresh, and Undo brings the former list back.
    bpy.ops.angen.day_leave()
    bpy.ops.ed.undo_push(message="left")
    scene.angen_day.seed = 5
    bpy.ops.ed.undo_push(message="seed")
    bpy.ops.angen.day_read()
    bpy.ops.ed.undo_push(message="read")
    assert list_lines() == []
    first = [item.start for item in scene.angen_day.done]
    bpy.ops.ed.undo()
    assert list_lines() and [i.start for i in bpy.context.scene.angen_day.done] != first
    bpy.ops.ed.undo()
    assert list_lines() == []
    bpy.ops.angen.day_show(index=1)
    scene = bpy.context.scene
    assert scene.frame_current == pytest.approx(1 + 10 * scene.angen_day.done[1].start, abs=1)


def test_a_routine_file_edited_on_disk_makes_the_list_stale(scene: Any, lived_home: Path) -> None:
    path = lived_home.parent / "week.toml"
    scene.angen_day.text, scene.angen_day.routine = None, "//week.toml"
    bpy.ops.angen.day_read()
    assert list_lines() == []
    path.write_text(ROUTINE.replace("90 min", "95 min"), encoding="utf-8")
    assert "Routine" in " ".join(drawn("ANGEN_PT_day").labels)
    assert not bpy.ops.angen.day_go.poll()
    bpy.ops.angen.day_read()
    assert list_lines() == []
    path.unlink()
    assert list_lines()


def test_esc_while_a_changed_home_is_read_leaves_the_list_stale(
    scene: Any, addon_part: Any
) -> None:
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    bpy.data.objects["Seat"].location.x += 0.25
    bpy.context.view_layer.update()
    work = addon_part("residents.operators.day").ANGEN_OT_day_read._begin(None, bpy.context)
    next(work)
    with pytest.raises(addon_part("sensor_logic.progress").Enough):
        work.throw(addon_part("sensor_logic.progress").Enough)
    scene.frame_set(scene.frame_current + 1)
    assert scene.angen_day.before and list_lines()


def test_another_place_on_earth_gives_the_shown_activity_its_light(scene: Any, world: Any) -> None:
    sun = world.link("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.0, (math.radians(60), 0, 0)
    world.sensor("LIGHT", "lux", method="ILLUMINANCE", samples=1).location = (1.5, 3.0, 1.0)
    site = scene.angen_site
    site.latitude, site.longitude, site.utc_offset = math.radians(59), math.radians(18), 1
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    north = sun.data.energy
    site.latitude = math.radians(0)
    assert bpy.ops.angen.day_show(index=1) == {"FINISHED"}
    assert sun.data.energy > 1.2 * north
    bpy.ops.angen.day_leave()
    assert sun.data.energy == 2.0


def rename(collection: Any, name: str) -> None:
    collection[name].name = f"{name} of the hall"


RENAMED = {
    "a door": lambda: rename(bpy.data.objects, "Door"),
    "two objects with each other's names": lambda: swap(bpy.data.objects, "Door", "Fan"),
    "a lamp": lambda: rename(bpy.data.objects, "Lamp"),
    "the light of a lamp": lambda: rename(bpy.data.lights, "Lamp"),
    "a resident": lambda: rename(bpy.data.objects, "Adult"),
    "the home's own action": lambda: rename(bpy.data.actions, "FanAction"),
    "the day's action": lambda: rename(bpy.data.actions, "Day Door"),
    "a bone": lambda: rename(bpy.data.objects["Adult"].data.bones, "chest"),
}


def swap(collection: Any, one: str, other: str) -> None:
    first, second = collection[one], collection[other]
    first.name, second.name = "x", one
    first.name = other


@pytest.mark.parametrize("saved", [False, True], ids=["", "saved"])
@pytest.mark.parametrize("renamed", RENAMED)
def test_what_is_renamed_while_a_day_is_shown_is_restored(
    scene: Any, tmp_path: Path, renamed: str, saved: bool
) -> None:
    """Objects are known by identity, also after saving."""

    def objects() -> list[Any]:
        rig = bpy.data.objects["Adult"]
        found = [bpy.data.objects[name] for name in ("Door", "Fan", "Adult", "Adult body")]
        return [*found, *rig.pose.bones]

    def names() -> list[str]:
        bones = [bone.name for bone in bpy.data.objects["Adult"].pose.bones]
        return ["Door", "Fan", "Adult", "Adult body", *bones]

    before, wanted, count = state(scene), names(), len(bpy.data.actions)
    bpy.data.objects["Fan"].animation_data.action.name = "FanAction"
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    scene.frame_set(scene.frame_start + 40)
    assert not np.allclose(state(scene), before, atol=1e-3)
    RENAMED[renamed]()
    if saved:
        scene = reopened(tmp_path / "renamed.blend")
    bpy.ops.angen.day_leave()
    scene.frame_set(20)
    # Back to the names, by the same changes.
    for collection in (
        bpy.data.objects,
        bpy.data.lights,
        bpy.data.actions,
        *(armature.bones for armature in bpy.data.armatures),
    ):
        for one in collection:
            one.name = one.name.removesuffix(" of the hall")
    if renamed.startswith("two"):
        RENAMED[renamed]()
    assert names() == wanted and len(objects()) == len(wanted)
    assert np.allclose(state(scene), before, atol=1e-6)
    assert len(bpy.data.actions) == count
    assert bpy.data.objects["Fan"].animation_data.action.name == "FanAction"
    moved = bpy.data.objects["Door"], bpy.data.lights["Lamp"]
    assert all(one.animation_data is None for one in moved)


def test_a_copy_made_while_a_day_is_shown_stays_where_it_was_made(scene: Any) -> None:
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    scene.frame_set(scene.frame_start + 40)
    door, copy = bpy.data.objects["Door"], bpy.data.objects["Door"].copy()
    scene.collection.objects.link(copy)
    copy.animation_data.action = door.animation_data.action.copy()
    own = bpy.data.objects["Fan"]
    own.keyframe_insert("scale", frame=scene.frame_current)
    place = copy.matrix_basis.copy()
    assert bpy.ops.angen.day_leave() == {"FINISHED"}
    for frame in (1, 30):
        scene.frame_set(frame)
        assert copy.matrix_basis == place
    assert not [action for action in bpy.data.actions if action.name.startswith("Day")]


def test_leaving_the_day_names_what_cannot_be_restored(scene: Any) -> None:
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    rig = bpy.data.objects["Adult"]
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    rig.data.edit_bones.remove(rig.data.edit_bones["head"])
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.data.objects.remove(bpy.data.objects["Fan"])
    assert bpy.ops.angen.day_leave() == {"FINISHED"}
    assert not scene.angen_day.before and not scene.angen_day.earlier
    assert bpy.data.objects["Door"].animation_data is None


@pytest.mark.parametrize("day", ["0001-01-01", "9999-12-30", "9999-12-31"])
def test_a_date_at_the_end_of_the_calendar_is_refused(scene: Any, day: str) -> None:
    scene.angen_day.date = day
    with pytest.raises(RuntimeError, match="First Day: "):
        bpy.ops.angen.day_read()


def test_exports_of_a_shown_activity_have_its_date_and_time(scene: Any, tmp_path: Path) -> None:
    scene.angen_start = "2020-01-01"
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    start = scene.angen_day.done[1].start
    begin = datetime(2026, 3, 2) + timedelta(seconds=(scene.frame_start - 1) / 10)
    assert datetime.fromisoformat(scene.angen_start) == begin
    assert begin == pytest.approx(datetime(2026, 3, 2) + timedelta(seconds=start - 2), abs=SECOND)
    bpy.ops.angen.simulate(frame_end=scene.frame_start + 200)
    bpy.ops.angen.export_events(filepath=str(tmp_path / "events.csv"))
    rows = read_rows(tmp_path / "events.csv")
    assert rows[0]["time_s"] == "0.000000"
    for row in rows:
        elapsed = timedelta(seconds=float(row["time_s"]))
        assert datetime.fromisoformat(row["time"]) - begin == pytest.approx(elapsed, abs=SECOND)
    bpy.ops.angen.export_format(filepath=str(tmp_path / "casas"), format="casas")
    lines = (tmp_path / "casas.txt").read_text(encoding="utf-8").splitlines()
    assert lines and all(line.startswith("2026-03-02 ") for line in lines)
    bpy.ops.angen.day_leave()
    assert scene.angen_start == "2020-01-01"


def test_esc_leaves_the_day_and_the_shown_activity_as_they_were(
    scene: Any, addon_part: Any
) -> None:
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    reading = addon_part("residents.operators.day").ANGEN_OT_day_read
    enough = addon_part("sensor_logic.progress").Enough
    scene.angen_day.number = 2
    whole = [one.share for one in reading._begin(None, bpy.context) if hasattr(one, "share")]
    assert len(whole) > 50 and whole == sorted(whole) and whole[-1] > 0.9
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    scene.frame_set(scene.frame_start + 50)
    before, told = state(scene), scene.angen_day.told
    for steps in (1, len(whole) // 2, len(whole) - 1):
        work = reading._begin(None, bpy.context)
        for _ in range(steps):
            next(work)
        with pytest.raises(enough):
            work.throw(enough)
        assert np.allclose(state(scene), before, atol=1e-6)
        assert bpy.ops.angen.day_leave.poll() and scene.angen_day.told == told
    assert bpy.ops.angen.day_leave() == {"FINISHED"}


def test_a_time_of_the_day_is_gone_to_exactly(scene: Any) -> None:
    bpy.ops.angen.day_read()
    assert bpy.ops.angen.day_go(time="07:00", person="anna") == {"FINISHED"}
    assert scene.frame_current == 1 + 10 * 7 * 3600 and scene.angen_day.shown == 0
    # Within the shown stretch only the playhead moves.
    scene.angen_day.time = "06:30:12"
    assert bpy.ops.angen.day_go() == {"FINISHED"}
    assert scene.frame_current == 1 + 10 * (6 * 3600 + 1812)
    for wrong in ("noon", "25:00"):
        with pytest.raises(RuntimeError, match=f"'{wrong}' is not a time of day such as 07:00"):
            bpy.ops.angen.day_go(time=wrong)
    bpy.ops.angen.day_leave()


def test_playback_jumps_over_the_time_in_which_nothing_moves(scene: Any, addon_part: Any) -> None:
    still = addon_part("residents.blender.still")
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    rests = json.loads(scene.angen_day.rests)
    (begin, end), rig = rests[0], bpy.data.objects["Adult"]

    def hips() -> Any:
        return np.array(rig.matrix_world @ rig.pose.bones[0].matrix.translation)

    # All that moves in the stretch is outside of the rests, which are most of it.
    assert sum(b - a for a, b in rests) > 0.9 * (scene.frame_end - scene.frame_start)
    places = []
    for frame in (begin, (begin + end) // 2, end):
        scene.frame_set(frame)
        places.append(hips())
    assert np.allclose(places, places[0], atol=1e-6)
    # Whoever scrubs gets each frame, and playback those with movement alone.
    scene.frame_set(begin + 1)
    assert scene.frame_current == begin + 1
    still.play()
    # Skipping frames edits nothing: during playback live sensing does not read all objects anew.
    assert not addon_part("angen_addon.runtime.handlers").has_other_frame_handlers()
    frames = [begin - 1]
    scene.frame_set(frames[0])
    for _ in range(4):
        scene.frame_set(scene.frame_current + 1)
        frames.append(scene.frame_current)
    assert frames == [begin - 1, begin, end, end + 1, end + 2]
    scene.frame_set(end + 1)
    for _ in range(2):
        scene.frame_set(scene.frame_current - 1)
    assert scene.frame_current == begin
    scene.angen_day.skip = False
    scene.frame_set(begin + 1)
    assert scene.frame_current == begin + 1
    scene.angen_day.skip = True
    bpy.ops.angen.day_leave()
    scene.frame_set(begin + 1)
    assert scene.frame_current == begin + 1
    still.stop()
    assert still._jump not in bpy.app.handlers.frame_change_pre


def test_what_is_shown_has_the_light_of_the_day(scene: Any, world: Any) -> None:
    sun = world.link("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.0, (math.radians(60), 0, 0)
    sky = bpy.data.worlds.new("Sky")
    sky.use_nodes, scene.world = True, sky
    strength = sky.node_tree.nodes["Background"].inputs["Strength"]
    site = scene.angen_site
    site.latitude, site.longitude, site.utc_offset = math.radians(59.33), math.radians(18.07), 1
    scene.angen_light_reference = 256
    settings = {"method": "ILLUMINANCE", "engine": "CYCLES", "samples": 16, "update_rate": 10.0}
    world.sensor("LIGHT", "lux", **settings).location = (1.5, 3.0, 1.0)
    world.update()
    actions = set(bpy.data.actions.keys())

    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    begin = scene.frame_start + 20
    track = world.run(scene.frame_start, begin + 20).tracks["lux"]
    assert min(track.value) > 0.0 and len(set(track.value)) > 1
    assert sun.data.energy != 2.0 and strength.default_value != 1.0
    assert bpy.ops.angen.day_leave() == {"FINISHED"}
    assert sun.data.energy == 2.0 and strength.default_value == 1.0
    assert sun.rotation_mode == "XYZ" and sun.rotation_euler.x == pytest.approx(math.radians(60))
    assert set(bpy.data.actions.keys()) == actions and "angen_light_begins" not in scene
    assert sky.node_tree.animation_data is None and sun.animation_data is None


def test_undo_brings_the_home_back_as_it_was(scene: Any) -> None:
    before = state(scene)
    bpy.ops.ed.undo_push(message="made")
    bpy.ops.angen.day_read()
    bpy.ops.ed.undo_push(message="read")
    actions = set(bpy.data.actions.keys())
    bpy.ops.angen.day_show(index=1)
    bpy.ops.ed.undo_push(message="shown")
    assert bpy.context.scene.render.fps == 10 and bpy.ops.angen.day_leave.poll()
    bpy.ops.ed.undo()
    scene, asked = bpy.context.scene, bpy.context.scene.angen_day
    assert np.allclose(state(scene), before, atol=1e-6)
    assert set(bpy.data.actions.keys()) == actions and not bpy.ops.angen.day_leave.poll()
    assert [item.name for item in asked.done] == ["Sleep", "Sit", "Sleep"]
    # Redo shows the stretch again, and it can be left as usual.
    bpy.ops.ed.redo()
    assert bpy.context.scene.render.fps == 10
    assert bpy.ops.angen.day_leave() == {"FINISHED"}
    assert np.allclose(state(bpy.context.scene), before, atol=1e-6)


def test_it_is_left_also_after_the_file_was_opened_again(scene: Any, tmp_path: Path) -> None:
    before = state(scene)
    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shown.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shown.blend"))
    scene = bpy.context.scene
    assert scene.render.fps == 10
    assert bpy.ops.angen.day_leave() == {"FINISHED"}
    assert np.allclose(state(scene), before, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [("date", "monday", "is not a date"), ("text", None, "choose a routine")],
)
def test_what_is_missing_is_told(scene: Any, name: str, value: Any, text: str) -> None:
    setattr(scene.angen_day, name, value)
    with pytest.raises(RuntimeError, match=text):
        bpy.ops.angen.day_read()


def test_panel_command_and_package_have_the_same_seed_unless_told(scene: Any) -> None:
    """The panel lists the day that the command simulated."""
    arguments = ["day", "--routine", "a.toml", "--start", "2026-03-02", "--out", "b"]
    command = parse(arguments, "angen").seed
    package = signature(Home.days).parameters["seed"].default
    panel = scene.angen_day.bl_rna.properties["seed"].default
    assert panel == command == package


def test_the_panel_shows_the_day_and_its_time(scene: Any, addon_part: Any) -> None:
    assert bpy.ops.angen.day_read() == {"FINISHED"}
    sitting = scene.angen_day.done[1]
    assert bpy.ops.angen.day_show(index=1) == {"FINISHED"}
    panel = drawn("ANGEN_PT_day")
    times = [i.time for _, _, i in panel.operators if hasattr(i, "person")]
    assert times == [f"{hour:02d}:00" for hour in range(24)]
    texts = [text for text, _, item in panel.operators if hasattr(item, "index")]
    begin, minutes = hours_minutes(sitting.start), round((sitting.end - sitting.start) / 60)
    assert texts[1] == f"{begin}, {minutes // 60} h {minutes % 60:02d} min: Sit, left"
    # The time of the frame that is shown.
    at = sitting.start - sitting.start % 60 + 60.0
    scene.frame_set(int(1 + 10 * at))
    told = [text for text in drawn("ANGEN_PT_day").labels if text.endswith("Sit (anna)")]
    assert told == [f"{int(at // 3600):02d}:{int(at // 60 % 60):02d}:00.0, Sit (anna)"]


def test_an_activity_has_the_colour_of_its_place_in_the_routine(
    scene: Any, addon_part: Any
) -> None:
    """So that it is the same on all days, whatever is done first."""
    strip = addon_part("residents.panels.strip")
    text = scene.angen_day.text
    lines = '[activity.Never]\ndo = ["lie Bed"]\n' + text.as_string().replace("schema = 1\n", "", 1)
    text.from_string("schema = 1\n" + lines)
    assert bpy.ops.angen.day_read() == {"FINISHED"}
    found = strip.colours_of(scene.angen_day.done)
    order = re.findall(r"^\[activity\.(\w+)\]", text.as_string(), re.MULTILINE)
    assert found and found == {name: strip.COLOURS[order.index(name)] for name in found}


def test_a_tile_of_the_strip_has_the_colours_of_its_hour(addon_part: Any) -> None:
    strip = addon_part("residents.panels.strip")
    red, blue = (200, 0, 0), (0, 0, 200)
    spans = [(0.0, 7.5 * 3600, red), (7.5 * 3600, 7.75 * 3600, blue), (27900.5, 27901.0, red)]

    def row(hour: int) -> list[tuple[int, ...]]:
        return [tuple(pixel) for pixel in strip.hour_pixels(hour, spans)[-1, :, :3].tolist()]

    assert row(6) == [red] * 32
    # An activity of half a second is visible.
    assert row(7) == [red] * 16 + [blue] * 8 + [red] + [strip.NOTHING] * 7
    assert row(8) == [strip.NOTHING] * 32
    # The numbers of the hours differ.
    assert len({strip.hour_pixels(hour, []).tobytes() for hour in range(24)}) == 24


@pytest.fixture
def running(lived_home: Path) -> Any:
    """The settings of a run as `lived` has it."""
    asked = bpy.context.scene.angen_day
    asked.routine, asked.seed, asked.formats = str(lived_home.parent / "week.toml"), 1, {"casas"}
    asked.out, asked.days = str(lived_home.parent / "window"), 2
    return asked


def begun(addon_part: Any) -> Any:
    """A run of days as the window advances it."""
    run = addon_part("residents.operators.day_run").ANGEN_OT_day_run
    stand_in = type("Run", (), {"_work": run._work})()
    return run._begin(stand_in, bpy.context)


@pytest.mark.slow
def test_a_run_in_the_window_writes_what_the_command_writes(
    running: Any, lived: Any, lived_home: Path
) -> None:
    before, actions = state_of_home(), set(bpy.data.actions.keys())
    bpy.context.scene.frame_set(7)
    assert bpy.ops.angen.day_run() == {"FINISHED"}
    assert bpy.context.scene.frame_current == 7
    assert np.allclose(state_of_home(), before, atol=1e-6)
    assert set(bpy.data.actions.keys()) == actions
    made = content(lived_home.parent / "window")
    assert {"events.csv", "activities.csv", "people.csv", "home.toml", "casas.txt"} <= set(made)
    assert made == content(lived(2))
    # It is whole, and changes nothing more.
    assert bpy.ops.angen.day_run() == {"FINISHED"}
    assert content(lived_home.parent / "window") == made


@pytest.mark.slow
def test_esc_keeps_whole_days_or_nothing(running: Any, addon_part: Any, lived: Any) -> None:
    enough, folder = addon_part("sensor_logic.progress").Enough, Path(running.out)
    before = state_of_home()
    # While the home is read nothing is written; in the first day nothing is kept.
    for text, ends in (("floors", True), ("day 1 of 2", False)):
        work = begun(addon_part)
        for step in work:
            if step.text.startswith(text):
                break
        assert folder.exists() != ends
        if ends:
            with pytest.raises(enough):
                work.throw(enough)
        else:
            with pytest.raises(StopIteration) as ended:
                work.throw(enough)
            assert ended.value.value.whole == 0
        work.close()
        assert not folder.exists() and np.allclose(state_of_home(), before, atol=1e-6)
    work = begun(addon_part)
    shares = []
    for step in work:
        shares.append(step.share)
        if step.text.startswith("day 2 of 2"):
            break
    assert shares == sorted(shares) and shares[-1] == pytest.approx(0.53, abs=0.02)
    with pytest.raises(StopIteration) as ended:
        work.throw(enough)
    assert ended.value.value.whole == 1
    work.close()
    assert np.allclose(state_of_home(), before, atol=1e-6)
    assert content(folder)["days/2026-03-02.json"] == content(lived(2))["days/2026-03-02.json"]
    assert {"events.csv", "home.toml"} <= set(content(folder))
    # The same again goes on with the second day.
    assert bpy.ops.angen.day_run() == {"FINISHED"}
    assert content(folder) == content(lived(2))


@pytest.mark.parametrize(
    ("setting", "text"),
    [
        ({"out": "none/there"}, r"Folder: the folder .*none does not exist"),
        ({"out": "."}, r"Folder: .* is not empty and holds no days; give a new folder"),
        ({"routine": ""}, "choose a routine"),
        ({"date": "9999-12-31", "days": 2}, r"First Day: '9999-12-31'|years 1 and 9999"),
    ],
)
def test_what_is_wrong_is_told_before_anything_runs(
    running: Any, lived_home: Path, setting: dict[str, Any], text: str
) -> None:
    before = set(lived_home.parent.rglob("*"))
    for name, value in setting.items():
        setattr(running, name, str(lived_home.parent / value) if name == "out" else value)
    with pytest.raises(RuntimeError, match=text):
        bpy.ops.angen.day_run()
    assert set(lived_home.parent.rglob("*")) == before


def test_an_unreachable_place_is_told_before_anything_is_written(running: Any) -> None:
    bpy.data.objects["Door"].angen_place.use = "NONE"
    with pytest.raises(RuntimeError, match="cannot reach it from"):
        bpy.ops.angen.day_run()
    assert not Path(running.out).exists()


def test_a_shown_activity_is_left_before_days_are_run(running: Any) -> None:
    bpy.ops.angen.day_read()
    assert bpy.ops.angen.day_run.poll()
    bpy.ops.angen.day_show(index=1)
    assert not bpy.ops.angen.day_run.poll()
    bpy.ops.angen.day_leave()
    assert bpy.ops.angen.day_run.poll()
    running.out = ""
    assert not bpy.ops.angen.day_run.poll()


def test_a_view_through_the_camera_stays_while_days_are_run(running: Any, addon_part: Any) -> None:
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    camera, screen = scene.camera, bpy.context.window_manager.windows[0].screen
    spaces = [area.spaces[0] for area in screen.areas if area.type == "VIEW_3D"]
    assert spaces
    for space in spaces:
        space.region_3d.view_perspective = "CAMERA"
    with closing(begun(addon_part)) as work:
        for step in work:
            if step.text.startswith("day 1 of 2"):
                break
        assert scene.camera is None
        for space in spaces:
            assert space.region_3d.view_perspective == "CAMERA" and space.camera == camera
    assert scene.camera == camera
    for space in spaces:
        assert space.region_3d.view_perspective == "CAMERA" and space.camera == camera
        assert not space.use_local_camera


def test_the_timeline_shows_the_frames_of_the_home_again(scene: Any, addon_part: Any) -> None:
    """Timelines of other workspaces follow when these open, as hidden ones cannot be scrolled."""
    window = bpy.context.window_manager.windows[0]

    def first_frames() -> list[float]:
        areas = [area for area in window.screen.areas if area.type == "DOPESHEET_EDITOR"]
        views = [next(r for r in a.regions if r.type == "WINDOW").view2d for a in areas]
        return [view.region_to_view(0, 0)[0] for view in views]

    bpy.ops.angen.day_read()
    bpy.ops.angen.day_show(index=1)
    assert first_frames() and min(first_frames()) > 100_000
    bpy.ops.angen.day_leave()
    assert max(first_frames()) < 48
    hidden = {screen.name for screen in bpy.data.screens} - {window.screen.name}
    assert addon_part("residents.operators.day")._behind == hidden
