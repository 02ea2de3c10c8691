# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels and the table of sensors, drawn into a layout that checks all names.

There is no window here: the layout checks that every icon, property, operator and menu exists in
this version of Blender.
"""

import csv
import math
from types import SimpleNamespace

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.appearance.appearance import appearance_of
from bl_ext.user_default.angen_sensors.angen_addon.recording.results import RESULTS
from bl_ext.user_default.angen_sensors.angen_addon.runtime.running import running
from bl_ext.user_default.angen_sensors.operators import show
from bl_ext.user_default.angen_sensors.panels.table import (
    NAME_SHARE,
    _room_for_name,
    sorted_and_filtered,
)
from bl_ext.user_default.angen_sensors.sensor_logic import parameters, progress
from bl_ext.user_default.angen_sensors.sensor_logic.kinds import KINDS
from bl_ext.user_default.angen_sensors.sensor_logic.parameters import specs
from bl_ext.user_default.angen_sensors.sensor_logic.report.facts import figures
from bl_ext.user_default.angen_sensors.sensor_logic.report.svg import shortened
from mathutils import Quaternion, Vector
from panel_layout import PANELS, activate, drawn, pad, pad_under_a_box, panel_of

ops = bpy.ops.angen


@pytest.fixture
def physics(world):
    return pad_under_a_box(world)


# Every kind


@pytest.mark.parametrize("kind", ["PIR", "OPTICAL_SWITCH", "PRESSURE", "LIGHT"])
@pytest.mark.parametrize("name", ["ANGEN_PT_physics", "ANGEN_PT_active_sensor"])
def test_every_used_parameter_is_drawn_once(world, kind, name):
    ops.sensor_add(kind=kind)
    group = getattr(bpy.context.object.angen_sensor, kind.lower())
    specs = parameters.specs(KINDS[kind].parameters)
    expected = [
        name
        for name, spec in specs.items()
        if parameters.is_chosen(group, spec.used_when) and len(spec.choices) != 1
    ]
    found = [name for name in drawn(name).props if name in specs]
    assert sorted(found) == sorted(expected)


def test_sections_name_each_parameter_once():
    for kind in KINDS.values():
        known = specs(kind.parameters)
        names = [name for _, names in appearance_of(kind).sections for name in names]
        assert sorted(names) == (sorted(known) if names else [])


def test_sections_open_and_close(world):
    ops.sensor_add(kind="PRESSURE")
    layout = drawn("ANGEN_PT_physics", opened=False)
    assert [closed for _, closed in layout.sections] == [False, True, True]
    assert len({idname for idname, _ in layout.sections}) == 3
    assert "threshold" not in layout.props


def test_presets_are_in_the_header_with_a_tick(world):
    ops.sensor_add(kind="PRESSURE", preset="FSR_406")
    assert drawn("ANGEN_PT_physics").menus == ["ANGEN_MT_presets"]
    assert drawn("ANGEN_PT_active_sensor").menus == ["ANGEN_MT_presets"]
    layout = drawn("ANGEN_MT_presets")
    assert [text for text, icon, _ in layout.operators if icon == "CHECKMARK"] == ["FSR 406, 10 kΩ"]
    parts = [item.preset for _, _, item in layout.operators if hasattr(item, "preset")]
    assert len(parts) == 10
    for part in parts:
        assert ops.preset_apply(preset=part) == {"FINISHED"}


# Readings


def test_while_a_run_drives_the_frames_no_old_reading_is_shown(physics):
    """The last readings belong to the frame before the run."""
    ops.simulate()
    physics.scene.frame_set(40)
    progress.working = progress.Working("angen.simulate", 0.25, "25 %, about 10 s left")
    try:
        with running():
            assert drawn("ANGEN_PT_table").labels[1] == "–"
            assert "25 %, about 10 s left. Esc ends" in drawn("ANGEN_PT_simulation").text
    finally:
        progress.working = None
    assert drawn("ANGEN_PT_table").labels[1] == "49.1 N"


def test_the_frames_to_simulate_are_those_of_the_preview_range(physics):
    layout = drawn("ANGEN_PT_simulation")
    assert "use_preview_range" in layout.props and "frame_preview_start" not in layout.props
    physics.scene.use_preview_range = True
    layout = drawn("ANGEN_PT_simulation")
    assert {"frame_preview_start", "frame_preview_end"} <= set(layout.props)


def test_the_doctor_tells_what_to_mend(world):
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
    assert "lumens divided by 683" in layout.text
    lamp.data.energy = 1.0
    ops.doctor()
    assert "No problem found" in drawn("ANGEN_PT_doctor").text


def test_sensors_in_instances_have_rows_and_say_what_they_share(world):
    sensor = world.switch("Door")
    made = world.aside("flat", sensor)
    for name in ("A", "B"):
        world.instance(name, made)
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
    assert "This frame is not recorded: live values" in drawn("ANGEN_PT_simulation").text
    physics.scene.angen_live = False
    assert "This frame is not recorded: no values" in drawn("ANGEN_PT_simulation").text
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


def test_what_is_not_valid_says_why(physics):
    ops.simulate()
    physics.scene.frame_set(1)
    layout = drawn("ANGEN_PT_physics")
    assert layout.labels[0] == "Not yet sure, 49.05 N" and layout.icons[0] == "SORTTIME"
    reason = (
        "Not yet sure: three frames in a row are not known. The force is computed as if all "
        "bodies were at rest"
    )
    assert reason in layout.text and "simulate" not in layout.text
    assert not {"QUESTION", "ERROR"} & set(layout.icons)
    readings = drawn("ANGEN_PT_table")
    assert readings.labels[1] == "49.1 N?" and readings.icons[0] == "SORTTIME"


def test_a_live_pad_is_shown_in_full(physics):
    for frame in range(1, 30):
        physics.scene.frame_set(frame)
    layout = drawn("ANGEN_PT_physics")
    reading = ["Pressed, 49.05 N", "Live, read at frame 28", "Pressed By", "box"]
    assert layout.labels[:4] == reading, "forces are known a frame later"
    physics.scene.frame_set(20)
    layout = drawn("ANGEN_PT_physics")
    assert layout.labels[0] == "Not yet sure, 49.05 N" and layout.icons[0] == "SORTTIME"
    assert (
        "The force is computed as if all bodies were at rest. Play the animation, or simulate"
        in layout.text
    )
    pad().angen_sensor.pressure.force_min = 30.0
    physics.scene.frame_set(21)
    layout = drawn("ANGEN_PT_physics")
    assert layout.labels[0] == "Invalid" and layout.icons[0] == "ERROR"
    assert "Pressed By" not in layout.labels


# Drawing


def everything(world):
    """Return all data that a panel could change."""
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


# The table of all sensors


SHOW = 1 << 30


@pytest.fixture
def home(world):
    """Add five sensors in two rooms, and objects that are no sensors."""
    world.wall(0.02)
    world.box((1, 1, 1), (9, 9, 9), name="a box")
    made = [
        (world.switch("Door b", update_rate=24.0), "hall"),
        (world.switch("Door c", update_rate=24.0, threshold=0.01), "kitchen"),
        (world.pir("Motion a", update_rate=24.0), "Hall 2"),
        (world.sensor("LIGHT", "lamp", enabled=False), "hall"),
        (world.switch("odd", update_rate=24.0, threshold=0.9), ""),
    ]
    for obj, room in made:
        if room:
            obj["room"] = room
    world.scene.frame_set(1)
    world.scene.frame_set(2)
    return world


@pytest.mark.parametrize("wide", [240, 320, 420])
def test_names_that_differ_at_the_end_only_differ_in_the_table(wide):
    names = [
        f"Motion detector of the living room, {end}" for end in ("sofa", "door", "east", "west")
    ]
    region = SimpleNamespace(width=wide)
    context = SimpleNamespace(region=region, preferences=bpy.context.preferences)
    room = _room_for_name(context, NAME_SHARE)
    assert len({shortened(name, room, 11.0) for name in names}) == 4
    assert shortened("Door b", room, 11.0) == "Door b"


def table(**settings):
    """Return the names in the table, from top to bottom."""
    chosen = SimpleNamespace(**{"sort": "NAME", "search": "", "reverse": False, **settings})
    objects = list(bpy.context.view_layer.objects)
    flags, places = sorted_and_filtered(objects, bpy.context.scene, chosen, SHOW)
    assert sorted(places) == list(range(len(objects)))
    rows = sorted(zip(places, flags, objects, strict=True), key=lambda row: row[0])
    return [obj.name for _, flag, obj in rows if flag == SHOW]


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        ({}, ["Door b", "Door c", "lamp", "Motion a", "odd"]),
        ({"reverse": True}, ["odd", "Motion a", "lamp", "Door c", "Door b"]),
        ({"sort": "ROOM"}, ["Door b", "lamp", "Motion a", "Door c", "odd"]),
        ({"sort": "KIND"}, ["Motion a", "Door b", "Door c", "odd", "lamp"]),
        # Errors come first: 'odd' can never open, 'Door c' is open, 'lamp' is off.
        ({"sort": "STATE"}, ["odd", "Door c", "Door b", "Motion a", "lamp"]),
    ],
)
def test_sorted(home, settings, expected):
    assert table(**settings) == expected


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("door", ["Door b", "Door c"]),
        ("HALL", ["Door b", "lamp", "Motion a"]),
        ("hall switch", ["Door b"]),
        ("invalid", ["odd"]),
        ("still", ["Motion a"]),
        ("off", ["lamp"]),
        ("attic", []),
    ],
)
def test_search_looks_at_name_room_kind_and_state(home, words, expected):
    assert table(search=words) == expected


def test_show_selects_one(home):
    bpy.data.objects["a box"].select_set(True)
    assert ops.sensor_show(name="Motion a") == {"FINISHED"}
    assert [obj.name for obj in bpy.context.selected_objects] == ["Motion a"]
    assert bpy.context.object.name == "Motion a"
    assert ops.sensor_show(name="odd", extend=True) == {"FINISHED"}
    assert {obj.name for obj in bpy.context.selected_objects} == {"Motion a", "odd"}
    assert bpy.context.object.name == "odd"


def test_show_says_why_not(home):
    with pytest.raises(RuntimeError, match="No sensor of this view layer is called 'a box'"):
        ops.sensor_show(name="a box")
    bpy.data.objects["odd"].hide_set(True)
    before = bpy.context.object
    assert ops.sensor_show(name="odd") == {"CANCELLED"}
    assert bpy.context.object == before
    bpy.data.objects["Door b"].hide_select = True
    assert ops.sensor_show(name="Door b") == {"CANCELLED"}
    home.update()
    bpy.context.view_layer.objects.active = bpy.data.objects["a box"]
    bpy.ops.object.mode_set(mode="EDIT")
    assert not ops.sensor_show.poll()
    bpy.ops.object.mode_set(mode="OBJECT")


def test_a_click_on_a_row_shows_its_sensor(home):
    settings = bpy.context.window_manager.angen_table
    names = [obj.name for obj in bpy.context.view_layer.objects]
    settings.index = names.index("Door c")
    assert bpy.context.object.name == "Door c" and settings.index == names.index("Door c")
    settings.index = names.index("a box")
    assert bpy.context.object.name == "Door c", "that is no row"


def test_the_view_holds_all_that_a_sensor_sees(home):
    sensor = next(s for s in home.sensors() if s.name == "Motion a")
    sensor.object.location = (5, 6, 7)
    home.update()
    middle, radius = show.surroundings(sensor, bpy.context)
    assert tuple(middle) == pytest.approx((5, 6, 5)) and radius == pytest.approx(2.0)
    view = framed(show, middle, radius, region("WINDOW", 0, 1000, 1000))
    # A lens of 36 mm on Blender's 72 mm wide window sees 45° to each side.
    assert view.view_distance == pytest.approx(1.25 * 2.0 * 2**0.5)
    assert view.view_perspective == "PERSP" and view.view_location == middle


def region(kind, x, width, height=1000):
    return SimpleNamespace(type=kind, x=x, width=width, height=height)


def framed(show, middle, radius, *regions):
    """Move the view of an area with these regions to a place; return the view."""
    view = SimpleNamespace(
        view_perspective="CAMERA", view_location=None, view_distance=0.0, view_rotation=Quaternion()
    )
    area = SimpleNamespace(regions=regions)
    space = SimpleNamespace(lens=36.0)
    show.frame_sphere(
        SimpleNamespace(space_data=space, region_data=view, area=area), middle, radius
    )
    return view


def test_what_is_shown_is_beside_the_sidebar(addon_part):
    """The place is in the centre of the part that the sidebar leaves free.

    A quarter of the window is covered: the centre of the rest is an eighth left of the window's.
    The whole sphere fits.
    """
    show, middle = addon_part("operators.show"), Vector((5, 6, 5))
    regions = region("WINDOW", 100, 1000, 800), region("UI", 850, 250, 800)
    view = framed(show, middle, 2.0, *regions)
    to_the_left = (middle - view.view_location).x / view.view_distance
    assert to_the_left == pytest.approx(-0.25), "of tan 45° to the window's edge"
    assert view.view_location.yz == middle.yz
    half = math.atan(0.75)
    assert view.view_distance * math.sin(half) == pytest.approx(1.25 * 2.0)
    # A sidebar beside the window, not over it, covers nothing.
    view = framed(show, middle, 2.0, regions[0], region("UI", 1100, 250, 800))
    assert view.view_location == middle


def test_an_event_is_a_row_of_the_log_everywhere(world, tmp_path):
    """The panel, a jump and the report count the rows of the CSV after the first update."""
    wall = world.box((2, 2, 0.1), at=(0, 0, -1), name="wall")
    world.key(wall, "location", {1: (0, 0, -3), 40: (0, 0, -1)})
    sensor = world.sensor("DISTANCE", "ranger", threshold=2.0)
    bpy.context.view_layer.objects.active = sensor
    world.update()
    assert ops.simulate() == {"FINISHED"}
    path = tmp_path / "events.csv"
    ops.export_events(filepath=str(path))
    with open(path, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["sensor"] == sensor.name]
    begin = rows[0]["time_s"]
    changes = [row for row in rows if row["time_s"] != begin]
    states = [row for row in changes if row["field"] != "distance_m"]
    assert 0 < len(states) < len(changes)
    track = RESULTS.recording(world.scene).track_of(sensor.session_uid)
    assert figures(track).events == len(changes)
    world.scene.frame_set(1)
    panel = drawn("ANGEN_PT_events")
    assert f"0 of {len(changes)} events passed" in panel.text
    assert f"{len(states)} of {len(changes)} shown: changes of state" in panel.text

    def visited():
        world.scene.frame_set(1)
        while ops.event_jump(direction="NEXT") == {"FINISHED"}:
            yield float(world.scene.frame_current)

    assert list(visited()) == sorted({float(row["frame"]) for row in states})
    world.scene.angen_timeline.values = True
    assert list(visited()) == sorted({float(row["frame"]) for row in changes})
    panel = drawn("ANGEN_PT_events")
    assert f"{len(changes)} of {len(changes)} events passed" in panel.text
    assert "shown" not in panel.text


def test_an_event_is_named_in_words_not_by_fields(addon_part):
    """Only the validity of a pad's reading has changed."""
    kind = addon_part("sensor_logic.kinds").KINDS["PRESSURE"]
    columns = {name: [0.0, 0.0] for name in ("pressed", "force_n")}
    columns |= {"partners": ["", ""], "valid": [True, False]}
    track = SimpleNamespace(kind=kind, columns=columns)
    event_name = addon_part("operators.markers").event_name
    assert event_name(track, 1) == "reading not valid"
    assert event_name(track, 0) == "Free, nobody, reading valid"


def test_a_file_without_sensors_is_not_said_to_have_live_values(world):
    assert "live values" not in drawn("ANGEN_PT_simulation").text
    world.pir()
    world.update()
    assert "Not recorded: live values" in drawn("ANGEN_PT_simulation").text
