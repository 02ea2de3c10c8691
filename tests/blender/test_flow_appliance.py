# SPDX-License-Identifier: GPL-3.0-or-later
"""Water flow sensors and smart plugs in Blender: what they watch, when it is used, and why."""

import csv
import re
from pathlib import Path

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.command_line import run_command
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.layout.apply import apply_layout
from bl_ext.user_default.angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner
from bl_ext.user_default.angen_sensors.angen_addon.runtime.time_base import clock_of
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensor_reader import SensorReader
from day_home import part
from mathutils import Vector
from panel_layout import drawn

PATH = "angen_use.in_use"


def flow(world, name="flow", **settings):
    return world.sensor("FLOW", name, **{"update_rate": 24.0, **settings})


def keyed(world, obj, *changes):
    """Key the use of an object: it changes at each of these frames, and is not used before."""
    frames = {1: False, **{frame: i % 2 == 0 for i, frame in enumerate(changes)}}
    world.key(obj, PATH, frames, "CONSTANT")


def context(examined):
    """Return the present scene as the doctor examines it."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return examined(bpy.context.scene, bpy.context.view_layer, depsgraph)


def rows(world, recording, sensor, field):
    """Return frame and value of each row of a field."""
    log = [row for row in world.log(recording) if row[2] == sensor and row[4] == field]
    return [(float(row[1]), row[5]) for row in log]


def test_a_cistern_fills_after_the_use_and_the_row_says_so(world):
    """6 L at 90 L/min take 4 s, 96 frames; the use ends at frame 30."""
    toilet = world.box((0.4, 0.6, 0.4), name="Toilet")
    keyed(world, toilet, 10, 30)
    flow(world, watched=toilet, flows="AFTER_USE", flow_rate=90.0)
    world.scene.frame_end = 200
    recording = world.run()
    assert rows(world, recording, "flow", "flowing") == [(1.0, "0"), (30.0, "1"), (126.0, "0")]
    measured = world.series(recording, "flow", "flow_lpm")
    assert sum(measured) / 24.0 / 60.0 == pytest.approx(6.0)


def test_a_plug_publishes_power_by_the_report_step(world):
    stove = world.box((0.6, 0.6, 0.9), name="Stove")
    keyed(world, stove, 10, 30)
    world.sensor(
        "APPLIANCE", "plug", update_rate=24.0, watched=stove, load="STOVE", report_step=1.0
    )
    recording = world.run(1, 60)
    assert rows(world, recording, "plug", "on") == [(1.0, "0"), (10.0, "1")]
    assert rows(world, recording, "plug", "power_w") == [(1.0, "0"), (10.0, "1500")]


def test_without_a_choice_it_watches_its_parent(world):
    sink = world.box((0.6, 0.6, 0.9), name="Sink")
    keyed(world, sink, 5, 9)
    sensor = flow(world)
    sensor.parent = sink
    recording = world.run(1, 20)
    assert rows(world, recording, "flow", "flowing") == [(1.0, "0"), (5.0, "1"), (9.0, "0")]
    bpy.context.view_layer.objects.active = sensor
    assert any("parent, 'Sink'" in text for text in drawn("ANGEN_PT_active_sensor").labels)


def test_live_reads_what_a_run_reads(world):
    toilet = world.box((0.4, 0.6, 0.4), name="Toilet")
    keyed(world, toilet, 8, 9)
    made = flow(world, watched=toilet, flows="AFTER_USE", refill_volume=0.1, update_rate=4.0)
    world.scene.frame_end = 60
    recording = world.run()
    on = dict(zip(recording.tracks["flow"].frames, recording.tracks["flow"].active, strict=True))
    assert any(on.values()) and not all(on.values())
    for frame in range(1, 61):
        world.scene.frame_set(frame)
        if frame in on:
            assert made.angen_sensor.active == on[frame], frame
    # A jump knows what keys tell of before.
    for frame in (37, 13, 55, 7, 25, 1):
        world.scene.frame_set(frame)
        assert made.angen_sensor.active == on[frame], frame


def test_a_run_of_later_frames_knows_what_was_used_before(world):
    tap = world.link("Tap", None)
    keyed(world, tap, 8, 20)
    flow(world, watched=tap, flows="AFTER_USE", refill_volume=0.2)
    world.sensor("APPLIANCE", "tv", update_rate=24.0, watched=tap, load="TELEVISION")
    whole = world.run(1, 80)
    assert rows(world, whole, "flow", "flowing") == [(1.0, "0"), (20.0, "1"), (68.0, "0")]
    part = world.run(30, 80)
    assert rows(world, part, "flow", "flowing") == [(30.0, "1"), (68.0, "0")]
    assert rows(world, part, "tv", "on") == [(30.0, "1")]


@pytest.mark.parametrize("how", ["repeated", "stepped", "ramps"])
def test_a_jump_knows_a_use_that_changes_between_its_keys(world, how, fcurves):
    tap = world.link("Tap", None)
    keyed(world, tap, 9, 21)
    (curve,) = fcurves(tap)
    if how == "repeated":
        curve.modifiers.new("CYCLES")
    elif how == "stepped":
        curve.modifiers.new("STEPPED").frame_step = 5
    else:
        # A curve that a script makes: use ends right after the key at which it has begun.
        action = tap.animation_data.action
        held = getattr(action, "fcurves", None)
        if held is None:
            held = action.layers[0].strips[0].channelbags[0].fcurves
        held.remove(curve)
        curve = held.new(PATH)
        for frame, value in ((1, 0), (20, 1), (60, 0)):
            curve.keyframe_points.insert(frame, value).interpolation = "LINEAR"
    made = flow(world, watched=tap, flows="AFTER_USE", refill_volume=0.1)
    world.scene.frame_end = 60
    recording = world.run()
    on = dict(zip(recording.tracks["flow"].frames, recording.tracks["flow"].active, strict=True))
    assert any(on.values()) and not all(on.values())
    for frame in range(60, 0, -7):
        world.scene.frame_set(frame)
        assert made.angen_sensor.active == on[frame], frame


def test_substeps_resolve_a_use_within_a_frame(world):
    tap = world.link("Tap", None)
    world.key(tap, PATH, {1: False, 10.25: True, 10.75: False}, "CONSTANT")
    flow(world, watched=tap, update_rate=96.0)
    assert rows(world, world.run(1, 20), "flow", "flowing") == [(1.0, "0")]
    world.scene.angen_substeps = 4
    found = rows(world, world.run(1, 20), "flow", "flowing")
    assert found == [(1.0, "0"), (10.25, "1"), (10.75, "0")]


def test_a_driver_can_say_what_is_in_use(world):
    tap, handle = world.link("Tap", None), world.link("Handle", None)
    world.key(handle, "location", {1: (0, 0, 0), 11: (0, 0, 1)}, "LINEAR")
    driver = tap.driver_add(PATH).driver
    driver.type = "SUM"
    target = driver.variables.new().targets[0]
    target.id, target.data_path = handle, "location.z"
    flow(world, watched=tap)
    found = rows(world, world.run(1, 20), "flow", "flowing")
    assert found[0] == (1.0, "0") and found[-1][1] == "1" and len(found) == 2


def test_what_nobody_uses_costs_no_reading_of_the_scene(world, monkeypatch):
    moving = world.box((1, 1, 1), (5, 0, 0), "moving")
    world.key(moving, "location", {1: (5, 0, 0), 60: (9, 0, 0)})
    flow(world, watched=world.box((0.4, 0.6, 0.4), name="Toilet"))
    sensor = world.sensors()[0]
    runner = SensorRunner(sensor, clock_of(world.scene))
    assert not runner.senses_between
    read, times = SensorReader.read, []

    def noted(self, *given):
        times.append(given)
        return read(self, *given)

    monkeypatch.setattr(SensorReader, "read", noted)
    recording = world.run(1, 60)
    assert rows(world, recording, "flow", "flowing") == [(1.0, "0")]
    assert len(times) < 5


def test_what_is_in_use_all_the_time_flows(world):
    tap = world.link("Tap", None)
    tap.angen_use.in_use = True
    flow(world, watched=tap)
    assert rows(world, world.run(1, 20), "flow", "flowing") == [(1.0, "1")]


def test_an_edit_of_the_use_makes_the_recording_stale(world, addon_part):
    tap = world.link("Tap", None)
    flow(world, watched=tap)
    assert bpy.ops.angen.simulate() == {"FINISHED"}
    results = addon_part("angen_addon.recording.results").RESULTS
    bpy.context.view_layer.update()
    assert results.recording(world.scene) is not None
    tap.angen_use.in_use = True
    bpy.context.view_layer.update()
    assert results.recording(world.scene) is None


def test_renamed_it_still_counts_and_removed_it_is_named_as_lacking(world, addon_part):
    tap = world.box((0.1, 0.1, 0.1), name="Tap")
    keyed(world, tap, 5, 9)
    made = flow(world, watched=tap)
    tap.name = "Mixer"
    recording = world.run(1, 20)
    (sensor,) = world.sensors()
    assert "Flowing: 'Mixer' is in use" in explain(world.scene, sensor, recording, 6).headline
    assert "No flow: 'Mixer'" in explain(world.scene, sensor, recording, 12).headline
    bpy.data.objects.remove(tap)
    recording = world.run(1, 20)
    assert rows(world, recording, "flow", "flowing") == [(1.0, "0")]
    (sensor,) = world.sensors()
    assert "watches no object" in explain(world.scene, sensor, recording, 12).headline
    bpy.context.view_layer.objects.active = made
    assert any("watches no object" in text for text in drawn("ANGEN_PT_active_sensor").labels)
    examined = addon_part("angen_addon.doctor.examined").Examined
    doctor = addon_part("angen_addon.doctor.sensors")
    (text, mend, *_), *_ = list(doctor.watches_nothing(context(examined)))
    assert "'flow' watches no object" in text and "Watches" in mend


def test_no_use_at_all_is_a_line_of_the_doctor(world, addon_part):
    tap = world.box((0.1, 0.1, 0.1), name="Tap")
    flow(world, watched=tap)
    examined = addon_part("angen_addon.doctor.examined").Examined
    doctor = addon_part("angen_addon.doctor.sensors")

    def found():
        return [text for text, *_ in doctor.watches_nothing(context(examined))]

    assert found() == ["Nothing keys whether 'Tap' is in use: 'flow' always reads the same"]
    keyed(world, tap, 5)
    assert found() == []
    # A place of residents is used in days.
    tap.animation_data_clear()
    tap.angen_place.use = "TAP"
    assert found() == []


def test_a_hidden_object_that_is_watched_is_named(world, addon_part):
    tap = world.box((0.1, 0.1, 0.1), name="Tap")
    keyed(world, tap, 5, 9)
    flow(world, watched=tap)
    tap.hide_viewport = True
    bpy.context.view_layer.update()
    examined = addon_part("angen_addon.doctor.examined").Examined
    ((text, *_),) = addon_part("angen_addon.doctor.sensors").watches_nothing(context(examined))
    assert "'flow': 'Tap' is disabled in viewports" in text
    with pytest.raises(addon_part("sensor_logic.logs.error").AngenError, match="'Tap' is disabled"):
        world.run(1, 20)


def test_a_watched_object_that_was_deleted_in_the_window_is_named_so(world, addon_part):
    """Its sensor keeps it in the file, without a collection."""
    tap = world.box((0.1, 0.1, 0.1), name="Tap")
    keyed(world, tap, 5, 9)
    flow(world, watched=tap)
    for collection in tap.users_collection:
        collection.objects.unlink(tap)
    bpy.context.view_layer.update()
    examined = addon_part("angen_addon.doctor.examined").Examined
    ((text, *_),) = addon_part("angen_addon.doctor.sensors").watches_nothing(context(examined))
    assert "'flow': 'Tap' is in no collection of this view layer" in text
    with pytest.raises(addon_part("sensor_logic.logs.error").AngenError, match="no collection"):
        world.run(1, 20)


def test_live_readings_of_others_go_on_where_a_watched_object_is_hidden(world):
    tap, stove = world.box((0.1, 0.1, 0.1), name="Tap"), world.link("Stove", None)
    keyed(world, tap, 5, 9)
    keyed(world, stove, 5, 9)
    made, plug = flow(world, watched=tap), world.sensor("APPLIANCE", "plug", watched=stove)
    plug.angen_sensor.update_rate = 24.0
    tap.hide_viewport = True
    world.scene.frame_set(6)
    assert plug.angen_sensor.active
    problems = part("angen_addon.runtime.live").live_of(world.scene).problems
    assert "'Tap' is disabled in viewports" in problems["flow"] and list(problems) == ["flow"]
    tap.hide_viewport = False
    world.scene.frame_set(7)
    assert made.angen_sensor.active


def test_nothing_is_said_of_where_plugs_and_water_meters_look(world, addon_part):
    """They are beside a wall or pipe, and see nothing."""
    wall = world.box((2.0, 2.0, 0.2), (0, 0, -0.15), "wall")
    flow(world, watched=wall)
    world.sensor("APPLIANCE", "plug", watched=wall)
    world.pir()
    examined = addon_part("angen_addon.doctor.examined").Examined
    found = addon_part("angen_addon.doctor.sensors").faces_a_wall(context(examined))
    assert [names[0] for _, _, names, *_ in found] == ["pir"]


@pytest.mark.parametrize(
    ("page", "target", "values"),
    [
        ("flow", "Toilet", {"flows": "AFTER_USE", "refill_volume": 6.0, "min_flow": 0.0}),
        ("appliance", "Washing machine", {"load": "WASHING_MACHINE", "max_power": 2500.0}),
    ],
)
def test_the_layout_of_a_page_makes_its_sensor(world, tmp_path, page, target, values):
    text = Path(__file__).resolve().parents[2].joinpath("docs", f"{page}.md").read_text("utf-8")
    (layout,) = re.findall(r"```json\n(.*?)```", text, re.DOTALL)
    (tmp_path / "layout.json").write_text(layout)
    watched = world.box((0.5, 0.5, 0.5), name=target)
    apply_layout(tmp_path / "layout.json", False)
    (sensor,) = world.sensors()
    assert sensor.parameters.watched == watched
    assert {name: getattr(sensor.parameters, name) for name in values} == values
    # The housing is that of the kind, not a cube of 30 mm.
    assert max(sensor.object.dimensions) == pytest.approx(0.062 if page == "flow" else 0.07)


ROUTINE = """
schema = 1
[person.anna]
resident = "Anna"
begins = "Rest"
[activity.Rest]
do = ["stand at Spot"]
[activity.Toilet]
do = ["sit Toilet 2 min", "use Sink 20 s", "stand at Spot"]
[[plan]]
person = "anna"
entries = [
  { at = "08:00", activity = "Toilet", lasts = "10 min" },
  { at = "08:20", activity = "Rest", until = "07:00" },
]
"""


@pytest.mark.slow
def test_a_day_flushes_after_the_toilet_and_names_who_used_it(world, tmp_path, capsys):
    world.hall(5.0, 4.0, 2.6)
    toilet = world.box((0.45, 0.45, 0.45), (4.3, 0.5, 0.225), "Toilet")
    sink = world.box((0.5, 0.5, 0.9), (0.5, 3.5, 0.45), "Sink")
    world.link("Spot", None, (3.0, 2.5, 0.0)).angen_place.use = "STAND"
    add = part("residents.blender.settings").add_resident
    adult = part("residents.body.skeleton").Sort.ADULT
    add(bpy.context, adult, Vector((2.0, 1.5, 0.0)), 0.0).name = "Anna"
    world.update()
    toilet.angen_place.use, toilet.angen_place.facing = "SIT", -np.pi / 2
    sink.angen_place.use = "TAP"
    world.sensor("FLOW", "flush", update_rate=1.0, watched=toilet, flows="AFTER_USE")
    world.sensor("FLOW", "tap", update_rate=1.0, watched=sink)
    world.sensor("APPLIANCE", "plug", update_rate=1.0, watched=sink, load="KETTLE")
    world.update()
    (tmp_path / "week.toml").write_text(ROUTINE)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    given = ["day", "--routine", tmp_path / "week.toml", "--start", "2026-03-02", "--quiet"]
    assert run_command([str(text) for text in [*given, "--out", tmp_path / "days"]]) == 0
    assert capsys.readouterr().err == ""
    with open(tmp_path / "days" / "events.csv", newline="") as file:
        found = {}
        for row in list(csv.DictReader(file)):
            second = np.datetime64(row["time"], "s") - np.datetime64("2026-03-02T08:00:00")
            key = row["sensor"], row["field"]
            found.setdefault(key, []).append((second.astype(int), row["value"], row["person"]))
    (_, off, _), (flushed, on, who), (full, off_again, _) = found["flush", "flowing"]
    assert (off, on, off_again, who) == ("0", "1", "0", "anna")
    # 2 min after who sat down, and until 6 L are in at 6 L a minute.
    assert 120 <= flushed < 150 and full - flushed == 60
    (_, _, _), (opened, _, who), (shut, _, _) = found["tap", "flowing"]
    # The time at the tap is drawn.
    assert opened > flushed and 5 <= shut - opened <= 80 and who == "anna"
    (_, _, _), (boils, _, who), (done, _, _) = found["plug", "on"]
    assert boils == shut and done - boils == 170 and who == "anna"
