# SPDX-License-Identifier: GPL-3.0-or-later
"""Which pictures a run takes for its light sensors, and when."""

import bpy
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime.simulation import simulate
from bl_ext.user_default.angen_sensors.sensor_logic.recording.tracks import Recording
from light_stage import key_lamp, lit_room, objects


@pytest.fixture
def room(world):
    return lit_room(world)


def light_sensor(world, name, at=(0, 0, 0)):
    settings = {"method": "ILLUMINANCE", "engine": "CYCLES", "samples": 16, "update_rate": 6.0}
    sensor = world.sensor("LIGHT", name, **settings)
    sensor.location = at
    return sensor


def carried(world, sensor):
    sensor.parent = world.link("carrier", None)
    world.key(sensor.parent, "location", {1: (0, 0, 0), 48: (1, 0, 0)})


MOVES = {
    "keys": lambda w, s: w.key(s, "location", {1: (0, 0, 0), 48: (1, 0, 0)}),
    "a parent": carried,
    "a constraint": lambda w, s: s.constraints.new("COPY_LOCATION"),
    "what it asks": lambda w, s: w.key(s, "angen_sensor.light.clip_end", {1: 5.0, 48: 3.0}),
}


def pictures(world, last):
    """A run's readings by sensor, and how many pictures of each sort it took by frame."""
    recording, found = Recording(), {}
    for progress in simulate(world.scene, world.sensors(), 1, last, recording):
        sort = "reference" if "reference" in progress.doing else "other"
        found.setdefault(progress.frame, []).append(sort)
    read = {name: world.series(recording, name, "illuminance_lux") for name in recording.tracks}
    # At its end each frame is told without a picture.
    return read, {frame: sorts[:-1] for frame, sorts in found.items()}


@pytest.mark.parametrize("how", MOVES)
def test_a_sensor_that_moves_makes_no_references(room, how):
    """They would be of use but once, and take the others' with them."""
    bpy.context.scene.angen_light_reference = 64
    light_sensor(room, "still", (0.5, 0, 0))
    alone, taken = pictures(room, 20)
    references = [frame for frame, sorts in taken.items() for s in sorts if s == "reference"]
    MOVES[how](room, light_sensor(room, "moves"))
    read, taken = pictures(room, 20)
    assert [f for f, sorts in taken.items() for s in sorts if s == "reference"] == references
    assert read["still"] == alone["still"]
    bpy.context.scene.angen_light_reference = 0
    assert pictures(room, 20)[0]["moves"] == read["moves"]


def switch_power():
    key_lamp((1, 4, 8, 12), (1.0, 0.0, 5.0, 2.0))
    data = objects("area").data
    for frame, colour in ((1, (1, 1, 1)), (12, (0.2, 0.4, 1))):
        data.color = colour
        data.keyframe_insert("color", frame=frame)


@pytest.mark.parametrize("reference", [0, 64])
def test_a_lamp_that_is_switched_or_dimmed_costs_no_picture(room, reference):
    objects("screen").animation_data_clear()
    switch_power()
    bpy.context.scene.angen_light_reference = reference
    light_sensor(room, "still", (0.5, 0, 0)).angen_sensor.update_rate = 24.0
    read, taken = pictures(room, 12)
    assert len(set(read["still"])) > 9
    assert all(taken.pop(1)) and not any(taken.values())
    for frame in (1, 4, 6, 12):
        again = Recording()
        list(simulate(room.scene, room.sensors(), frame, frame, again))
        (alone,) = room.series(again, "still", "illuminance_lux")
        assert read["still"][frame - 1] == alone


def test_how_far_a_reference_is_is_told(room):
    """A part of its paths at a time: whoever waits can leave at each."""
    bpy.context.scene.angen_light_reference = 40960
    light_sensor(room, "still", (0.5, 0, 0))
    run = simulate(room.scene, room.sensors(), 1, 1, Recording())
    told = [progress.doing for progress in run if "reference" in progress.doing]
    shares = [int(text.rsplit(" ", 3)[-3]) for text in told]
    assert len(told) >= 8 and shares == sorted(shares) and shares[-1] > 80
