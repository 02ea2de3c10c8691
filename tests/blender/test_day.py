# SPDX-License-Identifier: GPL-3.0-or-later
"""A simulated day: readings equal those of every frame, events name their causes, the truth agrees.

The same holds for the sample homes, and for their light.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from datetime import date
from itertools import pairwise
from pathlib import Path
from typing import Any

import bpy
import day_home
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.explain.explain import explain
from bl_ext.user_default.angen_sensors.angen_addon.runtime import stillness
from bl_ext.user_default.angen_sensors.angen_addon.scene.sensors import all_sensors
from bl_ext.user_default.angen_sensors.residents.blender import daylight, run
from bl_ext.user_default.angen_sensors.residents.blender.daylight import Daylight
from bl_ext.user_default.angen_sensors.residents.days import rows
from bl_ext.user_default.angen_sensors.residents.days.rows import LEAD_S as lead
from mathutils import Vector
from tiers import mostly_slow


@pytest.fixture
def short_days(
    monkeypatch: pytest.MonkeyPatch, addon_part: Callable[[str], Any], request: Any
) -> float:
    """Shorten days to some minutes, split where there is more than some seconds of movement."""
    seconds: float = getattr(request, "param", 400.0)
    for name in ("residents.days.truth", "residents.days.rows", "residents.blender.run"):
        monkeypatch.setattr(addon_part(name), "DAY_S", seconds)
    monkeypatch.setattr(run, "MOST_MOVEMENT", 6.0)
    return seconds


def run_day(world: Any, acted: Any, number: int = 0, keys: Any = None) -> Any:
    living = day_home.part("residents.blender.run")
    residents = {"anna": world.bpy.data.objects["anna"]}
    keys = keys or day_home.BoxKeys()
    what = acted, residents, keys, number
    day = living.DayRun(world.scene, world.sensors(), *what)
    *_, last = day.progress()
    day.steps = last
    return day


@pytest.mark.parametrize("seed", mostly_slow(range(2), 1))
def test_a_day_reads_what_every_frame_of_it_does(
    world: Any, seed: int, short_days: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    day_home.build(world)
    acted = day_home.acted(seed, day=short_days)
    keys = day_home.BoxKeys()
    found = run_day(world, acted, seed, keys)
    assert len(keys.shown) > 3 and found.steps.evaluated < 0.2 * found.steps.steps

    every = stillness.Stillness(np.empty((0, 2)), ("as a reference",))
    monkeypatch.setattr(stillness, "find_stillness", lambda *_: every)
    monkeypatch.setattr(run, "MOST_MOVEMENT", 1e9)
    whole = day_home.BoxKeys()
    plain = run_day(world, acted, seed, whole)
    assert len(whole.shown) == 1 and plain.steps.evaluated == plain.steps.steps
    assert plain.recording.tracks == found.recording.tracks
    assert plain.events == found.events
    assert {e.sensor for e in found.events if e.time} == set(found.recording.tracks)


@pytest.mark.parametrize(
    ("ways", "short_days"),
    [(7, 240.0), pytest.param(12, 400.0, marks=pytest.mark.slow)],
    ids=["short", "long"],
    indirect=["short_days"],
)
def test_each_event_has_the_cause_that_explain_names(
    world: Any, ways: int, short_days: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The cause in the log is the object that Explain names for that frame, of each kind."""
    day_home.build(world)
    monkeypatch.setattr(run, "MOST_MOVEMENT", 1e9)
    day = run_day(world, day_home.acted(3, ways, short_days))
    compared: dict[str, set[str]] = {}
    with run.at_ten_frames(world.scene):
        for event in day.events:
            track = day.recording.tracks[event.sensor]
            index = int(np.argmin(np.abs(np.asarray(track.times) - event.time / 1e6 - lead)))
            if event.time and (track.active[index] or event.field != "moved"):
                sensor = next(s for s in world.sensors() if s.name == event.sensor)
                found = explain(world.scene, sensor, day.recording, index)
                assert event.because == found.cause_name, (event, found.as_text())
                compared.setdefault(event.sensor, set()).add(event.because)
    assert set(compared) == set(day.recording.tracks) and "anna" in compared["scan"]


def test_each_event_tells_who_and_what_made_it(world: Any, short_days: float) -> None:
    day_home.build(world)
    acted = day_home.acted(1, day=short_days)
    found = [e for e in run_day(world, acted).events if e.time]
    moved = [e for e in found if e.field == "moved"]
    assert {(e.because, e.person) for e in moved if e.value} <= {("anna", "anna"), ("door", "anna")}
    assert {(e.because, e.person) for e in moved if not e.value} == {("", "anna")}
    assert {e.because for e in found if e.sensor == "switch"} == {"door"}
    assert {e.because for e in found if e.sensor == "pad"} == {"anna"}
    lit = [e for e in found if e.sensor == "lux"]
    assert {"lamp", "lamp 2"} <= {e.because for e in lit} <= {"lamp", "lamp 2", ""}
    # A cushion over a pad, below a person, counts as that person's load.
    cushion = world.box((0.4, 0.4, 0.1), (0.4, 0.0, 0.5), "cushion")
    world.bpy.context.view_layer.update()
    acted.bodies["anna"].points[:] = (0.4, 0.0, 0.7)
    causes = day_home.part("residents.blender.causes").Causes
    found_out = causes(world.scene, [], None, acted, {"anna": world.bpy.data.objects["anna"]}, 0.0)
    assert found_out.person_of("cushion", 200.0) == "anna"
    cushion.location.x = 1.0
    world.bpy.context.view_layer.update()
    assert found_out.person_of("cushion", 200.0) == ""
    # Only its owner moves a walking frame.
    anna = world.bpy.data.objects["anna"]
    anna.angen_resident.walking_frame = world.box((0.4, 0.4, 0.9), (2.0, 1.0, 0.5), "frame")
    found_out = causes(world.scene, [], None, acted, {"anna": anna}, 0.0)
    assert found_out.person_of("frame", 200.0) == "anna"
    # Truth and data agree: whenever an object moves, a resident moves.
    spans = acted.spans(0.0, short_days)
    for event in moved:
        if event.value:
            time = event.time / 1e6
            assert ((spans[:, 0] <= time) & (time <= spans[:, 1] + 1.5)).any(), event


# Both sample homes


SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
START = date(2026, 3, 2)
# Seconds before and after each time at which all residents come to rest for at least as long.
AROUND = 8.0
# Light is left out: Cycles would take minutes.
KINDS = {"PIR", "OPTICAL_SWITCH", "PRESSURE", "CONTACT"}


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1])
@pytest.mark.parametrize(
    ("home", "week"), [("angen.blend", "week.toml"), ("atelier.blend", "atelier_week.toml")]
)
def test_a_random_stretch_reads_what_every_frame_of_it_does(
    home: str, week: str, seed: int, monkeypatch: pytest.MonkeyPatch, empty_scene: Any
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / home), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live = False
    sensors = [s for s in all_sensors(bpy.context.view_layer) if s.kind.identifier in KINDS]
    household = run.HouseholdDays(scene, sensors, run.Plan.read(SAMPLES / week), START, seed)
    random = np.random.default_rng(seed)
    number = int(random.integers(7))
    spans = household.acted(number).spans(3600.0, 82_800.0)
    rests = spans[1:, 0] - spans[:-1, 1]
    middle = float(random.choice(spans[:-1, 1][rests > AROUND]))
    told = f"{home}, seed {seed}, day {number}, {middle:.1f} s"
    # Detectors settle in fewer frames than days have before midnight.
    for module in (run, rows):
        monkeypatch.setattr(module, "LEAD_S", 10.0)

    def stretch() -> tuple[Any, Any]:
        with household.keyed() as keys:
            between = middle - AROUND, middle + AROUND
            what = household.acted(number), household.residents, keys, number, between
            day = run.DayRun(scene, sensors, *what)
            *_, last = day.progress()
        return day, last

    monkeypatch.setattr(run, "MOST_MOVEMENT", 3.0)
    found, steps = stretch()
    every = stillness.Stillness(np.empty((0, 2)), ("as a reference",))
    monkeypatch.setattr(stillness, "find_stillness", lambda *_: every)
    monkeypatch.setattr(run, "MOST_MOVEMENT", 1e9)
    plain, plain_steps = stretch()
    assert steps.evaluated < plain_steps.evaluated == plain_steps.steps == steps.steps, told
    assert set(plain.recording.tracks) == {sensor.name for sensor in sensors}, told
    differ = [n for n, t in plain.recording.tracks.items() if found.recording.tracks[n] != t]
    assert not differ, f"{differ}: {told}"
    assert plain.events == found.events, told
    # The stretch has motion to sense.
    seen = [n for n, t in plain.recording.tracks.items() if np.asarray(t.active).any()]
    assert seen, told


# Light by Cycles on a day in the sample home


HOME = Path(__file__).resolve().parents[2] / "sample_blends" / "angen.blend"
# Seconds in which a resident walks all the time; the sun moves at NEXT.
BEGIN, NEXT, END = 45_591.0, 45_600.0, 45_608.0
# Seconds in which the bathroom's lamp goes off; a resident walks until LEFT.
OFF, LEFT = 25_762.0, 25_786.0
SENSORS = "Light sensor bedroom", "Light sensor kitchen"


@pytest.fixture
def lived(monkeypatch: pytest.MonkeyPatch, empty_scene: Any) -> Callable[..., Any]:
    """Return readings of light by sensor and second, of a stretch of a day."""
    bpy.ops.wm.open_mainfile(filepath=str(HOME), load_ui=False)
    scene = bpy.context.scene
    scene.angen_live, scene.angen_light_reference = False, 1024
    every = all_sensors(bpy.context.view_layer)
    plan = run.Plan.read(HOME.with_name("week.toml"))
    # The actions of residents do not depend on the sensors.
    household = run.HouseholdDays(scene, every, plan, START, 1)
    acted = household.acted(0)
    # The resistor of a light sensor lags by seconds; here the light itself is compared.
    for module in (run, rows):
        monkeypatch.setattr(module, "LEAD_S", 4.0)
    monkeypatch.setattr(run, "TILTS_BACK", 1)

    def live(
        begin: float = BEGIN, end: float = END, names: Sequence[str] = SENSORS, most: float = 1e9
    ) -> Any:
        monkeypatch.setattr(run, "MOST_MOVEMENT", most)
        sensors = [s for s in every if s.name in names]
        for sensor in sensors:
            light = sensor.settings.light
            light.samples, light.report_step = 64, 0.1
        with household.keyed() as keys, Daylight(scene, sensors, START):
            what = acted, household.residents, keys, 0, (begin, end), False
            day = run.DayRun(scene, sensors, *what)
            *_, _ = day.progress()
        assert "angen_light_begins" not in scene
        return readings(day.recording.tracks)

    return live


def readings(tracks: Any) -> dict[str, dict[float, float]]:
    return {
        name: dict(zip(np.asarray(track.frames), np.asarray(track.value), strict=True))
        for name, track in tracks.items()
    }


@pytest.mark.slow
def test_readings_are_of_their_frames_alone(lived: Any) -> None:
    found = lived()
    assert lived(most=3.0) == found
    for name in SENSORS:
        assert lived(names=[name]) == {name: found[name]}
    for begin, end in ((NEXT + 4.0, END), (BEGIN, NEXT - 4.0)):
        part = lived(begin, end)
        for name in SENSORS:
            assert len(part[name]) >= 8
            assert part[name].items() <= found[name].items(), (name, begin)
    assert all(len(set(found[name].values())) > 1 for name in SENSORS)


@pytest.mark.slow
def test_a_run_that_begins_with_a_lamp_off_reads_what_one_does_in_which_it_was_on(
    lived: Any,
) -> None:
    """Cycles distributes light paths by the brightest value of each lamp."""
    found = lived(OFF - 6.0, LEFT)
    later = lived(OFF + 6.0, LEFT)
    for name in SENSORS:
        assert len(later[name]) >= 8
        assert later[name].items() <= found[name].items(), name


# The sun of a home with a place on Earth follows date and hour, and is restored


NOON = 1 + 10 * 12 * 3600


def test_sun_and_sky_follow_the_hour(world: Any) -> None:
    world.sensor("LIGHT", "lux")
    sun = world.link("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 2.0, (math.radians(60), 0, 0)
    sky = bpy.data.worlds.new("Sky")
    sky.use_nodes, world.scene.world = True, sky
    strength = sky.node_tree.nodes["Background"].inputs["Strength"]
    world.update()

    def at(frame: int) -> tuple[float, float, Vector]:
        world.scene.frame_set(frame)
        return (
            sun.data.energy,
            strength.default_value,
            sun.matrix_world.to_3x3() @ Vector((0, 0, 1)),
        )

    # Without a place on Earth, the sun stays.
    with daylight.Daylight(world.scene, world.sensors(), date(2026, 6, 21)):
        assert at(1)[:2] == (2.0, 1.0)
    assert daylight.Daylight(world.scene, world.sensors(), date(2026, 6, 21)).changes() == []
    site = world.scene.angen_site
    site.latitude, site.longitude, site.utc_offset = math.radians(59.33), math.radians(18.07), 1
    # Up from 2:31 to 21:08 by winter time, it goes on every ten minutes.
    changes = daylight.Daylight(world.scene, world.sensors(), date(2026, 6, 21)).changes()
    assert (changes[0], changes[-1]) == pytest.approx((2.5 * 3600, 21.2 * 3600), abs=600)
    assert {b - a for a, b in pairwise(changes)} == {600.0}
    with daylight.Daylight(world.scene, world.sensors(), date(2026, 6, 21)):
        energy, sky_now, way = at(NOON)
        # At the solstice it is 54.1° high at noon, in the south: more than at the file's 30°.
        assert math.degrees(math.asin(way.z)) == pytest.approx(54.1, abs=0.3)
        assert way.y < -0.5 and abs(way.x) < 0.1
        assert energy > 2.0 and sky_now > 1.0
        dark = at(1)
        assert dark[0] == 0.0 and 0.0 < dark[1] < 0.01
    with daylight.Daylight(world.scene, world.sensors(), date(2026, 12, 21)):
        low = at(NOON)
        assert math.degrees(math.asin(low[2].z)) == pytest.approx(7.3, abs=0.3)
        assert 0.0 < low[0] < energy and low[1] < sky_now
    assert at(1)[:2] == (2.0, 1.0) and sun.rotation_mode == "XYZ"
    assert sun.rotation_euler.x == pytest.approx(math.radians(60))
    assert not bpy.data.actions
