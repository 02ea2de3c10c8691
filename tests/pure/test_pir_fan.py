# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a PIR's rays go, against rotation matrices written out here."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kind import RAYS
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, RangeScan, fan_directions
from angen_sensors.sensor_logic.model import Update, pose_from_matrix


def about_x(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def about_y(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


@pytest.mark.parametrize(
    ("rays", "fov", "vertical_fov", "step"),
    [(120, 120, 90, 10), (7, 360, 180, 22.5), (2, 30, 45, 45), (64, 90, 0, 10)],
)
def test_directions_in_closed_form(rays, fov, vertical_fov, step):
    parameters = PirParameters(
        rays=rays,
        horizontal_fov=math.radians(fov),
        vertical_fov=math.radians(vertical_fov),
        vertical_step=math.radians(step),
    )
    fan = fan_directions(parameters)
    tilts = max(1, round(vertical_fov / step))
    assert fan.shape == (tilts, rays, 3)
    for k in range(tilts):
        for i in range(rays):
            azimuth = math.radians(-fov / 2 + i * fov / (rays - 1))
            # Turning +Y's way is counter-clockwise seen from +Y; −Z goes to −Y against X's way.
            expected = about_x(-math.radians(k * step)) @ about_y(azimuth) @ (0, 0, -1)
            assert np.abs(fan[k, i] - expected).max() < 1e-12


def test_first_ray_is_on_the_right_and_tilts_go_down():
    fan = fan_directions(PirParameters(rays=3, horizontal_fov=math.pi / 2))
    half = math.sqrt(0.5)
    np.testing.assert_allclose(fan[0], [(half, 0, -half), (0, 0, -1), (-half, 0, -half)], atol=1e-9)
    angle = math.radians(80)  # the last of nine tilts
    np.testing.assert_allclose(fan[8, 1], (0, -math.sin(angle), -math.cos(angle)), atol=1e-9)


def test_a_single_ray_looks_straight_ahead():
    np.testing.assert_allclose(fan_directions(PirParameters(rays=1))[0, 0], (0, 0, -1))


@pytest.mark.parametrize(
    ("vertical_fov", "step", "tilts"),
    [(90, 10, 9), (90, 22.5, 4), (90, 40, 2), (90, 91, 1), (0, 10, 1), (89.9, 10, 8)],
)
def test_number_of_tilts(vertical_fov, step, tilts):
    exact = PirParameters(vertical_fov=math.radians(vertical_fov), vertical_step=math.radians(step))
    assert exact.tilt_count == tilts
    single = PirParameters(
        vertical_fov=float(np.float32(math.radians(vertical_fov))),
        vertical_step=float(np.float32(math.radians(step))),
    )
    assert single.tilt_count == tilts, "Blender stores angles in single precision"


def test_rays_start_at_range_min_and_turn_with_the_sensor():
    """A sensor turned to look along world +X, up along +Z, at (1, 2, 3)."""
    matrix = np.array([[0, 0, -1, 1], [-1, 0, 0, 2], [0, 1, 0, 3], [0, 0, 0, 1.0]])
    asked = []

    def cast(bundle, origins, directions, length):
        asked.append((origins.copy(), directions.copy(), length.copy()))
        return length

    parameters = PirParameters(rays=3, horizontal_fov=math.pi, range_min=0.5, range_max=4.0)
    RangeScan().update(parameters, Update(0, 0.0, pose_from_matrix(matrix), {RAYS: cast}))
    ((origins, directions, length),) = asked
    # The first ray is on the sensor's right, which is its +X: world −Y.
    np.testing.assert_allclose(directions, [(0, -1, 0), (1, 0, 0), (0, 1, 0)], atol=1e-12)
    np.testing.assert_allclose(origins, [(1, 1.5, 3), (1.5, 2, 3), (1, 2.5, 3)], atol=1e-12)
    np.testing.assert_allclose(length, 3.5)


def test_scale_and_mirroring_change_the_housing_only():
    plain = np.eye(4)
    for scale in [(1e-3, 1e-3, 1e-3), (1e3, 5.0, 2.0), (-1, 1, 1), (1, 1, 1e-6)]:
        scaled = plain @ np.diag([*scale, 1.0])
        pose = pose_from_matrix(scaled)
        np.testing.assert_allclose(pose.axes[:, 2], (0, 0, math.copysign(1, scale[2])))
        np.testing.assert_allclose(pose.axes[:, 1], (0, math.copysign(1, scale[1]), 0))
        assert np.linalg.det(pose.axes) == pytest.approx(1.0)


def test_a_sheared_sensor_keeps_its_view_direction():
    shear = np.eye(4)
    shear[1, 2] = shear[0, 1] = 0.5
    pose = pose_from_matrix(shear)
    np.testing.assert_allclose(pose.axes.T @ pose.axes, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose.axes[:, 2], np.array((0, 0.5, 1)) / math.sqrt(1.25))


@pytest.mark.parametrize("bad", [0.0, math.nan, math.inf])
def test_a_sensor_that_looks_nowhere_is_refused(bad):
    with pytest.raises(ValueError, match=r"scale|not a number"):
        pose_from_matrix(np.diag([1, 1, bad, 1]))


def test_unit_scale_turns_units_into_metres():
    matrix = np.eye(4)
    matrix[:3, 3] = (100, 200, 300)
    np.testing.assert_allclose(pose_from_matrix(matrix, 0.01).origin, (1, 2, 3))
