# SPDX-License-Identifier: GPL-3.0-or-later
"""The range scan: compared scans, movement, and the timing of the output."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kind import RAYS
from angen_sensors.sensor_logic.kinds.pir.range_scan import PirParameters, RangeScan, fan_directions
from angen_sensors.sensor_logic.model import Update, pose_from_matrix

DEGREE = math.pi / 180
ONE_TILT = {"rays": 5, "vertical_fov": 10 * DEGREE, "vertical_step": 10 * DEGREE}
THREE_TILTS = {"rays": 5, "vertical_fov": 30 * DEGREE, "vertical_step": 10 * DEGREE}


def moved(readings):
    return [int(reading.fields["moved"]) for reading in readings]


def degrees(readings):
    return [round(reading.fields["angle_rad"] / DEGREE) for reading in readings]


def test_sawtooth_scans_the_tilts_in_turn(stage):
    readings = stage.run(RangeScan(), PirParameters(), [2.0] * 20)
    assert degrees(readings) == [*range(0, 90, 10), *range(0, 90, 10), 0, 10]
    assert moved(stage.run(RangeScan(), PirParameters(**THREE_TILTS), [1, 2, 3])) == [0, 0, 0]


def test_the_rays_of_an_update_belong_to_one_tilt(stage):
    steepest = []

    def cast(bundle, origins, directions, length):
        steepest.append((bundle, round(math.degrees(math.asin(-directions[:, 1].min())))))
        return length

    stage.run(RangeScan(), PirParameters(**THREE_TILTS), [cast] * 4)
    assert steepest == [(0, 0), (1, 10), (2, 20), (0, 0)]


@pytest.mark.parametrize(
    ("worlds", "expected"),
    [
        # Different ranges at different tilts are no movement; a change since the last turn is.
        ([1, 2, 3] * 2 + [1, 2.5, 3] * 2, [0] * 7 + [1] + [0] * 4),
        # An object that comes and goes between two scans at a tilt is missed.
        ([3] * 3 + [1, 3, 3] + [3] * 3, [0, 0, 0, 1, 0, 0, 1, 0, 0]),
        ([3, 3, 3, 3, 1, 3, 3, 3, 3], [0, 0, 0, 0, 1, 0, 0, 1, 0]),
    ],
)
def test_a_scan_is_compared_with_the_previous_one_at_the_same_tilt(stage, worlds, expected):
    assert moved(stage.run(RangeScan(), PirParameters(**THREE_TILTS), worlds)) == expected


def test_all_tilts_sweep_scans_every_tilt_and_tells_where_it_moved(stage):
    def only_second_tilt(distance):
        def cast(bundle, origins, directions, length):
            assert len(directions) == 15
            ranges = np.full(15, 3.0)
            ranges[7] = distance
            return ranges

        return cast

    parameters = PirParameters(sweep="ALL", **THREE_TILTS)
    worlds = [only_second_tilt(d) for d in (2.0, 2.0, 1.0, 1.0)]
    readings = stage.run(RangeScan(), parameters, worlds)
    assert moved(readings) == [0, 0, 1, 0]
    assert degrees(readings) == [0, 0, 10, 0]


def test_nearer_than_range_min_is_not_seen(stage):
    """Rays start at range_min: nearer objects are not hit, and ranges are never less."""
    parameters = PirParameters(range_min=0.5, range_max=4.0, **ONE_TILT)

    def cast(bundle, origins, directions, length):
        np.testing.assert_allclose(np.linalg.norm(origins, axis=1), 0.5)
        return length

    assert moved(stage.run(RangeScan(), parameters, [cast, cast])) == [0, 0]
    noisy = PirParameters(range_min=0.5, range_max=0.56, noise_sigma=10.0, **ONE_TILT)
    # However strong the noise, ranges stay within range_min … range_max: they change by 0.06 at
    # most.
    assert any(moved(stage.run(RangeScan(), noisy, [9] * 20)))
    within = PirParameters(range_min=0.5, range_max=0.545, noise_sigma=10.0, **ONE_TILT)
    assert not any(moved(stage.run(RangeScan(), within, [9] * 20)))


def test_the_threshold_must_be_exceeded_by_one_ray(stage):
    # Powers of two, so that the change is exactly the threshold.
    parameters = PirParameters(range_min=0.0, threshold=0.25, **ONE_TILT)
    assert moved(stage.run(RangeScan(), parameters, [2.0, 1.75, 2.0])) == [0, 0, 0]
    above = 1.75 - 2**-20
    assert moved(stage.run(RangeScan(), parameters, [2.0, above])) == [0, 1]

    def cast(change):
        return lambda bundle, o, d, length: np.array([3, 3, 3, 3, 3 - change])

    parameters = PirParameters(**ONE_TILT)
    assert moved(stage.run(RangeScan(), parameters, [cast(0.0), cast(0.06)])) == [0, 1]
    # An object 0.04 m inside the range leaves: no change above 0.05; 0.06 m is one.
    parameters = PirParameters(range_max=4.0, **ONE_TILT)
    assert moved(stage.run(RangeScan(), parameters, [3.96, 1e9])) == [0, 0]
    assert moved(stage.run(RangeScan(), parameters, [3.94, 1e9])) == [0, 1]
    assert moved(stage.run(RangeScan(), parameters, [5.0, 1e9])) == [0, 0]


def outputs(stage, triggers, **timing):
    """Return the output at 10 Hz with movement at the updates marked 1."""
    distance, worlds = 3.0, [3.0]
    for trigger in triggers[1:]:
        distance = 4.0 - distance if trigger == "1" else distance
        worlds.append(distance)
    parameters = PirParameters(**ONE_TILT, **timing)
    return "".join(map(str, moved(stage.run(RangeScan(), parameters, worlds))))


@pytest.mark.parametrize(
    ("triggers", "timing", "expected"),
    [
        ("0110100010", {}, "0110100010"),
        # On for 0.5 s after the last trigger: five updates, the trigger's own among them.
        ("0100000000", {"hold_time": 0.5}, "0111110000"),
        ("0101000000", {"hold_time": 0.5}, "0111111100"),
        ("0100001000", {"hold_time": 0.5}, "0111111111"),
        ("0100000100", {"hold_time": 0.5}, "0111110111"),
        # Falls at update 2; triggers before update 5 (0.3 s later) are lost.
        ("0101100000", {"blocking_time": 0.3}, "0100000000"),
        ("0101110000", {"blocking_time": 0.3}, "0100010000"),
        ("0111110000", {"blocking_time": 0.3}, "0111110000"),
        ("0111111000", {"warm_up_time": 0.4}, "0000111000"),
        ("0110000000", {"warm_up_time": 0.4, "hold_time": 5.0}, "0000000000"),
        # On for 0.2 s, off at update 3, blocked until 6.
        ("0101111000", {"hold_time": 0.2, "blocking_time": 0.3}, "0111111100"),
        ("0100111000", {"hold_time": 0.2, "blocking_time": 0.3}, "0110001100"),
    ],
)
def test_timing_of_the_output(stage, triggers, timing, expected):
    assert outputs(stage, triggers, **timing) == expected


@pytest.mark.parametrize("frames", [7, 24, 240])
def test_hold_time_is_exact_at_any_frame_rate(stage, frames):
    """A hold of n updates lasts n updates, though k/rate is rounded."""
    stage.rate = 24.0
    triggers = "01" + "0" * (frames + 3)
    expected = "0" + "1" * frames + "0" * 4
    assert outputs(stage, triggers, hold_time=frames / 24.0) == expected


@pytest.mark.parametrize("sweep", ["SAWTOOTH", "ALL"])
@pytest.mark.parametrize("noise", [0.0, 0.03])
def test_an_array_handed_out_again_reads_as_one_that_is_equal(stage, sweep, noise):
    """A caster that returns the same array for "nothing changed" must not change readings."""
    parameters = PirParameters(sweep=sweep, noise_sigma=noise, **THREE_TILTS)
    random = np.random.default_rng(1)
    rays = 15 if sweep == "ALL" else 5
    kept = [random.uniform(0.1, 5.0, rays) for _ in range(3)]
    for array in kept:
        array.flags.writeable = False
    order = [0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 1, 0, 0, 0, 0, 0, 0, 2, 2, 2, 2]
    same, equal = (
        stage.run(
            RangeScan(), parameters, [lambda *_, k=k, give=give: give(kept[k]) for k in order]
        )
        for give in (lambda array: array, np.copy)
    )
    assert same == equal
    assert 3 <= sum(moved(same)) < len(order)


def test_an_array_that_is_written_to_is_looked_at_again(stage):
    ranges = np.full(5, 2.0)
    casts = [lambda *_, c=change: np.add(ranges, c, out=ranges) for change in (0.0, 0.0, 0.5, 0.0)]
    assert moved(stage.run(RangeScan(), PirParameters(**ONE_TILT), casts)) == [0, 0, 1, 0]


# The directions of its rays


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
            # A turn about +Y is counter-clockwise seen from +Y; −Z goes to −Y in the opposite sense
            # of X.
            expected = about_x(-math.radians(k * step)) @ about_y(azimuth) @ (0, 0, -1)
            assert np.abs(fan[k, i] - expected).max() < 1e-12


def test_first_ray_is_on_the_right_and_tilts_go_down():
    fan = fan_directions(PirParameters(rays=3, horizontal_fov=math.pi / 2))
    half = math.sqrt(0.5)
    np.testing.assert_allclose(fan[0], [(half, 0, -half), (0, 0, -1), (-half, 0, -half)], atol=1e-9)
    angle = math.radians(80)  # the last of nine tilts
    np.testing.assert_allclose(fan[8, 1], (0, -math.sin(angle), -math.cos(angle)), atol=1e-9)
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
    """A sensor turned to face world +X, up along +Z, at (1, 2, 3)."""
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


def test_scale_mirroring_and_shear_change_the_housing_only():
    for scale in [(1e-3, 1e-3, 1e-3), (1e3, 5.0, 2.0), (-1, 1, 1), (1, 1, 1e-6)]:
        pose = pose_from_matrix(np.diag([*scale, 1.0]))
        np.testing.assert_allclose(pose.axes[:, 1:], np.eye(3)[:, 1:])
        assert np.linalg.det(pose.axes) == pytest.approx(1.0)
    matrix = np.eye(4)
    matrix[1, 2] = matrix[0, 1] = 0.5
    matrix[:3, 3] = (100, 200, 300)
    pose = pose_from_matrix(matrix, 0.01)
    np.testing.assert_allclose(pose.axes.T @ pose.axes, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(pose.axes[:, 2], np.array((0, 0.5, 1)) / math.sqrt(1.25))
    np.testing.assert_allclose(pose.origin, (1, 2, 3))


@pytest.mark.parametrize("bad", [0.0, math.nan, math.inf])
def test_a_sensor_that_looks_nowhere_is_refused(bad):
    with pytest.raises(ValueError, match=r"scale|not a number"):
        pose_from_matrix(np.diag([1, 1, bad, 1]))
