# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes a new kind through every place that makes, senses, shows, explains or writes sensors.

test_new_kind.py runs this in a copy of the extension that has nothing but the kind added.
"""

import json
import math

import bpy
import numpy as np
import pytest
from panel_layout import PANELS, Layout, drawn

ops = bpy.ops.angen
# By kind: label, number, field of events, name of the main reading, its first and last value.
KINDS = {
    "RANGER": ("Ranger", 90, "near", "distance_m", 3.0, 0.5),
    "INCLINOMETER": ("Inclinometer", 91, "tipped", "tilt_rad", 0.0, 1.0),
}


@pytest.fixture(params=KINDS)
def kind(request):
    return request.param


@pytest.fixture
def sensor(world, kind):
    """Add a sensor above a floor that jumps up to it at frame 20; there the sensor tips over."""
    ops.sensor_add(kind=kind)
    made = bpy.context.object
    made.name, made.location, made.angen_sensor.room = "new", (0, 0, 0), "hall"
    floor = world.box((4, 4, 1), (0, 0, -3.5), name="floor")
    world.key(floor, "location", {1: (0, 0, -3.5), 20: (0, 0, -1.0)}, "CONSTANT")
    if kind == "INCLINOMETER":
        world.key(made, "rotation_euler", {1: (0, 0, 0), 20: (1.0, 0, 0)}, "CONSTANT")
    world.update()
    return made


def parameters_of(obj, kind):
    return getattr(obj.angen_sensor, kind.lower())


def command(addon_part, path, *arguments):
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return addon_part("angen_addon.commands.command_line").run_command(list(map(str, arguments)))


def test_it_is_in_the_enum_and_in_the_menus(world, kind):
    label, number, *_ = KINDS[kind]
    box = world.box((1, 1, 1))
    item = box.angen_sensor.bl_rna.properties["kind"].enum_items[kind]
    assert (item.name, item.value) == (label, number)
    for menu, texts in (
        ("ANGEN_MT_sensor_add", {label, f"{label} on Surface"}),
        ("ANGEN_MT_object_sensor", {f"Make {label}"}),
    ):
        layout = Layout()
        getattr(bpy.types, menu).draw(type("M", (), {"layout": layout}), bpy.context)
        assert texts <= {text for text, *_ in layout.operators}


def test_it_is_added_placed_and_assigned(world, kind):
    assert ops.sensor_add(kind=kind, preset="SHORT") == {"FINISHED"}
    assert len(bpy.context.object.data.polygons) >= 6, "a body, although none was declared"
    assert ops.sensor_place(kind=kind, location=(1, 2, 3), normal=(1, 0, 0)) == {"FINISHED"}
    placed = bpy.context.object
    assert tuple(-placed.matrix_world.col[2].xyz) == pytest.approx((1, 0, 0), abs=1e-6)
    box = world.box((1, 1, 1))
    bpy.context.view_layer.objects.active = box
    assert ops.sensor_assign(kind=kind) == {"FINISHED"}
    assert (box.angen_sensor.kind, box.angen_sensor.update_rate) == (kind, 24.0)


def test_its_reach_can_be_dragged(world, sensor, kind, addon_part):
    gizmos = addon_part("angen_addon.view.gizmos")
    sensor.select_set(True)
    found = gizmos.handles_of(gizmos.sensor_with_handles(bpy.context))
    assert len(found) == (kind == "RANGER")
    for handle in found:
        handle.set(gizmos.sensor_with_handles(bpy.context), 2.0)
        assert parameters_of(sensor, kind).reach == 2.0


def test_panels_and_presets(world, sensor, kind):
    shown = drawn("ANGEN_PT_active_sensor")
    assert {"limit", "update_rate", "room"} <= set(shown.props)
    for panel in PANELS:
        if panel not in ("ANGEN_PT_physics_weight", "ANGEN_PT_sidebar_weight"):
            drawn(panel)
    layout = Layout()
    bpy.types.ANGEN_MT_presets.draw(type("M", (), {"layout": layout}), bpy.context)
    (item,) = [item for text, _, item in layout.operators if text in ("Short ranger", "Touchy")]
    assert ops.preset_apply(preset=item.preset) == {"FINISHED"}
    (name,) = {"RANGER": ("reach",), "INCLINOMETER": ("limit",)}[kind]
    assert getattr(parameters_of(sensor, kind), name) == {"reach": 2.5, "limit": 0.25}[name]


def test_live_and_in_the_viewport(world, sensor, kind, addon_part):
    *_, first, last = KINDS[kind]
    for frame, value in ((1, first), (20, last)):
        world.scene.frame_set(frame)
        assert sensor.angen_sensor.value == pytest.approx(value, abs=1e-5)
        assert sensor.angen_sensor.active == (frame == 20)
    (found,) = world.sensors()
    shown = addon_part("angen_addon.view.readings").reading_text(found, world.scene)
    assert shown.text.startswith(("Near, 0.500 m", "Tipped, 57°"))
    seen = addon_part("angen_addon.view.overlay.picture").DrawnSensors(world.scene)
    seen.follow(world.scene, bpy.context.view_layer, world.update())
    (one,) = seen.seen
    figures = [figure for figure in one.figures if figure.lines]
    lines = np.concatenate([p.reshape(-1, 3) for f in figures for p in f.lines.values()])
    length = np.ptp(lines, axis=0).max()
    assert length == pytest.approx(0.49 if kind == "RANGER" else 0.1, abs=0.04)
    picture = addon_part("angen_addon.view.overlay.picture")
    assert picture.changing_figures(one, shown, 1.0) == []
    assert all(picture.picture(drawn, shown.icon, False) for drawn in figures)


def test_it_is_simulated_kept_and_loaded(world, sensor, kind, tmp_path, addon_part):
    *_, reading, first, last = KINDS[kind]
    assert ops.simulate() == {"FINISHED"}
    results = addon_part("angen_addon.recording.results").RESULTS
    track = results.recording(world.scene).tracks["new"]
    assert len(track) == 48
    assert list(track.columns[reading])[:20] == pytest.approx([first] * 19 + [last], abs=1e-5)
    history = addon_part("angen_addon.view.timeline.layout")
    rows = history.history_of(results.recording(world.scene), world.sensors()).rows
    assert [row.name for row in rows] == ["new"] and list(rows[0].spans.starts) == [1.0, 20.0]
    layout = addon_part("angen_addon.view.timeline.layout")
    view = layout.TimelineRegion(400, 0.0, 40.0, 1.0, 1.0, 48.0)
    made = history.history_of(results.recording(world.scene), world.sensors())
    assert layout.strips(made, view, frozenset()).quads
    assert ops.bake_keyframes() == {"FINISHED"}
    path = tmp_path / "home.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert bpy.data.objects["new"].angen_sensor.kind == kind
    bpy.context.view_layer.update()
    again = results.recording(bpy.context.scene)
    assert again is not None and list(again.tracks["new"].columns[reading]) == list(
        track.columns[reading]
    )


def test_it_is_logged_listed_explained_and_reported(
    world, sensor, kind, tmp_path, addon_part, capsys
):
    label, _, field, reading, *_ = KINDS[kind]
    path, samples = tmp_path / "home.blend", tmp_path / "samples"
    report, log = tmp_path / "report.html", tmp_path / "events.csv"
    assert command(addon_part, path, "simulate", "--events", log, "--samples", samples) == 0
    rows = [line.split(",") for line in log.read_text().splitlines()]
    assert [row[5] for row in rows if row[4] == field] == ["0", "1"]
    head = (samples / "new.csv").read_text().splitlines()[0]
    assert head == f"time_s,frame,{reading},{field}"
    capsys.readouterr()
    assert command(addon_part, path, "list", "--json") == 0
    out = capsys.readouterr().out
    (told,) = json.loads(out[out.index("[") :])
    assert (told["kind"], told["reading"]["field"]) == (kind, reading)
    assert command(addon_part, path, "explain", "--sensor", "new", "--time", "1.5") == 0
    text = capsys.readouterr().out
    assert ("Near: 0.500 m" in text and "'floor'" in text) or "Tipped: 57°" in text
    assert "Limit" in text
    assert command(addon_part, path, "doctor") in (0, 1)
    assert command(addon_part, path, "simulate", "--report", report, "--quiet") == 0
    page = report.read_text(encoding="utf-8")
    assert label in page and "new" in page


def test_every_format_takes_it(world, sensor, kind, tmp_path, addon_part):
    formats = addon_part("sensor_logic.logs.formats").FORMATS
    for name in formats:
        if name == "parquet":
            continue
        out = tmp_path / name
        done = command(
            addon_part, tmp_path / "home.blend", "simulate", "--format", name, "--out", out
        )
        assert done == 0 and any(tmp_path.glob(f"{name}*")), name


def test_the_plan_has_it(world, sensor, kind, addon_part):
    (storey,) = addon_part("angen_addon.plan.storeys").storeys(world.scene, world.sensors(), 1)
    (placed,) = storey.sensors
    assert placed.name == "new" and math.isfinite(placed.height)
    assert len(placed.beams) == (1 if kind == "RANGER" else 0)


def test_settings_are_copied(world, sensor, kind):
    ops.sensor_add(kind=kind)
    other = bpy.context.object
    parameters_of(sensor, kind).limit = 0.125
    sensor.select_set(True)
    bpy.context.view_layer.objects.active = sensor
    assert ops.copy_to_selected() == {"FINISHED"}
    assert parameters_of(other, kind).limit == 0.125
