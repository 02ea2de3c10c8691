# SPDX-License-Identifier: GPL-3.0-or-later
"""Presence radars in scenes of known measure: people who walk, breathe, or stand behind a wall."""

import math
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.api.home import Home
from bl_ext.user_default.angen_sensors.angen_addon.appearance.reading_text import ACTIVE, IDLE
from bl_ext.user_default.angen_sensors.angen_addon.coverage.maps import Views
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.kinds.presence_radar.figure import (
    plan_rays,
    rays_figure,
    targets_figure,
)
from bl_ext.user_default.angen_sensors.angen_addon.runtime.probes import Probes
from bl_ext.user_default.angen_sensors.angen_addon.runtime.sensor_runner import all_rays
from bl_ext.user_default.angen_sensors.angen_addon.runtime.time_base import clock_of
from bl_ext.user_default.angen_sensors.angen_addon.scene.home.evaluated_home import EvaluatedHome
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import read_parameters
from bl_ext.user_default.angen_sensors.angen_addon.view.readings import reading_text
from bl_ext.user_default.angen_sensors.sensor_logic.logs.error import AngenError
from bl_ext.user_default.angen_sensors.sensor_logic.model import Pose
from mathutils import Vector
from panel_layout import drawn, panel_of

ops = bpy.ops.angen
HOME = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"

# The axes of a sensor that looks level along Y.
LEVEL = (1, 0, 0), (0, 0, 1), (0, -1, 0)


def radar(world, name="radar", preset="LD2450", **settings):
    """Add a radar at the origin that looks along −Z, with +X to its right, at 10 Hz."""
    ops.sensor_add(kind="PRESENCE_RADAR", preset=preset)
    made = bpy.context.object
    made.name, made.matrix_world.translation = name, (0, 0, 0)
    made.rotation_euler = (0, 0, 0)
    made.angen_sensor.update_rate = settings.pop("update_rate", 24.0)
    for key, value in settings.items():
        setattr(made.angen_sensor.presence_radar, key, value)
    return made


def person(world, at, name="Anna", breathes="NO"):
    """Add a body of 0.4 by 1.7 by 0.2 m that is made of skin; Y is up in these scenes."""
    body = world.box((0.4, 1.7, 0.2), at, name)
    body.angen_radar.substance = "BODY"
    body.angen_breathing.breathes = breathes
    return body


def fields(world, recording, name, *sensor):
    return world.series(recording, sensor[0] if sensor else "radar", name)


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_a_walker_is_where_it_is_with_its_speed(world, scale):
    """At 1 m/s away from the radar, whose nearest face is 0.1 m before its centre."""
    world.scene.unit_settings.scale_length = scale
    anna = person(world, (0, 0, 0))
    anna.scale = (1 / scale,) * 3
    radar(world)
    start, end = (0.3 / scale, 0, -2.5 / scale), (0.3 / scale, 0, -4.5 / scale)
    world.key(anna, "location", {1: start, 49: end}, "LINEAR")
    recording = world.run(1, 48)
    speeds = [float(text) for text in fields(world, recording, "speed_mps")[1:]]
    assert speeds == pytest.approx([1.0] * 47, rel=0.03)
    for name, expected in (("x_m", 0.3), ("y_m", 3.4)):
        assert float(fields(world, recording, name)[24]) == pytest.approx(expected, abs=0.12)
    assert fields(world, recording, "moving") == [False] + [True] * 47, "no speed at the first"
    assert set(fields(world, recording, "targets")[1:]) == {1}


def test_who_sits_still_is_present_by_breathing(world):
    person(world, (0, 0, -2.0), breathes="YES")
    radar(world)
    world.sensor("PIR", "pir", update_rate=24.0)
    recording = world.run(1, 12)
    assert fields(world, recording, "presence") == [True] * 12
    assert not any(fields(world, recording, "moving"))
    assert not any(fields(world, recording, "moved", "pir"))
    assert fields(world, recording, "distance_m")[5] == pytest.approx(1.9, abs=0.1)


def test_furniture_that_stands_still_is_not_present(world):
    person(world, (0, 0, -2.0), breathes="NO")
    radar(world)
    recording = world.run(1, 3)
    assert not any(fields(world, recording, "presence"))
    assert set(fields(world, recording, "distance_m")) == {6.0}


@pytest.mark.parametrize(("substance", "present"), [("PLASTERBOARD", True), ("CONCRETE", False)])
def test_a_thin_wall_lets_waves_pass_and_concrete_does_not(world, substance, present):
    anna = person(world, (0, 0, -2.0))
    world.key(anna, "location", {1: (0, 0, -2.0), 25: (0, 0, -3.0)}, "LINEAR")
    wall = world.box((9, 9, 0.1), (0, 0, -1.2), "Wall west")
    wall.angen_radar.substance = substance
    radar(world)
    recording = world.run(1, 12)
    assert fields(world, recording, "presence")[3] == present
    (sensor,) = world.sensors()
    found = explain(world.scene, sensor, recording, 6)
    if present:
        assert found.headline.startswith("Present: 'Anna' moves, 2.")
        assert found.headline.endswith("away, seen through 'Wall west'")
        assert dict(found.facts)["Passed"].startswith("'Wall west': ")
        assert found.cause_name == "Anna" and not found.doubt
    else:
        assert found.headline == "Absent: nothing exceeds the threshold of a gate"
        assert dict(found.facts)["To be present"] == "nothing that moves or breathes is in sight"


def lies_down(world, body, place):
    """Let a body come nearer by 0.2 m in the first second; then it is still at `place`."""
    x, y, z = place
    world.key(body, "location", {1: (x, y, z - 0.2), 24: place, 192: place}, "LINEAR")


def test_a_sleeper_under_a_duvet_is_present_and_behind_a_board_explain_names_what_stops(world):
    anna = person(world, (0, 0, -2.3), breathes="YES")
    lies_down(world, anna, (0, 0, -2.3))
    duvet = world.box((1.4, 2.0, 0.2), (0, 0, -1.9), "Duvet")
    radar(world, preset="LD2410", update_rate=10.0, hold_time=1.0)
    recording = world.run(1, 192)
    assert fields(world, recording, "presence")[-1]
    (sensor,) = world.sensors()
    assert "seen through 'Duvet'" in explain(world.scene, sensor, recording, 78).headline
    duvet.angen_radar.substance = "CONCRETE"
    duvet.name = "Slab"
    recording = world.run(1, 24)
    assert not any(fields(world, recording, "presence"))
    facts = dict(explain(world.scene, sensor, recording, 2).facts)
    assert facts["Waves stop at"].startswith("'Slab'")


@pytest.mark.slow
def test_who_lies_in_the_bed_of_the_sample_home_is_present(world):
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    with Home.open(HOME) as home:
        duvet, mattress = bpy.data.objects["Duvet"], bpy.data.objects["Mattress"]
        top, under = ([obj.matrix_world @ Vector(corner) for corner in obj.bound_box]
                      for obj in (duvet, mattress))  # fmt: skip
        middle = sum(top, Vector()) / 8
        height = max(point.z for point in under)
        assert max(point.z for point in top) > height, "the duvet lies on the mattress"
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=(middle.x, middle.y, height - 0.06))
        body = bpy.context.object
        body.scale = 0.4, 0.4, 0.2
        body.angen_radar.substance, body.angen_breathing.breathes = "BODY", "YES"
        lies_down(world, body, tuple(body.location))
        at = (middle.x, middle.y, 2.35)
        home.add("PRESENCE_RADAR", name="Radar", at=at, look=(0, 0, -1), preset="LD2410")
        bpy.data.objects["Radar"].angen_sensor.presence_radar.hold_time = 1.0
        run = home.simulate(frames=(1, 192), sensors=["Radar"])
        assert run.samples("Radar")["presence"][-1]


def test_explain_says_who_breathes_and_what_holds_presence(world):
    anna = person(world, (0, 0, -2.3), breathes="YES")
    radar(world, preset="LD2410", hold_time=0.5, still_time=0.05)
    world.key(anna, "location", {1: (0, 0, -2.3), 10: (50, 0, 0)}, "CONSTANT")
    recording = world.run(1, 40)
    (sensor,) = world.sensors()
    found = explain(world.scene, sensor, recording, 4)
    assert found.headline.startswith("Present: 'Anna' breathes, 2.")
    assert dict(found.facts)["Gate"] == "3, 1.875–2.625 m"
    assert dict(found.facts)["Still energy"].endswith(" of 100, above 40")
    fades = explain(world.scene, sensor, recording, 10)
    assert fades.headline == "Present: the still energy of who was here fades in gate 3"
    held = explain(world.scene, sensor, recording, 20)
    assert held.headline.startswith("Present: nothing is detected now; presence stays on for 0.5 s")
    gone = explain(world.scene, sensor, recording, 39)
    assert gone.headline.startswith("Absent")
    still = [max(float(gate.partition("/")[2]) for gate in text.split(";"))
             for text in fields(world, recording, "gates")]  # fmt: skip
    last = max(i for i, energy in enumerate(still) if energy > 40.0)
    assert 8 < last < 16
    presence = fields(world, recording, "presence")
    assert presence == [True] * (last + 12) + [False] * (40 - last - 12), "0.5 s after the last"


def test_what_is_too_weak_is_named(world):
    person(world, (0, 0, -5.0), breathes="YES")
    radar(world, still_thresholds="60")
    recording = world.run(1, 3)
    (sensor,) = world.sensors()
    facts = dict(explain(world.scene, sensor, recording, 2).facts)
    assert facts["To be present"].startswith("more than 60 of 100 is needed in gate 1")
    assert facts["Nearest to it"] == "'Anna'"
    assert facts["Still energy"].endswith(" of 100, not above 60")


def walk(world, start, end, **settings):
    """Add a person who walks from one z to another in a second, and a radar."""
    anna = person(world, (0, 0, start))
    world.key(anna, "location", {1: (0, 0, start), 25: (0, 0, end)}, "LINEAR")
    radar(world, **settings)
    return anna


def told(world, recording, index):
    (sensor,) = world.sensors()
    return explain(world.scene, sensor, recording, index)


def test_who_is_too_weak_behind_walls_is_named(world):
    walk(world, -3, -4)
    for name, z in (("Wall west", -1.2), ("Wall east", -1.6)):
        wall = world.box((9, 9, 0.1), (0, 0, z), name)
        wall.angen_radar.substance = "PLASTERBOARD"
    facts = dict(told(world, world.run(1, 6), 3).facts)
    assert facts["Moving energy"].endswith(" of 100, not above 15")
    assert facts["To be present"].startswith("more than 15 of 100 is needed in gate 10")
    assert facts["Nearest to it"] == "'Anna'"


def test_who_moves_in_a_gate_that_is_off_is_named(world):
    walk(world, -2, -3, moving_thresholds="100", still_thresholds="100")
    facts = dict(told(world, world.run(1, 6), 3).facts)
    assert facts["To be present"] == "gate 6 is switched off for movement: its threshold is 100"
    assert facts["Nearest to it"] == "'Anna'"


@pytest.mark.parametrize("preset", ["LD2410", "LD2450"])
def test_explain_tells_the_run_whatever_the_scene_is_now(world, preset):
    anna = walk(world, -2, -3, preset=preset)
    recording = world.run(1, 24)
    before = [told(world, recording, index) for index in (0, 1, 12, 23)]
    assert before[2].cause_name == "Anna" and not any(found.doubt for found in before)
    bpy.data.objects.remove(anna)
    world.update()
    assert [told(world, recording, index) for index in (0, 1, 12, 23)] == before


def test_explain_shows_the_distance_with_its_noise(world):
    walk(world, -2, -3, range_noise=0.1)
    recording = world.run(1, 12)
    found, recorded = told(world, recording, 5), fields(world, recording, "distance_m")[5]
    assert found.cause.distance == pytest.approx(recorded, abs=1e-9) and not found.doubt
    assert f"{recorded:.2f}"[:3] in found.headline


def test_a_keyframe_that_jumps_is_no_movement(world):
    anna = person(world, (0, 0, -2))
    world.key(anna, "location", {1: (0, 0, -2), 5: (0, 0, -4)}, "CONSTANT")
    radar(world)
    recording = world.run(1, 8)
    assert not any(fields(world, recording, "moving"))
    assert set(fields(world, recording, "speed_mps")) == {""}


def test_a_parameter_out_of_its_limits_is_refused(world):
    made = radar(world)
    settings = made.angen_sensor.presence_radar
    for name, value, limit in (
        ("horizontal_fov", 1e-4, "at least 1°"),
        ("still_range", 1e30, "at most 100 m"),
        ("energy_noise", 1e6, "at most 100"),
    ):
        before = getattr(settings, name)
        setattr(settings, name, value)
        with pytest.raises(AngenError, match=f"{name} is .* it must be {limit}"):
            world.run(1, 2)
        setattr(settings, name, before)
    settings.horizontal_fov = math.radians(1)
    world.run(1, 2)


def test_live_reading_and_panel_show_the_gates(world):
    anna = person(world, (0, 0, -2.0))
    world.key(anna, "location", {1: (0, 0, -2.0), 25: (0, 0, -3.0)}, "LINEAR")
    radar(world, preset="LD2410")
    for frame in range(1, 8):
        world.scene.frame_set(frame)
    (sensor,) = world.sensors()
    shown = reading_text(sensor, world.scene)
    assert shown.text.startswith("Present") and sensor.object.angen_sensor.active
    assert len(shown.fields["gates"].split(";")) == 9
    assert sensor.object.angen_sensor.value == pytest.approx(2.26, abs=0.15)
    bpy.context.view_layer.objects.active = sensor.object
    panel = drawn("ANGEN_PT_active_sensor")
    assert "Energy of each gate, 0 to 100" in panel.labels
    assert any(text.startswith("1.875–2.625 m: moving ") for text in panel.labels)
    signs = [icon for icon in panel.icons if icon in (ACTIVE, IDLE)][1:]
    moving = [float(gate.partition("/")[0]) for gate in shown.fields["gates"].split(";")]
    needed = (50, 50, 40, 30, 20, 15, 15, 15, 15)
    over = [energy > least for energy, least in zip(moving, needed, strict=True)]
    assert signs == [ACTIVE if found else IDLE for found in over] and over[3] and not all(over)


def test_substance_is_set_on_surfaces_and_breathing_also_on_the_armature(world):
    rig = world.link("Rig", bpy.data.armatures.new("Rig"), (0, 0, 0))
    for obj, has_substance in ((rig, False), (person(world, (0, 0, 0)), True)):
        bpy.context.view_layer.objects.active = obj
        assert panel_of("ANGEN_PT_object_radar").poll(bpy.context) == has_substance
        assert panel_of("ANGEN_PT_object_breathing").poll(bpy.context)


def test_a_target_is_a_ring_with_an_arrow_as_long_as_half_a_second():
    seen = SimpleNamespace(pose=Pose(np.zeros(3), np.eye(3)))
    absent = {"presence": False, "distance_m": 6.0, "x_m": "", "y_m": "", "speed_mps": ""}
    assert targets_figure(seen, absent, 1.0) is None
    two = {"x_m": "1.0;-1.0", "y_m": "2.0;3.0", "speed_mps": "0.8;0.0"}
    figure = targets_figure(seen, {**absent, "presence": True, **two}, 0.5)
    points = figure.lines["force"].reshape(-1, 3) * 0.5
    for x, z in ((1.0, -2.0), (-1.0, -3.0)):
        assert np.linalg.norm(points - (x, 0.0, z), axis=1).min() < 1e-6
    tip = figure.fills["force"][0, 0] * 0.5
    away = np.array([1.0, 0.0, -2.0]) / math.sqrt(5.0)
    assert tip == pytest.approx(np.array([1.0, 0.0, -2.0]) + 0.4 * away, abs=1e-6)
    arc = targets_figure(seen, {**absent, "presence": True, "distance_m": 3.0}, 1.0)
    assert np.linalg.norm(arc.lines["force"], axis=-1) == pytest.approx(3.0)


def test_in_the_floor_plan_a_radar_at_the_ceiling_covers_an_area(world):
    """A level fan would be a line; a fan around the field of view is a square of ±60°."""
    level, down = (Pose(np.zeros(3), np.array(axes, float).T) for axes in (LEVEL, np.eye(3)))
    radar(world, preset="LD2410")
    (sensor,) = world.sensors()
    parameters = read_parameters(sensor, sensor.settings)
    fan = plan_rays(SimpleNamespace(parameters=parameters, pose=level), 1.0)
    assert np.allclose(fan.directions[:, 2], 0.0) and len(fan.directions) == 25
    around = plan_rays(SimpleNamespace(parameters=parameters, pose=down), 0.5)
    assert np.linalg.norm(around.directions, axis=1) == pytest.approx(1.0)
    assert np.allclose(around.directions[0], around.directions[-1]) and around.reach[0] == 12.0
    assert np.degrees(np.arcsin(np.ptp(around.directions, axis=0)[:2] / 2)) == pytest.approx(60.0)


def test_gates_are_drawn_up_to_the_wall(world):
    world.wall(2.0, size=20.0)
    radar(world, preset="LD2410")
    (sensor,) = world.sensors()
    probes, depsgraph = Probes(world.scene), world.update()
    probes.look(depsgraph)
    trace = all_rays(sensor, clock_of(world.scene), depsgraph, probes)
    cast = trace.bundles[0]
    seen = SimpleNamespace(parameters=trace.parameters, pose=trace.pose)
    figure = rays_figure(seen, 0, cast, 1.0)
    arcs = np.linalg.norm(figure.lines["gate"], axis=-1)
    gates = np.round(arcs.ravel() / trace.parameters.bin_length, 4)
    assert set(gates) == set(range(1, 9)), "2 m ahead, and far aside"
    assert figure.lines["gate"][..., 2].min() > -2.05


def test_a_map_knows_the_losses_between_walls(world):
    """Boards at 0.95 m and at 1.95 m, concrete at 3 m, and no step beyond the second boards."""
    for name, z in (("Wall west", -1.0), ("Wall east", -2.0)):
        wall = world.box((90, 90, 0.1), (0, 0, z), name)
        wall.angen_radar.substance = "PLASTERBOARD"
    world.wall(3.0, size=90.0)
    narrow = math.radians(10)
    radar(world, range_max=100.0, gate_length=1.0, horizontal_fov=narrow, vertical_fov=narrow)
    (sensor,) = world.sensors()
    looking = Views(EvaluatedHome(world.update())).of(sensor)
    lost = looking.loss / looking.loss[-1]
    for first, last, share in ((0, 3, 0.0), (4, 7, 0.5), (8, len(lost) - 1, 1.0)):
        assert lost[first : last + 1] == pytest.approx(share), (first, last)
    assert len(lost) == 9


def test_a_jump_gives_no_speed(world):
    anna = person(world, (0, 0, -2.0))
    world.key(anna, "location", {1: (0, 0, -2.0), 48: (0, 0, -5.0)}, "LINEAR")
    radar(world)
    for frame in (1, 2, 3):
        world.scene.frame_set(frame)
    (sensor,) = world.sensors()
    assert sensor.object.angen_sensor.active
    world.scene.frame_set(40)
    assert not reading_text(sensor, world.scene).fields["moving"]


def test_a_radar_that_turns_with_its_parent_keeps_its_axes(world):
    """The radar looks along +X after a turn; a walker on its right has a positive x."""
    made = radar(world)
    made.rotation_euler = (math.pi / 2, 0, -math.pi / 2)
    anna = person(world, (0, 0, 0))
    anna.rotation_euler = (math.pi / 2, 0, 0)
    world.key(anna, "location", {1: (3.0, -1.0, 0), 25: (2.0, -1.0, 0)}, "LINEAR")
    recording = world.run(1, 6)
    assert float(fields(world, recording, "x_m")[3]) == pytest.approx(1.0, abs=0.1)
    assert float(fields(world, recording, "speed_mps")[3]) < -0.8


def test_frames_in_batches_and_one_by_one_give_the_same_bits(world):
    anna = person(world, (0, 0, -2.0), breathes="YES")
    world.key(anna, "location", {5: (0, 0, -2.0), 20: (0.4, 0, -3.0), 30: (0.4, 0, -3.0)})
    wall = world.box((9, 9, 0.1), (0, 0, -1.2), "Wall west")
    wall.angen_radar.substance = "WOOD"
    radar(world, update_rate=10.0)
    together = world.run(1, 40)
    # Another add-on's handler makes each batch one frame.

    def handler(*_):
        pass

    bpy.app.handlers.frame_change_post.append(handler)
    try:
        alone = world.run(1, 40)
    finally:
        bpy.app.handlers.frame_change_post.remove(handler)
    for name in ("presence", "moving", "distance_m", "x_m", "y_m", "speed_mps", "gates"):
        assert fields(world, together, name) == fields(world, alone, name), name
    assert any(fields(world, together, "moving"))


def test_each_state_has_words_of_its_own_and_who_is_absent_has_no_distance(world, addon_part):
    """Anna walks away for a second, and vanishes from sight behind the range."""
    anna = person(world, (0, 0, -2.0))
    world.key(anna, "location", {1: (0, 0, -2.0), 25: (0, 0, -3.0), 26: (0, 50, 0)}, "LINEAR")
    sensor = radar(world, hold_time=0.0)
    run = world.run()
    track = run.tracks["radar"]
    name = addon_part("operators.markers").event_name
    walks = int(np.flatnonzero(fields(world, run, "presence"))[0])
    assert name(track, walks) == "Present, moving"
    assert "not moving" in name(track, 0)
    (found,) = world.sensors()
    world.scene.frame_set(40)
    assert reading_text(found, world.scene).text.startswith("Absent"), sensor
    assert " m" not in reading_text(found, world.scene).text.partition(",")[0]
    assert reading_text(found, world.scene).brief == "Absent"
