# SPDX-License-Identifier: GPL-3.0-or-later
"""The presence radar against closed forms: geometry, speeds, gates, radar equation, breathing."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.coverage.motions import MOTIONS, Start
from angen_sensors.sensor_logic.formats.home_assistant import BINARY_CLASSES, NUMBER_CLASSES
from angen_sensors.sensor_logic.kinds.presence_radar import KIND
from angen_sensors.sensor_logic.kinds.presence_radar.coverage import view
from angen_sensors.sensor_logic.kinds.presence_radar.parameters import (
    FARTHEST,
    FASTEST,
    NARROWEST,
    RadarParameters,
)
from angen_sensors.sensor_logic.kinds.presence_radar.radar import (
    TRUNK,
    PresenceRadar,
    bessel_j0,
    breathing_share,
    calibration,
    echo_powers,
    energies,
    gate_energies,
    measure,
    modulated_share,
    person_power,
    radar_beams,
    separate,
    sweep,
)
from angen_sensors.sensor_logic.model import Pose, Update, Updates
from angen_sensors.sensor_logic.noise import generator
from angen_sensors.sensor_logic.radio.echoes import ECHOES, Echoes
from angen_sensors.sensor_logic.radio.substances import attenuation, reflectance
from radar_scene import POSE, Ball, Person, Scene, Wall, last, numbers, polar, run, tracker

AWAY = (0.0, 1.0, 0.0)
PRESETS = {preset.identifier: preset for preset in KIND.presets}


def part(name, **values):
    return RadarParameters(**{**PRESETS[name].values, **values})


def echoes(ranges, speed=0.0, breathing=0.0, loss=0.0, share=1.0):
    """Return the echoes of rays that all hit something."""
    ranges = np.atleast_1d(np.asarray(ranges, float))
    full = [np.full(len(ranges), value) for value in (breathing, 0.25, loss, share)]
    return Echoes(ranges, np.full((1, len(ranges)), speed), *full, np.ones(len(ranges), np.intp))


# Numbers of others


@pytest.mark.parametrize(
    ("x", "value"),
    # Abramowitz and Stegun, table 9.1; the zeros in table 9.5.
    [(0.0, 1.0), (1.0, 0.7651976865579666), (2.0, 0.2238907791412357),
     (5.0, -0.1775967713143383), (10.0, -0.2459357644513483), (17.5, -0.1031103982286874),
     (2.404825557695773, 0.0), (5.520078110286311, 0.0)],
)  # fmt: skip
def test_the_bessel_function_is_that_of_the_tables(x, value):
    assert bessel_j0(x) == pytest.approx(value, abs=2e-15)
    assert bessel_j0([x, -x]) == pytest.approx([value, value], abs=2e-15)


def test_breathing_moves_power_into_the_sidebands():
    wavelength = 0.0124
    # A small swing A has 2(2πA/λ)²·… = x²/2 of the power in its sidebands, with x = 4πA/λ.
    x = 4.0 * math.pi * 1e-5 / wavelength
    assert modulated_share(2e-5, wavelength) == pytest.approx(x * x / 2.0, rel=1e-4)
    zero = 2.404825557695773 * wavelength / (2.0 * math.pi)
    assert modulated_share(zero, wavelength) == pytest.approx(1.0)
    assert modulated_share(0.0, wavelength) == 0.0


def test_speeds_below_half_a_wavelength_in_the_integration_time_do_not_count():
    parameters = RadarParameters()
    assert parameters.wavelength == pytest.approx(0.012427, rel=1e-4)
    assert parameters.minimum_speed == pytest.approx(0.0621, rel=1e-3)
    for speed, moves in ((0.0620, False), (0.0623, True), (-0.0623, True)):
        seen = sweep(parameters, np.ones(1), echoes(2.0, speed=speed))
        assert bool(seen.moving.any()) == moves


# Geometry


@pytest.mark.parametrize("distance", [1.0, 2.0, 3.3, 5.0])
@pytest.mark.parametrize("degrees", [-50.0, -15.0, 0.0, 8.0, 40.0])
def test_a_small_target_is_where_it_is(distance, degrees):
    parameters = tracker(
        moving_range=60.0, horizontal_fov=math.radians(120), rays_across=240, rays_up=120
    )
    way = np.array(polar(1.0, degrees))
    ball = Ball(polar(distance + 0.1, degrees), 0.1, velocity=tuple(-0.5 * way))
    fields = last(Scene([ball]), parameters, updates=2)
    x, y = numbers(fields["x_m"])[0], numbers(fields["y_m"])[0]
    # The radar sees the near surface: between the front and the rim of the ball.
    assert distance - 0.051 <= math.hypot(x, y) <= distance + 0.05
    assert math.degrees(math.atan2(x, y)) == pytest.approx(degrees, abs=0.5), "within a beam"
    assert fields["targets"] == 1 and fields["moving"] and fields["presence"]


@pytest.mark.parametrize("speed", [-1.2, -0.4, 0.7, 1.4])
def test_a_walker_has_its_speed_within_two_percent(speed):
    person = Person((0.0, 4.0, 0.0), velocity=(0.0, speed, 0.0))
    fields = last(Scene([person]), tracker(), updates=6)
    assert numbers(fields["speed_mps"])[0] == pytest.approx(speed, rel=0.02)


def test_the_radial_part_of_a_speed_is_seen():
    person = Person(polar(4.0, 0.0), velocity=(0.8, 0.8, 0.0))
    fields = last(Scene([person]), tracker(), updates=2)
    assert numbers(fields["speed_mps"])[0] == pytest.approx(0.8, rel=0.05)
    # Nothing but the rim of a body that circles the radar moves towards it or away.
    beams = radar_beams(tracker(), POSE)
    scene = Scene([Person(polar(4.0, 0.0), velocity=(0.8, 0.0, 0.0))])
    rays = beams.origins, beams.directions, beams.length, 24.125, 0.1
    scene.answer(0, *rays)
    seen = sweep(tracker(), beams.weight, scene.at(0.1).answer(0, *rays))
    assert 0.04 < np.abs(seen.speed).max() < 0.06 and seen.moving.sum() == 0.0


@pytest.mark.parametrize(("distance", "gate"), [(0.7499, 0), (0.7501, 1), (5.2499, 6), (5.2501, 7)])
def test_a_gate_ends_at_a_multiple_of_its_length(distance, gate):
    parameters = RadarParameters()
    assert parameters.gates == 8
    seen = sweep(parameters, np.ones(1), echoes(distance, speed=1.0))
    assert np.flatnonzero(seen.moving).tolist() == [gate]


def test_two_bodies_are_two_targets_if_range_or_angle_separate_them():
    def count(*bodies):
        return last(Scene(list(bodies)), tracker(angle_resolution=math.radians(20)))["targets"]

    def person(distance, degrees, speed=0.6):
        return Person(polar(distance, degrees), velocity=(0.0, speed, 0.0))

    assert count(person(3.0, 0.0)) == 1
    assert count(person(2.0, 0.0), person(3.0, 12.0)) == 2, "apart in range"
    assert count(person(3.0, -20.0), person(3.0, 20.0)) == 2, "apart in angle"
    assert count(person(3.0, -6.0), person(3.1, 8.0)) == 1, "not apart: one target"
    four = [person(2.0, -15.0), person(2.0, 15.0), person(4.0, -40.0), person(4.0, 40.0)]
    assert count(*four) == 3, "at most three"
    both = last(Scene([person(2.0, -20.0, 0.6), person(3.5, 25.0, -0.9)]), tracker())
    x, y, speed = (numbers(both[name]) for name in ("x_m", "y_m", "speed_mps"))
    assert len(x) == 2 and x[0] < 0.0 < x[1] and y[0] < y[1], "to the right is positive"
    assert speed[0] > 0.0 > speed[1], "away is positive"


def test_groups_are_cut_along_both_axes():
    ranges = np.array([1.0, 1.1, 1.0, 1.1, 3.0])
    azimuth = np.array([-0.5, -0.5, 0.5, 0.5, 0.0])
    groups = sorted(sorted(group.tolist()) for group in separate(ranges, azimuth, 0.3, 0.35))
    assert groups == [[0, 1], [2, 3], [4]]
    assert len(list(separate(ranges, azimuth, 5.0, 5.0))) == 1
    assert list(separate(np.empty(0), np.empty(0), 0.3, 0.3)) == []


# The radar equation


def test_the_energy_of_a_small_target_falls_with_the_fourth_power_of_its_distance():
    parameters = RadarParameters(
        horizontal_fov=math.radians(20), vertical_fov=math.radians(20), rays_across=300,
        rays_up=300, moving_range=3.0, moving_thresholds="30",
    )  # fmt: skip
    beams = radar_beams(parameters, POSE)
    powers = []
    for distance in (2.0, 4.0):
        scene = Scene([Ball((0.0, distance, 0.0), 0.1, velocity=AWAY)])
        rays = beams.origins, beams.directions, beams.length, parameters.frequency, 0.1
        scene.answer(0, *rays)
        seen = sweep(parameters, beams.weight, scene.at(0.1).answer(0, *rays))
        powers.append(float(seen.moving.sum()))
    assert 10.0 * math.log10(powers[0] / powers[1]) == pytest.approx(40.0 * math.log10(2), abs=0.5)
    # The power is σ/R⁴ with the silhouette of the ball, except near its rim.
    expected = reflectance("BODY", 24.125) * math.pi * 0.1**2 / 4.0**4
    assert powers[1] == pytest.approx(expected, rel=0.08)


def test_energies_are_decibels():
    found = energies(np.array([0.0, 1.0, 10.0, 1e9, 1e-9]), 1.0, 40.0)
    assert found == pytest.approx([0.0, 40.0, 65.0, 100.0, 0.0]), "2.5 points a dB"


def test_the_antenna_has_half_of_its_gain_at_the_edges_of_the_field_of_view_each_way():
    parameters = RadarParameters(rays_across=120001, rays_up=1, vertical_fov=1e-3)
    beams = radar_beams(parameters, POSE)
    ahead = np.argmin(np.abs(beams.azimuth))
    assert beams.weight[-1] / beams.weight[ahead] == pytest.approx(0.25, rel=1e-4)
    assert beams.weight[0] / beams.weight[ahead] == pytest.approx(0.25, rel=1e-4)


def test_the_rays_fill_their_field_of_view():
    for across, up in ((60, 30), (1, 1), (7, 2)):
        parameters = RadarParameters(rays_across=across, rays_up=up)
        beams = radar_beams(parameters, POSE)
        assert np.linalg.norm(beams.directions, axis=1) == pytest.approx(1.0)
        assert np.abs(beams.azimuth).max() <= parameters.horizontal_fov / 2
        assert beams.directions.shape == (across * up, 3)
    only = radar_beams(RadarParameters(rays_across=1, rays_up=1), POSE)
    assert only.directions[0] == pytest.approx(AWAY), "a single ray looks ahead"
    level = math.radians(120) * 2.0 * math.sin(math.radians(60))
    gain = np.exp2(-2.0 * (only.azimuth / math.radians(60)) ** 2)
    assert only.weight / gain == pytest.approx([level]), "all of the solid angle"


@pytest.mark.parametrize("name", ["LD2410", "LD2450", "MR60BHA1"])
def test_a_standard_person_is_just_detected_at_the_ranges_of_the_data_sheet(name):
    """Within 10 %: on the edge of two gates, each has a part of the power.

    With half of it, the distance is less by the fourth root of a half, 16 %.
    """
    parameters = part(name, rays_across=300, rays_up=150, hold_time=0.0, range_max=7.0)

    def detects(distance, **person):
        return last(Scene([Person((0.0, distance + 0.2, 0.0), **person)]), parameters)["presence"]

    for farthest, person in (
        (parameters.moving_range, {"velocity": (0.0, -0.7, 0.0)}),
        (parameters.still_range, {"breathing": 0.005}),
    ):
        shares = np.arange(0.72, 1.1, 0.02)
        seen = [detects(share * farthest, **person) for share in shares.tolist()]
        assert shares[np.flatnonzero(seen)[-1]] == pytest.approx(1.0, abs=0.101)
        assert all(seen[: int(np.searchsorted(shares, 0.8))])


@pytest.mark.parametrize("name", PRESETS)
def test_no_gate_before_the_range_of_the_data_sheet_is_blind(name):
    parameters = part(name)
    known = calibration(parameters)
    distance = np.linspace(0.05, 1.0, 200)
    for share, needed, farthest in (
        (1.0, known.moving_needed, parameters.moving_range),
        (breathing_share(parameters), known.still_needed, parameters.still_range),
    ):
        at = distance * min(farthest, parameters.range_max) * 0.999
        gate = np.minimum((at / parameters.gate_length).astype(int), parameters.gates - 1)
        power = share * np.array([person_power(parameters, one) for one in at.tolist()])
        assert (power > needed[gate]).all()


# Walls


def test_a_wall_of_plasterboard_weakens_by_its_loss_twice():
    person = Person((0.0, 3.0, 0.0), velocity=(0.0, 0.3, 0.0))
    parameters = RadarParameters(moving_range=3.0, moving_thresholds="60")
    free = last(Scene([person]), parameters)
    through = last(Scene([person], [Wall(1.5)]), parameters)
    loss = 2.0 * attenuation("PLASTERBOARD", 0.025, parameters.frequency)
    one, two = (gate_energies(found["gates"])[3][0] for found in (free, through))
    assert one - two == pytest.approx(2.5 * loss, abs=1.0), "rounded to whole points"
    assert 8.0 < loss < 12.0


def test_nothing_is_seen_behind_a_wall_that_stops_the_waves():
    person = Person((0.0, 3.0, 0.0), velocity=(0.0, 0.3, 0.0))
    scene = Scene([person], [Wall(1.5, "CONCRETE", 0.2, stops=True)])
    fields = last(scene, tracker())
    assert not fields["presence"] and not fields["moving"] and fields["targets"] == 0
    assert fields["distance_m"] == 6.0 and fields["x_m"] == ""


def test_the_loss_counts_twice_in_the_power():
    parameters = RadarParameters()
    both = [echo_powers(parameters, np.ones(1), echoes(2.0, loss=loss))[0] for loss in (0.0, 5.0)]
    assert both[0] == pytest.approx(0.25) and both[1] == pytest.approx(0.025)


# Breathing


def test_a_person_who_only_breathes_is_present_but_does_not_move():
    person = Person((0.5, 2.5, 0.0), breathing=0.005)
    fields = last(Scene([person]), tracker())
    assert fields["presence"] and not fields["moving"]
    assert fields["distance_m"] == pytest.approx(math.hypot(0.5, 2.5) - 0.2, abs=0.1)
    assert numbers(fields["speed_mps"]) == [0.0] and fields["targets"] == 1
    still = last(Scene([Person((0.5, 2.5, 0.0))]), tracker())
    assert not still["presence"], "furniture does not breathe"


def test_only_the_trunk_breathes_and_rays_that_move_do_not_count_as_still():
    parameters = RadarParameters()
    power = float(echo_powers(parameters, np.ones(1), echoes(2.0))[0])
    share = float(modulated_share(0.005, parameters.wavelength))
    seen = sweep(parameters, np.ones(1), echoes(2.0, breathing=0.005))
    assert seen.still.sum() == pytest.approx(TRUNK * share * power)
    assert seen.moving.sum() == 0.0
    seen = sweep(parameters, np.ones(1), echoes(2.0, breathing=0.005, speed=1.0))
    assert seen.still.sum() == 0.0 and seen.moving.sum() == pytest.approx(power)


# Time


def test_presence_holds_and_keeps_the_last_distance():
    scene = Scene([Person((0.0, 2.2, 0.0), velocity=(0.0, 1.0, 0.0))])
    parameters = tracker(hold_time=1.0)
    model = PresenceRadar()
    seen = run(scene, parameters, updates=5, model=model)[-1].fields
    scene.bodies = []
    after = run(scene, parameters, updates=15, model=model, first=5)
    assert [reading.active for reading in after] == [True] * 9 + [False] * 6, "1 s after 0.4 s"
    assert not any(reading.fields["moving"] for reading in after)
    assert {reading.fields["distance_m"] for reading in after[:9]} == {seen["distance_m"]}
    assert {reading.fields["distance_m"] for reading in after[9:]} == {parameters.range_max}


def test_a_new_start_after_a_jump_gives_no_speed():
    scene = Scene([Person((0.0, 3.0, 0.0), velocity=(0.0, 1.0, 0.0))])
    run(scene, tracker(), updates=3)
    # A new model, while the scene still knows the query before the jump.
    reading = run(scene, tracker(), updates=1, first=40)[0]
    assert not reading.fields["moving"] and reading.fields["targets"] == 0


def test_after_skipped_updates_the_speed_is_the_mean_over_the_gap():
    scene = Scene([Person((0.0, 2.0, 0.0), velocity=(0.0, 0.5, 0.0))])
    model = PresenceRadar()
    run(scene, tracker(), updates=2, model=model)
    fields = run(scene, tracker(), updates=1, first=21, model=model)[0].fields
    assert numbers(fields["speed_mps"])[0] == pytest.approx(0.5, rel=0.03)


def test_many_updates_at_once_give_the_readings_of_one_at_a_time():
    class Batch:
        """A scene that answers many updates, the last five with the same echoes."""

        def __init__(self, scene):
            self.scene, self.asks = scene, 0

        def ask(self, need, *question, which=None):
            from angen_sensors.sensor_logic.model import Answers

            table = [self.scene.at(k / 10.0).answer(*question) for k in range(6)]
            still = self.scene.at(0.5).answer(*question)
            rows = np.array([0, 1, 2, 3, 4, 5, 6, 6, 6, 6])
            return Answers([*table, still], rows)

    def scene():
        return Scene([Person((0.0, 2.0, 0.0), velocity=(0.0, 0.4, 0.0), breathing=0.004)])

    parameters = tracker(hold_time=0.3)
    updates = Updates(
        np.arange(10), np.arange(10) / 10.0, np.ones(10, bool), POSE,
        {"echoes": lambda *question, which=None: Batch(scene()).ask("echoes", *question)},
        lambda number: generator(0, "radar", number), lambda: generator(0, "radar", 0),
    )  # fmt: skip
    together = PresenceRadar().sense(parameters, updates)
    alone = run(scene(), parameters, updates=6)
    assert [together[i].fields for i in range(6)] == [one.fields for one in alone]
    assert together[9].fields["presence"] and not together[9].fields["moving"]
    assert together[6].fields == together[9].fields


# Hard cases


def is_finite(fields):
    texts = [fields[name] for name in ("x_m", "y_m", "speed_mps") if fields[name]]
    values = [v for text in texts for v in numbers(text)] + [fields["distance_m"]]
    values += [v for pair in gate_energies(fields["gates"]) for v in pair]
    return all(math.isfinite(v) for v in values)


def test_a_radar_that_hits_nothing_reads_no_one():
    fields = last(Scene(), tracker())
    assert (fields["presence"], fields["targets"], fields["distance_m"]) == (False, 0, 6.0)
    assert set(fields["gates"].split(";")) == {"0/0"} and is_finite(fields)


@pytest.mark.parametrize("distance", [0.0, 1e-12, 0.005])
def test_a_target_at_the_radar_itself_gives_finite_numbers(distance):
    parameters = tracker()
    beams = radar_beams(parameters, POSE)
    near = echoes(np.full(len(beams.length), distance), speed=1.0)
    found = measure(parameters, calibration(parameters), beams, near)
    assert found.moving[0] and found.moving_energy[0] == 100.0
    assert found.distance == pytest.approx(distance) and math.isfinite(found.targets[0].power)


def test_one_ray_is_enough():
    fields = last(
        Scene([Person((0.0, 2.0, 0.0), velocity=(0.0, 0.4, 0.0))]),
        tracker(rays_across=1, rays_up=1),
    )
    assert fields["targets"] == 1 and numbers(fields["x_m"]) == [0.0] and is_finite(fields)


def test_nearer_than_range_min_or_at_range_max_nothing_is_seen():
    parameters = RadarParameters(range_min=0.4)
    ranges = np.array([0.3999, 0.4001, 5.9999, 6.0])
    seen = echo_powers(parameters, np.ones(4), echoes(ranges)) > 0.0
    assert seen.tolist() == [False, True, True, False]


def test_a_threshold_of_100_switches_a_gate_off_and_0_leaves_it_on():
    person = Person((0.0, 1.9, 0.0), velocity=(0.0, 0.4, 0.0))
    for thresholds, found in (("100", False), ("100 100 99 100", True), ("0", True)):
        parameters = RadarParameters(moving_thresholds=thresholds, hold_time=0.0, moving_range=30.0)
        assert last(Scene([person]), parameters)["presence"] == found
    empty = RadarParameters(moving_thresholds="0", still_thresholds="0")
    assert not last(Scene(), empty)["presence"], "no energy is not above 0"


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"moving_thresholds": "40 x"}, ["moving_thresholds", "40 x"]),
        ({"still_thresholds": ""}, ["still_thresholds", "0 to 100"]),
        ({"still_thresholds": "40 101"}, ["still_thresholds"]),
        ({"moving_thresholds": "nan"}, ["moving_thresholds"]),
        ({"range_min": 6.0}, ["range_min", "range_max"]),
        ({"rays_across": 1000, "rays_up": 101}, ["1000 times 101"]),
        ({"range_max": 100.0, "gate_length": 0.05}, ["gate_length", "1000 gates"]),
        ({"horizontal_fov": 1e-4}, ["horizontal_fov", "at least 1°"]),
        ({"vertical_fov": 1e-4}, ["vertical_fov", "at least 1°"]),
        ({"range_max": 101.0}, ["range_max", "at most 100 m"]),
        ({"moving_range": 1e30}, ["moving_range", "at most 100 m"]),
        ({"still_range": 1e30}, ["still_range", "at most 100 m"]),
        ({"energy_noise": 1e6}, ["energy_noise", "at most 100"]),
    ],
)  # fmt: skip
def test_what_contradicts_itself_is_named(values, words):
    problems = RadarParameters(**values).problems()
    assert len(problems) == 1 and all(word in problems[0] for word in words)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("fov", [NARROWEST, math.radians(178)])
@pytest.mark.parametrize("distance", [0.1, FARTHEST])
def test_the_least_and_the_largest_parameters_give_numbers(fov, distance):
    parameters = tracker(
        horizontal_fov=fov, vertical_fov=fov, moving_range=distance, still_range=distance,
        range_max=FARTHEST, energy_noise=100.0, rays_across=30, rays_up=30,
    )  # fmt: skip
    assert not parameters.problems()
    scene = Scene([Person((0.0, 0.5, 0.0), velocity=(0.0, 1.0, 0.0), breathing=0.005)])
    assert all(is_finite(reading.fields) for reading in run(scene, parameters, updates=20))


def test_targets_have_the_noise_of_the_energies():
    person = Person((0.0, 5.0, 0.0), velocity=(0.0, 0.05, 0.0), breathing=0.005)
    parameters = tracker(energy_noise=8.0, hold_time=0.0, still_range=5.0)
    found = [reading.fields for reading in run(Scene([person]), parameters, updates=100)]
    assert {one["presence"] for one in found} == {True, False}
    assert all(one["presence"] for one in found if one["targets"])
    assert any(one["targets"] for one in found)


@pytest.mark.parametrize(("speed", "moves"), [(9.9, True), (10.1, False), (-47.9, False)])
def test_what_jumps_does_not_count_as_moving(speed, moves):
    parameters = RadarParameters()
    seen = sweep(parameters, np.ones(1), echoes(2.0, speed=speed))
    assert bool(seen.moving.any()) == moves == (abs(speed) <= FASTEST)


def test_thresholds_that_no_energy_exceeds_are_advised_on():
    never = RadarParameters(moving_thresholds="100", still_thresholds="100, 100")
    assert "never goes on" in never.unreachable()[0].problem
    assert RadarParameters(moving_thresholds="100").unreachable() == []


def test_an_integration_time_too_short_for_any_speed_is_advised_on():
    short = RadarParameters(frequency=10.0, integration_time=0.001)
    assert "nothing counts as moving" in short.unreachable()[0].problem
    assert RadarParameters(integration_time=0.001).unreachable() == []


def test_noise_scatters_and_repeats():
    person = Person((0.0, 3.0, 0.0), breathing=0.005)
    parameters = tracker(range_noise=0.05, angle_noise=math.radians(2), energy_noise=3.0)
    one, two = (run(Scene([person]), parameters, updates=200) for _ in range(2))
    assert [reading.fields for reading in one] == [reading.fields for reading in two]
    y = np.array([numbers(reading.fields["y_m"])[0] for reading in one])
    assert y.std() == pytest.approx(0.05, rel=0.2)
    energy = np.array([gate_energies(reading.fields["gates"])[8][1] for reading in one])
    assert energy.std() == pytest.approx(3.0, rel=0.2)
    assert all(is_finite(reading.fields) for reading in one)


# Formats


def test_home_assistant_gets_occupancy_motion_and_distance():
    quantities = {field.name: field.quantity for field in KIND.events}
    assert BINARY_CLASSES[quantities["presence"]] == "occupancy"
    assert BINARY_CLASSES[quantities["moving"]] == "motion"
    assert NUMBER_CLASSES[quantities["distance_m"]] == "distance"


# Coverage maps


def covered(name, distance, motion, degrees=0.0, walls=(), heading=math.pi / 2, **values):
    """Return the strength with which a radar at 1 m above the floor notices a motion."""
    parameters = part(name, rays_across=200, rays_up=100, **values)
    scene = Scene([], list(walls))
    pose = Pose(np.array([0.0, 0.0, 1.0]), POSE.axes)
    looking = view(parameters, Update(0, 0.0, pose, {ECHOES: scene.answer}), 10.0)
    x, y, _ = polar(distance, degrees)
    moves = MOTIONS[motion]
    length = float(moves.lengths(np.full((1, 8), 5.0))[0, 0])
    start = Start(np.array([[x, y, 0.0]]), np.array([heading]), np.array([length]))
    assert looking.may_notice(moves, start).all() or not looking.strengths(moves, start).any()
    return float(looking.strengths(moves, start)[0])


def test_a_map_covers_what_the_radar_detects():
    assert covered("LD2410", 4.0, "STEP") > 1.0 > covered("LD2410", 7.5, "STEP")
    assert covered("LD2410", 3.0, "STILL") > 1.0
    assert covered("LD2410", 1.4, "ARM", heading=0.0) > 1.0
    assert covered("LD2410", 3.0, "CRAWL") > covered("LD2410", 3.0, "CAT")
    assert covered("LD2410", 3.0, "STEP", degrees=95.0) == 0.0, "outside of the field of view"
    assert covered("LD2410", 3.0, "STILL", walls=[Wall(2.0, "CONCRETE", 0.2, True)]) == 0.0


def test_a_map_counts_a_wall_twice_and_only_in_front_of_the_body():
    free = covered("LD2410", 3.0, "STILL")
    behind = covered("LD2410", 3.0, "STILL", walls=[Wall(1.5)])
    loss = attenuation("PLASTERBOARD", 0.025, 24.125)
    assert behind == pytest.approx(free * 10.0 ** (-0.2 * loss))
    assert covered("LD2410", 3.0, "STILL", walls=[Wall(3.5)]) == free


def losses_asked(scene, **values):
    """Return the view of a radar in a scene, and the number of its queries."""
    asked = []

    def answer(*question):
        asked.append(question)
        return scene.answer(*question)

    parameters = part("LD2410", **values)
    return view(parameters, Update(0, 0.0, POSE, {ECHOES: answer}), 10.0), len(asked)


def test_a_map_asks_for_losses_only_as_far_as_they_grow(monkeypatch):
    walls = [Wall(1.0), Wall(2.0, "CONCRETE", 0.2, True)]
    narrow = {"horizontal_fov": 0.2, "vertical_fov": 0.2, "range_max": 100.0, "gate_length": 0.75}
    looking, asked = losses_asked(Scene([], walls), **narrow)
    assert asked <= 7, "up to 1.25 m"
    assert (looking.loss[-1] > 0.0).all() and not looking.loss[3].any()
    assert losses_asked(Scene([], walls[1:]), **narrow)[1] == 1, "nothing lets waves pass"
    monkeypatch.setattr("angen_sensors.sensor_logic.kinds.presence_radar.coverage.MOST_LOSSES", 1)
    coarse, asked = losses_asked(Scene([], walls), **narrow)
    assert asked == 2 and coarse.step == pytest.approx(2.0, abs=0.05)
    assert np.array_equal(coarse.loss[-1], looking.loss[-1])


def test_a_map_agrees_with_the_model():
    """A cylinder of the same size, height and speed gives the model the same ratio."""
    parameters = part("LD2410", rays_across=200, rays_up=100)
    still = MOTIONS["STILL"]
    scene = Scene([Person((0.0, 3.0, 0.925 - 1.0), half=0.325, breathing=0.005)])
    beams = radar_beams(parameters, POSE)
    rays = beams.origins, beams.directions, beams.length, parameters.frequency, 0.1
    seen = sweep(parameters, beams.weight, scene.answer(0, *rays))
    ratio = (seen.still / calibration(parameters).still_needed).max()
    assert (still.bottom, still.top) == (0.6, 1.25)
    assert covered("LD2410", 3.0, "STILL") == pytest.approx(ratio, rel=1e-9)
