# SPDX-License-Identifier: GPL-3.0-or-later
"""A run leaves out what cannot have changed: it reads the same as one that leaves out nothing."""

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import simulation
from bl_ext.user_default.angen_sensors.angen_addon.runtime.probes import Probes
from bl_ext.user_default.angen_sensors.angen_addon.runtime.sensor_runner import SensorRunner
from bl_ext.user_default.angen_sensors.angen_addon.runtime.time_base import clock_of
from bl_ext.user_default.angen_sensors.angen_addon.scene import sensors
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays import frames
from bl_ext.user_default.angen_sensors.angen_addon.scene.rays.caster import RayCaster
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording
from random_scene import LAST_FRAME, RandomScene
from tiers import mostly_slow


def plainly(monkeypatch):
    """Frame by frame, every bundle is cast anew and every sensor read anew."""
    see_at = RayCaster.see_at

    def anew(self, sensor, bundle, *rest):
        self._bundles.pop((sensor, bundle), None)
        return see_at(self, sensor, bundle, *rest)

    monkeypatch.setattr(frames, "MOST_FRAMES", 1)
    monkeypatch.setattr(SensorRunner, "steady", property(lambda _: False, lambda *_: None))
    monkeypatch.setattr(RayCaster, "see_at", anew)


def content(recording):
    """All that a run read, to the bit, but for the session's numbers."""
    found = {}
    for name, track in recording.tracks.items():
        columns = [track.frames, track.active, track.value, *track.columns.values()]
        found[name] = [np.array(c).tobytes() for c in columns]
    return found


def moving_empty(name, frames):
    empty = bpy.data.objects.new(name, None)
    bpy.context.scene.collection.objects.link(empty)
    for frame in frames:
        empty.location = (0.1 * frame, 0.0, -0.05 * frame)
        empty.keyframe_insert("location", frame=frame)
    return empty


def place_sensors(world, scene):
    """Detectors that stand, are carried, follow a constraint, have driven and keyed parameters."""
    random = np.random.default_rng(len(scene.objects))
    made = []
    for i in range(7):
        settings = {"vertical_fov": 0.6, "vertical_step": 0.2, "rays": 12, "range_max": 1.2}
        sensor = world.pir(f"pir {i}", **settings)
        sensor.location = random.uniform(-2.0, 2.0, 3)
        sensor.rotation_euler = random.uniform(-3.0, 3.0, 3)
        made.append(sensor)
    made[1].angen_sensor.pir.sweep = "ALL"
    carrier = moving_empty("carrier", (6, 14, 20))
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


def run(scene, edits):
    """A run, with `edits` made to the scene after some of its frames."""
    recording = Recording()
    bpy.context.view_layer.update()
    every = sensors.all_sensors(bpy.context.view_layer)
    for done in simulation.simulate(scene, every, 1, LAST_FRAME, recording):
        edit = edits.get(round(done.frame))
        if edit is not None:
            edit()
    return content(recording)


@pytest.mark.parametrize("instances", [False, True])
@pytest.mark.parametrize("seed", mostly_slow(range(3), 0))
def test_a_run_reads_the_same_as_one_that_looks_at_everything(world, monkeypatch, seed, instances):
    random_scene = RandomScene(seed, instances)
    placed = place_sensors(world, world.scene)
    assert len(placed) == 8
    first = run(random_scene.scene, {})
    plainly(monkeypatch)
    assert run(random_scene.scene, {}) == first
    moved = [sum(np.frombuffer(first[f"pir {i}"][1], np.int8)) for i in range(7)]
    assert sum(m > 0 for m in moved) >= 3


@pytest.mark.parametrize("seed", mostly_slow(range(4), 0))
def test_edits_during_a_run_are_seen_at_once(world, monkeypatch, seed):
    """Each kind of edit, with the shortcuts and without, from the same state."""
    RandomScene(seed, False)
    placed = place_sensors(world, world.scene)
    scene = world.scene
    thing = bpy.data.objects["mesh 1"]
    thing.hide_viewport = False

    def change(value):
        def edit():
            settings = placed[0].angen_sensor
            if value == 1:
                settings.pir.range_max = 0.4
                placed[7].location.x += 0.5
            elif value == 2:
                settings.enabled = False
                thing.scale *= 1.4
            elif value == 3:
                settings.enabled = True
                settings.pir.rays = 30
                thing.hide_viewport = True
            elif value == 4:
                placed[0].location.z += 0.3
                thing.hide_viewport = False
                thing.data = bpy.data.objects["mesh 2"].data

        return edit

    def back():
        settings = placed[0].angen_sensor
        settings.enabled, settings.pir.range_max, settings.pir.rays = True, 1.2, 12
        placed[0].location, placed[7].location = start, at
        thing.scale, thing.data, thing.hide_viewport = scale, data, False

    monkeypatch.setattr(frames, "MOST_FRAMES", 1)
    start, at = placed[0].location.copy(), placed[7].location.copy()
    scale, data = thing.scale.copy(), thing.data
    edits = {4 * i: change(i) for i in (1, 2, 3, 4)}
    unchanged = run(scene, {})
    first = run(scene, edits)
    back()
    plainly(monkeypatch)
    assert run(scene, edits) == first
    assert first["pir 0"] != unchanged["pir 0"]


def test_what_a_sensor_names_is_read_anew(world):
    """A text or a collection can change without the sensor."""
    sensor = world.pir("pyro", model="PYROELECTRIC", lens_table=bpy.data.texts.new("lens"))
    table = sensor.angen_sensor.pir.lens_table
    table.write("0, 0, 10, 10, +, 1\n6, 0, 10, 10, -, 1\n")
    plain = world.pir("plain")
    clock = clock_of(world.scene)
    probes = Probes(world.scene)
    depsgraph = world.update()
    probes.look(depsgraph, None)
    found = {}
    for one in world.sensors():
        here = SensorRunner(one, clock)
        before = here.take(0, 0, depsgraph, probes).parameters
        table_before = before.lens_table
        if one.object == sensor:
            table.write("12, 0, 10, 10, +, 1\n")
            probes.note_edits()
        after = here.take(1, 1, depsgraph, probes).parameters
        found[one.name] = table_before != after.lens_table
    assert found == {"pyro": True, "plain": False}
    assert plain.animation_data is None


def test_what_leaves_for_far_away_in_one_step_is_missed_there(world):
    """Where it is now, no ray comes near it: only that it was met says that it must be cast."""
    world.pir("pir")
    thing = world.box((1, 1, 1), (0, 0, -2), "thing")
    places = {1: (0, 0, -2), 5: (0, 0, -2.2), 9: (90, 0, 0), 13: (0, 0, -2), 17: (0, 70, 0)}
    world.key(thing, "location", places, "CONSTANT")
    moved = world.series(world.run(1, 20), "pir", "moved")
    assert [frame for frame, on in enumerate(moved, 1) if on] == [5, 9, 13, 17]
