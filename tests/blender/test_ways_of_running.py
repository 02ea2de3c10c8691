# SPDX-License-Identifier: GPL-3.0-or-later
"""All ways of running give the same bits as evaluating the whole scene at each frame.

And sensors do not depend on each other.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.commands.open_home import ProgressLine
from bl_ext.user_default.angen_sensors.angen_addon.runtime import live as live_sensors
from bl_ext.user_default.angen_sensors.angen_addon.runtime import moving_scene, stage
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import simulate
from bl_ext.user_default.angen_sensors.angen_addon.scene import capture, memory
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays.caster import RayCaster
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensor_reader import SensorReader
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording
from light_stage import lamp
from moving_scenes import SCENES, SWITCHED, followed, moved, watched_bodies
from pressure_scenes import live_problem
from random_scene import LAST_FRAME, RandomScene
from tiers import mostly_slow


def run(world: Any, edits: Any = None) -> tuple[Any, Any]:
    """Return the tracks of a run with `edits` after some of its frames, and its last progress."""
    recording, scene, done = Recording(), world.scene, None
    for done in simulate(scene, world.sensors(), scene.frame_start, scene.frame_end, recording):
        if edits and round(done.frame) in edits:
            edits[round(done.frame)]()
    return recording.tracks, done


@contextmanager
def everything_anew() -> Iterator[None]:
    """Evaluate each frame alone, cast each ray and read each sensor again.

    A handler of other code, which may change anything, forces this.
    """
    see_at = RayCaster.see_at

    def anew(self: Any, sensor: Any, bundle: Any, *rest: Any) -> Any:
        self._bundles.pop((sensor, bundle), None)
        return see_at(self, sensor, bundle, *rest)

    def act(*_: Any) -> None:
        pass

    lists = bpy.app.handlers.frame_change_pre, bpy.app.handlers.depsgraph_update_post
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(capture, "MOST_FRAMES", 1)
        patch.setattr(stage, "_weights_stay", lambda _: False)
        patch.setattr(SensorReader, "steady", property(lambda _: False, lambda *_: None))
        patch.setattr(RayCaster, "see_at", anew)
        for functions in lists:
            functions.append(act)
        try:
            yield
        finally:
            for functions in lists:
                functions.remove(act)


# Frames of a batch, and from how many objects on a run has a moving scene.
BATCHES = {"of 1": (1, 10**9), "of 5": (5, 10**9), "alone": (256, 0), "of 5, alone": (5, 0)}
USUAL = (
    "pauses_between_linear_keys", "between_frames", "a_sensor_that_moves", "noise_of_a_sensor",
    "a_chain_of_bones", "strips", "a_strip_of_changing_influence", "one_action_for_two",
    "cycles_of_keys", "a_driver_on_the_frame", "a_simulation_of_nodes", "a_falling_body",
    "a_wall_that_glows", "the_warmth_of_a_material", "a_load_on_a_pad", "bends", "is_instanced",
    "comes_with_what_hangs_on_it", "changes_what_sensors_are", "begins_late", "steps_on_a_pad",
    "held", "lamp_lit", "of_another_sensor", "part_is_moved_by_its_parent",
    "holder_within_a_holder_moves",
)  # fmt: skip


@pytest.mark.parametrize("name", mostly_slow(SCENES, *USUAL))
def test_each_way_of_running_reads_the_same(
    name: str, world: Any, tmp_path: Any, fcurves: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    world.curves_of = fcurves
    build, skips = SCENES[name]
    build(world, tmp_path)
    scenes = len(bpy.data.scenes)
    with everything_anew():
        plain, all_of_it = run(world)
    assert all_of_it.evaluated == all_of_it.steps
    readings = [v for t in plain.values() for v in (*t.value, *t.active) if not math.isnan(v)]
    assert len(set(readings)) > 1, "nothing that could be read otherwise"
    found, progress = run(world)
    assert found == plain
    if skips is not None:
        evaluated, steps = progress.evaluated, progress.steps
        assert (evaluated < steps / 1.3) == skips, f"{evaluated} of {steps}"
    monkeypatch.setattr(stage, "PROGRESS_INTERVAL", 1e9)
    for batches, (most, least) in BATCHES.items():
        monkeypatch.setattr(capture, "MOST_FRAMES", most)
        monkeypatch.setattr(moving_scene, "LEAST_OBJECTS", least)
        assert run(world)[0] == plain, f"in batches {batches}"
    # Nodes that read the whole scene keep their objects in it.
    assert len(bpy.data.scenes) == scenes


RADARS = ("pauses_between_linear_keys", "between_frames", "a_chain_of_bones",
          "a_simulation_of_nodes", "bends", "is_instanced", "comes_with_what_hangs_on_it",
          "begins_late")  # fmt: skip


@pytest.mark.parametrize(
    "name", mostly_slow(RADARS, "pauses_between_linear_keys", "bends", "begins_late")
)
def test_radars_measure_the_same_speeds_in_each_way_of_running(
    name: str, world: Any, tmp_path: Any, fcurves: Any, monkeypatch: pytest.MonkeyPatch, echoes: Any
) -> None:
    world.curves_of = fcurves
    SCENES[name][0](world, tmp_path)
    for rate in (3.0, 11.0):
        world.sensor("PRESENCE_RADAR", f"at {rate:g} Hz", None, update_rate=rate)

    def speeds(anew: bool = False) -> dict[Any, list[Any]]:
        echoes.clear()
        with everything_anew() if anew else nullcontext():
            run(world)
        return {key: one.speed.tolist() for key, one in echoes.items()}

    plain = speeds(anew=True)
    assert any(np.any(speed) for speed in plain.values()), "nothing moved"
    monkeypatch.setattr(stage, "PROGRESS_INTERVAL", 1e9)
    for batches, (most, least) in BATCHES.items():
        monkeypatch.setattr(capture, "MOST_FRAMES", most)
        monkeypatch.setattr(moving_scene, "LEAST_OBJECTS", least)
        assert speeds() == plain, f"in batches {batches}"


@pytest.mark.parametrize("name", ["part_is_hidden", "part_changes_shape", "holder_is_hidden"])
def test_a_change_within_an_instance_is_seen(name, world, each_caster, tmp_path):
    SCENES[name][0](world, tmp_path)
    rows = world.log(world.run())
    assert [(row[1], row[5]) for row in rows] == [("1", "0"), (str(SWITCHED), "1")]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("strips", "; nothing moved at 85 % of the steps\n"),
        ("a_driver_on_the_frame", "; no step could be skipped: a driver of 'wall' may follow the"),
        ("cycles_of_keys", "'wall' has animation without an end"),
    ],
)
def test_the_closing_line_tells_what_was_skipped_or_why_nothing_was(
    name, words, world, tmp_path, fcurves
):
    world.curves_of = fcurves
    SCENES[name][0](world, tmp_path)
    said = io.StringIO()
    line = ProgressLine(said, False)
    line.show(run(world)[1])
    line.finish(2.0, 48)
    assert words in said.getvalue()


def test_a_run_that_is_left_keeps_what_it_looked_at(world, tmp_path, monkeypatch):
    SCENES["begins_late"][0](world, tmp_path)
    world.scene.angen_substeps, world.scene.render.frame_map_new = 1, 100
    whole = run(world)[0]["all"]
    monkeypatch.setattr(capture, "MOST_FRAMES", 7)
    recording = Recording()
    steps = simulate(world.scene, world.sensors(), 1, 48, recording)
    for _ in range(3):
        next(steps)
    steps.close()
    track = recording.tracks["all"]
    assert 7 < len(track) < 48 and recording.frame_end == track.frames[len(track) - 1]
    assert list(track.active) == list(whole.active)[: len(track)]


def test_what_leaves_for_far_away_in_one_step_is_missed_there(world):
    """No ray passes near its new place: only the last hit shows that the ray must be cast again."""
    world.pir("pir")
    thing = world.box((1, 1, 1), (0, 0, -2), "thing")
    places = {1: (0, 0, -2), 5: (0, 0, -2.2), 9: (90, 0, 0), 13: (0, 0, -2), 17: (0, 70, 0)}
    world.key(thing, "location", places, "CONSTANT")
    seen = world.series(world.run(1, 20), "pir", "moved")
    assert [frame for frame, on in enumerate(seen, 1) if on] == [5, 9, 13, 17]


def test_what_returns_as_a_mesh_gets_other_faces_is_met_there(world):
    """The other faces end a batch of frames, and the door is where it was before that batch."""
    world.switch()
    world.door(6, 12, 18)
    blob = world.box((1, 1, 1), (9, 0, 0), "blob")
    blob.modifiers.new("finer", "SUBSURF")
    world.key(blob, 'modifiers["finer"].levels', {1: 1, 18: 2}, "CONSTANT")
    track = world.run(1, 20).tracks["switch"]
    assert [frame for frame, on in enumerate(track.active, 1) if on] == [*range(6, 12), 18, 19, 20]


# Random scenes, and edits


def place_sensors(world: Any) -> list[Any]:
    """Add detectors that are still, parented, constrained, with driven and keyed parameters."""
    random = np.random.default_rng(len(world.scene.objects))
    made = []
    for i in range(7):
        settings = {"vertical_fov": 0.6, "vertical_step": 0.2, "rays": 12, "range_max": 1.2}
        sensor = world.pir(f"pir {i}", **settings)
        sensor.location = random.uniform(-2.0, 2.0, 3)
        sensor.rotation_euler = random.uniform(-3.0, 3.0, 3)
        made.append(sensor)
    made[1].angen_sensor.pir.sweep = "ALL"
    carrier = world.link("carrier", None)
    for frame in (6, 14, 20):
        carrier.location = (0.1 * frame, 0.0, -0.05 * frame)
        carrier.keyframe_insert("location", frame=frame)
    made[2].parent = carrier
    made[3].constraints.new("COPY_LOCATION").target = carrier
    driver = made[4].driver_add("angen_sensor.pir.range_max").driver
    variable = driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = carrier, "location.x"
    variable.name, driver.expression = "x", "0.8 + x"
    world.key(made[5], "angen_sensor.enabled", {1: True, 8: False, 15: True}, "CONSTANT")
    made[6].angen_sensor.pir.noise_sigma = 0.02
    beam = world.switch("switch", range_max=4.0, threshold=1.0)
    beam.location, beam.rotation_euler = (-2.0, 0.0, 1.0), (0.3, 1.2, 0.0)
    return [*made, beam]


@pytest.mark.parametrize("instances", [False, True])
@pytest.mark.parametrize("seed", mostly_slow(range(3), 0))
def test_random_scenes_and_edits_during_a_run(world, monkeypatch, seed, instances):
    """Each kind of edit counts at once, as in a run that evaluates everything again."""
    RandomScene(seed, instances)
    placed = place_sensors(world)
    world.scene.frame_end = LAST_FRAME
    thing, settings = bpy.data.objects["mesh 1"], placed[0].angen_sensor
    thing.hide_viewport = False
    start, at = placed[0].location.copy(), placed[7].location.copy()
    scale, data, other = thing.scale.copy(), thing.data, bpy.data.objects["mesh 2"].data

    def shorten():
        settings.pir.range_max, placed[7].location.x = 0.4, at.x + 0.5

    def switch_off():
        settings.enabled, thing.scale = False, scale * 1.4

    def switch_on():
        settings.enabled, settings.pir.rays, thing.hide_viewport = True, 30, True

    def exchange():
        placed[0].location.z, thing.hide_viewport, thing.data = start.z + 0.3, False, other

    def put_back():
        settings.enabled, settings.pir.range_max, settings.pir.rays = True, 1.2, 12
        placed[0].location, placed[7].location = start, at
        thing.scale, thing.data, thing.hide_viewport = scale, data, False

    # An edit during a run counts from the next frame that is read on.
    monkeypatch.setattr(capture, "MOST_FRAMES", 1)
    edits = {4: shorten, 8: switch_off, 12: switch_on, 16: exchange}
    found = run(world)[0]
    edited = run(world, edits)[0]
    put_back()
    with everything_anew():
        assert run(world)[0] == found
        assert run(world, edits)[0] == edited
    assert edited["pir 0"] != found["pir 0"]
    assert sum(any(found[f"pir {i}"].active) for i in range(7)) >= 3


# At the playhead


@pytest.fixture
def afresh():
    """Clear what another test left."""
    memory.forget_file()


def played(world: Any) -> dict[str, dict[float, Any]]:
    """Return, by sensor, the updates shown while the playhead goes through the frames."""
    found: dict[str, dict[float, Any]] = {}
    for frame in range(world.scene.frame_start, world.scene.frame_end + 1):
        world.scene.frame_set(frame)
        for name, published in live_sensors.known_live().readings.items():
            found.setdefault(name, {})[published.frame] = published.reading
    return found


@pytest.mark.parametrize(
    "name",
    ["pauses_between_linear_keys", "a_sensor_that_moves", "settings_of_a_sensor",
     "a_driver_that_follows_keys", "a_driver_of_what_sensors_say", "a_load_on_a_pad", "moved",
     "part_is_hidden", "a_thing_that_comes_and_goes_before_warmth"],
)  # fmt: skip
def test_following_the_playhead_shows_what_a_run_records(name, world, afresh, tmp_path, fcurves):
    world.curves_of = fcurves
    SCENES[name][0](world, tmp_path)
    shown = played(world)
    tracks = run(world)[0]
    for sensor, readings in shown.items():
        track = tracks[sensor]
        then = {frame: n for n, frame in enumerate(track.frames)}
        assert readings and readings.keys() <= then.keys()
        for frame, reading in readings.items():
            values = track.active[then[frame]], track.value[then[frame]]
            assert (reading.active, reading.value) == values, (sensor, frame)


def test_a_setting_changed_while_it_plays_counts_from_the_next_frame_on(world, afresh):
    world.wall(0.3)
    sensor = world.switch(range_max=0.5, threshold=0.1)
    for frame, range_max, expected in ((1, 0.5, 0.3), (2, 0.5, 0.3), (3, 0.2, 0.2)):
        sensor.angen_sensor.optical_switch.range_max = range_max
        world.update()
        world.scene.frame_set(frame)
        value = live_sensors.known_live().readings["switch"].reading.value
        assert value == pytest.approx(expected, abs=1e-6)


# Beside other sensors


def test_a_run_of_one_sensor_reads_what_it_reads_among_all(world, command, tmp_path):
    """The switch, which the run leaves out, moves the wall."""
    followed(world)
    moved(world)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "home.blend"))
    all_rows = command("simulate", "--quiet")[1].splitlines()
    status, out, told = command("simulate", "--sensor", "lux", "--samples", tmp_path / "samples")
    rows = out.splitlines()
    assert status == 0 and rows == [r for r in all_rows if r.split(",")[2] in ("sensor", "lux")]
    assert len(rows) > 4
    assert "also simulated, since drivers read their outputs: 'switch'" in told
    # Only the chosen sensors are written.
    assert [path.name for path in (tmp_path / "samples").iterdir()] == ["lux.csv"]


CYCLES = {"engine": "CYCLES", "samples": 4, "update_rate": 24.0}
ADDED = {
    "range scan": ("PIR", {"rays": 9, "update_rate": 24.0}),
    "pyroelectric": ("PIR", {"model": "PYROELECTRIC", "update_rate": 24.0}),
    "switch": ("OPTICAL_SWITCH", {"update_rate": 24.0}),
    "swept switch": ("OPTICAL_SWITCH", {"swept": True, "update_rate": 2.0}),
    "pad": ("PRESSURE", {"update_rate": 24.0}),
    "walls by Cycles": ("LIGHT", {"method": "FOUR_WALL", **CYCLES}),
    "lux by Cycles": ("LIGHT", {"method": "ILLUMINANCE", **CYCLES}),
}
QUICK = ("range scan", "swept switch", "pad")
CROWDED = (
    "falling", "hidden_in_renders", "loose_bodies", "whole_scene_is_bodies",
    "bodies_without_a_world", "comes_with_what_hangs_on_it", "steps_on_a_pad", "a_chain_of_bones",
    "a_simulation_of_nodes", "a_driver_on_the_frame", "hair_that_grows", "part_is_hidden",
)  # fmt: skip


def furnish(world: Any, name: str, folder: Any) -> None:
    """Build the scene with a moving lamp, over six frames."""
    SCENES[name][0](world, folder)
    if "switch" not in world.scene.objects:
        watched_bodies(world)
    world.scene.frame_end = 6
    # Few paths, and more of them in the reference, as in a usual run.
    world.scene.angen_light_reference = 16
    shine = lamp(world, "AREA", at=(0, 0, 3), energy=10.0, size=0.5)
    world.key(shine, "location", {1: (0, 0, 3), 6: (1, 0, 3)})


def add(world: Any, what: str) -> Any:
    kind, settings = ADDED[what]
    if kind == "PRESSURE":
        obj = world.box((0.2, 0.2, 0.01), (2, 2, 0.005), "added")
    else:
        obj = world.link("added", None, (0.5, -0.5, 1.5))
    return world.sensor(kind, "added", obj, **settings)


def recorded(world: Any, *beside: str) -> dict[Any, str]:
    """Return every reading of a run to the bit, without the sensors `beside`."""
    return {
        (name, column): repr(list(values))
        for name, track in run(world)[0].items()
        if name not in beside
        for column, values in {**track.columns, "frame": track.frames}.items()
    }


def shown(world: Any, *beside: str) -> dict[Any, Any]:
    """Return the readings at the playhead at each frame, with light measured, in the same form."""
    live_sensors._current = None
    found = {}
    for frame in range(1, 7):
        world.scene.frame_set(frame)
        live = live_sensors.known_live()
        if live.has_waiting_light:
            live.measure_waiting(world.scene, bpy.context.view_layer)
        for name, reading in live.readings.items():
            if name not in beside:
                found[name, frame] = repr(reading), live_problem(name)
    return found


@pytest.mark.parametrize("name", ["falling", "steps_on_a_pad", "part_is_hidden"])
def test_sensors_without_cycles_change_nothing_in_a_run(world, name, tmp_path):
    """Quick cases of the next test."""
    furnish(world, name, tmp_path)
    expected = recorded(world)
    for what in QUICK:
        obj = add(world, what)
        assert recorded(world, "added") == expected, f"beside {what}"
        bpy.data.objects.remove(obj)


@pytest.mark.parametrize("name", mostly_slow(CROWDED))
def test_no_sensor_changes_what_the_others_read(world, name, tmp_path, fcurves):
    world.curves_of = fcurves
    furnish(world, name, tmp_path)
    in_run, live = recorded(world), shown(world)
    assert recorded(world) == in_run, "two runs are the same"
    meter = world.link("meter", None, (0.3, 0.3, 0.3))
    world.sensor("LIGHT", "meter", meter, method="ILLUMINANCE", **{**CYCLES, "update_rate": 12.0})
    assert recorded(world, "meter") == in_run
    assert shown(world, "meter") == live
    in_run, live = recorded(world), shown(world)
    for what in ADDED:
        obj = add(world, what)
        assert recorded(world, "added") == in_run, f"in a run beside {what}"
        assert shown(world, "added") == live, f"at the playhead beside {what}"
        bpy.data.objects.remove(obj)
