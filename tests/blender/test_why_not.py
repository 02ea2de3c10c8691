# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a sensor reports something or nothing, in panels, Explain and the command line."""

import math
import re

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import run_command
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import MEMORY
from bl_ext.user_default.angen_sensors.angen_addon.recording.results import RESULTS
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import all_sensors
from bl_ext.user_default.angen_sensors.angen_addon.view.readings import reading_text
from bl_ext.user_default.angen_sensors.angen_addon.view.timeline.layout import INVALID, spans_of
from light_stage import facing, lamp
from panel_layout import drawn

ops = bpy.ops.angen


def asked(frame):
    """Return the headline and all facts of Explain for the active sensor at a frame."""
    bpy.context.scene.frame_set(frame)
    buttons = [text for text, *_ in drawn("ANGEN_PT_events").operators]
    assert "Why Not Now?" in buttons
    assert ops.explain(now=True) == {"FINISHED"}
    # Long lines are wrapped.
    return " ".join(drawn("ANGEN_PT_events").text.split())


def activate(obj):
    bpy.context.view_layer.objects.active = obj
    return obj


@pytest.fixture
def passing(world):
    """Add a detector with a warm-up of 60 s, and a box that moves in its view at every frame."""
    box = world.box((1, 1, 1), at=(-2, 0, -3), name="Box")
    world.key(box, "location", {1: (-2, 0, -3), 48: (2, 0, -3)})
    world.scene.frame_end = 48
    ops.sensor_add(kind="PIR", preset="HC_SR501_SCAN")
    obj = bpy.context.object
    obj.location, obj.rotation_euler = (0, 0, 0), (0, 0, 0)
    obj.angen_sensor.pir.sweep = "ALL"
    return obj


def test_a_detector_that_warms_up_says_so_everywhere(world, passing):
    assert passing.angen_sensor.pir.warm_up_time == 60.0
    ops.simulate()
    world.scene.frame_set(25)
    panel = drawn("ANGEN_PT_active_sensor")
    assert panel.labels[1] == "Warming up, 59 s left"
    assert "Warm-up" in drawn("ANGEN_PT_table").labels
    text = "Its warm-up time of 60 s is longer than the animation of 2 s, so it reports nothing"
    assert text in panel.text
    ((_, _, button),) = (o for o in panel.operators if o[0] == "Set to 0 s")
    assert asked(25).startswith("0 of 0 events")
    assert "Warming up, 59 s left." in asked(25)
    bpy.ops.wm.context_set_float(data_path=button.data_path, value=button.value)
    assert "outlasts" not in drawn("ANGEN_PT_active_sensor").text
    ops.simulate()
    world.scene.frame_set(40)
    assert drawn("ANGEN_PT_active_sensor").labels[1].startswith("Motion")


def test_a_detector_that_warms_up_is_not_valid_in_window_timeline_and_report(
    world, passing, tmp_path
):
    """The log of a kind without `valid` stays as it is; all else tells one truth."""
    passing.angen_sensor.pir.warm_up_time = 1.0
    ops.simulate()
    name = passing.name
    track = RESULTS.kept(world.scene).recording.tracks[name]
    bad = track.invalid()
    assert bad.any() and any(track.active)
    assert list(bad) == [time < 1.0 for time in track.times]
    for _ in range(2):
        track = RESULTS.kept(bpy.context.scene).recording.tracks[name]
        spans = spans_of(track, 1, 48)
        assert spans.states[0] == INVALID and INVALID not in spans.states[1:]
        assert (spans.starts[0], spans.ends[0]) == (1, 25)
        for frame in (1, 24, 25):
            bpy.context.scene.frame_set(frame)
            (sensor,) = all_sensors(bpy.context.view_layer)
            shown = reading_text(sensor, bpy.context.scene)
            assert shown.problem.startswith("warming up") == (frame < 25)
            assert (shown.icon == "SORTTIME") == (frame < 25)
        ops.export_report(filepath=str(tmp_path / "report.html"))
        cells = re.findall(r"<td[^>]*>([^<]*)</td>", (tmp_path / "report.html").read_text())
        share = np.asarray(track.active)[~bad].mean()
        assert f"{share:.1%}" in cells and f"{bad.mean():.1%}" in cells
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "home.blend"))
    ops.export_events(filepath=str(tmp_path / "events.csv"))
    assert "0.000000,1," in (tmp_path / "events.csv").read_text()


def test_the_command_line_says_so_too(world, passing, capsys, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))

    def run(*arguments):
        capsys.readouterr()
        assert run_command(list(arguments)) == 0
        return capsys.readouterr()

    told = run("simulate", "--events", str(tmp_path / "events.csv")).err
    text = "its warm-up time of 60 s is longer than the animation of 2 s, so it reports nothing"
    assert f"'{passing.name}': {text}" in told
    told = run("explain", "--sensor", passing.name, "--time", "1.5", "--now").out
    assert told.startswith(f"{passing.name}, frame 37 (1.500 s)")
    ignored = "Motion (ignored: warm-up or blocking time): 'Box'"
    assert f"Warming up, 58 s left. {ignored}" in told and "To fire" not in told
    # Its last event is the first update.
    assert "frame 1 (0.000 s)" in run("explain", "--sensor", passing.name, "--time", "1.5").out


def test_a_detector_that_is_blocked_says_so(world, passing):
    pir = passing.angen_sensor.pir
    pir.warm_up_time, pir.hold_time, pir.blocking_time = 0.0, 0.0, 30.0
    # It stops for a while, so that the output goes off, and starts again.
    world.key(
        bpy.data.objects["Box"], "location", {10: (-1, 0, -3), 20: (-1, 0, -3), 48: (2, 0, -3)}
    )
    ops.simulate()
    told = asked(40)
    assert "Blocked after it went off, 29 s left" in told


def test_the_nearest_movement_and_why_it_is_not_seen(world):
    for name, x, z in (("Near", 0.0, -6.0), ("Far", 0.0, -20.0)):
        box = world.box((1, 1, 1), at=(x, 0, z), name=name)
        world.key(box, "location", {1: (x, 0, z), 48: (x + 1, 0, z)})
    world.box((1, 1, 1), at=(0, 3, 0), name="Still")
    obj = activate(world.pir(range_max=4.0))
    ops.simulate()
    assert "'Near', 5.500 m away: beyond the range max of 4 m" in asked(20)
    obj.angen_sensor.pir.range_max = 10.0
    obj.rotation_euler = (0, math.radians(180), 0)
    ops.simulate()
    told = asked(20)
    assert "° beside the detector's axis, while the field of view ends at 60°" in told
    assert "a range must change by more than 0.05 m: the largest change is 0 % of that" in told


def test_what_is_seen_moving_too_little_is_not_called_hidden(world):
    creeping = world.box((1, 1, 1), at=(0, 0, -3), name="Creeping")
    world.key(creeping, "location", {1: (0, 0, -3), 48: (0, 0, -2.5)})
    activate(world.pir())
    ops.simulate()
    told = asked(20)
    assert "'Creeping', 2.298 m away: seen, but the readings change too little" in told
    assert "hidden" not in told


def test_nor_is_who_is_warm_and_too_weak_for_the_threshold(world):
    person = world.box((0.4, 1.7, 0.3), at=(0, 0, -1.8), name="Person")
    world.key(person, "location", {1: (-1.5, 0, -1.8), 48: (1.5, 0, -1.8)})
    person.angen_warmth.use_temperature, person.angen_warmth.temperature = True, 23.0
    world.box((6, 3, 0.1), at=(0, 0, -6), name="Wall")
    activate(world.sensor("PIR", "pir", model="PYROELECTRIC"))
    ops.simulate()
    told = asked(25)
    assert "changed the radiation" in told and "rays now" in told
    assert "'Person', 1.650 m away: seen, but the readings change too little" in told


def test_a_shut_switch_tells_how_far_the_beam_must_be_clear(world):
    world.wall(0.012, name="Flag")
    activate(world.switch())
    ops.simulate()
    told = asked(5)
    assert "the beam must be free up to 0.05 m: 'Flag' blocks it 0.038 m before that" in told


def test_a_pad_tells_what_is_above_it_and_its_threshold(world):
    world.scene.frame_end = 8
    world.box((0.2, 0.2, 0.2), at=(0, 0, 0.3), name="Box").angen_load.mass = 5.0
    ops.sensor_add(kind="PRESSURE")
    pad = bpy.context.object
    pad.location = (0, 0, 0)
    pad.angen_sensor.update_rate = 24.0
    world.update()
    top = max((pad.matrix_world @ v.co).z for v in pad.data.vertices)
    ops.simulate()
    told = asked(4)
    assert f"'Box', by {0.2 - top:.3f} m" in told
    assert "more than 1 N is needed, the reading is 0 % of that" in told


def test_a_dark_light_sensor_tells_its_share_of_the_threshold(world):
    world.scene.angen_luminous_efficacy = 1.0
    source = lamp(world, "POINT", at=(0, 0, 10), energy=100.0 * 4 * math.pi * 100)
    obj = world.sensor(
        "LIGHT", "light", method="ILLUMINANCE", samples=16, update_rate=24.0, threshold=500.0
    )
    obj.matrix_world = facing((0, 0, 1)).tolist()
    obj.rotation_euler = (math.pi, 0, 0)
    activate(obj)
    world.scene.frame_end = 4
    full = source.data.energy
    world.key(source.data, "energy", {1: full, 3: 2 * full}, "CONSTANT")
    ops.simulate()
    assert "more than 500 lx is needed, the reading is 40 % of that" in asked(4)
    # Its reading changed, though not its state: that is an event to count and to jump to.
    world.scene.frame_set(1)
    assert "0 of 1 events passed" in drawn("ANGEN_PT_events").text
    assert ops.event_jump(direction="NEXT") == {"FINISHED"}
    assert world.scene.frame_current == 3


# Explanations as the operator, the panel and the command line show them


def operators(world):
    box = world.box((1, 1, 1), at=(9, 0, -2.0), name="Box")
    world.key(box, "location", {1: (9, 0, -2.0), 10: (0, 0, -2.0), 20: (9, 0, -2)}, "CONSTANT")
    obj = world.pir(rays=1)
    bpy.context.view_layer.objects.active = obj
    return obj


def kept(world, addon_part, obj):
    """Return the panel's text at the playhead."""
    recording = RESULTS.recording(world.scene)
    if recording is None:
        return None
    scene, event_at = world.scene, addon_part("operators.explain").event_at
    index = event_at(recording.tracks[obj.name], scene.frame_current)
    return MEMORY.recall(recording, obj.session_uid, index)


def test_it_is_shown_until_the_playhead_leaves_or_the_scene_changes(world, addon_part):
    obj = operators(world)
    world.update()
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    world.scene.frame_set(10)
    assert kept(world, addon_part, obj) is None
    assert bpy.ops.angen.explain() == {"FINISHED"}
    world.update()
    assert world.scene.frame_current == 10
    found = kept(world, addon_part, obj)
    assert found is not None, "the recording was lost"
    assert "'Box' came in" in found.headline
    assert "Box" in found.as_text()
    world.scene.frame_set(11)
    assert kept(world, addon_part, obj) is None
    world.scene.frame_set(10)
    assert kept(world, addon_part, obj) is found
    world.link("new", bpy.data.objects["Box"].data, (0, 0, -0.5))
    world.update()
    assert kept(world, addon_part, obj) is None


def test_what_the_operator_needs(world):
    def why():
        with pytest.raises(RuntimeError) as error:
            bpy.ops.angen.explain()
        return str(error.value)

    obj = operators(world)
    bpy.context.view_layer.objects.active = bpy.data.objects["Box"]
    world.update()
    assert "active" in why()
    bpy.context.view_layer.objects.active = obj
    assert "Simulate first" in why()


def test_the_command_line_tells_the_same(world, tmp_path, capsys):
    operators(world)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    capsys.readouterr()

    def explain(*arguments):
        status = run_command(["explain", *arguments])
        told = capsys.readouterr()
        return status, told.out, told.err

    status, out, _ = explain("--sensor", "pir", "--time", "0.375", "--quiet")
    assert status == 0
    assert out.splitlines()[0] == "pir, frame 10 (0.375 s)"
    assert "'Box' came in" in out
    status, out, _ = explain("--sensor", "pir", "--time", "0.37", "--quiet")
    assert (status, "first scan" in out) == (0, True)
    status, out, error = explain("--sensor", "pr", "--time", "0.37")
    assert (status, out, "did you mean pir?" in error) == (2, "", True)
    assert explain("--sensor", "pir")[0] == 2
    assert explain("--sensor", "pir", "--time", "-1")[0] == 2
    bpy.data.objects["pir"].angen_sensor.enabled = False
    status, _, error = explain("--sensor", "pir", "--time", "1")
    assert (status, "switched off" in error) == (1, True)
