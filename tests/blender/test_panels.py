# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels show, drawn into a layout that takes down what it is given and checks its names.

There is no window here: that every icon, property, operator and menu exists in this version of
Blender is what the layout below makes sure of.
"""

import bpy
import pytest
from panel_layout import PANELS, activate, drawn, pad, pad_under_a_box, panel_of

ops = bpy.ops.angen


@pytest.fixture
def physics(world):
    return pad_under_a_box(world)


# Every kind


@pytest.mark.parametrize("kind", ["PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT"])
@pytest.mark.parametrize("name", ["ANGEN_PT_physics", "ANGEN_PT_active_sensor"])
def test_every_used_parameter_is_drawn_once(world, addon_part, kind, name):
    ops.sensor_add(kind=kind)
    group = getattr(bpy.context.object.angen_sensor, kind.lower())
    parameters = addon_part("sensor_logic.parameters")
    specs = parameters.specs(addon_part("sensor_logic.kinds").KINDS[kind].parameters)
    expected = [
        name
        for name, spec in specs.items()
        if parameters.is_chosen(group, spec.used_when) and len(spec.choices) != 1
    ]
    found = [name for name in drawn(name).props if name in specs]
    assert sorted(found) == sorted(expected)


def test_sections_name_each_parameter_once(addon_part):
    appearance_of = addon_part("angen_addon.kinds").appearance_of
    for kind in addon_part("sensor_logic.kinds").KINDS.values():
        known = addon_part("sensor_logic.parameters").specs(kind.parameters)
        names = [name for _, names in appearance_of(kind).sections for name in names]
        assert sorted(names) == (sorted(known) if names else [])


def test_a_pad_shows_only_what_the_chosen_resistor_uses(world):
    ops.sensor_add(kind="PRESSURE")
    assert "exponent" not in drawn("ANGEN_PT_physics").props
    bpy.context.object.angen_sensor.pressure.resistor = "POWER_LAW"
    assert {"exponent", "resistance_at_1n"} <= set(drawn("ANGEN_PT_physics").props)


def test_sections_open_and_close(world):
    ops.sensor_add(kind="PRESSURE")
    layout = drawn("ANGEN_PT_physics", opened=False)
    assert [closed for _, closed in layout.sections] == [False, True, True]
    assert len({idname for idname, _ in layout.sections}) == 3
    assert "threshold" not in layout.props


def test_a_mistake_in_the_settings_is_told(world):
    ops.sensor_add(kind="PRESSURE")
    bpy.context.object.angen_sensor.pressure.force_min = 30.0
    layout = drawn("ANGEN_PT_physics")
    assert "Force min (30 N) must be smaller" in layout.text


def test_presets_are_in_the_header_with_a_tick(world):
    ops.sensor_add(kind="PRESSURE", preset="FSR_406")
    assert drawn("ANGEN_PT_physics").menus == ["ANGEN_MT_presets"]
    assert drawn("ANGEN_PT_active_sensor").menus == ["ANGEN_MT_presets"]
    layout = drawn("ANGEN_MT_presets")
    assert [text for text, icon, _ in layout.operators if icon == "CHECKMARK"] == ["FSR 406, 10 kΩ"]
    parts = [item.preset for _, _, item in layout.operators if hasattr(item, "preset")]
    assert len(parts) == 7
    for part in parts:
        assert ops.preset_apply(preset=part) == {"FINISHED"}


# Readings


def test_while_a_run_drives_the_frames_no_old_reading_is_shown(addon_part, physics):
    """The readings that stand are of the frame before the run."""
    ops.simulate()
    physics.scene.frame_set(40)
    cache = addon_part("angen_addon.runtime.state").CACHE
    cache.running, cache.progress = True, 0.25
    try:
        assert drawn("ANGEN_PT_table").labels[1] == "–"
        assert "Esc keeps what is done" in drawn("ANGEN_PT_simulation").text
    finally:
        cache.running = False
    assert drawn("ANGEN_PT_table").labels[1] == "49.1 N"


def test_the_frames_to_simulate_are_those_of_the_preview_range(physics):
    layout = drawn("ANGEN_PT_simulation")
    assert "use_preview_range" in layout.props and "frame_preview_start" not in layout.props
    physics.scene.use_preview_range = True
    layout = drawn("ANGEN_PT_simulation")
    assert {"frame_preview_start", "frame_preview_end"} <= set(layout.props)


def test_the_doctor_tells_what_to_mend(world, addon_part):
    assert [text for text, *_ in drawn("ANGEN_PT_doctor").operators] == [None]
    lamp = world.link("Lamp", bpy.data.lights.new("Lamp", "POINT"), (0, 0, 2))
    world.box((4, 3, 5), name="Room")
    lamp.data.energy = 100.0
    world.sensor("LIGHT", "Light")
    world.update()
    ops.doctor()
    layout = drawn("ANGEN_PT_doctor")
    # Its lines select the lamp.
    lines = [(text, item.index) for text, _, item in layout.operators if text]
    assert "'Lamp' shines with 100 W of light" in " ".join(text for text, _ in lines)
    assert {index for _, index in lines} == {0}
    assert "divide lumens by 683" in layout.text
    lamp.data.energy = 1.0
    ops.doctor()
    assert "Nothing to mend was found" in drawn("ANGEN_PT_doctor").text


def test_sensors_in_instances_have_rows_and_say_what_they_share(world):
    made = bpy.data.collections.new("flat")
    sensor = world.switch("Door")
    world.scene.collection.objects.unlink(sensor)
    made.objects.link(sensor)
    for name in ("A", "B"):
        holder = world.link(name, None)
        holder.instance_type, holder.instance_collection = "COLLECTION", made
    world.update()
    layout = drawn("ANGEN_PT_table")
    assert "In collection instances: 2" in layout.labels
    assert [text for text, *_ in layout.operators if "/" in (text or "")] == ["A/Door", "B/Door"]
    assert "No sensors yet" not in layout.text
    ops.sensor_show(name="B/Door")
    panel = drawn("ANGEN_PT_active_sensor")
    assert panel.labels[0] == "B/Door" and "the same in all instances" in panel.text
    assert "threshold" in panel.props


def test_beyond_the_recording_values_are_said_to_be_live(physics):
    ops.simulate(frame_start=1, frame_end=20)
    physics.scene.frame_set(20)
    assert "live" not in drawn("ANGEN_PT_simulation").text
    physics.scene.frame_set(21)
    assert "This frame is not in it: live values" in drawn("ANGEN_PT_simulation").text
    physics.scene.angen_live = False
    assert "This frame is not in it: no values" in drawn("ANGEN_PT_simulation").text
    pad().location.z += 1.0
    physics.update()
    assert "Live is off: no values are shown" in drawn("ANGEN_PT_simulation").text


def test_events_say_that_the_recording_is_stale_and_the_way_out(physics):
    assert drawn("ANGEN_PT_events").text == "Simulate first"
    ops.simulate()
    assert "events passed" in drawn("ANGEN_PT_events").text
    pad().angen_sensor.pressure.threshold = 3.0
    text = drawn("ANGEN_PT_events").text
    assert "stale" in text and "Simulate again, or undo the change" in text
    for operator in (ops.markers_add, ops.event_jump, ops.export_report):
        with pytest.raises(RuntimeError, match=r"stale.* Simulate again"):
            operator()


def test_a_slow_pyroelectric_detector_gets_a_rate_in_one_click(world):
    ops.sensor_add(kind="PIR", preset="HC_SR501")
    for fps, rate in ((24, 24.0), (30, 30.0), (60, 20.0), (50, 25.0), (12, 20.0)):
        world.scene.render.fps = fps
        bpy.context.object.angen_sensor.update_rate = 10.0
        buttons = [o for o in drawn("ANGEN_PT_active_sensor").operators if "Hz" in str(o[0])]
        ((text, _, item),) = buttons
        assert text == f"Set to {rate:g} Hz" and item.value == rate
        assert item.data_path == "object.angen_sensor.update_rate"
        bpy.ops.wm.context_set_float(data_path=item.data_path, value=item.value)
        assert bpy.context.object.angen_sensor.update_rate == rate
        assert "updates a second" not in drawn("ANGEN_PT_active_sensor").text


def test_a_signal_is_told_in_percent_without_its_sign(addon_part):
    signal = addon_part("sensor_logic.kinds").KINDS["PIR"].fields["signal"]
    assert signal.text(-1.739) == "174 % of threshold"
    assert signal.text(0.5) == "50 % of threshold"


def test_short_readings_are_short(addon_part):
    force = addon_part("sensor_logic.kinds").KINDS["PRESSURE"].fields["force_n"]
    found = [force.short(v) for v in (-0.01, 34.67, 99.94, 99.96, 502.24, float("nan"))]
    assert found == ["0.0 N", "34.7 N", "99.9 N", "100 N", "502 N", "–"]


def test_a_recorded_pad_is_shown_in_full(physics):
    ops.simulate()
    physics.scene.frame_set(40)
    layout = drawn("ANGEN_PT_physics")
    assert layout.labels[0] == "Pressed, 49.05 N" and layout.icons[0] == "RADIOBUT_ON"
    assert layout.labels[1] == "Recorded at frame 40"
    found = dict(zip(layout.labels[2::2], layout.labels[3::2], strict=False))
    assert found["Pressed By"] == "box"
    assert found["Centre"] == "X 2.0 cm, Y 0.0 cm"
    assert found["Resistor"] == "739 Ω"
    assert found["Output"] == "4.66 V, ADC 952"
    assert "ERROR" not in layout.icons and "QUESTION" not in layout.icons
    readings = drawn("ANGEN_PT_table")
    assert readings.labels == ["pad", "49.1 N"]
    assert readings.icons == ["RADIOBUT_ON", "NONE"]
    assert [item.name for _, _, item in readings.operators] == ["pad"], "to show it again"


def test_a_free_pad_names_what_rests_on_it(physics):
    """Its newtons are of something, as the log says."""
    pad().angen_sensor.pressure.threshold = 100.0
    ops.simulate()
    physics.scene.frame_set(40)
    layout = drawn("ANGEN_PT_physics")
    assert layout.labels[0] == "Free, 49.05 N"
    assert layout.labels[2:4] == ["On It", "box"] and "Pressed By" not in layout.labels


def test_what_is_not_valid_says_why(physics):
    ops.simulate()
    physics.scene.frame_set(1)
    layout = drawn("ANGEN_PT_physics")
    assert layout.labels[0] == "Not yet sure, 49.05 N" and layout.icons[0] == "SORTTIME"
    reason = (
        "Not yet sure: three frames in a row are not known. The force is that of bodies at rest"
    )
    assert reason in layout.text and "simulate" not in layout.text
    assert not {"QUESTION", "ERROR"} & set(layout.icons)
    readings = drawn("ANGEN_PT_table")
    assert readings.labels[1] == "49.1 N?" and readings.icons[0] == "SORTTIME"


def test_states_differ_by_word_and_by_icon(addon_part, physics):
    shown = addon_part("panels.readings").shown
    (sensor,) = physics.sensors()
    seen = {}
    ops.simulate()
    for frame in (1, 40):
        physics.scene.frame_set(frame)
        found = shown(sensor, physics.scene)
        seen[found.text.partition(",")[0]] = found.icon
    ops.clear_recording()
    found = shown(sensor, physics.scene)
    seen[found.text.partition(",")[0]] = found.icon
    for frame in range(1, 6):
        physics.scene.frame_set(frame)
    pad().angen_sensor.pressure.threshold = 100.0
    for frame in range(1, 30):
        physics.scene.frame_set(frame)
    found = shown(sensor, physics.scene)
    seen[found.text.partition(",")[0]] = found.icon
    pad().angen_sensor.enabled = False
    found = shown(sensor, physics.scene)
    seen[found.text.partition(",")[0]] = found.icon
    assert set(seen) == {"Not yet sure", "Pressed", "Free", "Off", "No reading"}
    assert len(set(seen.values())) == 5


def test_a_recording_is_believed_before_what_was_live(physics):
    physics.scene.frame_set(20)  # a jump: live readings are not valid
    assert drawn("ANGEN_PT_table").labels[1].startswith("Invalid")
    ops.simulate()
    physics.scene.frame_set(20)
    assert drawn("ANGEN_PT_table").labels[1] == "49.1 N"


def test_a_live_pad_is_shown_in_full(physics):
    for frame in range(1, 30):
        physics.scene.frame_set(frame)
    layout = drawn("ANGEN_PT_physics")
    reading = ["Pressed, 49.05 N", "Live, read at frame 28", "Pressed By", "box"]
    assert layout.labels[:4] == reading, "forces are known a frame later"
    physics.scene.frame_set(20)
    layout = drawn("ANGEN_PT_physics")
    assert layout.labels[0] == "Not yet sure, 49.05 N" and layout.icons[0] == "SORTTIME"
    assert "The force is that of bodies at rest; play on, or simulate" in layout.text
    pad().angen_sensor.pressure.force_min = 30.0
    physics.scene.frame_set(21)
    layout = drawn("ANGEN_PT_physics")
    assert layout.labels[0] == "Invalid" and layout.icons[0] == "ERROR"
    assert "Pressed By" not in layout.labels


# Drawing


def everything(world):
    """What a panel could have changed."""
    groups = [obj.angen_sensor for obj in bpy.data.objects]
    groups += [group.pressure for group in groups] + [obj.angen_load for obj in bpy.data.objects]
    names = [(group, prop.identifier) for group in groups for prop in group.bl_rna.properties]
    values = [(n, str(getattr(group, n)), group.is_property_set(n)) for group, n in names]
    return values, world.scene.frame_current, bpy.context.object.name, ops.clear_recording.poll()


def test_drawing_writes_nothing_and_causes_no_update(physics):
    ops.simulate()
    activate(physics, pad())
    before = everything(physics)
    seen = []

    def noted(*_):
        seen.append(1)

    bpy.app.handlers.depsgraph_update_post.append(noted)
    try:
        for name in PANELS:
            if not hasattr(panel_of(name), "poll") or panel_of(name).poll(bpy.context):
                drawn(name)
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(noted)
    assert seen == []
    assert everything(physics) == before


def test_panels_of_a_scene_without_anything(world):
    assert "No sensors yet" in drawn("ANGEN_PT_table").text
    drawn("ANGEN_PT_simulation")
    for name in ("ANGEN_PT_physics", "ANGEN_PT_active_sensor", "ANGEN_PT_sidebar_weight"):
        assert not panel_of(name).poll(bpy.context)
