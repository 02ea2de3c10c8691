# SPDX-License-Identifier: GPL-3.0-or-later
"""Infrared arrays in scenes: shares of pixels, odd poses, explanations, live and recorded."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.view.readings import reading_text
from bl_ext.user_default.angen_sensors.sensor_logic.heat import HEATS, STEP
from panel_layout import drawn

ops = bpy.ops.angen
ZERO = 273.15
PERSON = 29.0


def warm(obj, celsius, emissivity=0.95):
    settings = obj.angen_warmth
    settings.use_temperature, settings.temperature = True, celsius
    settings.emissivity = emissivity
    return obj


def array(world, name="array", **settings):
    plain = {"update_rate": 24.0, "hold_time": 0.0, **settings}
    return world.sensor("THERMAL_ARRAY", name, **plain)


def frames(world, recording, name="array"):
    texts = world.series(recording, name, "frame_c")
    values = np.array([text.split(";") for text in texts], float)
    side = math.isqrt(values.shape[1])
    return values.reshape(len(texts), side, side) if side**2 == values.shape[1] else values


def looks_like(celsius, emissivity=0.95, share=1.0, ambient=21.0):
    hot, cold = (celsius + ZERO) ** 4, (ambient + ZERO) ** 4
    return (share * emissivity * (hot - cold) + cold) ** 0.25 - ZERO


@pytest.fixture
def room(world):
    world.scene.angen_ambient_temperature = 21.0
    world.wall(4.0, size=20.0)
    return world


def test_a_plate_that_fills_half_of_each_pixel_in_a_row(room, each_caster):
    """The plate ends in the middle of the fourth row from above, in the shape of a band."""
    step = math.tan(math.radians(30)) / 4 * 2.0
    plate = warm(room.box((9, 2.5 * step, 0.001), (0, step * 1.75, -2.0), "plate"), PERSON)
    array(room, rays=64)
    found = frames(room, room.run(1, 1))[0]
    assert found[1:3] == pytest.approx(looks_like(PERSON), abs=0.01)
    assert found[3] == pytest.approx(looks_like(PERSON, share=0.5), abs=0.05 + 8 / 64)
    assert found[4:] == pytest.approx(21.0, abs=0.005)
    plate.location.y *= -1
    assert frames(room, room.run(1, 1))[0] == pytest.approx(found[::-1], abs=0.2)


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_scaled_and_mirrored_objects_and_units_change_nothing(room, scale):
    room.scene.unit_settings.scale_length = scale
    for obj in bpy.data.objects:
        obj.location /= scale
        obj.scale = (1 / scale,) * 3
    box = warm(room.box((1, 1, 1), (0.3 / scale, 0.2 / scale, -2.0 / scale), "body"), PERSON)
    box.scale = (-0.6 / scale, 0.9 / scale, 0.3 / scale)
    sensor = array(room)
    sensor.scale = (-1.0, 2.0, 3.0)
    found = frames(room, room.run(1, 1))[0]
    assert found.max() == pytest.approx(looks_like(PERSON), abs=0.01)
    assert found[:, :2].max() == pytest.approx(21.0, abs=0.01), "on the right of the axis"
    assert found[:4].sum() > found[4:].sum(), "above the axis"


def test_upside_down_it_sees_upside_down(room):
    warm(room.box((0.5, 0.5, 0.1), (0.6, 0.5, -2.0), "body"), PERSON)
    sensor = array(room, rays=100)
    upright = frames(room, room.run(1, 1))[0]
    sensor.rotation_euler.z = math.pi
    turned = frames(room, room.run(1, 1))[0]
    assert turned == pytest.approx(upright[::-1, ::-1], abs=0.5)
    assert np.unravel_index(upright.argmax(), (8, 8)) == (2, 6)


def test_nothing_metal_a_lamp_and_frost(world):
    """Left: bare metal; above: a lamp of 250 °C; below: a wall of −12 °C; elsewhere nothing."""
    world.scene.angen_ambient_temperature = 21.0
    warm(world.box((2, 9, 0.1), (-1.4, 0, -1.0), "metal"), 90.0, 0.1)
    warm(world.box((0.3, 0.3, 0.1), (0.2, 0.35, -1.0), "lamp"), 250.0)
    warm(world.box((9, 1, 0.1), (4.8, -0.9, -1.0), "frost"), -12.0)
    array(world, hottest=80.0, rays=200, columns=8)
    found = frames(world, world.run(1, 1))[0]
    assert found[4, 0] == pytest.approx(looks_like(90.0, 0.1), abs=0.05)
    assert found[7, 7] == pytest.approx(looks_like(-12.0), abs=0.05)
    assert found[3, 4] == pytest.approx(21.0, abs=0.005)
    assert found[1, 5] == 80.0, "the part reads no more"


def test_a_body_that_touches_the_lens_fills_all_pixels(room):
    warm(room.box((0.6, 0.6, 0.6), (0, 0, -0.1), "body"), 33.0)
    array(room)
    assert frames(room, room.run(1, 1))[0] == pytest.approx(looks_like(33.0), abs=0.01)


def key_use(obj, *keys):
    """Key whether an object is in use: pairs of a frame and a truth value."""
    for frame, used in keys:
        obj.angen_use.in_use = used
        obj.keyframe_insert("angen_use.in_use", frame=frame)


def test_what_is_in_use_is_warm_and_cools_down(room):
    """A kettle for two minutes: 2.5 more until it has boiled, then it cools down."""
    fps = room.scene.render.fps
    kettle = room.box((9, 9, 0.001), (0, 0, -2.0), "kettle")
    kettle.angen_heat.sort = "KETTLE"
    key_use(kettle, (1, False), (10 * fps, True), (130 * fps, False))
    array(room, update_rate=0.2)
    found = frames(room, room.run(1, 500 * fps))[:, 3, 3]
    times = np.arange(len(found)) * 5.0
    heat = HEATS["KETTLE"]
    excess = heat.excess * (1 - np.exp(-np.clip(times - 10, 0, 120 + heat.runs_on) / heat.rise))
    excess *= np.exp(-np.clip(times - 130 - heat.runs_on, 0, None) / heat.fall)
    assert found == pytest.approx(looks_like(21.0 + excess), abs=STEP + 0.1)
    assert (
        found.max() > 60 and found[0] == pytest.approx(21.0, abs=0.01) and found[-1] < found.max()
    )


def test_use_warms_only_what_is_marked_and_without_keys_wholly(room):
    box = room.box((9, 9, 0.001), (0, 0, -2.0), "box")
    box.angen_use.in_use = True
    array(room)
    assert frames(room, room.run(1, 1))[0] == pytest.approx(21.0, abs=0.01)
    box.angen_heat.sort = "RADIATOR"
    assert frames(room, room.run(1, 1))[0] == pytest.approx(looks_like(51.0), abs=0.05)


def test_one_pixel(room):
    body = warm(room.box((9, 9, 0.1), (0, 0, -2), "body"), PERSON)
    array(room, columns=1, rows=1, min_pixels=1, background="LEARNT")
    room.key(body, "location", {1: (50, 0, -2), 10: (0, 0, -2)}, "CONSTANT")
    recording = room.run(1, 12)
    assert room.series(recording, "array", "occupied") == [False] * 9 + [True] * 3


def person_who_enters(world, **settings):
    body = warm(world.box((0.4, 0.9, 0.3), (9, 0, -2), "Person"), PERSON)
    world.key(body, "location", {1: (9, 0, -2), 10: (0.1, 0.1, -2), 20: (9, 0, -2)}, "CONSTANT")
    return array(world, **settings)


def test_the_log_has_who_enters_and_the_highest_temperature(room):
    person_who_enters(room)
    recording = room.run(1, 24)
    rows = [(float(r[1]), r[4], r[5]) for r in room.log(recording) if r[4] != "warm_pixels"]
    hot = f"{looks_like(PERSON):.4g}"
    short = [(f, n, v if n == "occupied" else f"{float(v):.4g}") for f, n, v in rows]
    assert short == [
        (1.0, "max_c", "21"),
        (1.0, "occupied", "0"),
        (10.0, "max_c", hot),
        (10.0, "occupied", "1"),
        (20.0, "max_c", "21"),
        (20.0, "occupied", "0"),
    ]


def test_explain_names_who_warms_which_pixels(room):
    warm(room.box((0.05, 0.05, 0.05), (-0.8, 0, -2), "Lamp"), 60.0)
    person_who_enters(room, min_pixels=3)
    recording = room.run(1, 24)
    (sensor,) = room.sensors()
    there = explain(room.scene, sensor, recording, 12)
    facts = dict(there.facts)
    assert there.headline.startswith("Occupied: 'Person'") and not there.doubt
    assert there.cause_name == "Person" and facts["In them"].startswith("'Person' ")
    assert facts["Background"] == "21.0 °C, the median of the frame"
    count = room.series(recording, "array", "warm_pixels")[12]
    assert facts["Warm pixels"].startswith(f"{count} of 64: 2 K above it; 3 are needed")
    hottest = int(frames(room, recording)[12].argmax())
    assert f"row {hottest // 8 + 1} from above, column {hottest % 8 + 1} " in facts["Highest"]
    empty = explain(room.scene, sensor, recording, 2)
    assert empty.headline == "Empty: no pixel is warm" or "are needed" in empty.headline
    bpy.data.objects["Person"].angen_warmth.temperature = 36.0
    room.update()
    assert explain(room.scene, sensor, recording, 12) == there


def test_explain_reads_the_learnt_background(room):
    radiator = warm(room.box((0.5, 0.5, 0.1), (-0.8, 0, -2.2), "Radiator"), 50.0)
    person_who_enters(room, background="LEARNT")
    recording = room.run(1, 24)
    (sensor,) = room.sensors()
    there = explain(room.scene, sensor, recording, 12)
    assert there.cause_name == "Person" and radiator.name not in there.headline
    assert there.cause.warm == room.series(recording, "array", "warm_pixels")[12]
    assert "learnt" in dict(there.facts)["Background"]


@pytest.mark.parametrize(
    "settings", [{}, {"background": "LEARNT"}, {"settling_time": 2.0}, {"netd": 0.3}], ids=str
)
def test_explain_needs_no_frames_in_the_recording(room, settings):
    person_who_enters(room, keep_frames=False, **settings)
    recording = room.run(1, 24)
    (sensor,) = room.sensors()
    columns = recording.tracks["array"].columns
    for index in (0, 2, 12, 23):
        found = explain(room.scene, sensor, recording, index)
        count, highest = columns["warm_pixels"][index], columns["max_c"][index]
        facts = dict(found.facts)
        assert facts["Warm pixels"] == f"{count} of 64: 2 K above it; 2 are needed"
        assert facts["Highest"].startswith(f"{highest:.1f} °C, row ")
        assert found.cause_name == ("Person" if count else "")
    assert columns["warm_pixels"][12] > 2 or "settling_time" in settings


def test_why_not_says_how_much_warmer_a_pixel_must_be(room, addon_part):
    body = warm(room.box((0.4, 0.9, 0.3), (0, 0, -2), "Person"), 22.5)
    array(room)
    assert body
    recording = room.run(1, 2)
    (sensor,) = room.sensors()
    look = addon_part("angen_addon.appearance.appearance").appearance_of(sensor.kind)
    recorded = addon_part("angen_addon.appearance.recorded").RecordedSensor
    found = explain(room.scene, sensor, recording, 1)
    found = look.lacking(recorded(room.scene, sensor, recording), 1, found)
    last = np.sort(frames(room, recording)[1].ravel())[-2] - 21.0
    assert dict(found.facts)["To be occupied"] == (
        f"2 pixels must be 2 K above the background: the last of them is {last:.1f} K above"
    )


def test_live_reads_what_the_run_reads(room):
    person_who_enters(room, netd=0.2)
    assert ops.simulate() == {"FINISHED"}
    results = __import__(
        "bl_ext.user_default.angen_sensors.angen_addon.recording.results", fromlist=["RESULTS"]
    ).RESULTS
    track = results.recording(room.scene).tracks["array"]
    recorded = track.columns["frame_c"][11]
    room.scene.frame_set(12)
    (sensor,) = room.sensors()
    assert reading_text(sensor, room.scene).fields["frame_c"] == recorded
    ops.clear_recording()
    room.scene.frame_set(11)
    room.scene.frame_set(12)
    assert reading_text(sensor, room.scene).fields["frame_c"] == recorded


def test_without_frames_samples_have_no_column(room, tmp_path):
    array(room, keep_frames=False)
    assert ops.simulate() == {"FINISHED"}
    ops.export_samples(directory=str(tmp_path))
    head = (tmp_path / "array.csv").read_text().splitlines()[0]
    assert head == "time_s,frame,max_c,occupied,warm_pixels,mean_c"


@pytest.mark.parametrize("name", ["casas", "home-assistant", "mcap", "influx"])
def test_formats_have_the_temperature(room, tmp_path, command, name):
    person_who_enters(room)
    home, out = tmp_path / "home.blend", tmp_path / "out"
    bpy.ops.wm.save_as_mainfile(filepath=str(home))
    bpy.ops.wm.open_mainfile(filepath=str(home))
    assert command("simulate", "--format", name, "--out", out)[0] == 0
    texts = {path.name: path.read_bytes() for path in tmp_path.glob("out*")}
    whole = b"".join(texts.values())
    expected = {
        "casas": b"T001 28.",
        "home-assistant": b'\\"device_class\\": \\"temperature\\"',
        "mcap": b"sensor_msgs/msg/Temperature",
        "influx": b"max_c=28.",
    }
    assert expected[name] in whole.replace(b": ", b": "), whole[:2000]


@pytest.mark.slow
def test_default_rays_hold_a_tenth_of_a_kelvin_in_the_home(world):
    """Against 32 × 32 rays a pixel, where the person walks in the living room."""
    path = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    bpy.context.scene.angen_live = False
    warm(bpy.data.objects["Person"], PERSON)
    names, found = ("PIR living room",), {}
    for sensor in world.sensors():
        sensor.settings.enabled = sensor.name in names
    for rays in (34, 1024):
        for name in names:
            settings = bpy.data.objects[name].angen_sensor
            settings.kind, settings.update_rate = "THERMAL_ARRAY", 1.0
            default = settings.thermal_array.bl_rna.properties["rays"].default
            settings.thermal_array.rays = rays
        recording = world.run(1609, 1609)
        found[rays] = np.array([frames(world, recording, name) for name in names])
    error = found[34] - found[1024]
    assert default == 34 and np.ptp(found[1024]) > 5.0
    assert math.sqrt((error**2).mean()) < 0.1


def drawn_sensor(world, addon_part):
    picture = addon_part("angen_addon.view.overlay.picture")
    seen = picture.DrawnSensors(world.scene)
    seen.follow(world.scene, bpy.context.view_layer, world.update())
    (one,) = seen.seen
    return picture, one


def test_the_view_has_a_coloured_pixel_for_each_temperature(room, addon_part):
    person_who_enters(room)
    room.scene.frame_set(12)
    (sensor,) = room.sensors()
    picture, one = drawn_sensor(room, addon_part)
    shown = reading_text(sensor, room.scene)
    (figure,) = picture.changing_figures(one, shown, 1.0)
    assert figure.fills["value"].shape == (128, 3, 3)
    values = np.repeat(np.array(shown.fields["frame_c"].split(";"), float), 2)
    bright = figure.colours["value"][:, :3].sum(axis=1)
    assert (bright[values > 28] > bright[values < 22].max()).all()
    warmest = figure.fills["value"][values > 28].reshape(-1, 3)
    assert warmest[:, 2].min() > -1.95 and warmest[:, 2].max() < -1.8, "on the person"
    made = picture.picture(figure, shown.icon, True)["fills"]
    assert made.colours.shape == (384, 4) and len(np.unique(made.colours[:, :3], axis=0)) > 2


def test_the_panel_has_the_reading_and_sections(room):
    sensor = person_who_enters(room)
    room.update()
    bpy.context.view_layer.objects.active = sensor
    sensor.select_set(True)
    room.scene.frame_set(12)
    shown = drawn("ANGEN_PT_active_sensor")
    found = {s.name: s for s in room.sensors()}["array"]
    count = reading_text(found, room.scene).fields["warm_pixels"]
    assert any(f"{count} of 64" in label for label in shown.labels) and shown.pictures == 1
    assert {"threshold", "min_pixels", "columns", "netd", "keep_frames"} <= set(shown.props)
    sensor.angen_sensor.thermal_array.keep_frames = False
    room.update()
    room.scene.frame_set(12)
    assert drawn("ANGEN_PT_active_sensor").pictures == 0


def test_in_the_floor_plan_an_array_at_the_ceiling_covers_an_area(room, addon_part):
    array(room)
    (sensor,) = room.sensors()
    parameters = addon_part("angen_addon.scene.sensors").read_parameters(sensor, sensor.settings)
    parameters = replace(parameters, horizontal_fov=math.radians(90), vertical_fov=math.radians(60))
    pose = addon_part("sensor_logic.model").Pose(np.zeros(3), np.eye(3))
    plan_rays = addon_part("angen_addon.kinds.thermal_array.figure").plan_rays
    rays = plan_rays(SimpleNamespace(parameters=parameters, pose=pose), 1.0)
    floor = rays.directions / -rays.directions[:, 2:]
    assert np.ptp(floor[:, 0]) == pytest.approx(2.0)
    assert np.ptp(floor[:, 1]) == pytest.approx(2.0 / math.sqrt(3.0))
    assert np.allclose(floor[0], floor[-1])


def test_the_panel_shows_the_frame_as_an_icon(room, addon_part):
    icons = addon_part("angen_addon.appearance.pixel_icons")
    colours = np.zeros((2, 4, 3))
    colours[0, 0] = (1.0, 0.0, 1.0)
    pixels = icons.blocks(colours)
    assert pixels.shape == (256, 256, 4)
    assert tuple(pixels[191, 0]) == (1.0, 0.0, 1.0, 1.0), "the upper left is the first"
    assert pixels[0, 0, 3] == 0.0 and pixels[64, 255, 3] == 1.0
    number = icons.icon_of("a", "one", colours)
    assert icons.icon_of("a", "one", colours) == number, "0 without a window"
    assert list(icons._PICTURES.previews["a"].image_pixels_float) == list(pixels.ravel())


def test_too_many_rays_are_refused_before_the_run(room, addon_part):
    array(room, columns=160, rows=160, rays=1024)
    with pytest.raises(
        addon_part("sensor_logic.logs.error").AngenError, match="at most 7 rays a pixel"
    ):
        room.run(1, 1)
