# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures drawn for sensors are what detects: the same rays, and the same ends."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from overlay_scenes import of


def ends(seen, back=0.0):
    """(n, 3) m: where its rays end, or so far before that."""
    met = seen.rays.bundles.values()
    return np.concatenate([m.origins + m.directions * (m.ranges - back)[:, None] for m in met])


def drawn(seen, meaning, what="lines"):
    """All lines, or fills, of a meaning."""
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
    detector = addon_part("sensor_logic.kinds.pir.pyroelectric")
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
    figures = addon_part("angen_addon.kinds.pressure")
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
