# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport draws is what detects: the same rays, the same ends, the same movement.

There is no GPU here: the drawing itself is seen in a real window (scripts/pictures).
"""

import itertools
import math

import bpy
import numpy as np
import pytest


@pytest.fixture
def field(world, addon_part):
    """The field of the scene; called, it follows it to the present frame."""
    cache = addon_part("angen_addon.runtime.state").CACHE
    made = cache.overlay = addon_part("angen_addon.view.overlay.field").Field(world.scene)

    def follow(frame=None, in_handler=True):
        if frame is not None:
            world.scene.frame_set(frame)
        world.update()
        layer = bpy.context.view_layer
        made.follow(world.scene, layer, layer.depsgraph, in_handler)
        return made

    yield follow
    cache.overlay = None


def of(field, name):
    return next(seen for seen in field.seen if seen.sensor.name == name)


def ends(seen):
    return seen.rays.origins + seen.rays.directions * seen.ranges[:, None]


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
    seen = of(field(in_handler=False), "pir")
    rows = [seen.rays.bundle(number) for number in range(seen.rays.rows)]
    assert len(rows) == 3
    if sweep == "ALL":
        rows = [slice(0, 21)]
    for number, row in enumerate(rows):
        origins, directions, ranges = world.rays(sensor, number)
        assert np.array_equal(seen.rays.origins[row] * scale, origins)
        assert np.array_equal(seen.rays.directions[row], directions)
        assert np.allclose(seen.ranges[row] * scale, ranges, rtol=0, atol=1e-12)
    assert (seen.ranges < seen.rays.reach).any()


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
    seen = of(field(in_handler=False), "pir")
    lines = seen.figure.lines["outline"]
    assert off_lines(ends(seen) - seen.rays.directions * 0.01, lines) < 0.005
    assert len(lines) <= 2 * 12 if not round_wall else len(lines) > 2 * 40


def test_rays_end_on_the_wall_and_the_tilts_are_sheets_apart(world, field):
    world.pir(rays=5, vertical_fov=math.radians(40), vertical_step=math.radians(20), range_max=9)
    world.wall(3.0, size=40.0)
    seen = of(field(in_handler=False), "pir")
    assert ends(seen)[:, 2] == pytest.approx(-3.0, abs=1e-5)
    lines, fills = seen.figure.lines, seen.figure.fills
    drawn_ends = ends(seen) - seen.rays.directions * 0.01
    assert off_lines(drawn_ends, lines["outline"]) < 0.002
    assert off_lines(drawn_ends, fills["sheet"][:, 1:]) < 0.002
    assert "limit" not in lines or not len(lines["limit"])
    # A centimetre before the wall along each ray, nowhere behind it.
    heights = lines["outline"][..., 2]
    assert (heights > -3.0).all() and (heights < -2.98).all()
    angles = np.arctan2(-lines["outline"][..., 1], -lines["outline"][..., 2]).reshape(2, -1)
    middle = np.degrees(angles.mean(axis=1))
    assert middle[0] == pytest.approx(0.0, abs=1e-3) and middle[1] > 15.0


def test_what_meets_nothing_ends_at_range_max_and_is_drawn_apart(world, field):
    world.pir(rays=5, range_max=2.5)
    seen = of(field(in_handler=False), "pir")
    assert np.linalg.norm(ends(seen), axis=1) == pytest.approx(2.5)
    assert len(seen.figure.lines["outline"]) == 0 and len(seen.figure.lines["limit"]) == 2


def test_a_switch_shows_where_its_beam_breaks(world, field):
    world.switch(range_max=0.5, threshold=0.2)
    wall = world.wall(0.3)
    seen = of(field(in_handler=False), "switch")
    assert ends(seen)[0] == pytest.approx([0, 0, -0.3], abs=1e-6)
    lines = seen.figure.lines
    assert lines["break"].mean(axis=(0, 1))[2] == pytest.approx(-0.29, abs=1e-6)
    assert lines["dark"][-1, -1] == pytest.approx([0, 0, -0.5], abs=1e-6)
    assert lines["gate"].mean(axis=(0, 1)) == pytest.approx([0, 0, -0.2], abs=1e-6)
    wall.location.z = -0.6
    world.update()
    field().outdated = True
    seen = of(field(in_handler=False), "switch")
    assert ends(seen)[0] == pytest.approx([0, 0, -0.5], abs=1e-6)
    assert "break" not in seen.figure.lines


def test_the_views_of_a_light_sensor_are_those_of_its_cameras(world, field):
    turn = (0.4, -0.3, 2.0)
    sensor = world.sensor("LIGHT", "light", field_of_view=0.3, clip_start=0.5, clip_end=5.0)
    sensor.rotation_euler, sensor.location = turn, (1, 2, 3)
    seen = of(field(in_handler=False), "light")
    assert seen.rays.rows == 4
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle, data.clip_start, data.clip_end = "HORIZONTAL", 0.3, 0.5, 5.0
    world.scene.render.resolution_x = world.scene.render.resolution_y = 4
    frame = np.array([tuple(corner) for corner in data.view_frame(scene=world.scene)])
    ways = frame / -frame[:, 2:]
    axes = np.array(sensor.matrix_world, float)[:3, :3]
    for wall, about in enumerate(([0, 0, -1], [-1, 0, 0], [0, 0, 1], [1, 0, 0])):
        row = slice(5 * wall, 5 * wall + 5)
        assert seen.rays.directions[row][0] == pytest.approx(axes @ about, abs=1e-6)
        quarter = np.array(
            __import__("mathutils").Matrix.Rotation(wall * math.pi / 2, 3, "Y"), float
        )
        corners = ways @ (axes @ quarter).T * 5.0 + (1, 2, 3)
        found = (seen.rays.origins + seen.rays.directions * seen.rays.reach[:, None])[row][1:]
        for corner in corners:
            assert np.linalg.norm(found - corner, axis=1).min() < 1e-5
        assert seen.rays.origins[row] @ (axes @ about) - (axes @ about) @ (1, 2, 3) == (
            pytest.approx(0.5, abs=1e-6)
        )


@pytest.mark.parametrize("scale", [1.0, 0.01])
def test_the_zones_drawn_hold_the_rays_of_the_lens(world, field, addon_part, scale):
    world.scene.unit_settings.scale_length = scale
    sensor = world.pir(update_rate=24.0)
    sensor.angen_sensor.pir.model = "PYROELECTRIC"
    sensor.location = (0.1 / scale, 0.2 / scale, 0.3 / scale)
    world.wall(3.0 / scale, size=100.0 / scale)
    seen = of(field(in_handler=False), "pir")
    detector = addon_part("sensor_logic.kinds.pir.pyroelectric.detector")
    zones = detector.zones_of(seen.parameters)
    cast = addon_part("sensor_logic.kinds.pir.pyroelectric.zones").zone_rays(zones, 12)
    corners = seen.rays.directions.reshape(len(zones), 5, 3)
    for number in range(len(zones)):
        axis, edges = corners[number, 0], corners[number, 1:]
        inside = cast.directions[cast.zone == number]
        # Before each of the four planes through neighbouring corners.
        normals = np.cross(edges, np.roll(edges, -1, axis=0))
        normals *= np.sign(normals @ axis)[:, None]
        assert (inside @ normals.T > -1e-9).all()
    hit = seen.rays.directions[:, 2] < -0.2
    assert ends(seen)[hit, 2] * scale == pytest.approx(-3.0, abs=1e-4)
    plus = sum(zone.polarity > 0 for zone in zones)
    assert len(seen.figure.fills["picture"]) == 2 * plus
    assert len(seen.figure.lines["picture"]) == 4 * len(zones)


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
        seen = of(field(frame), "pir")
        states.append(sensor.angen_sensor.active)
        lit.append(seen.sweep.lit is not None and bool(seen.sweep.lit.any()))
        if seen.sweep.lit is not None:
            rows = np.flatnonzero(seen.sweep.lit.any(axis=1))
            assert rows.tolist() == list(seen.sweep.tilts)
            angle = sensor.angen_sensor.value
            assert rows[0] * math.radians(10) == pytest.approx(angle, abs=1e-6)
            assert len(seen.lit.lines["lit"]) == seen.sweep.lit.sum()
    assert lit == states
    assert 5 < sum(lit) < 45


def test_following_changes_no_reading(world, field):
    """A live run with the drawing and one without, and a recording made in between."""
    sensor = make_pir(world)
    switch = world.switch(update_rate=24.0)
    random_walk(world)

    def play(follow):
        values = []
        for frame in range(1, 49):
            world.scene.frame_set(frame)
            if follow:
                field()
                if frame % 7 == 0:
                    field(in_handler=False)
            values += [(o.angen_sensor.active, o.angen_sensor.value) for o in (sensor, switch)]
        world.scene.frame_set(1)
        return values

    alone = play(False)
    assert play(True) == alone
    before, again = world.run(), world.run()
    assert world.log(again) == world.log(before)
    field(20)
    after = world.run()
    assert world.log(after) == world.log(before)
    for name, track in before.tracks.items():
        assert after.tracks[name].value == track.value


def test_at_rest_all_is_as_it_is_now(world, field):
    """After playing, every ray ends where a caster of its own says."""
    make_pir(world)
    random_walk(world)
    for frame in range(1, 30):
        found = field(frame)
    assert found.unseen
    found = field(in_handler=False)
    assert not found.unseen
    seen = of(found, "pir")
    for number in range(3):
        ranges = world.rays(seen.sensor.object, number)[2]
        assert seen.ranges[seen.rays.bundle(number)] == pytest.approx(ranges, abs=1e-9)


def test_after_a_jump_nothing_is_lit_and_all_is_cast(world, field):
    make_pir(world)
    random_walk(world)
    for frame in range(1, 20):
        field(frame)
    found = field(33)
    seen = of(found, "pir")
    assert seen.sweep.lit is None and not found.unseen
    for number in range(3):
        ranges = world.rays(seen.sensor.object, number)[2]
        assert seen.ranges[seen.rays.bundle(number)] == pytest.approx(ranges, abs=1e-9)


def test_a_moved_or_altered_sensor_is_followed(world, field):
    sensor = make_pir(world)
    first = of(field(in_handler=False), "pir").rays
    sensor.location.x = 2.0
    world.update()
    moved = field(in_handler=False)
    assert of(moved, "pir").rays.origins == pytest.approx(first.origins + (2, 0, 0))
    sensor.angen_sensor.pir.rays = 9
    moved.outdated = True
    assert len(of(field(in_handler=False), "pir").rays.reach) == 27
    sensor.angen_sensor.enabled = False
    moved.outdated = True
    assert of(field(in_handler=False), "pir").figure is None
    sensor.angen_sensor.enabled = True
    sensor.angen_sensor.pir.range_min = 9.0
    moved.outdated = True
    assert "range_min" in of(field(in_handler=False), "pir").problem


def test_keyed_parameters_are_followed(world, field):
    sensor = make_pir(world)
    world.key(sensor, "angen_sensor.pir.range_max", {1: 2.0, 11: 3.0})
    assert of(field(1), "pir").rays.reach[0] == pytest.approx(1.95)
    assert of(field(11), "pir").rays.reach[0] == pytest.approx(2.95)


@pytest.fixture
def casts(addon_part, monkeypatch):
    """The numbers of the bundles that meet a solid anew."""
    asked = []
    caster = addon_part("angen_addon.scene.rays.caster").RayCaster
    hits = caster._hits
    monkeypatch.setattr(caster, "_hits", lambda *a: asked.append(1) or hits(*a))
    return asked


def test_a_still_scene_is_not_cast_again(world, field, casts):
    make_pir(world)
    world.wall(2.0)
    field(1)
    figure = of(field(2), "pir").figure
    casts.clear()
    for frame in range(3, 30):
        assert of(field(frame), "pir").figure is figure
    assert casts == []


@pytest.mark.parametrize("sweep", ["SAWTOOTH", "ALL"])
def test_while_it_plays_nothing_is_cast_but_what_sensors_cast(world, field, casts, sweep):
    """All of their rays as they are, and those of a still switch, in a scene in which one walks."""
    make_pir(world).angen_sensor.pir.sweep = sweep
    world.switch().location = (0, 0.5, -1.2)
    random_walk(world)
    field(1)
    field(2)
    for frame in range(3, 40):
        world.scene.frame_set(frame)
        casts.clear()
        field()
        assert casts == []


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
    for frame in range(1, 12):
        found = field(frame)
    pad = {"force_n": 10.0, "cop_x_m": 0.0, "cop_y_m": 0.0}
    for icon in addon_part("angen_addon.view.overlay.looks").LOOKS:
        one = readings.Shown("", icon, "", pad)
        drawn = [list(picture.figures(seen, one, 1.0)) for seen in found.seen]
        # The detector's fan has a tilt that is scanned and rays that are lit, the pad its force.
        assert sorted(map(len, drawn)) == [1, 1, 1, 1, 2, 3 if icon == readings.ACTIVE else 2]
        for figure in itertools.chain(*drawn):
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
    given = []
    monkeypatch.setattr(draw, "_batch", lambda part: given.append(part) or part)
    flag = world.box((0.2, 0.2, 0.01), (0, 0, -0.3), name="flag")
    world.key(flag, "location", {1: (0, 0, -0.3), 40: (0, 0, -0.3), 60: (0, 0, -0.1)})
    world.switch("a")
    for name in ("b", "c"):
        world.switch(name).location.x = 5.0
    world.box((1, 1, 0.01), (5, 0, -0.2), name="still")
    world.update()

    def sent(frame, icon="RADIOBUT_OFF"):
        """How much of what is drawn the GPU has to be given anew."""
        found = field(frame)
        given.clear()
        parts = draw._parts_to_draw(found, world.scene, [readings.Shown("", icon)] * 3)
        assert len(parts) == 3
        return len(given)

    a_switch = sent(1) // 3
    assert a_switch > 0 and [sent(frame) for frame in range(2, 40)] == [0] * 38
    assert [sent(frame) for frame in range(42, 59)] == [a_switch] * 17
    assert sent(61) == a_switch and [sent(frame) for frame in range(62, 70)] == [0] * 8
    assert sent(70, "RADIOBUT_ON") == 3 * a_switch, "another colour"


def test_a_tilt_is_drawn_as_it_is_and_made_anew_only_where_something_moved(
    world, field, addon_part
):
    figures = addon_part("angen_addon.kinds.pir.figure")
    world.pir(rays=9, vertical_fov=math.radians(40), vertical_step=math.radians(20), range_max=9)
    wall = world.wall(3.0, size=40.0)
    world.key(wall, "location", {10: (0, 0, -3.0), 16: (0, 0, -2.0)})
    drawn = {}
    for frame in range(1, 25):
        seen = of(field(frame), "pir")
        fresh = figures.scanned_figure(seen, 1.0)
        for now, then in ((seen.scan.lines, fresh.lines), (seen.scan.fills, fresh.fills)):
            assert now.keys() == then.keys()
            assert all(np.array_equal(now[name], then[name]) for name in now), frame
        drawn[frame] = seen.scan
    assert drawn[8] is drawn[6] and drawn[24] is drawn[22]
    assert drawn[8].lines["now"].mean() != drawn[24].lines["now"].mean()


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


def test_the_handlers_call_it(world, addon_part, monkeypatch):
    called = []
    overlay = addon_part("angen_addon.view.overlay.refresh")
    monkeypatch.setattr(overlay, "follow", lambda *a: called.append("follow"))
    monkeypatch.setattr(overlay, "note_edit", lambda *a: called.append("edit"))
    world.scene.frame_set(7)
    assert called.count("follow") == 1
    world.box((1, 1, 1))
    world.update()
    assert "edit" in called
