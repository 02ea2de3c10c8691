# SPDX-License-Identifier: GPL-3.0-or-later
"""The source and age of shown readings: recorded, live or baked."""

from importlib import import_module
from types import SimpleNamespace

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import handlers
from bl_ext.user_default.angen_sensors.angen_addon.runtime.live import known_live
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import simulate
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import all_sensors
from bl_ext.user_default.angen_sensors.angen_addon.view import readings
from bl_ext.user_default.angen_sensors.angen_addon.view.readings import reading_text
from bl_ext.user_default.angen_sensors.operators.simulate import ANGEN_OT_simulate
from bl_ext.user_default.angen_sensors.sensor_logic.progress import Enough
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording

ADDON = "bl_ext.user_default.angen_sensors"
ops = bpy.ops.angen


def part(name):
    return import_module(f"{ADDON}.{name}")


def results():
    return part("angen_addon.recording.results").RESULTS


def told(name="Front door"):
    """Return the text of panels, table and overlay on a sensor."""
    sensors = all_sensors(bpy.context.view_layer)
    (sensor,) = (s for s in sensors if s.name == name)
    return reading_text(sensor, bpy.context.scene)


def sensor():
    return bpy.data.objects["Front door"]


def leaf():
    return bpy.data.objects["door"]


@pytest.fixture
def door(world):
    """Add a switch at 1 Hz, and a door at 24 frames a second, open from frame 13 to 37."""
    obj = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.02), name="door")
    world.key(obj, "location", {1: (0, 0, -0.02), 13: (1, 0, -0.02), 37: (0, 0, -0.02)}, "CONSTANT")
    world.switch("Front door", update_rate=1.0)
    world.scene.frame_end = 72
    world.update()
    bpy.ops.ed.undo_push(message="door")
    return world


# Age


def test_an_old_reading_says_how_old_it_is(door):
    """At frame 48 the door has been shut for half a second; the switch updated at frame 25."""
    ops.simulate()
    door.scene.frame_set(25)
    assert told().text.startswith("Open") and "ago" not in told().text
    door.scene.frame_set(48)
    assert told().text.startswith("Open") and told().text.endswith(", 1.0 s ago")
    assert told().origin == "Recorded at frame 25"
    door.scene.frame_set(49)
    assert told().text.startswith("Closed") and "ago" not in told().text


# Live


def test_no_live_reading_is_of_a_later_frame(door):
    """Scrubbed back between two updates: the reading of frame 20 is of an open door."""
    door.scene.frame_set(20)
    assert told().text.startswith("Open")
    door.scene.frame_set(5)
    assert told().text.startswith("Closed") and told().origin == "Live, read at frame 5"
    assert not sensor().angen_sensor.active
    door.scene.frame_set(12)
    assert told().origin == "Live, read at frame 5", "forwards the same update stands"


def test_the_extensions_own_playback_is_no_edit_for_live_sensors(door):
    live, scene = part("angen_addon.runtime.live").live_of(door.scene), door.scene

    def edits():
        before = live.edits
        for frame in range(3, 8):
            scene.frame_set(frame)
        return live.edits - before

    scene.frame_set(2)
    for started in bpy.app.handlers.animation_playback_pre:
        started(scene)
    assert edits() == 0, "the scene is read anew at each frame of playback"
    for ended in bpy.app.handlers.animation_playback_post:
        ended(scene)

    def meddles(*_):
        pass

    bpy.app.handlers.frame_change_post.append(meddles)
    try:
        assert edits() > 0, "another extension's handler may have moved anything"
    finally:
        bpy.app.handlers.frame_change_post.remove(meddles)


def test_an_edit_makes_live_readings_old(door):
    door.scene.frame_set(20)
    assert told().text.startswith("Open") and told().icon == readings.ACTIVE
    leaf().location = (0, 0, -0.02)
    door.update()
    assert told().text.endswith(", old") and told().icon == readings.OLD
    assert "edited after" in told().old
    door.scene.frame_set(20)
    assert told().old == ""


def rest():
    """Follow the scene as if the playhead and the user had come to rest in a window."""
    for _ in range(20):
        handlers._shown_at = 0.0
        if handlers._sense_at_rest() is None:
            return
    raise AssertionError("it never comes to rest")


def test_an_edit_is_sensed_once_the_user_rests(door):
    door.scene.frame_set(20)
    leaf().location = (0, 0, -0.02)
    door.update()
    rest()
    assert told().text == "Closed, 0.015 m" and told().old == ""
    assert not sensor().angen_sensor.active and not known_live().outdated
    assert leaf().location.x == 0, "the frame is not set anew"


def test_an_edit_beside_a_recording_that_it_makes_stale_is_sensed(door):
    """Values are then shown as live."""
    ops.simulate()
    door.scene.frame_set(1)
    rest()
    assert told().recorded
    leaf().animation_data_clear()
    leaf().location = (5, 0, 0)
    door.update()
    rest()
    assert told().text.startswith("Open") and told().origin == "Live, read at frame 1"


def test_light_is_not_measured_after_each_edit(door):
    """It takes long: the reading is old until the playhead has moved."""
    light = door.sensor("LIGHT", "light", samples=16)
    door.box((9, 9, 9), name="room")
    door.update()
    door.scene.frame_set(20)
    rest()
    before = told("light")
    assert before.text.startswith("Dark") and before.old == ""
    leaf().location.y = 3
    door.update()
    rest()
    assert told("light").text == f"{before.text}, old" and "move the playhead" in told("light").old
    assert told().old == ""
    leaf().location.y = 4
    door.update()
    rest()
    assert told("light").text == f"{before.text}, old"
    door.scene.frame_set(21)
    rest()
    assert told("light").old == ""
    light.angen_sensor.light.method = "ILLUMINANCE"
    assert told("light").text == "No reading", "percent are not told as lux"


def edit(scale):
    leaf().scale.x = scale
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="edit")


@pytest.fixture
def lit(door):
    """Add two light sensors to the door, and a room around it, at frame 20."""
    for name in ("light", "other"):
        door.sensor("LIGHT", name, samples=16)
    door.box((9, 9, 9), name="room")
    door.update()
    door.scene.frame_set(20)
    bpy.ops.ed.undo_push(message="before")
    return door


@pytest.mark.parametrize("recorded", [False, True], ids=["", "recorded"])
def test_light_is_measured_also_after_an_edit_an_undo_and_an_edit(lit, recorded):
    """No light sensor waits without end: none was measured before."""
    if recorded:
        ops.simulate(without_light=True)
        bpy.ops.ed.undo_push(message="recorded")
    edit(2)
    bpy.ops.ed.undo()
    edit(3)
    rest()
    assert told("light").text == told("other").text == "Dark, 0.0 %"
    assert told("light").old == told("other").old == ""


def test_light_that_was_measured_is_shown_as_old_after_undo(lit):
    """To measure it after each edit takes too long: it says what to press."""
    rest()
    assert told("light").text == "Dark, 0.0 %" and told("light").old == ""
    edit(2)
    bpy.ops.ed.undo()
    assert told("light").text == "Dark, 0.0 %, old"
    for act in (rest, lambda: edit(3), rest, bpy.ops.ed.undo, rest):
        act()
        assert told("light").text == "Dark, 0.0 %, old"
    assert "Measure Now" in told("light").old


def test_a_light_sensor_without_a_reading_is_measured_once_the_user_rests(lit):
    """Where others keep an old reading: it is new, or measures otherwise than before."""
    rest()
    lit.sensor("LIGHT", "new", samples=16)
    named = bpy.data.objects["other"].angen_sensor.light
    named.method = "ILLUMINANCE"
    lit.update()
    rest()
    assert told("light").text == "Dark, 0.0 %, old"
    assert told("new").text == "Dark, 0.0 %" and told("new").old == ""
    assert told("other").text == "Dark, 0 lx" and told("other").old == ""


def test_after_undo_live_values_are_there_again(lit):
    """Nothing is recorded; light that was measured is there once the playhead has moved."""
    rest()
    edit(2)
    bpy.ops.ed.undo()
    rest()
    assert told().fields is not None and told().old == ""
    assert "move the playhead" in told("light").old
    bpy.context.scene.frame_set(21)
    rest()
    assert told("light").old == ""


def test_before_the_start_nothing_is_read(door):
    door.scene.frame_start = 10
    door.scene.frame_set(12)
    assert told().fields is not None
    door.scene.frame_set(5)
    assert told().text == "No reading" and "before the scene's first frame" in told().old


def test_an_opened_file_shows_what_is_recorded(door, tmp_path):
    """The file was saved with the outputs of another frame, as after a run without a window."""
    door.scene.frame_set(20)
    ops.simulate()
    sensor().angen_sensor.active, sensor().angen_sensor.value = False, 7.0
    path = str(tmp_path / "a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    assert told().recorded and told().text.startswith("Closed, 0.015 m")
    assert sensor().angen_sensor.value == pytest.approx(0.015), "drivers read the same"
    assert results().kept(bpy.context.scene).stale == "", "showing it is no edit"


# Baked keys


def test_baked_keys_never_pose_as_live_values(door):
    """After the bake the door is moved away for good: it is open, whatever the keys say."""
    ops.simulate()
    ops.bake_keyframes()
    door.scene.frame_set(1)
    assert told().recorded and told().text == "Closed, 0.015 m"
    leaf().animation_data_clear()
    leaf().location = (5, 0, 0)
    door.update()
    assert told().text == "Baked: Closed, 0.015 m" and told().icon == readings.BAKED
    assert told().short == "Baked: Closed" and "scrub" in told().old
    door.scene.frame_set(1)
    assert told().text.startswith("Open") and told().origin == "Live, read at frame 1"
    assert told().keys == "Closed, 0.015 m", "they stand beside, as drivers read them"
    assert not sensor().angen_sensor.active


def test_unbake_removes_the_keys_and_nothing_else(door, fcurves):
    ops.simulate()
    before = len(bpy.data.actions)
    ops.bake_keyframes()
    assert ops.unbake_keyframes() == {"FINISHED"}
    assert sensor().animation_data.action is None and len(bpy.data.actions) == before
    assert told().keys == "" and not ops.unbake_keyframes.poll()
    door.key(sensor(), "rotation_euler", {1: (0, 0, 0), 48: (0, 0, 0)})
    action = sensor().animation_data.action
    ops.simulate()
    ops.bake_keyframes()
    ops.unbake_keyframes()
    assert sensor().animation_data.action == action
    assert {c.data_path for c in fcurves(sensor())} == {"rotation_euler"}
    door.scene.frame_set(20)
    assert sensor().angen_sensor.active == told().text.startswith("Open")


def test_unbake_of_the_selected_alone_and_its_undo(door, fcurves, capfd):
    door.switch("Back door").location.x = 9
    door.update()
    ops.simulate()
    ops.bake_keyframes()
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = sensor()
    bpy.ops.ed.undo_push(message="baked")
    assert ops.unbake_keyframes(selected=True) == {"FINISHED"}
    assert "Removed the keyframes of 1 sensor" in capfd.readouterr().out
    assert told().keys == "" and told("Back door").keys
    bpy.ops.ed.undo_push(message="unbaked")
    bpy.ops.ed.undo()
    assert told().keys and len(fcurves(sensor())) == 2


# Clear


# A run that is stopped


def run_of(steps):
    """Return the recording of a run that was left after so many steps."""
    recording = Recording()
    sensors = all_sensors(bpy.context.view_layer)
    run = simulate(bpy.context.scene, sensors, 1, 72, recording)
    for _ in zip(range(steps), run, strict=False):
        pass
    run.close()
    return recording


def stop(recording, early=True):
    """Return the operator's report when Esc, or an error, ends the run that made `recording`."""
    operator, said = ANGEN_OT_simulate, []
    scene = bpy.context.scene
    stub = SimpleNamespace(_recording=recording, _scene_uid=scene.session_uid, _settings={})
    stub.without_light, stub._references = False, {}
    stub._store = lambda context, early: operator._store(stub, context, early)
    stub.report = lambda _, text: said.append(text)
    stub._updates = lambda: operator._updates(stub)
    stub._has_a_frame = lambda: operator._has_a_frame(stub)
    stub._stays = lambda scene: operator._stays(stub, scene)
    stub._keeps_earlier = lambda scene: operator._keeps_earlier(stub, scene)
    operator._finish(stub, bpy.context, early)
    return said


def test_a_stopped_run_takes_no_recording_that_holds(door):
    ops.simulate()
    assert stop(run_of(2)) == ["Stopped: frames 1 to 72 stay recorded"]
    door.scene.frame_set(60)
    assert told().text.startswith("Closed") and told().origin == "Recorded at frame 49"


@pytest.mark.usefixtures("frame_by_frame")
def test_a_stopped_run_is_kept_where_the_recording_is_stale(door):
    ops.simulate()
    sensor().angen_sensor.update_rate = 24.0
    recording = run_of(2)
    updates = len(recording.tracks["Front door"])
    assert 0 < updates < 72
    assert stop(recording) == [
        f"Stopped. Recorded frames 1 to {recording.frame_end}: {updates} updates. "
        "Undo brings back frames 1 to 72"
    ]
    assert results().recording(door.scene) is recording


@pytest.mark.usefixtures("door")
@pytest.mark.parametrize(("last", "early"), [(72, False), (73, True)])
def test_esc_after_the_last_frame_stops_nothing(last, early):
    stub = SimpleNamespace(_recording=run_of(1000), _planned=SimpleNamespace(last=last))
    steps = iter([SimpleNamespace(frame=72.0, share=1.0, doing="")])
    run = ANGEN_OT_simulate._steps(stub, (step for step in steps))
    next(run)
    with pytest.raises(StopIteration) as ended:
        run.throw(Enough)
    assert ended.value.value is early


@pytest.mark.parametrize("early", [True, False])
def test_a_run_that_ends_in_its_first_frame_is_no_recording(door, early):
    """The light of the first frame takes long, and other sensors have read already."""
    recording = run_of(9)
    recording.frame_end = 0
    assert stop(recording, early) == [
        "Stopped before the first frame was done: nothing is recorded"
    ]
    assert results().kept(door.scene) is None


@pytest.mark.parametrize("recorded", [False, True])
def test_esc_during_the_first_picture_of_light_sensors_alone_is_told(door, world, recorded):
    if recorded:
        ops.simulate()
    world.sensor("LIGHT", "light")
    recording = Recording()
    lights = [s for s in all_sensors(bpy.context.view_layer) if s.name == "light"]
    run = simulate(door.scene, lights, 1, 72, recording)
    while not next(run).doing:
        pass
    run.close()
    assert not any(map(len, recording.tracks.values()))
    stays = "the earlier recording stays" if recorded else "nothing is recorded"
    assert stop(recording) == [f"Stopped before the first frame was done: {stays}"]


def test_a_run_in_which_no_sensor_is_on_is_told(door):
    recording = Recording(frame_start=1, frame_end=72)
    assert stop(recording, False) == ["No sensor was on in these frames: nothing is recorded"]


def test_undo_brings_a_cleared_recording_back(door, tmp_path):
    ops.simulate()
    door.scene.frame_set(20)
    before = told()
    bpy.ops.ed.undo_push(message="recorded")
    assert ops.clear_recording() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="clear")
    assert told().text == "No reading" and not ops.clear_recording.poll()
    bpy.ops.ed.undo()
    assert told() == before and results().kept(bpy.context.scene).stale == ""
    assert ops.export_events(filepath=str(tmp_path / "a.csv")) == {"FINISHED"}
    bpy.ops.ed.redo()
    assert results().kept(bpy.context.scene) is None
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert results().kept(bpy.context.scene) is None, "files do not keep it"
    assert ops.simulate() == {"FINISHED"} and told().recorded


@pytest.mark.parametrize(
    ("age", "text"),
    [(0.1, ""), (59.0, "59 s ago"), (59.7, "1 min ago"), (3599.0, "1 h 0 min ago"),
     (9879.0, "2 h 45 min ago"), (-1.0, "at frame 7")],
)  # fmt: skip
def test_an_age_is_in_units_that_are_read_at_once(addon_part, age, text):
    found = addon_part("angen_addon.runtime.playhead").PlayheadReading("", frame=7.0, age=age)
    assert addon_part("angen_addon.view.readings").age_text(found, 0.2) == text
