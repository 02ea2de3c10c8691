# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport draws follows the scene and the detectors, from frame to frame.

There is no GPU here: the drawing itself is seen in a real window (scripts/pictures).
"""

import math

import bpy
import numpy as np
import pytest
from overlay_scenes import make_pir, of, random_walk


@pytest.mark.parametrize("recorded", [False, True])
def test_rays_are_lit_exactly_where_the_detector_says_that_something_moved(world, field, recorded):
    """`moved` of a run against the lit rays of frames played one by one."""
    sensor = make_pir(world)
    random_walk(world)
    if recorded:
        assert bpy.ops.angen.simulate() == {"FINISHED"}
    states, lit = [], []
    for frame in range(1, 49):
        seen = of(field(frame, publish=not recorded), "pir")
        states.append(sensor.angen_sensor.active)
        lit.append(bool(seen.lit))
        if seen.lit:
            (tilt,) = seen.rays.scan
            assert tilt * math.radians(10) == pytest.approx(sensor.angen_sensor.value, abs=1e-6)
            met, before = seen.rays.bundles[tilt], seen.rays.scan[tilt]
            assert len(seen.lit[0].lines["lit"]) == (np.abs(met.ranges - before) > 0.05).sum()
    assert lit == states
    assert 5 < sum(lit) < 45


def test_the_view_holds_what_is_drawn(world, field, addon_part):
    """A beam of 4 m that ends after 1.5 m."""
    obj = world.switch(range_max=4.0)
    world.box((1, 1, 1), (0, 0, -2))
    field()
    sensor = next(s for s in world.sensors() if s.object == obj)
    middle, radius = addon_part("operators.show").surroundings(sensor, bpy.context)
    assert tuple(middle) == pytest.approx((0, 0, -0.75), abs=1e-6)
    assert radius == pytest.approx(0.75)


def test_following_changes_no_reading(world, field):
    """A live run with the drawing and one without, and a recording made in between."""
    sensor = make_pir(world)
    switch = world.switch(update_rate=24.0)
    world.switch("swept", update_rate=6.0, swept=True)
    random_walk(world)

    def play(follow):
        values = []
        for frame in range(1, 49):
            world.scene.frame_set(frame)
            if follow and frame % 7 == 0:
                field()
            values += [(o.angen_sensor.active, o.angen_sensor.value) for o in (sensor, switch)]
        world.scene.frame_set(1)
        return values

    alone = play(False)
    assert play(True) == alone
    before, again = world.run(), world.run()
    assert world.log(again) == world.log(before)
    field(20)
    field()
    after = world.run()
    assert world.log(after) == world.log(before)
    for name, track in before.tracks.items():
        assert after.tracks[name].value == track.value


def test_what_is_recorded_stays_shown_while_rays_are_looked_at(world, field):
    """The outputs are those of the recording, also where the sensor would read something else."""
    sensor = make_pir(world)
    random_walk(world)
    sensor.angen_sensor.active = True
    for frame in (1, 2, 3):
        world.scene.angen_live = False
        found = field(frame, publish=False)
        assert of(found, "pir").rays.bundles and sensor.angen_sensor.active


def assert_all_is_as_it_is_now(world, seen):
    assert sorted(seen.rays.bundles) == [0, 1, 2]
    for number, met in seen.rays.bundles.items():
        ranges = world.rays(seen.sensor.object, number)[2]
        assert met.ranges == pytest.approx(ranges, abs=1e-9)


def test_at_rest_all_is_as_it_is_now_and_after_a_jump_what_was_sensed(world, field):
    make_pir(world)
    random_walk(world)
    for frame in range(1, 20):
        field(frame)
    assert len(of(field(20), "pir").rays.bundles) == 3
    seen = of(field(33), "pir")
    assert len(seen.rays.bundles) == 1 and not seen.lit
    assert_all_is_as_it_is_now(world, of(field(), "pir"))


def test_a_moved_or_altered_sensor_is_followed(world, field):
    sensor = make_pir(world)
    first = of(field(), "pir").rays.bundles[0].origins
    sensor.location.x = 2.0
    moved = field()
    assert of(moved, "pir").rays.bundles[0].origins == pytest.approx(first + (2, 0, 0))
    sensor.angen_sensor.pir.rays = 9
    moved.outdated = True
    assert [len(met.reach) for met in of(field(), "pir").rays.bundles.values()] == [9, 9, 9]
    for change in ("enabled", "range_min"):
        sensor.angen_sensor.enabled = change != "enabled"
        sensor.angen_sensor.pir.range_min = 9.0 if change == "range_min" else 0.05
        moved.outdated = True
        seen = of(field(), "pir")
        assert seen.rays is None and not seen.figures


def test_keyed_parameters_are_followed(world, field):
    sensor = make_pir(world)
    world.key(sensor, "angen_sensor.pir.range_max", {1: 2.0, 11: 3.0})
    for frame, reach in ((1, 1.95), (11, 2.95)):
        (met,) = of(field(frame), "pir").rays.bundles.values()
        assert met.reach[0] == pytest.approx(reach)


def test_a_still_scene_is_not_drawn_anew(world, field):
    make_pir(world)
    world.wall(2.0)
    field(1)
    revision = [of(field(frame), "pir").revision for frame in range(2, 30)]
    assert len(set(revision[8:])) == 1


def test_the_drawing_casts_no_rays(world, field, addon_part, monkeypatch):
    """Neither while it plays, live or beside a recording, nor at rest."""
    drawn = addon_part("angen_addon.view.overlay.picture").DrawnSensors
    caster = addon_part("angen_addon.scene.rays.caster").RayCaster
    follow, see_at, cast = drawn.follow, caster.see_at, []

    def followed(*arguments):
        monkeypatch.setattr(caster, "see_at", lambda *a: cast.append(a) or see_at(*a))
        follow(*arguments)
        monkeypatch.setattr(caster, "see_at", see_at)

    monkeypatch.setattr(drawn, "follow", followed)
    make_pir(world)
    world.sensor("LIGHT", "views")
    world.sensor("DISTANCE", "zones")
    random_walk(world)
    for frame in range(1, 30):
        field(frame, publish=frame < 15)
    assert all(seen.figures for seen in field().seen)
    assert cast == []


def test_undo_and_load_leave_nothing(world, field, addon_part):
    make_pir(world)
    cache = addon_part("angen_addon.runtime.state").CACHE
    cache.overlay = field(3)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert cache.overlay is None


# Looks


def test_every_state_has_a_look_and_no_two_the_same_shape(addon_part):
    looks = addon_part("angen_addon.view.overlay.picture").LOOKS
    readings = addon_part("panels.readings")
    different = {
        (look.lines.tobytes(), look.faces.tobytes())
        for icon, look in looks.items()
        if icon != readings.DOUBTFUL
    }
    assert len(different) == len(looks) - 1
    # Loud is only what is set up wrong, not what a jump of the playhead makes unsure.
    assert looks[readings.DOUBTFUL].colour == looks[readings.NOT_SURE].colour
    assert looks[readings.NOT_SURE].colour == looks[readings.UNKNOWN].colour
    assert looks[readings.WRONG].colour != looks[readings.DOUBTFUL].colour
    assert set(looks) == {
        readings.ACTIVE, readings.IDLE, readings.OFF, readings.DOUBTFUL, readings.WRONG,
        readings.UNKNOWN, readings.OLD, readings.BAKED, readings.NOT_SURE,
    }  # fmt: skip


def test_every_meaning_is_coloured(world, field, addon_part):
    """One of each kind, all that they draw, in all states."""
    picture = addon_part("angen_addon.view.overlay.picture")
    readings = addon_part("panels.readings")
    make_pir(world)
    random_walk(world)
    world.switch()
    world.pir("lens").angen_sensor.pir.model = "PYROELECTRIC"
    world.sensor("LIGHT", "views")
    world.sensor("LIGHT", "face").angen_sensor.light.method = "ILLUMINANCE"
    bpy.ops.angen.sensor_add(kind="PRESSURE")
    field()
    for frame in range(1, 12):
        found = field(frame)
    pad = {"force_n": 10.0, "cop_x_m": 0.0, "cop_y_m": 0.0}
    for icon in addon_part("angen_addon.view.overlay.picture").LOOKS:
        one = readings.ReadingText("", icon, "", pad)
        passing = [picture.passing(seen, one, 1.0) for seen in found.seen]
        # The detector's fan has a tilt that is scanned and rays that are lit, the pad its force.
        assert sorted(map(len, passing)) == [0, 0, 0, 0, 1, 2 if icon == readings.ACTIVE else 1]
        for seen, more in zip(found.seen, passing, strict=True):
            assert seen.figures
            for figure in [*seen.figures, *more]:
                for name, part in picture.picture(figure, icon, False).items():
                    assert len(part.points) == len(part.colours)
                    assert len(part.points) % part.corners == 0
                    assert np.isfinite(part.points).all(), name
                    assert part.points.dtype == part.colours.dtype == np.float32


def test_what_moves_leaves_the_fields_alone_in_which_nothing_does(
    world, field, addon_part, monkeypatch
):
    """A switch whose flag moves from frame 40 on, and two that see nothing move."""
    draw = addon_part("angen_addon.view.overlay.draw")
    readings = addon_part("panels.readings")
    row = addon_part("angen_addon.view.overlay.picture").SensorRow
    given = []
    monkeypatch.setattr(draw, "_batch", lambda part: given.append(part) or part)
    flag = world.box((0.2, 0.2, 0.01), (0, 0, -0.3), name="flag")
    world.key(flag, "location", {1: (0, 0, -0.3), 40: (0, 0, -0.3), 60: (0, 0, -0.1)})
    for name, x in (("a", 0.0), ("b", 5.0), ("c", 5.0)):
        world.switch(name, update_rate=24.0).location.x = x
    world.box((1, 1, 0.01), (5, 0, -0.2), name="still")
    joined = draw.Joined()

    def sent(frame, icon="RADIOBUT_OFF"):
        """How many points the GPU is given anew, of how many that are drawn, in how many parts."""
        found = field(frame)
        given.clear()
        rows = [row(seen, readings.ReadingText("", icon), False) for seen in found.seen]
        parts = [part for group in joined.batches(rows, 1.0) for part in group.values()]
        count = sum(len(part.points) for part in given)
        return count, sum(len(part.points) for part in parts), len(parts)

    first = sent(1)
    every = first[0]
    assert every == first[1] > 0
    later = [sent(frame) for frame in range(2, 40)]
    assert sum(count > 0 for count, *_ in later) == 1, "once they have stayed as they are"
    assert [(total, parts) for _, total, parts in later] == [(every, first[2])] * 38
    moving = [sent(frame)[0] for frame in range(40, 60)][3:]
    assert all(0 < count < every / 2 for count in moving)
    assert [sent(frame)[0] for frame in range(60, 90)][20:] == [0] * 10
    assert sent(90, "RADIOBUT_ON")[0] == every, "another colour"


# Off, and in the background


def test_nothing_is_done_in_the_background(world, addon_part):
    make_pir(world)
    assert bpy.app.background
    assert world.scene.angen_overlay.show
    world.scene.frame_set(5)
    world.update()
    assert addon_part("angen_addon.runtime.state").CACHE.overlay is None
    assert addon_part("angen_addon.view.overlay.draw")._handles == []
    assert not bpy.app.timers.is_registered(addon_part("angen_addon.view.overlay.refresh")._later)
