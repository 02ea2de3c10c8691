# SPDX-License-Identifier: GPL-3.0-or-later
"""Following the playhead from frame to frame shows what a run records, and looks again at nothing
that cannot have changed."""

import pytest
from bl_ext.user_default.angen_sensors.angen_addon.runtime import state
from pressure_scenes import Physics


@pytest.fixture(autouse=True)
def afresh():
    """No test follows what another one left."""
    state.CACHE.clear()


def played(world, frames=range(1, 49)):
    """By name, the updates as they are shown while the playhead goes through the frames."""
    found = {}
    for frame in frames:
        world.scene.frame_set(frame)
        for name, published in state.CACHE.live.readings.items():
            found.setdefault(name, {})[published.frame] = published.reading
    return found


def same_as_run(world, shown):
    recording = world.run()
    for name, readings in shown.items():
        track = recording.tracks[name]
        then = {f: n for n, f in enumerate(track.frames)}
        assert readings and readings.keys() <= then.keys()
        for frame, reading in readings.items():
            at = then[frame]
            assert (reading.active, reading.value) == (track.active[at], track.value[at]), frame
    return recording


def passing_wall(world):
    wall = world.wall(0.3)
    world.key(wall, "location", {1: (-2, 0, -0.3), 48: (2, 0, -0.3)})


def drive(obj, path, sensor):
    """A property of an object follows a sensor's state."""
    driver = obj.driver_add(*path).driver
    driver.type = "SUM"
    variable = driver.variables.new()
    variable.targets[0].id, variable.targets[0].data_path = sensor, "angen_sensor.active"


@pytest.mark.parametrize("rate", [2.0, 6.0, 8.0, 24.0])
def test_a_pad_that_is_read_rarely_shows_what_a_run_records(world, rate):
    physics = Physics(world)
    physics.on_floor(48)
    physics.pad(update_rate=rate)
    body = physics.carried("body", (0.05, 0.05, 0.05), (0, 0, 0.06), 4.0)
    world.key(body, "location", {1: (0, 0, 0.06), 30: (0, 0, 0.06), 48: (0, 0, 0.4)}, "BEZIER")
    recording = same_as_run(world, shown := played(world))
    assert len(shown["pad"]) >= len(recording.tracks["pad"].frames) - 1
    assert max(reading.value for reading in shown["pad"].values()) > 30.0


def test_what_an_output_drives_is_met_from_the_next_frame_on(world):
    passing_wall(world)
    sensor = world.switch(range_max=0.5, threshold=0.4)
    other = world.switch("other", range_max=3.0, threshold=1.0)
    other.location = (9, 0, 0)
    shutter = world.wall(2.0, "shutter")
    shutter.location = (9, 0, -2)
    drive(shutter, ("location", 1), sensor)
    world.update()
    recording = same_as_run(world, played(world))
    assert len(set(recording.tracks["other"].value)) > 1


def test_keyed_and_driven_settings_are_read_at_each_frame(world):
    passing_wall(world)
    keyed = world.switch(range_max=0.5)
    world.key(keyed, "angen_sensor.optical_switch.range_max", {1: 0.1, 24: 0.5, 48: 0.2})
    moved = world.switch("moved", range_max=0.5)
    world.key(moved, "location", {1: (0, 0, -0.2), 48: (0, 0, 0.1)})
    held = world.switch("held", range_max=0.5)
    held.parent = moved
    recording = same_as_run(world, played(world))
    for name in ("switch", "moved", "held"):
        assert len(set(recording.tracks[name].value)) > 2, name


def test_a_setting_changed_while_it_plays_counts_from_the_next_frame_on(world):
    world.wall(0.3)
    sensor = world.switch(range_max=0.5, threshold=0.1)
    played(world, range(1, 5))
    before = state.CACHE.live.readings["switch"].reading
    sensor.angen_sensor.optical_switch.range_max = 0.2
    world.update()
    after = played(world, range(5, 7))["switch"][6]
    assert before.value == pytest.approx(0.3, abs=1e-6) and after.value == pytest.approx(0.2)


def test_a_switch_that_breaks_does_not_make_the_scene_be_listed_anew(world):
    """No driver reads it, and listing a home takes longer than all its sensors together."""
    passing_wall(world)
    world.switch(range_max=0.5, threshold=0.4)
    world.scene.frame_set(1)
    world.scene.frame_set(2)
    solids = state.CACHE.live._probes.caster.solids
    listed = solids.listing
    shown = played(world, range(3, 49))["switch"]
    assert len({reading.active for reading in shown.values()}) == 2
    assert solids.listing == listed
