# SPDX-License-Identifier: GPL-3.0-or-later
"""The signs in the viewport are those of the sensing, and follow the scene from frame to frame.

There is no GPU here; scripts/pictures shows the drawing itself in a real window.
"""

import math
import types

import bpy
import numpy as np
import pytest
from bl_ext.user_default.angen_sensors.angen_addon.kinds.pressure import force_figure
from bl_ext.user_default.angen_sensors.angen_addon.view import readings
from bl_ext.user_default.angen_sensors.angen_addon.view.overlay import picture, refresh
from bl_ext.user_default.angen_sensors.angen_addon.view.overlay.labels import arrange
from bl_ext.user_default.angen_sensors.angen_addon.view.overlay.picture import LOOKS as looks
from bl_ext.user_default.angen_sensors.sensor_logic import model
from bl_ext.user_default.angen_sensors.sensor_logic.kinds.pir import pyroelectric
from mathutils import Matrix


def of(field, name):
    return next(seen for seen in field.seen if seen.sensor.name == name)


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
            cast, before = seen.rays.bundles[tilt], seen.rays.scan[tilt]
            assert len(seen.lit[0].lines["lit"]) == (np.abs(cast.ranges - before) > 0.05).sum()
    assert lit == states
    assert 5 < sum(lit) < 45


def test_following_changes_no_reading(world, field):
    """A live run with the drawing and one without, with a recording made in between."""
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


def assert_all_is_as_it_is_now(world, seen):
    assert sorted(seen.rays.bundles) == [0, 1, 2]
    for number, cast in seen.rays.bundles.items():
        ranges = world.rays(seen.sensor.object, number)[2]
        assert cast.ranges == pytest.approx(ranges, abs=1e-9)


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
    assert [len(cast.reach) for cast in of(field(), "pir").rays.bundles.values()] == [9, 9, 9]
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
        (cast,) = of(field(frame), "pir").rays.bundles.values()
        assert cast.reach[0] == pytest.approx(reach)


def test_undo_and_load_leave_nothing(world, field):
    make_pir(world)
    refresh.overlay = field(3)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert refresh.overlay is None


# Looks


def test_every_state_has_a_look_and_no_two_the_same_shape():
    different = {
        (look.lines.tobytes(), look.faces.tobytes())
        for icon, look in looks.items()
        if icon != readings.DOUBTFUL
    }
    assert len(different) == len(looks) - 1
    # Only wrong settings are loud, not readings that a jump of the playhead makes uncertain.
    assert looks[readings.DOUBTFUL].colour == looks[readings.NOT_SURE].colour
    assert looks[readings.NOT_SURE].colour == looks[readings.UNKNOWN].colour
    assert looks[readings.WRONG].colour != looks[readings.DOUBTFUL].colour
    assert set(looks) == {
        readings.ACTIVE, readings.IDLE, readings.OFF, readings.DOUBTFUL, readings.WRONG,
        readings.UNKNOWN, readings.OLD, readings.BAKED, readings.NOT_SURE,
    }  # fmt: skip


def test_every_meaning_is_coloured(world, field):
    """A sensor of each kind, with all its signs, in all states."""
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
    for icon in looks:
        one = readings.ReadingText("", icon, "", pad)
        passing = [picture.changing_figures(seen, one, 1.0) for seen in found.seen]
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
    """The flag of one switch moves from frame 40 on; nothing moves before the other two."""
    draw = addon_part("angen_addon.view.overlay.draw")
    readings = addon_part("angen_addon.view.readings")
    row = addon_part("angen_addon.view.overlay.picture").SensorRow
    given = []
    monkeypatch.setattr(draw, "_batch", lambda part: given.append(part) or part)
    flag = world.box((0.2, 0.2, 0.01), (0, 0, -0.3), name="flag")
    world.key(flag, "location", {1: (0, 0, -0.3), 40: (0, 0, -0.3), 60: (0, 0, -0.1)})
    for name, x in (("a", 0.0), ("b", 5.0), ("c", 5.0)):
        world.switch(name, update_rate=24.0).location.x = x
    world.box((1, 1, 0.01), (5, 0, -0.2), name="still")
    joined = draw.JoinedBatches()

    def sent(frame, icon="RADIOBUT_OFF"):
        """Return how many points go to the GPU again, of how many drawn, in how many parts."""
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


# The figures drawn for sensors are those of the sensing


def ends(seen, back=0.0):
    """Return the ends (n, 3) of a sensor's rays in m, or points `back` before them."""
    cast = seen.rays.bundles.values()
    return np.concatenate([m.origins + m.directions * (m.ranges - back)[:, None] for m in cast])


def drawn(seen, meaning, what="lines"):
    """Return all lines, or fills, of a meaning."""
    parts = [getattr(figure, what).get(meaning) for figure in seen.figures]
    kept = [part for part in parts if part is not None and len(part)]
    return np.concatenate(kept) if kept else np.empty((0, 2, 3))


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
    for number, cast in found.items():
        origins, directions, ranges = world.rays(sensor, number)
        assert len(origins) == (21 if sweep == "ALL" else 7)
        assert np.allclose(cast.origins, origins, rtol=0, atol=1e-12)
        assert np.array_equal(cast.directions, directions)
        assert np.allclose(cast.ranges, ranges, rtol=0, atol=1e-12)
    assert any((cast.ranges < cast.reach).any() for cast in found.values())


def off_lines(points, lines):
    """Return the greatest distance (m) of points from the nearest of lines (n, 2, 3)."""
    start, way = lines[:, 0], lines[:, 1] - lines[:, 0]
    to_point = points[:, None] - start
    share = (to_point * way).sum(axis=2) / np.maximum((way * way).sum(axis=1), 1e-12)
    feet = start + np.clip(share, 0.0, 1.0)[..., None] * way
    return np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1).max()


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
        cast = found[wall]
        assert cast.directions[0] == pytest.approx(axes @ about, abs=1e-6)
        quarter = np.array(Matrix.Rotation(wall * math.pi / 2, 3, "Y"), float)
        corners = ahead @ (axes @ quarter).T * 5.0 + (1, 2, 3)
        far = (cast.origins + cast.directions * cast.reach[:, None])[1:]
        for corner in corners:
            assert np.linalg.norm(far - corner, axis=1).min() < 1e-5
        assert (cast.origins - (1, 2, 3)) @ axes @ about == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_zones_are_drawn_where_the_rays_in_them_end(world, field, scale):
    """On a leaning wall, without overlap: each zone contains the rays cast in it."""
    world.scene.unit_settings.scale_length = scale
    lens = world.pir("lens", update_rate=24.0)
    lens.angen_sensor.pir.model, lens.angen_sensor.pir.range_max = "PYROELECTRIC", 60.0
    lens.location = (0.1 / scale, 0.2 / scale, 0.3 / scale)
    ranger = world.sensor("DISTANCE", "ranger", zones_across=3, zones_up=2, rays=3)
    ranger.rotation_euler.z = 0.2
    wall = world.wall(3.0 / scale, size=1000.0 / scale)
    wall.rotation_euler.x = 0.1
    wall.scale = (1.0, 1.0, 1.0)
    found = field()
    zones = pyroelectric.zones_of(of(found, "lens").parameters)
    normal = np.array([0.0, -math.sin(0.1), math.cos(0.1)])
    for name, count, meaning in (("lens", len(zones), "picture"), ("ranger", 6, "outline")):
        seen = of(found, name)
        (cast,) = seen.rays.bundles.values()
        corners = drawn(seen, meaning).reshape(-1, 4, 2, 3)[:, :, 0] * scale
        assert len(corners) == count
        ways = corners - seen.pose.origin
        size = np.linalg.norm(ways, axis=-1, keepdims=True)
        inside = cast.directions.reshape(count, -1, 3)
        for edges, rays in zip(ways / size, inside, strict=True):
            # Before each of the four planes through neighbouring corners.
            sides = np.cross(edges, np.roll(edges, -1, axis=0))
            sides *= np.sign(sides @ edges.mean(axis=0))[:, None]
            assert (rays @ sides.T > -1e-6).all()
        # A centimetre before the wall, which all rays of a zone hit.
        hit = (cast.ranges < cast.reach).reshape(count, -1).all(axis=1)
        places = corners + ways / size * 0.01
        assert hit.any()
        assert (places[hit] - (0, 0, -3.0)) @ normal == pytest.approx(0.0, abs=2e-3)
    assert len(drawn(of(found, "lens"), "picture", "fills")) == 2 * sum(
        zone.polarity > 0 for zone in zones
    )


@pytest.mark.parametrize("scale", [1.0, 0.01])
@pytest.mark.parametrize(("wall", "reach"), [(2.0, 5.0), (10.0, 5.0), (10.0, 60.0)])
def test_zones_of_a_lens_end_at_walls_and_at_the_detection_distance(
    world, field, scale, wall, reach
):
    """The rays of the lens reach 50 m, because warm walls there count."""
    world.scene.unit_settings.scale_length = scale
    world.pir("lens", model="PYROELECTRIC", range_max=reach)
    world.wall(wall / scale, size=1000.0 / scale)
    seen = of(field(), "lens")
    ends = drawn(seen, "picture").reshape(-1, 3) * scale
    away, depth = np.linalg.norm(ends, axis=1), -ends[:, 2]
    assert away.max() < reach * (1 + 1e-5) and depth.max() < wall
    beside = np.abs(ends[:, 0] / depth) < 0.5
    assert beside.any()
    at_wall = wall / (depth[beside] / away[beside]) < reach
    assert at_wall.all() if wall < 5.0 else not at_wall.any() or reach > 50.0
    expected = np.where(at_wall, wall / (depth / away)[beside] - 0.01, reach)
    assert away[beside] == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("kind", ["lens", "ranger"])
def test_no_zone_is_drawn_through_the_edge_of_a_wall(world, field, kind):
    """The left half of the view ends at a wall at 2 m, the right half at 4 m."""
    if kind == "lens":
        world.pir("lens", model="PYROELECTRIC", range_max=5.0)
    else:
        world.sensor("DISTANCE", "ranger", rays=4, horizontal_fov=1.0)
    near = world.wall(2.0, "near", size=20.0)
    world.wall(3.4, "far", size=50.0)
    near.location.x = -10.0 - 0.05
    seen = of(field(), kind)
    meanings = ("picture",) if kind == "lens" else ("outline", "limit")
    ends = np.concatenate([drawn(seen, name) for name in meanings]).reshape(-1, 3)
    depth = -ends[:, 2]
    assert depth.max() < 3.4 * 1.02
    # Seen from the sensor, these corners are before the near wall.
    behind = ends[:, 0] / depth < (-0.05 / 2.0) - 0.03
    inside = np.abs(ends[:, 1] / depth) < 4.0
    assert (behind & inside).sum() > 3
    assert depth[behind & inside].max() < 2.0


def test_a_pads_arrow_is_as_long_as_its_force():
    pose = model.Pose(np.array([1.0, 2.0, 3.0]), np.eye(3))
    for force, length in ((500.0, 0.5), (100.0, 0.1), (1.0, 0.06), (9e4, 1.2)):
        figure = force_figure(pose, 1.0, force, (0.1, -0.2))
        points = np.concatenate(
            [figure.lines["force"][:1].reshape(-1, 3), figure.fills["force"][0]]
        )
        # From the tail of its shaft to its tip on the centre of pressure.
        assert np.ptp(points[:, 2]) == pytest.approx(length, abs=1e-6)
        tip = points[points[:, 2].argmin()]
        assert tip == pytest.approx([1.1, 1.8, 3.01], abs=1e-5)


# The places of labels beside the sensors in the viewport


OFF, RING_PIXELS = 8.0, 11.3
WINDOW = (0.0, 0.0, 1057.0, 618.0)
SIDEBAR = (766.0, 0.0, 1057.0, 564.0)
# The bathroom and the closet of the home in a window of 1280 × 720.
CLOSE = [(481.0, 351.0), (502.0, 349.0), (520.0, 349.0), (446.0, 341.0), (451.0, 321.0)]


@pytest.fixture
def arranged():

    def run(markers, sizes, wanted=(), covered=(SIDEBAR,), first=()):
        order, first = range(len(markers)), frozenset(first)
        return arrange(markers, sizes, order, frozenset(wanted), WINDOW, covered, OFF, first)

    return run


def distance(plate, point):
    x = max(plate[0] - point[0], 0.0, point[0] - plate[2])
    y = max(plate[1] - point[1], 0.0, point[1] - plate[3])
    return math.hypot(x, y)


def covers(one, two):
    return one[0] < two[2] and two[0] < one[2] and one[1] < two[3] and two[1] < one[3]


@pytest.mark.parametrize("seed", range(5))
def test_each_label_is_beside_its_own_marker_and_covers_nothing(arranged, seed):
    random = np.random.default_rng(seed)
    markers = [*CLOSE, *map(tuple, random.uniform((60, 10), (750, 600), (25, 2)).tolist())]
    sizes = [(float(w), 17.0) for w in random.uniform(60, 190, len(markers))]
    plates = arranged(markers, sizes)
    assert 8 <= len(plates) < len(markers), "what does not fit is hidden"
    for number, plate in plates.items():
        assert plate[2] - plate[0] == pytest.approx(sizes[number][0])
        nearest = min(range(len(markers)), key=lambda n: distance(plate, markers[n]))
        assert nearest == number and distance(plate, markers[number]) <= OFF + 1e-6
        others = [m for n, m in enumerate(markers) if n != number]
        assert min(distance(plate, m) for m in others) >= 2 * OFF
        assert not covers(plate, SIDEBAR)
        assert plate[0] >= 0 and plate[2] <= 1057 and plate[1] >= 0 and plate[3] <= 618
        assert not any(covers(plate, other) for n, other in plates.items() if n != number)


def test_what_is_selected_or_hovered_has_its_label_in_any_crowd(arranged):
    sizes = [(150.0, 17.0)] * len(CLOSE)
    alone = arranged(CLOSE, sizes)
    hidden = set(range(len(CLOSE))) - set(alone)
    assert hidden
    for number in hidden:
        plates = arranged(CLOSE, sizes, wanted=[number])
        # It lies beside the ring around its sign, not below it.
        assert RING_PIXELS <= distance(plates[number], CLOSE[number]) <= 1.5 * OFF + 1e-6
        assert not any(covers(plates[number], p) for n, p in plates.items() if n != number)
    at_the_edge = arranged([(762.0, 300.0), (4.0, 4.0)], [(150.0, 17.0)] * 2, wanted=[0, 1])
    assert at_the_edge[0][2] <= 766 and at_the_edge[1][0] >= 0 and at_the_edge[1][1] >= 0


def test_what_is_selected_has_its_label_among_its_own_handles(arranged):
    around = [(340.0, 240.0, 460.0, 360.0)]
    assert arranged([(400.0, 300.0)], [(150.0, 17.0)], covered=around) == {}
    assert list(arranged([(400.0, 300.0)], [(150.0, 17.0)], covered=around, wanted=[0])) == [0]


def test_what_is_active_has_its_label_where_idle_ones_crowd_it(arranged):
    """Nearer idle sensors leave no space beside the last; once active, it takes theirs."""
    sizes = [(150.0, 17.0)] * len(CLOSE)
    hidden = set(range(len(CLOSE))) - set(arranged(CLOSE, sizes))
    assert hidden
    for number in hidden:
        plates = arranged(CLOSE, sizes, first=[number])
        assert distance(plates[number], CLOSE[number]) <= OFF + 1e-6
        assert not any(covers(plates[number], p) for n, p in plates.items() if n != number)
        both = arranged(CLOSE, sizes, wanted=[min(hidden)], first=[number])
        assert both[min(hidden)] == arranged(CLOSE, sizes, wanted=[min(hidden)])[min(hidden)]


def test_a_label_stays_until_an_active_sensor_needs_its_place(labels_of):
    """The playhead moves before two sensors with space for one label."""
    idle, active = readings.IDLE, readings.ACTIVE
    shown = [labels_of(*icons) for icons in ((idle, idle), (idle, active), (idle, idle))]
    assert shown == [{0}, {1}, {1}]
    assert labels_of(active, active) == {0}, "the nearer one"


@pytest.fixture
def labels_of(world, addon_part):
    """The numbers of the sensors that have labels in a small view with two that are in these
    states."""
    labels, part = addon_part("angen_addon.view.overlay.labels"), types.SimpleNamespace
    board = labels.RegionLabels()
    region = part(type="WINDOW", x=0, y=0, width=200, height=30)
    system, view = part(ui_scale=1.0), part()
    overlay = part(show_overlays=False, show_text=False)
    context = part(
        area=part(regions=[region]),
        region=region,
        scene=world.scene,
        view_layer=bpy.context.view_layer,
        space_data=part(show_gizmo=False, overlay=overlay),
        preferences=part(system=system, view=view),
    )

    def run(*icons):
        active = frozenset(n for n, icon in enumerate(icons) if icon == readings.ACTIVE)
        markers, near, widths = [(20.0, 15.0), (180.0, 15.0)], [100.0, 50.0], [100.0] * 2
        labels._place_labels(context, board, markers, near, widths, frozenset(), active)
        return set(board.rooms)

    return run


def test_labels_lie_above_signs(addon_part, monkeypatch):
    """A selected sensor has its label in any crowd: also above the sign of another sensor."""
    labels, part = addon_part("angen_addon.view.overlay.labels"), types.SimpleNamespace
    monkeypatch.setattr(labels, "_batch", lambda points, colours, kind: np.array(points))
    rows = [part(shown=part(icon=icon)) for icon in (readings.ACTIVE, readings.IDLE)]
    plate = (10.0, 0.0, 90.0, 20.0)
    drawn = labels._batches([plate], rows, [(0.0, 10.0), (50.0, 10.0)], [], 5.0)
    order = [(kind, tuple(points.min(axis=0)), tuple(points.max(axis=0))) for kind, points in drawn]
    assert [kind for kind, *_ in order] == ["TRIS", "LINES", "TRIS"]
    assert order[-1][1:] == ((10.0, 0.0), (90.0, 20.0))


def test_what_lies_over_a_view_of_a_small_window(addon_part):
    """Blender 4.3 at 1280 × 720, with sidebar and toolbar open."""
    part = types.SimpleNamespace
    regions = [
        ("HEADER", 0, 666, 1057, 27), ("TOOL_HEADER", 0, 639, 1057, 27),
        ("ASSET_SHELF", 0, 75, 1, 1), ("TOOLS", 0, 75, 58, 564), ("UI", 766, 75, 291, 564),
        ("HUD", 58, 75, 1, 1), ("WINDOW", 0, 75, 1057, 618),
    ]  # fmt: skip
    area = part(regions=[part(type=t, x=x, y=y, width=w, height=h) for t, x, y, w, h in regions])
    overlay = part(show_overlays=True, show_text=True, show_stats=False)
    space = part(show_gizmo=True, show_gizmo_navigate=True, overlay=overlay)
    view = part(mini_axis_type="GIZMO", gizmo_size_navigate_v3d=80, show_navigate_ui=True)
    preferences = part(system=part(ui_scale=1.0), view=view)
    covered = addon_part("angen_addon.view.overlay.labels").covered_rects
    found = covered(area, area.regions[-1], space, preferences)

    def free(x, y):
        """Return whether a point of the picture, from its upper left, is free."""
        low = 720 - y - 75
        return not any(r[0] < x < r[2] and r[1] < low < r[3] for r in found)

    for x, y in ((900, 300), (30, 300), (500, 41), (500, 68)):
        assert not free(x, y), "under a panel"
    for x, y in ((713, 119), (745, 145), (743, 285), (683, 121)):
        assert not free(x, y), "under a gizmo"
    assert not free(200, 118) and free(400, 118), "the texts at the upper left"
    assert free(700, 285) and free(500, 400) and free(740, 400)
    space.show_gizmo = overlay.show_text = False
    found = covered(area, area.regions[-1], space, preferences)
    assert free(713, 119) and free(200, 118)


# A click on a sensor selects it


@pytest.fixture
def view(world):
    """Return the context of a 3D view of 400 × 300 pixels, 100 per metre, along +Y."""
    part, bpy_context = types.SimpleNamespace, bpy.context
    matrix = Matrix.Translation((0, 0, -5)) @ Matrix.Rotation(-math.pi / 2, 4, "X")
    lens = Matrix.Diagonal((1 / 2, 1 / 1.5, -0.01, 1.0))
    areas = bpy_context.window_manager.windows[0].screen.areas
    return part(
        scene=world.scene,
        view_layer=bpy_context.view_layer,
        mode="OBJECT",
        region=part(width=400, height=300, as_pointer=lambda: 7),
        region_data=part(
            perspective_matrix=lens @ matrix,
            view_matrix=matrix,
            is_perspective=False,
            view_perspective="ORTHO",
        ),
        space_data=next(area for area in areas if area.type == "VIEW_3D").spaces.active,
        window_manager=bpy_context.window_manager,
        preferences=part(system=part(ui_scale=1.0)),
        evaluated_depsgraph_get=world.update,
    )


def pixels(place):
    return 200 + 100 * place[0], 150 + 100 * place[2]


@pytest.fixture
def click(view, addon_part):
    """Click on a place in world space, as Blender calls the operator; return its result."""
    run = addon_part("operators.sign_select").ANGEN_OT_sign_select.invoke

    def at(place, shift=False, off=(0, 0), button="LEFTMOUSE"):
        x, y = pixels(place)
        mouse = {"mouse_region_x": round(x + off[0]), "mouse_region_y": round(y + off[1])}
        event = types.SimpleNamespace(type=button, value="CLICK", shift=shift, **mouse)
        view.selected_objects = bpy.context.selected_objects
        return run(types.SimpleNamespace(), view, event)

    return at


@pytest.fixture
def signs(field, addon_part):
    """Draws the sensors' signs, and a label to the right of each, without a GPU."""
    board = addon_part("angen_addon.view.overlay.labels").RegionLabels()

    def draw():
        for seen in field().seen:
            x, y = board.markers[seen.uid] = pixels(seen.matrix.translation)
            board.plates[seen.uid] = x + 8.0, y - 9.0, x + 100.0, y + 9.0
        refresh.overlay.boards[7] = board

    return draw


def chosen():
    selected = sorted(obj.name for obj in bpy.context.selected_objects)
    return bpy.context.view_layer.objects.active.name, selected


def test_a_click_on_a_sign_or_label_selects_the_sensor_and_no_other_click_does(world, click, signs):
    wall = world.box((4, 0.1, 4), (0, 1, 0), name="wall")
    wall.select_set(True)
    bpy.context.view_layer.objects.active = wall
    for name, x in (("left", -1.0), ("right", 1.0)):
        world.pir(name).location = (x, 0, 0)
    signs()
    assert click((0, 0, 0.5)) == {"PASS_THROUGH"} and chosen() == ("wall", ["wall"])
    assert click((1, 0, 0), off=(0, 30)) == {"PASS_THROUGH"}
    assert click((1, 0, 0), off=(5, 5)) == {"FINISHED"} and chosen() == ("right", ["right"])
    assert click((-1, 0, 0), shift=True, off=(60, 5)) == {"FINISHED"}
    assert chosen() == ("left", ["left", "right"])
    click((1, 0, 0), shift=True)
    assert chosen() == ("right", ["left", "right"]), "the other becomes the active one"
    click((1, 0, 0), shift=True)
    assert chosen() == ("right", ["left"])
    click((-1, 0, 0))
    assert chosen() == ("left", ["left"])
    world.scene.angen_overlay.show = False
    assert click((1, 0, 0)) == {"PASS_THROUGH"} and chosen() == ("left", ["left"])
    world.scene.angen_overlay.show = True
    assert click((1, 0, 0), button="RIGHTMOUSE") == {"PASS_THROUGH"}, "it opens a menu"
    bpy.data.objects["right"].hide_select = True
    assert click((1, 0, 0)) == {"PASS_THROUGH"}


def test_a_press_on_one_of_many_selects_it_alone_when_released(world, view, signs, addon_part):
    """In the tool Tweak, where a drag moves all that are selected."""
    for name, x in (("left", -1.0), ("right", 1.0)):
        sensor = world.pir(name)
        sensor.location.x = x
        sensor.select_set(True)
    signs()
    view.selected_objects, part = bpy.context.selected_objects, types.SimpleNamespace
    view.window_manager = part(
        keyconfigs=bpy.context.window_manager.keyconfigs, modal_handler_add=lambda operator: True
    )
    view.preferences.inputs = part(drag_threshold_mouse=3)
    own, operator = addon_part("operators.sign_select").ANGEN_OT_sign_select, part()

    def event(kind, value, x=300):
        return part(type=kind, value=value, shift=False, mouse_region_x=x, mouse_region_y=150)

    assert own.invoke(operator, view, event("LEFTMOUSE", "PRESS")) == {"RUNNING_MODAL"}
    assert chosen() == ("right", ["left", "right"])
    for before in (event("MOUSEMOVE", "NOTHING", 301), event("TIMER", "NOTHING")):
        assert own.modal(operator, view, before) == {"RUNNING_MODAL"}
    assert own.modal(operator, view, event("LEFTMOUSE", "RELEASE")) == {"FINISHED"}
    assert chosen() == ("right", ["right"])


def test_a_housing_stands_for_its_sensor(world, click, addon_part):
    """A click on it selects the sensor; panels and operators treat it as the sensor."""
    sensor = world.pir("hall")
    housing = world.box((0.5, 0.5, 0.5), (0, 0, 0), name="housing")
    lens = world.box((0.2, 0.2, 0.2), (0, -0.4, 0), name="lens")
    housing.parent, lens.parent = sensor, housing
    pad = world.sensor("PRESSURE", "pad", world.box((1, 1, 0.1), (1.5, 0, 0), name="pad"))
    cushion = world.box((0.5, 0.5, 0.5), (0, 0, 0.3), name="cushion")
    cushion.parent = pad
    world.update()
    for place in ((0, 0, 0), (0.2, 0, 0.2)):
        assert click(place) == {"FINISHED"} and chosen() == ("hall", ["hall"])
    assert click((1.5, 0, 0.3)) == {"PASS_THROUGH"}, "a pad is its own body"
    world.box((0.1, 0.1, 0.1), (0.0, -2.0, 0.0), name="before it")
    world.update()
    assert click((0, 0, 0)) == {"PASS_THROUGH"}
    active = addon_part("angen_addon.view.active").active_sensor
    for obj, expected in ((housing, sensor), (lens, sensor), (cushion, None), (pad, pad)):
        bpy.context.view_layer.objects.active = obj
        found = active(bpy.context)
        assert (found and found.object) == expected
    bpy.context.view_layer.objects.active = lens
    assert bpy.ops.angen.preset_apply(preset="EKMC1601111") == {"FINISHED"}
    assert sensor.angen_sensor.pir.model == "PYROELECTRIC"


def test_a_click_in_a_scene_without_sensors_casts_no_ray(world, click, view, monkeypatch):
    world.box((4, 0.1, 4), (0, 1, 0), name="wall")
    monkeypatch.setattr(view, "evaluated_depsgraph_get", None)
    assert click((0, 0, 0)) == {"PASS_THROUGH"}
    world.pir("hall")
    with pytest.raises(TypeError):
        click((0, 0, 0))


def test_clicks_go_to_signs_before_what_blender_does_with_them():
    configuration = bpy.context.window_manager.keyconfigs.addon
    if configuration is None:
        pytest.skip("this Blender has no keys in the background")
    for name in ("Object Mode", "3D View Tool: Tweak"):
        items = configuration.keymaps[name].keymap_items
        assert [item.shift for item in items if item.idname == "angen.sign_select"]
