# SPDX-License-Identifier: GPL-3.0-or-later
"""Explanations of readings: their facts are those of the sensor's own rays, noise and threshold."""

import math
import random

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.scene.light import probe
from bl_ext.user_default.angen_sensors.angen_addon.scene.light.cycles import Light as light
from bl_ext.user_default.angen_sensors.sensor_logic.kinds.light import shares_at
from bl_ext.user_default.angen_sensors.sensor_logic.logs.error import AngenError
from bl_ext.user_default.angen_sensors.sensor_logic.recording.file import from_bytes, to_bytes
from light_stage import lamp, material, plate, sky
from mathutils import Vector

G = 9.81


@pytest.fixture
def explained(world):
    """Simulate, and explain update `index` of the object's sensor; return (track, explanation)."""

    def run(obj, index, recording=None):
        sensor = next(s for s in world.sensors() if s.object == obj)
        recording = recording or world.run()
        track = recording.tracks[obj.name]
        found = explain(world.scene, sensor, recording, index)
        return track, found

    return run


def first_active(recording, name):
    return list(recording.tracks[name].active).index(1)


# Motion detectors


def test_what_comes_before_a_wall_is_named(world, explained, each_caster):
    world.wall(3.0)
    box = world.box((1, 1, 1), at=(9, 0, -2.0), name="Box")
    world.key(box, "location", {1: (9, 0, -2.0), 10: (0, 0, -2.0)}, "CONSTANT")
    obj = world.pir(rays=1, range_max=4.0)
    recording = world.run()
    index = first_active(recording, "pir")
    track, found = explained(obj, index, recording)
    assert track.frames[index] == found.frame == 10
    cause = found.cause
    assert (cause.culprit, cause.names) == ("Box", ("wall", "Box"))
    assert (cause.before, cause.after) == pytest.approx((3.0, 1.5), abs=1e-5)
    assert cause.over == (("Box", 1),)
    assert found.headline == "Motion: 'Box' came in front of 'wall'; ray 0 changed by 1.500 m"
    assert dict(found.facts)["Compared with"] == "frame 9 (0.333 s)"
    assert not found.doubt
    assert world.scene.frame_current == 1


def test_what_left_what_moved_and_nothing_behind(world, explained):
    box = world.box((1, 1, 1), at=(0, 0, -2.0), name="Box")
    places = {1: (0, 0, -2.0), 5: (0, 0, -2.5), 9: (9, 0, -2.5), 13: (0, 0, -2.5)}
    world.key(box, "location", places, "CONSTANT")
    obj = world.pir(rays=1, range_max=4.0)
    recording = world.run()
    told = {f: explained(obj, f - 1, recording)[1] for f in (1, 2, 5, 9, 13)}
    assert "first scan" in told[1].headline
    assert told[1].cause is None
    assert not told[2].cause.triggered
    assert "no ray" in told[2].headline
    assert "'Box' moved away" in told[5].headline
    assert told[5].cause.change == pytest.approx(0.5, abs=1e-5)
    assert "'Box' left" in told[9].headline
    assert told[9].cause.names == ("Box", "")
    assert told[9].cause.after == 4.0
    assert "'Box' came in" in told[13].headline
    assert not any(found.doubt for found in told.values())


def test_noise_alone_and_the_sensors_own_movement(world, explained):
    world.wall(2.0)
    obj = world.pir(rays=9, threshold=0.05, noise_sigma=0.05)
    recording = world.run()
    index = first_active(recording, "pir")
    _, found = explained(obj, index, recording)
    assert found.cause.culprit == "noise"
    assert "noise alone" in found.headline
    obj.angen_sensor.pir.noise_sigma = 0.0
    world.key(obj, "location", {1: (0, 0, 0), 20: (0, 0, 0.3)}, "CONSTANT")
    _, found = explained(obj, 19)
    assert "the sensor itself moved by 0.300 m" in dict(found.facts)["Sensor"]


def stage(world, seed):
    """Add a room of walls in which boxes wander and jump; no mesh deforms."""
    numbers = random.Random(seed)
    for i, (x, z) in enumerate([(0, -4), (4, 0), (-4, 0), (0, 4)]):
        size = (8, 3, 0.1) if z else (0.1, 3, 8)
        world.box(size, at=(x, 0, z), name=f"wall {i}")
    for i in range(5):
        box = world.box([numbers.uniform(0.2, 0.8) for _ in range(3)], name=f"box {i}")
        keys = {
            frame: [numbers.uniform(-3, 3), numbers.uniform(-1, 1), numbers.uniform(-3, -0.8)]
            for frame in (1, 12, 20, 30)
        }
        world.key(box, "location", keys, numbers.choice(["LINEAR", "CONSTANT"]))


@pytest.mark.parametrize("caster", ["FAST", "SCENE"])
@pytest.mark.parametrize(
    ("sweep", "noise", "substeps"), [("SAWTOOTH", 0.0, 1), ("ALL", 0.02, 1), ("SAWTOOTH", 0.01, 3)]
)
def test_it_names_a_ray_over_the_threshold_exactly_where_the_model_says_moved(
    world, explained, caster, sweep, noise, substeps
):
    """The named object is the one that Blender's own ray cast hits on that ray."""
    stage(world, substeps + len(sweep))
    scene = world.scene
    scene.angen_ray_caster, scene.frame_end, scene.angen_substeps = caster, 30, substeps
    obj = world.pir(
        rays=15,
        vertical_fov=math.radians(60),
        vertical_step=math.radians(20),
        sweep=sweep,
        noise_sigma=noise,
        threshold=0.1,
        update_rate=10.0,
        range_max=6.0,
        range_min=0.05,
    )
    obj.location = (0.1, 0.05, 0.2)
    obj.rotation_euler = (0.1, 0.2, 0.0)
    recording = world.run()
    track = recording.tracks["pir"]
    assert 2 < sum(track.active) < len(track)
    named = set()
    for index in range(len(track)):
        _, found = explained(obj, index, recording)
        cause, moved = found.cause, bool(track.active[index])
        assert not found.doubt, (index, found)
        if cause is None:
            assert not moved
            continue
        assert cause.triggered == moved
        assert (cause.change > 0.1) == moved
        assert bool(cause.over) == moved
        angle = track.columns["angle_rad"][index]
        assert not moved or -cause.elevation == pytest.approx(angle)
        whole = not (track.frames[index] % 1.0)
        # A change by noise alone, below the threshold, has no ray.
        assert cause.ray >= 0 or not moved
        if whole and cause.ray >= 0:
            name, length = what_is_there(world, obj, cause, int(track.frames[index]))
            assert cause.names[1] == name, (index, found)
            assert abs(cause.after - length) < 1e-4 + 6 * noise
        named.add(cause.culprit)
    assert len(named - {"noise"}) > 1


def what_is_there(world, obj, cause, frame):
    """Return name and range (m) of the object that Blender's ray cast hits on a cause's ray."""
    scene, settings = world.scene, obj.angen_sensor.pir
    scene.frame_set(frame)
    a, t = cause.azimuth, -cause.elevation
    ahead = Vector((-math.sin(a), -math.cos(a) * math.sin(t), -math.cos(a) * math.cos(t)))
    way = (obj.matrix_world.to_3x3() @ ahead).normalized()
    start = obj.matrix_world.translation + way * settings.range_min
    reach = settings.range_max - settings.range_min
    hit, place, _, _, seen, _ = scene.ray_cast(world.update(), start, way, distance=reach)
    if not hit:
        return "", settings.range_max
    return seen.name, (place - start).length + settings.range_min


def test_instances_are_named_with_what_brings_them_forth(world, explained):
    inner = bpy.data.collections.new("set")
    chair = bpy.data.objects.new("Chair", world.box((1, 1, 1), at=(0, 0, 50)).data)
    inner.objects.link(chair)
    empty = world.instance("Dining", inner, (0, 0, -2))
    world.key(empty, "location", {1: (9, 0, -2), 5: (0, 0, -2)}, "CONSTANT")
    obj = world.pir(rays=1)
    _, found = explained(obj, 4)
    assert found.cause.culprit == "Chair in Dining"


def test_outputs_that_drive_the_scene_are_as_they_were_in_the_run(world, explained):
    """A wall moves when the detector fires, which makes it fire again."""
    wall = world.wall(2.0)
    box = world.box((0.5, 0.5, 0.5), at=(9, 0, -1.0), name="Box")
    world.key(box, "location", {1: (9, 0, -1), 6: (0, 0, -1), 8: (9, 0, -1)}, "CONSTANT")
    obj = world.pir(rays=1)
    driver = wall.driver_add("location", 2).driver
    driver.type = "SCRIPTED"
    variable = driver.variables.new()
    variable.name = "on"
    variable.targets[0].id = obj
    variable.targets[0].data_path = "angen_sensor.active"
    driver.expression = "-2.0 - 0.5 * on"
    recording = world.run()
    track = recording.tracks["pir"]
    for index in range(1, len(track)):
        _, found = explained(obj, index, recording)
        assert not found.doubt, index
        assert found.cause.triggered == bool(track.active[index])
    assert sum(track.active) > 2
    assert not obj.angen_sensor.active


def test_what_is_explained_is_the_run_whatever_the_scene_is_now(world, explained):
    box = world.box((1, 1, 1), at=(0, 0, -2.0), name="Box")
    world.key(box, "location", {1: (9, 0, -2.0), 5: (0, 0, -2.0)}, "CONSTANT")
    sensors = world.pir(rays=1), world.switch(range_max=3.0, threshold=2.0)
    recording = world.run()
    told = [explained(sensor, 4, recording)[1] for sensor in sensors]
    assert [one.cause_name for one in told] == ["Box", "Box"]
    bpy.data.objects.remove(box)
    for sensor in sensors:
        sensor.angen_sensor.pir.rays = 7
    assert [explained(sensor, 4, recording)[1] for sensor in sensors] == told


def test_a_recording_from_a_file_explains_the_same_and_one_without_evidence_is_refused(
    world, explained
):
    box = world.box((1, 1, 1), at=(0, 0, -2.0), name="Box")
    world.key(box, "location", {1: (9, 0, -2.0), 5: (0, 0, -2.0)}, "CONSTANT")
    obj = world.pir(rays=1)
    recording = world.run(1, 8)
    told = [explained(obj, i, recording)[1] for i in range(8)]
    again = from_bytes(to_bytes(recording, {}))[0]
    again.tracks["pir"].uid = recording.tracks["pir"].uid
    assert [explained(obj, i, again)[1] for i in range(8)] == told
    again.tracks["pir"].evidence.updates = 0
    with pytest.raises(AngenError, match=r"does not tell why 'pir' read this: simulate again"):
        explained(obj, 4, again)


# Switches


def test_what_breaks_a_beam_and_no_longer_does(world, explained, each_caster):
    flag = world.box((0.1, 0.1, 0.01), at=(0, 0, -0.025), name="Flag")
    places = {1: (0, 0, -0.025), 6: (1, 0, -0.025), 11: (0, 0, -0.025)}
    world.key(flag, "location", places, "CONSTANT")
    world.wall(0.3)
    obj = world.switch()
    recording = world.run()
    told = {f: explained(obj, f - 1, recording)[1] for f in (1, 6, 11)}
    assert told[1].headline.startswith("Closed: 'Flag' breaks the beam 0.020 m")
    assert told[1].cause.before is None
    assert told[6].headline == "Open: 'Flag' no longer breaks the beam, which reaches 'wall'"
    assert told[6].cause.before.range == pytest.approx(0.02, abs=1e-6)
    assert told[6].cause.now.range == pytest.approx(0.3, abs=1e-6)
    assert "'Flag' at 0.020 m" in dict(told[11].facts)["Now"]
    assert not any(found.doubt for found in told.values())


# Pads


def test_who_presses_with_how_much(physics, world, explained):
    physics.floor()
    pad = physics.pad("pad", (0.5, 0.5, 0.01), threshold=5.0, update_rate=24.0)
    physics.body("Light box", (0.1, 0.1, 0.1), (-0.2, 0, 0.12), 3.0)
    physics.body("Heavy box", (0.1, 0.1, 0.1), (0.2, 0, 0.12), 5.0)
    _, found = explained(pad, 24)
    assert not found.doubt
    names, newtons = zip(*found.cause.partners, strict=True)
    assert names == ("Heavy box", "Light box")
    assert newtons == pytest.approx((5 * G, 3 * G), rel=5e-3)
    assert found.cause.force == pytest.approx(8 * G, rel=5e-3)
    assert found.cause.force == pytest.approx(sum(newtons), rel=1e-9)
    assert found.cause.centre[0] == pytest.approx(0.2 * (5 - 3) / 8, abs=2e-3)
    assert found.headline.startswith("Pressed by 'Heavy box' with 49.")


# Light


@pytest.fixture
def meter(world):
    """Add a lux meter that looks up, 1 lx per W/m², with further settings."""
    world.scene.angen_luminous_efficacy = 1.0

    def make(**settings):
        given = {"method": "ILLUMINANCE", "samples": 256, "update_rate": 24.0, "threshold": 1.0}
        sensor = world.sensor("LIGHT", "light", **given | settings)
        sensor.rotation_euler = (math.pi, 0, 0)
        return sensor

    return make


@pytest.mark.parametrize("reference", [0, 4096])
def test_each_source_has_its_share_of_the_reading(world, explained, meter, reference):
    """The shares of all sources add up to the reading.

    Point lamps above a face give Φ cos θ / (4π r²); one is behind a plate. Two share their data, a
    panel glows, the sky shines, and a wall reflects light.
    """
    world.scene.angen_light_reference = reference
    one = lamp(world, "POINT", at=(0, 0, 2), energy=100.0)
    one.name = "One"
    lamp(world, "POINT", at=(0, 0, 4), energy=100.0).name = "Two"
    lamp(world, "POINT", at=(3, 0, 1), energy=500.0).name = "Hidden"
    shared = lamp(world, "POINT", at=(0, 1, 2), energy=10.0)
    shared.name = "Left"
    world.link("Right", shared.data, (0, -1, 2))
    # Black, so that no light of the hidden lamp is reflected.
    world.box((0.1, 40, 40), at=(1.5, 0, 0), name="Plate").data.materials.append(material(1e-9))
    plate(world, 0.2, (-0.5, 0, 1), (0, 0, -1), material(glows=1.0))
    sky(world, 0.05)
    sensor = meter(samples=4096)
    world.key(one.data, "energy", {1: 0.0, 6: 100.0}, "CONSTANT")
    recording = world.run(1, 8)
    track, found = explained(sensor, 5, recording)
    shares = {share.names or share.source: share.light for share in found.cause.now}
    assert shares["One",] == pytest.approx(100 / (4 * math.pi * 4), rel=0.05)
    assert shares["Two",] == pytest.approx(100 / (4 * math.pi * 16), rel=0.05)
    assert shares["Left", "Right"] == pytest.approx(20 * 2 / (4 * math.pi * 5**1.5), rel=0.05)
    assert shares["Hidden",] == pytest.approx(0.0, abs=1e-4)
    # The part of the half space that the plate leaves free.
    seen = (1 + 1.45 / math.hypot(1.45, 20)) / 2
    assert shares["World"] == pytest.approx(0.05 * math.pi * seen, rel=0.05)
    assert shares["Other sources"] == pytest.approx(0.04 / 1.25**2, rel=0.05)
    assert sum(shares.values()) == pytest.approx(track.value[5], rel=1e-6)
    assert found.headline == f"Lit: 'One' changed from 0 lx to {shares['One',]:.3g} lx"
    assert found.cause_name == "One"
    facts = dict(found.facts)
    assert facts["Reading"].endswith("(Cycles)") and "Hidden" not in facts
    assert facts["All light"] == facts["Reading"].removesuffix(" (Cycles)")
    assert {"Left, Right", "World", "Other sources"} <= facts.keys()
    _, later = explained(sensor, 6, recording)
    share = 100 * shares["One",] / track.value[5]
    assert later.headline == f"Lit: 'One' gives {share:.0f} % of the light"


def test_shares_of_four_walls_are_in_percent_and_those_of_dimmed_lamps_follow(
    world, explained, meter
):
    box = world.box((4, 4, 4))
    box.data.materials.append(material(0.5))
    lamps = [lamp(world, "POINT", at=(0, y, 0), energy=3.0) for y in (-0.1, 0.1)]
    lamps[0].name, lamps[1].name = "Steady", "Dimmed"
    world.key(lamps[1].data, "energy", {1: 3.0, 3: 1.5}, "CONSTANT")
    sensor = meter(method="FOUR_WALL", threshold=10.0)
    recording = world.run(1, 4)
    track, found = explained(sensor, 2, recording)
    then, now = ({s.names: s.light for s in shares_at(track, index)} for index in (1, 2))
    assert now["Dimmed",] == pytest.approx(then["Dimmed",] / 2, rel=1e-5)
    assert now["Steady",] == pytest.approx(then["Steady",], rel=1e-5)
    # The reading itself is in whole counts of 8 bits.
    assert sum(now.values()) == pytest.approx(track.value[2], abs=100 / 255)
    assert "'Dimmed' changed from" in found.headline and "%" in found.headline


@pytest.mark.parametrize("power", [-60.0, -1000.0])
def test_a_lamp_that_takes_light_away_is_told_of(world, explained, meter, power):
    """A negative lamp takes away its share; a reading is never negative."""
    lamp(world, "POINT", at=(0, 0, 2), energy=100.0).name = "Plus"
    lamp(world, "POINT", at=(0, 0, 4), energy=power).name = "Minus"
    sensor = meter(samples=4096)
    recording = world.run(1, 2)
    _, found = explained(sensor, 1, recording)
    facts, away = dict(found.facts), -power / 100.0 / 4.0
    assert facts["Plus"].endswith(", 100 % of all")
    taken = facts["Minus"].removesuffix(" % of all").rpartition(", ")[2]
    assert float(taken) == pytest.approx(100 * away, rel=0.05)
    reading = recording.tracks["light"].value[1]
    if away < 1.0:
        assert found.headline == "Lit: 'Plus' gives 100 % of the light"
        assert facts["All light"] == f"{reading:.3g} lx"
    else:
        assert reading == 0.0 and found.headline == "Dark: 'Minus' takes the light away"
        assert facts["All light"].startswith("-")


def test_without_light_nothing_is_named(world, explained, meter):
    world.scene.world = None
    _, found = explained(meter(samples=4), 1)
    assert (found.headline, found.cause_name) == ("Dark: no light reaches it", "")
    assert dict(found.facts)["All light"] == "0 lx"


def test_eevee_tells_no_lamp(world, explained, meter, monkeypatch):
    """It is not rendered again, because its picture has no light groups."""
    asked = []

    def by_eevee(scene, view_layer, group):
        asked.append(group)
        return {request.name: light(np.full(3, 2.0)) for request in group}, []

    monkeypatch.setattr(probe.engine, "why_no_eevee", lambda: "")
    monkeypatch.setattr(probe, "_by_eevee", by_eevee)
    lamp(world, "POINT")
    sensor = meter(engine="EEVEE")
    recording = world.run(1, 2)
    count = len(asked)
    _, found = explained(sensor, 1, recording)
    assert count and len(asked) == count
    assert found.headline == "Lit: EEVEE cannot tell lamps apart: set Engine to Cycles"
    assert dict(found.facts)["Reading"] == "2.00 lx (EEVEE)"
    assert found.cause_name == "" and "All light" not in dict(found.facts)


# Pyroelectric detectors


def test_the_warm_thing_that_moves_is_named(world, explained):
    """A warm box crosses the zones, before a still colder one and a wall."""
    world.wall(4.0, size=8.0)
    still = world.box((0.4, 1.0, 0.4), at=(-1.0, 0, -3.0), name="Still")
    walker = world.box((0.5, 1.7, 0.3), at=(-3, 0, -2.5), name="Walker")
    for obj, celsius in ((still, 60.0), (walker, 34.0)):
        obj.angen_warmth.use_temperature, obj.angen_warmth.temperature = True, celsius
    world.key(walker, "location", {1: (-3, -0.3, -2.5), 12: (-3, -0.3, -2.5), 48: (3, -0.3, -2.5)})
    obj = world.sensor("PIR", "pir", model="PYROELECTRIC", update_rate=24.0)
    recording = world.run()
    track = recording.tracks["pir"]
    index = list(track.active).index(1)
    assert index > 11
    _, found = explained(obj, index, recording)
    assert abs(found.cause.signal) > 1.0
    assert found.cause.things[0].name == "Walker"
    assert found.cause.things[0].temperature == pytest.approx(34 + 273.15)
    assert found.headline.startswith("Motion: 'Walker' changed the radiation")
    _, before = explained(obj, 8, recording)
    assert abs(before.cause.signal) < 1.0
    assert "nothing warmer or colder" in before.headline
