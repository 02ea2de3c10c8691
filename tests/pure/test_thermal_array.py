# SPDX-License-Identifier: GPL-3.0-or-later
"""The infrared array against closed forms: pixels, filter, noise, background and output."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.coverage.motions import MOTIONS, WALKER, Rays, Start, hits
from angen_sensors.sensor_logic.kind import RAYS, WARMTH
from angen_sensors.sensor_logic.kinds.thermal_array import KIND
from angen_sensors.sensor_logic.kinds.thermal_array.array import (
    Background,
    Settling,
    ThermalArray,
    array_rays,
    celsius,
)
from angen_sensors.sensor_logic.kinds.thermal_array.parameters import (
    MAX_RAYS,
    ThermalArrayParameters,
)
from angen_sensors.sensor_logic.model import Answers, Emission, Pose, Update, Updates
from angen_sensors.sensor_logic.noise import generator
from angen_sensors.sensor_logic.physics import STEFAN_BOLTZMANN, radiosity

POSE = Pose(np.zeros(3), np.eye(3))
ZERO = 273.15
PRESETS = {preset.identifier: preset for preset in KIND.presets}
AMBIENT = 21.0
EXACT = {"rays": 1024}


class Room:
    """Shapes across the axis at a distance, as functions of the tangents (x, y) of rays."""

    def __init__(self, *shapes, ambient=AMBIENT):
        self.shapes, self.ambient = shapes, ambient

    def ask(self, bundle, origins, ways, length, *_):
        x, y = ways[:, 0] / -ways[:, 2], ways[:, 1] / -ways[:, 2]
        kelvin, emissivity = np.full(len(ways), self.ambient + ZERO), np.full(len(ways), 0.95)
        for inside, hot, shines in self.shapes:
            hit = inside(x, y)
            kelvin[hit], emissivity[hit] = hot + ZERO, shines
        return Emission(kelvin, emissivity, self.ambient + ZERO)


def disc(radius, distance, celsius, emissivity=1.0, at=(0.0, 0.0)):
    return (
        lambda x, y: np.hypot(x - at[0], y - at[1]) < radius / distance,
        celsius,
        emissivity,
    )


def left_of(edge, celsius, emissivity=1.0):
    return lambda x, y: x < edge, celsius, emissivity


def read(parameters, *rooms, rate=10.0, name="array", pose=POSE, sensor=None):
    sensor = sensor or ThermalArray()
    return [
        sensor.update(
            parameters,
            Update(
                k,
                k / rate,
                pose,
                {WARMTH: room.ask},
                lambda k=k: generator(0, name, k),
                lambda: generator(0, f"{name}, part", 0),
            ),
        )
        for k, room in enumerate(rooms)
    ]


def several(first, rooms, rate=10.0):
    """Return the updates of an array from number `first` on, one in each room."""

    def ask(bundle, *rays, indices=None):
        return Answers([room.ask(bundle, *rays) for room in rooms], np.arange(len(rooms)))

    numbers = first + np.arange(len(rooms))
    return Updates(
        numbers,
        numbers / rate,
        np.ones(len(rooms), bool),
        POSE,
        {WARMTH: ask},
        lambda k: generator(0, "array", k),
        lambda: generator(0, "array, part", 0),
    )


def frame(reading, parameters=None):
    values = [float(text) for text in reading.fields["frame_c"].split(";")]
    parameters = parameters or ThermalArrayParameters()
    return np.array(values).reshape(parameters.rows, parameters.columns)


def mixed(share, celsius, emissivity=1.0, ambient=AMBIENT):
    """Return the temperature of a pixel that a surface fills by `share`, in closed form."""
    hot, cold = (celsius + ZERO) ** 4, (ambient + ZERO) ** 4
    return (share * emissivity * (hot - cold) + cold) ** 0.25 - ZERO


@pytest.mark.parametrize(
    ("radius", "distance", "celsius"),
    [(0.1, 1.5, 29.0), (0.1, 2.5, 29.0), (0.1, 4.0, 30.0), (0.02, 1.0, 30.0), (0.08, 1.0, 10.0)],
)
def test_a_disc_counts_by_its_share_of_a_pixel(radius, distance, celsius):
    parameters = ThermalArrayParameters(
        columns=1, rows=1, horizontal_fov=math.radians(10), vertical_fov=math.radians(10), **EXACT
    )
    side = 2 * math.tan(math.radians(5))
    share = math.pi * (radius / distance) ** 2 / side**2
    assert radius / distance < side / 2
    (seen,) = read(parameters, Room(disc(radius, distance, celsius)))
    assert frame(seen, parameters)[0, 0] == pytest.approx(mixed(share, celsius), abs=0.05)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 1.0])
@pytest.mark.parametrize("rays", [13, 21, 34])
def test_an_upright_edge_divides_a_pixel_within_half_a_ray(share, rays):
    """The pixels in column 4 begin on the axis; the ones left of it are full."""
    parameters = ThermalArrayParameters(rays=rays)
    step = math.tan(math.radians(30)) / 4
    found = frame(read(parameters, Room(left_of(share * step, 29.0)))[0])
    assert found[:, :4] == pytest.approx(mixed(1.0, 29.0), abs=0.006)
    assert found[:, 5:] == pytest.approx(AMBIENT, abs=0.006)
    low, high = (mixed(min(max(share + d / rays, 0.0), 1.0), 29.0) for d in (-0.5, 0.5))
    assert (found[:, 4] >= low - 0.01).all() and (found[:, 4] <= high + 0.01).all()


def test_pixels_are_rows_from_the_upper_left_with_equal_tangents():
    parameters = ThermalArrayParameters(columns=4, rows=2, rays=1, horizontal_fov=math.radians(80))
    _, ways, _ = array_rays(parameters, POSE)
    x, y = ways[:, 0] / -ways[:, 2], ways[:, 1] / -ways[:, 2]
    wide, high = math.tan(math.radians(40)), math.tan(math.radians(30))
    assert x == pytest.approx(wide * np.tile([-0.75, -0.25, 0.25, 0.75], 2))
    assert y == pytest.approx(high * np.repeat([0.5, -0.5], 4))


def test_turned_upside_down_it_sees_the_room_turned():
    room = Room(disc(0.3, 2.0, 30.0, at=(0.3, 0.2)))
    turned = Pose(np.zeros(3), np.diag([-1.0, -1.0, 1.0]))
    upright, over = (frame(read(ThermalArrayParameters(), room, pose=p)[0]) for p in (POSE, turned))
    assert np.abs(upright - over[::-1, ::-1]).max() < 1.0, "the lattice is not symmetric"
    assert upright[2, 6] > 25.0 and over[5, 1] > 25.0


def test_nothing_in_view_reads_the_ambient_temperature():
    for ambient in (-20.0, 0.0, 21.0):
        (seen,) = read(ThermalArrayParameters(), Room(ambient=ambient))
        assert frame(seen) == pytest.approx(ambient)
        assert not seen.active and seen.fields["warm_pixels"] == 0
        assert seen.value == pytest.approx(ambient) == seen.fields["mean_c"]


def test_bare_metal_mirrors_the_room():
    """Of emissivity 0.1, at 100 °C, it looks like 32 °C: it emits a tenth."""
    (seen,) = read(ThermalArrayParameters(), Room(disc(9.0, 1.0, 100.0, emissivity=0.1)))
    assert seen.value == pytest.approx(mixed(1.0, 100.0, 0.1), abs=1e-9)
    assert seen.value == pytest.approx(32.05, abs=0.01)


def test_a_hot_lamp_is_limited_to_the_range_of_the_part():
    parameters = ThermalArrayParameters(coldest=0.0, hottest=80.0)
    (lamp,) = read(parameters, Room(disc(9.0, 1.0, 200.0)))
    (frost,) = read(parameters, Room(ambient=-15.0))
    assert (lamp.value, frost.value) == (80.0, 0.0)


def test_one_pixel_works_alone():
    parameters = ThermalArrayParameters(columns=1, rows=1, min_pixels=1, background="LEARNT")
    empty, person = read(parameters, Room(), Room(disc(9.0, 1.0, 29.0)))
    assert (empty.active, person.active) == (False, True)
    assert ";" not in person.fields["frame_c"]
    stuck = ThermalArrayParameters(columns=1, rows=1, min_pixels=1).unreachable()
    assert "never goes on" in stuck[0].text


# Noise, resolution, spread of devices.


def noise_of(name, count=400, **values):
    """Return the noise (rows, columns) of a preset's pixels, by differences, and its frames."""
    parameters = ThermalArrayParameters(**PRESETS[name].values | values)
    room = Room()
    found = read(parameters, *[room] * count, rate=PRESETS[name].rate)
    frames = np.array([frame(r, parameters) for r in found])
    return np.diff(frames, axis=0).std(axis=0) / math.sqrt(2), frames


def parts_of(noise):
    """Return the noise of the middle four pixels, the median of the edge, and of the corners."""
    (rows, columns), edge = noise.shape, np.ones(noise.shape, bool)
    edge[1:-1, 1:-1] = False
    middle = noise[rows // 2 - 1 : rows // 2 + 1, columns // 2 - 1 : columns // 2 + 1]
    return middle.mean(), np.median(noise[edge]), noise[:: rows - 1, :: columns - 1].mean()


def test_a_mlx90640_at_8_hz_has_the_measured_noise():
    """Measured: 0.277 K in the middle, the median pixel 0.356 K, the edge 0.465 K."""
    noise, _ = noise_of("MLX90640_BAA", 160, rays=1, netd=0.196 * math.sqrt(2))
    middle, edge, _ = parts_of(noise)
    assert middle == pytest.approx(0.277, abs=0.03)
    assert np.median(noise) == pytest.approx(0.356, abs=0.02)
    assert edge == pytest.approx(0.465, abs=0.03)


def test_a_grid_eye_has_the_measured_noise_and_drift():
    """Measured: 0.20, 0.253 and 0.288 K; means of 50 frames 0.087 K, of a pixel 0.046 K."""
    noise, frames = noise_of("AMG8833", 1200, rays=1)
    assert parts_of(noise) == pytest.approx((0.2, 0.253, 0.288), abs=0.02)
    assert frames / 0.25 == pytest.approx(np.round(frames / 0.25))
    means = frames.reshape(-1, 50, 64).mean(axis=1)
    whole = means.mean(axis=1, keepdims=True)
    assert whole.std() == pytest.approx(0.087, abs=0.04)
    assert np.median((means - whole).std(axis=0)) == pytest.approx(0.046, abs=0.01)


@pytest.mark.parametrize(("name", "ratio"), [("D6T_1616L", 2.33), ("HTPA32", 2.0)])
def test_corner_pixels_have_the_measured_share_of_noise(name, ratio):
    noise, _ = noise_of(name, 300, rays=1)
    middle, _, corner = parts_of(noise)
    assert corner / middle == pytest.approx(ratio, abs=0.25)


def test_a_running_mean_lags_and_its_noise_is_that_of_the_mean():
    cold, warm = Room(), Room(disc(9.0, 1.0, 31.0))
    parameters = ThermalArrayParameters(columns=1, rows=1, min_pixels=1, rays=1, mean_of=4)
    found = [r.value for r in read(parameters, cold, *[warm] * 5)]
    assert found == pytest.approx([21.0, 23.6, 26.1, 28.6, 31.0, 31.0], abs=0.1)
    noisy = ThermalArrayParameters(rays=1, mean_of=4, netd=0.2)
    frames = np.array([frame(r) for r in read(noisy, *[cold] * 200)]).reshape(200, -1) - AMBIENT
    assert frames[4:].std() == pytest.approx(0.2, rel=0.05)
    lags = [np.mean(frames[4:-k] * frames[4 + k :]) / 0.04 for k in (1, 2, 4)]
    assert lags == pytest.approx([0.75, 0.5, 0.0], abs=0.06)


DRIFTING = {
    "netd": 0.1, "noise_rise": 0.5, "frame_noise": 0.05, "frame_drift": 0.2, "pixel_drift": 0.1,
    "drift_time": 0.4, "fixed_pattern": 0.3, "mean_of": 3, "blur": 0.5,
}  # fmt: skip


def test_the_noise_of_an_update_is_the_same_wherever_a_run_begins():
    parameters = ThermalArrayParameters(**DRIFTING)

    def run(first):
        updates = several(first, [Room()] * (12 - first))
        found = ThermalArray().sense(parameters, updates)
        return [found[k].fields for k in range(len(found))]

    whole = run(0)
    assert run(5) == whole[5:] and run(11) == whole[11:]
    assert len({fields["mean_c"] for fields in whole}) == 12


def test_drift_is_slow_and_a_fixed_pattern_stays():
    room = Room()
    slow = ThermalArrayParameters(rays=1, frame_drift=0.3, pixel_drift=0.2, drift_time=10.0)
    frames = np.array([frame(r) for r in read(slow, *[room] * 1000)]).reshape(1000, -1)
    assert np.abs(np.diff(frames, axis=0)).max() < 0.03
    means = frames.mean(axis=1)
    assert 0.1 < means.std() < 0.5
    assert (frames - means[:, None]).std() == pytest.approx(0.2, abs=0.03)
    still = ThermalArrayParameters(rays=1, fixed_pattern=0.3)
    frames = np.array([frame(r) for r in read(still, *[room] * 5)]).reshape(5, -1)
    assert np.ptp(frames, axis=0).max() == 0.0
    assert frames[0].std() == pytest.approx(0.3, abs=0.08)


# Blur.


@pytest.mark.parametrize("blur", [0.3, 0.5, 1.0])
def test_a_blurred_edge_is_the_integral_of_a_gaussian(blur):
    """Also in the last column, whose rays reach beyond the frame."""
    pixel = 2 * math.tan(math.radians(30)) / 8
    columns = np.arange(8) + 0.5
    parameters = ThermalArrayParameters(blur=blur, rays=1024)
    for edge in (3.0, 7.6, 8.3):
        hot = left_of((edge - 4) * pixel, 31.0)
        (seen,) = read(parameters, Room(hot))

        def h(z):
            normal = np.array([math.erf(x / math.sqrt(2)) for x in z]) / 2 + 0.5
            return z * normal + np.exp(-(z**2) / 2) / math.sqrt(2 * math.pi)

        low, high = (edge - columns - 0.5) / blur, (edge - columns + 0.5) / blur
        share = blur * (h(high) - h(low))
        expected = [mixed(s, 31.0) for s in share]
        assert frame(seen)[3] == pytest.approx(expected, abs=0.02)


def test_blur_keeps_the_warmth_of_a_body():
    body = disc(0.2, 2.0, 31.0)
    sharp, soft = (
        frame(read(ThermalArrayParameters(blur=b, rays=500), Room(body))[0]) for b in (0.0, 0.7)
    )
    assert soft.max() < sharp.max() - 0.5
    assert (soft - AMBIENT).sum() == pytest.approx((sharp - AMBIENT).sum(), rel=0.02)


def test_the_same_seed_gives_the_same_frames_and_devices_differ():
    parameters = ThermalArrayParameters(netd=0.2, offset_sigma=1.0)
    first, again, other = (read(parameters, *[Room()] * 3, name=n) for n in ("a", "a", "b"))
    assert [r.fields for r in first] == [r.fields for r in again]
    offsets = [np.mean([frame(r).mean() for r in run]) for run in (first, other)]
    assert abs(offsets[0] - offsets[1]) > 0.1
    means = [r.fields["mean_c"] for r in first]
    assert np.ptp(means) < 0.1, "the error of a device stays"


# The settling filter.


@pytest.mark.parametrize("rate", [2.0, 10.0, 64.0])
def test_the_filter_is_exact_for_a_ramp_at_any_rate(rate):
    """Radiation that grows by s a second from t = 0: y = u − sτ(1 − exp(−t/τ))."""
    tau, slope = 0.5, 5.0
    parameters = ThermalArrayParameters(columns=1, rows=1, min_pixels=1, rays=1, settling_time=tau)
    times = np.arange(int(2 * rate) + 1) / rate
    cold = (AMBIENT + ZERO) ** 4

    def kelvin(t):
        return (cold + slope * t * 1e8) ** 0.25

    rooms = [Room(disc(9.0, 1.0, kelvin(t) - ZERO)) for t in times]
    found = [r.value + ZERO for r in read(parameters, *rooms, rate=rate)]
    lag = slope * 1e8 * tau * (1 - np.exp(-times / tau))
    assert found == pytest.approx((cold + slope * 1e8 * times - lag) ** 0.25, abs=1e-6)


def test_updates_one_by_one_and_together_give_the_same():
    rooms = [Room(disc(0.3, 2.0, 25.0 + 2 * k)) for k in range(6)]
    parameters = ThermalArrayParameters(
        settling_time=0.2, background="LEARNT", background_time=2.0, hold_time=0.3, **DRIFTING
    )
    alone = read(parameters, *rooms)

    together = ThermalArray().sense(parameters, several(0, rooms))
    assert [together[k].fields for k in range(6)] == [one.fields for one in alone]


# Background and output.

PERSON = disc(0.35, 2.0, 29.0)


def test_occupied_needs_enough_warm_pixels_and_is_held():
    parameters = ThermalArrayParameters(hold_time=0.3, min_pixels=4)
    small = disc(0.08, 2.0, 29.0, at=(0.07, 0.07))
    found = read(parameters, Room(), Room(small), Room(PERSON), *[Room()] * 4)
    assert [r.active for r in found] == [False, False, True, True, True, False, False]
    assert found[1].fields["warm_pixels"] == 1 and found[2].fields["warm_pixels"] >= 4


def test_the_threshold_is_an_excess_over_the_background():
    for excess, warm in ((1.9, 0), (2.1, 16)):
        edge = math.tan(math.radians(30)) / 4 * 2
        room = Room(left_of(-edge, AMBIENT + excess))
        (seen,) = read(ThermalArrayParameters(), room)
        assert seen.fields["warm_pixels"] == warm


def test_a_radiator_stays_warm_against_the_median_and_is_learnt():
    radiator = disc(0.3, 2.0, 45.0, at=(0.35, -0.3))
    median, learnt = (
        read(ThermalArrayParameters(background=b, hold_time=0.0), *[Room(radiator)] * 3)
        for b in ("MEDIAN", "LEARNT")
    )
    assert all(r.active for r in median) and not any(r.active for r in learnt)
    learnt = read(
        ThermalArrayParameters(background="LEARNT", hold_time=0.0),
        Room(radiator),
        *[Room(radiator, PERSON)] * 600,
        Room(radiator),
    )
    assert all(r.active for r in learnt[1:-1]), "who stays is not learnt"
    assert not learnt[-1].active


def test_a_slow_warming_room_is_learnt():
    rooms = [Room(ambient=18.0 + k / 100) for k in range(600)]
    parameters = ThermalArrayParameters(background="LEARNT", background_time=5.0)
    found = read(parameters, *rooms)
    assert not any(r.active for r in found) and found[-1].value > 23.5


def test_the_lens_touching_a_body_reads_the_body():
    (seen,) = read(ThermalArrayParameters(), Room((lambda x, y: x > -99, 33.0, 0.98)))
    assert frame(seen) == pytest.approx(mixed(1.0, 33.0, 0.98), abs=0.006)
    assert not seen.active, "nothing else is in view to compare with"


# Coverage maps.


def plain_room(floor=0.0):
    """Return the answers of a room with nothing but a floor at the ambient temperature."""

    def ranges(bundle, origins, ways, length):
        with np.errstate(divide="ignore"):
            far = np.where(ways[:, 2] < 0, (floor - origins[:, 2]) / ways[:, 2], np.inf)
        return np.minimum(far, length)

    def warmth(bundle, origins, ways, length):
        kelvin = np.full(len(ways), AMBIENT + ZERO)
        return Emission(kelvin, np.full(len(ways), 0.95), AMBIENT + ZERO)

    return {RAYS: ranges, WARMTH: warmth}


def strength(parameters, motion, place, length, pose, rate=10.0):
    looking = KIND.view(parameters, Update(0, 0.0, pose, plain_room()), rate)
    start = Start(np.array([[*place, 0.0]]), np.zeros(1), np.array([length]))
    found = looking.strengths(motion, start)
    assert looking.may_notice(motion, start)[0] or found[0] == 0.0
    return found[0]


# At 2.5 m, it looks down.
CEILING = Pose(np.array([0.0, 0.0, 2.5]), np.eye(3))


@pytest.mark.parametrize("background", ["MEDIAN", "LEARNT"])
@pytest.mark.parametrize("moving", [0.0, 0.9])
def test_a_person_below_is_covered_also_at_rest(background, moving):
    parameters = ThermalArrayParameters(background=background)
    step = MOTIONS["STEP"]
    below = strength(parameters, step, (0.0, 0.0), moving, CEILING)
    assert below == pytest.approx((mixed(1.0, WALKER.celsius, 0.95) - AMBIENT) / 2.0, abs=1e-9)
    assert strength(parameters, step, (4.0, 0.0), moving, CEILING) == 0.0


def test_who_sits_still_below_is_covered_and_who_is_aside_is_not():
    parameters = ThermalArrayParameters(**PRESETS["MLX90640_BAA"].values)
    still = MOTIONS["STILL"]
    assert strength(parameters, still, (0.0, 0.3), 0.3, CEILING) > 1.0
    assert strength(parameters, still, (6.0, 0.3), 0.3, CEILING) < 1.0


def test_the_strength_is_that_of_the_model():
    """The body of the map, as the model sees it with rays of its own."""
    for place in ((0.9, 0.0), (1.3, 0.2), (1.6, 0.0), (1.8, 0.0), (2.0, 0.3)):
        for need in (1, 2, 4, 9):
            parameters = ThermalArrayParameters(min_pixels=need)
            motion, start = MOTIONS["CHEST"], Start(np.array([[*place, 0.0]]), *np.zeros((2, 1)))

            def warmth(bundle, origins, ways, length, *_, motion=motion, start=start):
                free = np.full(len(ways), 50.0)
                found = hits(motion, start, 0.0, Rays(origins[0], ways, free))
                kelvin = np.full(len(ways), AMBIENT + ZERO)
                kelvin[found.ray] = WALKER.celsius + ZERO
                return Emission(kelvin, np.full(len(ways), WALKER.emissivity), AMBIENT + ZERO)

            update = Update(0, 0.0, CEILING, {WARMTH: warmth})
            reading = ThermalArray().update(parameters, update)
            found = strength(parameters, motion, place, 0.0, CEILING)
            assert (found > 1.0) == reading.active
            excess = np.sort(frame(reading).ravel())[-need] - AMBIENT
            assert found == pytest.approx(excess / 2.0, abs=0.003)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"min_pixels": 65}, "is more than the array has"),
        ({"coldest": 80.0, "hottest": 20.0}, "must be smaller"),
        ({"columns": 0}, "at least 1"),
        ({"columns": 160, "rows": 160, "rays": 1024}, "take at most 7 rays a pixel"),
        ({"horizontal_fov": math.radians(170)}, "at most 150°"),
    ],
)
def test_values_that_contradict_each_other_are_named(values, words):
    assert words in ThermalArrayParameters(**values).problems()[0]


@pytest.mark.parametrize("values", [{}, *(preset.values for preset in KIND.presets)])
def test_defaults_and_presets_have_few_enough_rays(values):
    parameters = ThermalArrayParameters(**values)
    assert not parameters.problems()
    assert parameters.columns * parameters.rows * parameters.rays <= MAX_RAYS / 5


@pytest.mark.parametrize(
    ("settling_time", "learning", "noticed"),
    [(0.5, 60.0, False), (3.0, 60.0, False), (3.0, 5.0, False), (0.5, 600.0, True)],
)
def test_the_strength_is_that_of_pixels_that_settle_while_the_background_learns(
    settling_time, learning, noticed
):
    """A body that appears: the largest excess of the model over the background that it learns."""
    for place in ((0.5, 0.1), (0.9, 0.0)):
        motion, start = MOTIONS["CHEST"], Start(np.array([[*place, 0.0]]), *np.zeros((2, 1)))
        ways = array_rays(ThermalArrayParameters(), CEILING)[1]
        found = hits(motion, start, 0.0, Rays(CEILING.origin, ways, np.full(len(ways), 50.0)))
        empty = STEFAN_BOLTZMANN * np.full(64, AMBIENT + ZERO) ** 4
        kelvin, emissivity = np.full(len(ways), AMBIENT + ZERO), np.zeros(len(ways))
        kelvin[found.ray], emissivity[found.ray] = WALKER.celsius + ZERO, WALKER.emissivity
        seen = radiosity(Emission(kelvin, emissivity, AMBIENT + ZERO)).reshape(64, -1).mean(axis=1)
        parameters = ThermalArrayParameters(
            background="LEARNT",
            background_time=learning,
            settling_time=settling_time,
            min_pixels=1,
            # Just below what the pixels have in the end, and what a fixed background would give.
            threshold=0.97 * float(celsius(seen).max() - AMBIENT),
        )
        steps = np.array([0.0, *[0.1] * 300])
        frames = Settling().run(np.array([empty, *[seen] * 300]), steps, settling_time)
        frames = celsius(frames)
        learnt, warm = Background().run(parameters, frames, steps)
        largest = (frames - learnt).max() / parameters.threshold
        shown = strength(parameters, motion, place, 0.0, CEILING)
        assert shown == pytest.approx(largest, rel=0.003)
        assert (shown > 1.0) == warm.any() == noticed
