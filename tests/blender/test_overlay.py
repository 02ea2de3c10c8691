# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport draws is what detects: the same rays, the same ends, the same movement.

There is no GPU here: the drawing itself is seen in a real window (scripts/pictures).
"""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix


@pytest.fixture
def field(world, addon_part):
    """The field of the scene; called, it follows it to a frame, as played if one is given, else as
    when the playhead rests."""
    state = addon_part("angen_addon.runtime.state").CACHE
    live_of = addon_part("angen_addon.runtime.live").live_of
    made = state.overlay = addon_part("angen_addon.view.overlay.drawn_sensors").DrawnSensors(
        world.scene
    )

    def follow(frame=None, publish=True):
        scene, layer = world.scene, bpy.context.view_layer
        world.update()
        if frame is None:
            live_of(scene).look_around(scene, layer, layer.depsgraph)
        else:
            world.scene.frame_set(frame)
            if not publish:
                live_of(scene).follow(scene, layer, layer.depsgraph, publish)
        made.follow(scene, layer, layer.depsgraph)
        return made

    yield follow
    state.overlay = None


def of(field, name):
    return next(seen for seen in field.seen if seen.sensor.name == name)


def ends(seen, back=0.0):
    """(n, 3) m: where its rays end, or so far before that."""
    met = seen.rays.bundles.values()
    return np.concatenate([m.origins + m.directions * (m.ranges - back)[:, None] for m in met])


def drawn(seen, meaning, what="lines"):
    """All lines, or fills, of a meaning."""
    parts = [getattr(figure, what).get(meaning) for figure in seen.figures]
    kept = [part for part in parts if part is not None and len(part)]
    return np.concatenate(kept) if kept else np.empty((0, 2, 3))


# Its rays


@pytest.mark.parametrize("scale", [1.0, 0.01])
@pytest.mark.parametrize("sweep", ["SAWTOOTH", "ALL"])
def test_the_rays_drawn_are_those_that_the_detector_casts(world, field, sweep, scale):
    world.scene.unit_settings.scale_length = scale
    sensor = world.pir(rays=7, vertical_fov=math.radians(60), vertical_step=math.radians(20))
    sensor.angen_sensor.pir.sweep = sweep
    sensor.location = (1.0 / scale, 2.0 / scale, 3.0 / scale)
    sensor.rotation_euler = (0.3, 1.0, -2.0)
    world.box((30 / scale, 0.1 / scale, 30 / scale), (0, 4 / scale, 0))
    found = of(field(), "pir").rays.bundles
    assert list(found) == ([0] if sweep == "ALL" else [0, 1, 2])
    for number, met in found.items():
        origins, directions, ranges = world.rays(sensor, number)
        assert len(origins) == (21 if sweep == "ALL" else 7)
        assert np.allclose(met.origins, origins, rtol=0, atol=1e-12)
        assert np.array_equal(met.directions, directions)
        assert np.allclose(met.ranges, ranges, rtol=0, atol=1e-12)
    assert any((met.ranges < met.reach).any() for met in found.values())


def off_lines(points, lines):
    """How far (m) the farthest of some points is from the nearest of lines (n, 2, 3)."""
    start, way = lines[:, 0], lines[:, 1] - lines[:, 0]
    to_point = points[:, None] - start
    share = (to_point * way).sum(axis=2) / np.maximum((way * way).sum(axis=1), 1e-12)
    feet = start + np.clip(share, 0.0, 1.0)[..., None] * way
    return np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1).max()


@pytest.mark.parametrize("round_wall", [False, True])
def test_what_is_straight_is_one_line_and_what_is_round_stays_so(world, field, round_wall):
    """Few lines are fast to draw; each ray still ends on one."""
    world.pir(rays=120, vertical_fov=math.radians(40), vertical_step=math.radians(20), range_max=9)
    if round_wall:
        angles = np.radians(np.arange(0, 361, 2))
        ring = [(3 * math.sin(a), -3 * math.cos(a)) for a in angles]
        points = [(x, y, z) for y in (-20.0, 20.0) for x, z in ring]
        n = len(ring)
        faces = [(i, i + 1, n + i + 1, n + i) for i in range(n - 1)]
        world.link("wall", world.mesh(points, faces))
    else:
        world.wall(3.0, size=40.0)
    seen = of(field(), "pir")
    lines = drawn(seen, "outline")
    assert off_lines(ends(seen, 0.01), lines) < 0.005
    assert len(lines) <= 2 * 12 if not round_wall else len(lines) > 2 * 40


def test_rays_end_on_the_wall_and_the_tilts_are_sheets_apart(world, field):
    world.pir(rays=5, vertical_fov=math.radians(40), vertical_step=math.radians(20), range_max=9)
    world.wall(3.0, size=40.0)
    seen = of(field(), "pir")
    assert ends(seen)[:, 2] == pytest.approx(-3.0, abs=1e-5)
    assert off_lines(ends(seen, 0.01), drawn(seen, "outline")) < 0.002
    assert off_lines(ends(seen, 0.01), drawn(seen, "sheet", "fills")[:, 1:]) < 0.002
    assert not len(drawn(seen, "limit"))
    # A centimetre before the wall along each ray, nowhere behind it.
    heights = drawn(seen, "outline")[..., 2]
    assert (heights > -3.0).all() and (heights < -2.98).all()
    lines = drawn(seen, "outline")
    angles = np.arctan2(-lines[..., 1], -lines[..., 2]).reshape(2, -1)
    middle = np.degrees(angles.mean(axis=1))
    assert middle[0] == pytest.approx(0.0, abs=1e-3) and middle[1] > 15.0


def test_what_meets_nothing_ends_at_range_max_and_is_drawn_apart(world, field):
    world.pir(rays=5, range_max=2.5)
    seen = of(field(), "pir")
    assert np.linalg.norm(ends(seen), axis=1) == pytest.approx(2.5)
    assert len(drawn(seen, "outline")) == 0 and len(drawn(seen, "limit")) == 2


def test_a_switch_shows_where_its_beam_breaks(world, field):
    world.switch(range_max=0.5, threshold=0.2)
    wall = world.wall(0.3)
    seen = of(field(), "switch")
    assert ends(seen)[0] == pytest.approx([0, 0, -0.3], abs=1e-6)
    assert drawn(seen, "break").mean(axis=(0, 1))[2] == pytest.approx(-0.29, abs=1e-6)
    assert drawn(seen, "dark")[-1, -1] == pytest.approx([0, 0, -0.5], abs=1e-6)
    assert drawn(seen, "gate").mean(axis=(0, 1)) == pytest.approx([0, 0, -0.2], abs=1e-6)
    wall.location.z = -0.6
    seen = of(field(), "switch")
    assert ends(seen)[0] == pytest.approx([0, 0, -0.5], abs=1e-6)
    assert not len(drawn(seen, "break"))


def test_the_views_of_a_light_sensor_are_those_of_its_cameras(world, field):
    sensor = world.sensor("LIGHT", "light", field_of_view=0.3, clip_start=0.5, clip_end=5.0)
    sensor.rotation_euler, sensor.location = (0.4, -0.3, 2.0), (1, 2, 3)
    found = of(field(), "light").rays.bundles
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle, data.clip_start, data.clip_end = "HORIZONTAL", 0.3, 0.5, 5.0
    world.scene.render.resolution_x = world.scene.render.resolution_y = 4
    frame = np.array([tuple(corner) for corner in data.view_frame(scene=world.scene)])
    ahead = frame / -frame[:, 2:]
    axes = np.array(sensor.matrix_world, float)[:3, :3]
    assert list(found) == [0, 1, 2, 3]
    for wall, about in enumerate(([0, 0, -1], [-1, 0, 0], [0, 0, 1], [1, 0, 0])):
        met = found[wall]
        assert met.directions[0] == pytest.approx(axes @ about, abs=1e-6)
        quarter = np.array(Matrix.Rotation(wall * math.pi / 2, 3, "Y"), float)
        corners = ahead @ (axes @ quarter).T * 5.0 + (1, 2, 3)
        far = (met.origins + met.directions * met.reach[:, None])[1:]
        for corner in corners:
            assert np.linalg.norm(far - corner, axis=1).min() < 1e-5
        assert (met.origins - (1, 2, 3)) @ axes @ about == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_zones_are_drawn_where_the_rays_in_them_end(world, field, addon_part, scale):
    """On a wall that leans, and apart from each other: each zone holds the rays cast in it."""
    world.scene.unit_settings.scale_length = scale
    lens = world.pir("lens", update_rate=24.0)
    lens.angen_sensor.pir.model = "PYROELECTRIC"
    lens.location = (0.1 / scale, 0.2 / scale, 0.3 / scale)
    ranger = world.sensor("DISTANCE", "ranger", zones_across=3, zones_up=2, rays=3)
    ranger.rotation_euler.z = 0.2
    wall = world.wall(3.0 / scale, size=1000.0 / scale)
    wall.rotation_euler.x = 0.1
    wall.scale = (1.0, 1.0, 1.0)
    found = field()
    detector = addon_part("sensor_logic.kinds.pir.pyroelectric.detector")
    zones = detector.zones_of(of(found, "lens").parameters)
    normal = np.array([0.0, -math.sin(0.1), math.cos(0.1)])
    for name, count, meaning in (("lens", len(zones), "picture"), ("ranger", 6, "outline")):
        seen = of(found, name)
        (met,) = seen.rays.bundles.values()
        corners = drawn(seen, meaning).reshape(-1, 4, 2, 3)[:, :, 0] * scale
        assert len(corners) == count
        ways = corners - seen.pose.origin
        size = np.linalg.norm(ways, axis=-1, keepdims=True)
        inside = met.directions.reshape(count, -1, 3)
        for edges, rays in zip(ways / size, inside, strict=True):
            # Before each of the four planes through neighbouring corners.
            sides = np.cross(edges, np.roll(edges, -1, axis=0))
            sides *= np.sign(sides @ edges.mean(axis=0))[:, None]
            assert (rays @ sides.T > -1e-6).all()
        # A centimetre before the wall, where all rays of a zone meet it.
        hit = (met.ranges < met.reach).reshape(count, -1).all(axis=1)
        places = corners + ways / size * 0.01
        assert hit.any()
        assert (places[hit] - (0, 0, -3.0)) @ normal == pytest.approx(0.0, abs=2e-3)
    assert len(drawn(of(found, "lens"), "picture", "fills")) == 2 * sum(
        zone.polarity > 0 for zone in zones
    )


def test_a_pads_arrow_is_as_long_as_its_force(addon_part):
    figures = addon_part("angen_addon.kinds.pressure.figure")
    model = addon_part("sensor_logic.model")
    pose = model.Pose(np.array([1.0, 2.0, 3.0]), np.eye(3))
    for force, length in ((500.0, 0.5), (100.0, 0.1), (1.0, 0.06), (9e4, 1.2)):
        figure = figures.force_figure(pose, 1.0, force, (0.1, -0.2))
        points = np.concatenate(
            [figure.lines["force"][:1].reshape(-1, 3), figure.fills["force"][0]]
        )
        # From the tail of its shaft to its tip, which stands on the centre of pressure.
        assert np.ptp(points[:, 2]) == pytest.approx(length, abs=1e-6)
        tip = points[points[:, 2].argmin()]
        assert tip == pytest.approx([1.1, 1.8, 3.01], abs=1e-5)


# From frame to frame


def random_walk(world):
    box = world.box((0.4, 1.8, 0.4), (0, 0, -1.5), name="walker")
    world.key(box, "location", {1: (-1.5, 0, -1.5), 40: (1.5, -0.4, -2.5), 48: (1.5, -0.4, -2.5)})
    return box


def make_pir(world):
    return world.pir(
        rays=31,
        vertical_fov=math.radians(30),
        vertical_step=math.radians(10),
        horizontal_fov=math.radians(90),
        threshold=0.05,
        update_rate=12.0,
    )


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
    drawn = addon_part("angen_addon.view.overlay.drawn_sensors").DrawnSensors
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
    looks = addon_part("angen_addon.view.overlay.looks").LOOKS
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
    for icon in addon_part("angen_addon.view.overlay.looks").LOOKS:
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
    row = addon_part("angen_addon.view.overlay.drawn_sensors").SensorRow
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
