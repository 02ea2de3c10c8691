# SPDX-License-Identifier: GPL-3.0-or-later
"""The presence radar against closed forms: geometry, speeds, gates, radar equation, breathing."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from angen_sensors.sensor_logic.coverage.motions import MOTIONS, Start
from angen_sensors.sensor_logic.kinds.presence_radar import KIND
from angen_sensors.sensor_logic.kinds.presence_radar.coverage import view
from angen_sensors.sensor_logic.kinds.presence_radar.gate_evidence import gate_energies
from angen_sensors.sensor_logic.kinds.presence_radar.parameters import (
    FARTHEST,
    FASTEST,
    NARROWEST,
    RadarParameters,
)
from angen_sensors.sensor_logic.kinds.presence_radar.radar import (
    PERSON_BREATHING,
    PERSON_RATE,
    ROUND,
    WALKING,
    LeakyMean,
    PresenceRadar,
    breathing_speed,
    calibration,
    doppler_weight,
    echo_powers,
    hann,
    person_power,
    radar_beams,
    ray_angles,
    separate,
    sweep,
    two_way_gain,
)
from angen_sensors.sensor_logic.logs.formats.home_assistant import BINARY_CLASSES, NUMBER_CLASSES
from angen_sensors.sensor_logic.model import Answers, Pose, Update, Updates
from angen_sensors.sensor_logic.noise import generator
from angen_sensors.sensor_logic.radio.echoes import ECHOES, Echoes
from angen_sensors.sensor_logic.radio.substances import attenuation, reflectance
from radar_scene import POSE, Ball, Person, Scene, Wall, last, numbers, polar, run, tracker

AWAY = (0.0, 1.0, 0.0)
# Without random numbers, energies are means over the fading, and floors are constant.
QUIET = {"fading": False, "floor_noise": 0.0}
PRESETS = {preset.identifier: preset for preset in KIND.presets}


def part(name, **values):
    return RadarParameters(**{**PRESETS[name].values, **values})


def echoes(ranges, speed=0.0, breathing=0.0, loss=0.0, share=1.0):
    """Return the echoes of rays that all hit something."""
    ranges = np.atleast_1d(np.asarray(ranges, float))
    full = [np.full(len(ranges), value) for value in (breathing, 0.25, loss, share)]
    speeds = np.broadcast_to(np.atleast_2d(speed).T, (np.size(speed), len(ranges)))
    return Echoes(ranges, speeds, *full, np.ones(len(ranges), np.intp))


class Answer:
    """A scene that gives the same echoes at each update, whatever the rays are."""

    def __init__(self, found):
        self.found = found

    def answer(self, *question):
        return self.found

    def at(self, time):
        return self


def received(parameters, found, weight=1.0):
    """Return what a radar receives by rays of equal weight that met what `found` has."""
    count = found.ranges.size
    beams = radar_beams(replace(parameters, rays_across=count, rays_up=1), POSE)
    beams = replace(beams, weight=np.full(count, weight))
    return sweep(parameters, calibration(parameters), beams, found)


def energies(reading):
    """Return the energies (gates, 2) of a reading."""
    return np.array(gate_energies(reading.fields["gates"]))


# Speeds


def test_the_slower_the_less_it_counts_as_moving():
    parameters = RadarParameters()
    assert parameters.wavelength == pytest.approx(0.012427, rel=1e-4)
    corner = parameters.moving_corner
    assert corner == pytest.approx(0.0621, rel=1e-3)
    still = doppler_weight(0.0, corner)
    for speed, part in ((corner, 0.5), (-corner, 0.5), (0.1 * corner, 1 / 101), (3.0, 0.9996)):
        powers = received(parameters, echoes(2.0, speed=speed)).powers[:, 0]
        assert powers[0] == pytest.approx(part**2 * 0.25, rel=1e-3), "of the amplitude"
        assert powers[1] >= powers[0]
    assert still == 0.0


def test_what_swings_within_the_integration_time_moves():
    parameters = RadarParameters(max_targets=1)
    seen = received(parameters, echoes(2.0, speed=[0.6, -0.6, 0.6, -0.6]))
    assert seen.powers[0, 0] == pytest.approx(0.25, rel=0.03)
    assert seen.speed[0] == 0.0, "it stays where it is"


def test_a_chest_that_breathes_hardly_counts_as_moving_but_as_still():
    parameters = RadarParameters()
    speed = breathing_speed(PERSON_BREATHING, PERSON_RATE)
    turn = np.linspace(0.0, math.tau, 1000, endpoint=False)
    chest = math.pi * 0.005 * 0.25 * np.cos(turn)
    assert speed == pytest.approx((chest**4).mean() ** 0.25)
    moving, still = received(parameters, echoes(2.0, breathing=0.005)).powers[:, 0] / 0.25
    assert moving == pytest.approx((speed / parameters.moving_corner) ** 4, rel=0.01)
    assert math.sqrt(still) == pytest.approx(speed**2 / (speed**2 + parameters.still_corner**2))
    assert math.sqrt(moving) < 0.01 and 0.4 < math.sqrt(still) < 0.6


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
    person = Person(polar(4.0, 0.0), velocity=(0.8, 0.0, 0.0))
    assert abs(numbers(last(Scene([person]), tracker(), updates=2)["speed_mps"] or "0")[0]) < 0.06


def test_gates_are_bins_of_a_spectrum_with_a_hann_window():
    parameters = RadarParameters(tail_share=0.0)
    assert parameters.gates == 9, "0 to 8"
    # Sums of a cosine of the frequency x and a Hann window of N points, for large N.
    count = 4096
    window = np.hanning(count + 1)[:-1]
    for x in (0.0, 0.3, 0.5, 1.0, 1.7):
        bins = np.abs(np.exp(2j * np.pi * x * np.arange(count) / count) @ window) / window.sum()
        assert hann(x) == pytest.approx(bins, abs=1e-3)
        assert hann(-x) == hann(x)
    for at, expected in (
        (3.0, {3: 0.5, 4: 1.0, 5: 0.5}),
        (3.375, {3: 0.17, 4: 0.849, 5: 0.849, 6: 0.17}),
    ):
        gates = received(parameters, echoes(at, speed=1.0)).profile.gates[0]
        share = gates / (calibration(parameters).gain[0] / at)
        assert np.flatnonzero(share).tolist() == list(expected)
        assert share[list(expected)] == pytest.approx(list(expected.values()), abs=0.005)


def test_echoes_by_way_of_the_room_are_behind_the_body():
    parameters = RadarParameters(tail_share=0.4, tail_length=1.5)
    gates = received(parameters, echoes(1.5, speed=1.0)).profile.gates[0]
    alone = received(replace(parameters, tail_share=0.0), echoes(1.5, speed=1.0)).profile.gates[0]
    assert gates[0] == alone[0] and gates[2] == pytest.approx(alone[2], rel=0.1)
    assert not alone[4:].any()
    # A point has Σ W² = 1.5 of its power in all gates, so a uniform tail has 1.5 of its density.
    behind = gates[4:8] / alone[2]
    assert behind[1:] / behind[:-1] == pytest.approx(math.exp(-0.5), rel=0.02)
    expected = 0.4 * math.sqrt(1.5) * math.exp(-2.25 / 1.5)
    assert behind[1] == pytest.approx(expected, rel=0.1)


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


def test_the_power_of_a_small_target_falls_with_the_fourth_power_of_its_distance():
    parameters = RadarParameters(
        horizontal_fov=math.radians(20), vertical_fov=math.radians(20), rays_across=300,
        rays_up=300, tail_share=0.0,
    )  # fmt: skip
    beams = radar_beams(parameters, POSE)
    powers = []
    for distance in (2.0, 4.0):
        scene = Scene([Ball((0.0, distance - 0.5, 0.0), 0.1, velocity=(0.0, 5.0, 0.0))])
        rays = beams.origins, beams.directions, beams.length, parameters.frequency, 0.1
        scene.answer(0, *rays)
        seen = scene.at(0.1).answer(0, *rays)
        powers.append(
            float(sweep(parameters, calibration(parameters), beams, seen).powers[0].sum())
        )
    assert 10.0 * math.log10(powers[0] / powers[1]) == pytest.approx(40.0 * math.log10(2), abs=0.5)
    # The power is σ/R⁴ with the silhouette of the ball, except near its rim.
    expected = reflectance("BODY", 24.125) * math.pi * 0.1**2 / 4.0**4
    assert powers[1] == pytest.approx(expected, rel=0.08)


def test_energies_are_in_proportion_to_the_amplitude_or_decibels():
    """Four times the power: twice the amplitude, or 6 dB."""
    for scale, more in (("AMPLITUDE", lambda e: 2.0 * e), ("DECIBELS", lambda e: e + 6.02)):
        parameters = RadarParameters(scale=scale, rays_across=1, rays_up=1, **QUIET)
        far, near = (
            energies(run(Answer(echoes(3.0, speed=1.0, share=share)), parameters)[-1])[4, 0]
            for share in (0.0005, 0.002)
        )
        assert far > 5.0 and near == pytest.approx(more(far), abs=1.0)


def test_energies_end_at_100_and_floors_add_as_powers():
    parameters = RadarParameters(moving_floors="10 5", still_floors="3", **QUIET)
    empty = energies(run(Scene(), parameters)[-1])
    assert empty[:, 0].tolist() == [10.0, *[5.0] * 8]
    assert empty[:, 1].tolist() == [0.0, 0.0, *[3.0] * 7], "thresholds of 0 switch gates off"
    walker = Scene([Person((0.0, 4.0, 0.0), velocity=AWAY)])
    alone = energies(run(walker, replace(parameters, moving_floors="0"))[-1])[:, 0]
    both = energies(run(walker, parameters)[-1])[:, 0]
    assert both[2:] == pytest.approx(np.hypot(alone[2:], 5.0), abs=1.0) and both.max() < 100.0
    near = energies(run(Scene([Person((0.0, 1.0, 0.0), velocity=AWAY)]), parameters)[-1])
    assert near[1].tolist() == near[2].tolist()[:1] + [0.0] == [100.0, 0.0]


def test_the_antenna_has_half_of_its_gain_at_the_edges_of_the_field_of_view_each_way():
    gain = two_way_gain(RadarParameters(), np.radians([0, 60, -60, 75]), 0.0)
    assert gain == pytest.approx([1.0, 0.25, 0.25, 0.115], abs=1e-3), "it falls on outside"


def test_the_rays_fill_the_angles_in_front_of_the_board():
    for across, up in ((60, 30), (1, 1), (7, 2)):
        parameters = RadarParameters(rays_across=across, rays_up=up)
        beams = radar_beams(parameters, POSE)
        assert np.linalg.norm(beams.directions, axis=1) == pytest.approx(1.0)
        ahead = np.degrees(np.arccos(beams.directions[:, 1]))
        assert ahead.max() < 78.01, "nothing behind the board, and the least to its sides"
        assert beams.directions.shape == (across * up, 3)
    only = radar_beams(RadarParameters(rays_across=1, rays_up=1), POSE)
    assert only.directions[0] == pytest.approx(AWAY), "a single ray looks ahead"
    gain = two_way_gain(RadarParameters(), only.azimuth, 0.0)
    assert only.weight / gain == pytest.approx(
        [math.radians(156) * 2.0 * math.sin(math.radians(78))]
    )


def test_rays_are_as_dense_ahead_as_if_they_divided_the_field_of_view():
    fov = math.radians(120)
    angles = np.degrees(ray_angles(np.linspace(-1.0, 1.0, 61), fov))
    assert angles[[0, 30, 60]] == pytest.approx([-78.0, 0.0, 78.0])
    assert np.diff(angles)[30] == pytest.approx(2.0, abs=0.01)
    assert (np.diff(np.diff(angles)[30:]) > 0.0).all()
    assert ray_angles(1.0, math.radians(178)) == pytest.approx(math.radians(78))
    assert ray_angles(1.0, math.radians(20)) == pytest.approx(math.radians(15))


@pytest.mark.parametrize("name", ["LD2410", "LD2450", "MR60BHA1"])
def test_a_standard_person_has_the_energies_of_the_parameters(name):
    parameters = part(
        name, rays_across=300, rays_up=150, range_max=14.0, tail_share=0.0, moving_floors="0",
        still_floors="0", moving_thresholds="1", still_thresholds="1", **QUIET,
    )  # fmt: skip
    for channel, farthest, energy, person in (
        (0, parameters.moving_range, 15.0, {"velocity": AWAY}),
        (1, parameters.still_range, 20.0, {"breathing": 0.005}),
    ):
        # At the middle of a gate, so that it has all of the amplitude.
        bin_length = parameters.bin_length
        at = round(farthest / bin_length) * bin_length
        scene = Scene([Person((0.0, at + 0.2 - 0.1 * (channel == 0), 0.0), **person)])
        found = energies(run(scene, parameters)[-1])[:, channel].max()
        # A cylinder that moves as a whole, and not as a resident who walks on the spot.
        share = WALKING if channel == 0 else ROUND
        expected = energy * math.sqrt(
            person_power(parameters, at) / person_power(parameters, farthest) / share
        )
        assert found == pytest.approx(expected, rel=0.15, abs=0.6)


@pytest.mark.parametrize("name", PRESETS)
def test_no_gate_before_the_range_of_the_data_sheet_is_blind(name):
    """Gates that are off by construction leave it to those beside them."""
    parameters = part(name, **QUIET)
    known = calibration(parameters)
    breath = doppler_weight(breathing_speed(0.005, 0.25), parameters.still_corner)
    for channel, share, farthest in (
        (0, WALKING, parameters.moving_range),
        (1, ROUND * breath, parameters.still_range),
    ):
        end = min(farthest, parameters.range_max) / parameters.range_scale * 0.95
        for at in np.linspace(max(0.1, parameters.range_min), end, 100).tolist():
            places = at / parameters.bin_length - np.arange(parameters.gates)
            root = math.sqrt(person_power(parameters, at) * share)
            found = np.hypot(known.gain[channel] * root * hann(places), known.floors[channel])
            most = (found / known.thresholds[channel]).max()
            # Between two gates, each has 0.85 of the amplitude.
            assert most > 0.85, at


# A module that was measured: docs/presence_radar.md.


class OnTheSpot(Scene):
    """A scene in which all bodies walk on the spot, with as strong echoes as residents have."""

    speed, share = 0.6, WALKING

    def answer(self, *question):
        found = super().answer(*question)
        speed = np.where(found.solid > 0, self.speed, 0.0)[None]
        return replace(found, speed=speed, reflectance=found.reflectance * self.share)


class Standing(OnTheSpot):
    """A scene in which all bodies stand still: their balance moves them by 4 mm/s.

    That is a sway of 5 mm at 0.15 Hz, as in benchmarks/movements.py, along rays that rise and fall.
    """

    speed, share = 0.004, ROUND


def walker(distance, breathing=0.005):
    """Return the scene of a person who walks on the spot, on a mark at `distance`.

    The front of this round body is 0.12 m before the mark, as that of a resident.
    """
    return OnTheSpot([Person((0.0, distance + 0.08, 0.0), breathing=breathing)])


def rayleigh_share(distance):
    """Return the share of updates in which a walker's echo and floor exceed a threshold together.

    All of this body is at one distance, so its gates fade together. The limbs of a resident are at
    several: tests/blender/test_measured.py has the share that was measured.
    """
    known = calibration(part("LD2410"))
    quiet = part("LD2410", **QUIET, moving_floors="0")
    echo = energies(run(walker(distance), quiet, updates=2)[-1])[:, 0]
    over = known.thresholds[0] ** 2 - known.floors[0] ** 2
    return np.exp(-math.pi / 4.0 * over / np.maximum(echo, 1e-9) ** 2).max()


@pytest.mark.parametrize(
    ("distance", "energy", "moving"), [(1.0, 99.0, 1.0), (2.0, 85.1, 0.98), (5.0, 27.6, None)]
)
def test_walks_on_the_spot_have_the_energies_of_a_measured_module(distance, energy, moving):
    readings = run(walker(distance), part("LD2410"), updates=600)
    found = np.array([energies(one)[:, 0].max() for one in readings])
    moves = np.array([one.fields["moving"] for one in readings])
    assert found[moves].mean() == pytest.approx(energy, rel=0.1)
    share = rayleigh_share(distance) if moving is None else moving
    assert moves.mean() == pytest.approx(share, abs=0.06)
    distances = np.array([one.fields["distance_m"] for one in readings])[moves]
    assert distances.mean() == pytest.approx(distance, rel=0.08)
    assert 0.03 < distances.std() < 0.15, "it is interpolated between gates that fade"


def test_energies_fade_as_the_sum_of_many_scatterers_without_memory():
    readings = run(walker(4.0), part("LD2410", moving_floors="0", still_floors="0"), updates=600)
    found = np.array([energies(one)[:, 0] for one in readings])
    gate = found.mean(axis=0).argmax()
    one = found[:, gate]
    # A Rayleigh distribution has √(4/π − 1).
    assert one.std() / one.mean() == pytest.approx(0.523, abs=0.04)
    assert abs(np.corrcoef(one[1:], one[:-1])[0, 1]) < 0.1
    assert np.corrcoef(one, found[:, gate + 1])[0, 1] > 0.5, "the same body is in both"
    mean = energies(run(walker(4.0), part("LD2410", moving_floors="0", **QUIET))[-1])[gate, 0]
    assert one.mean() == pytest.approx(mean, rel=0.06)


def test_who_stands_still_has_little_movement_near_and_is_present_to_5_m():
    near = run(Standing([Person((0.0, 1.0, 0.0), breathing=0.005)]), part("LD2410"), updates=300)
    moving = np.mean([energies(one)[:, 0] for one in near], axis=0)
    assert moving[1] == pytest.approx(30.9, abs=7.2) and moving[2] == pytest.approx(25.3, abs=6.0)
    for distance in (1.0, 2.3, 4.0, 5.0):
        scene = Standing([Person((0.0, distance, 0.0), breathing=0.005)])
        readings = run(scene, part("LD2410"), updates=100)
        assert all(one.active for one in readings), distance
        assert energies(readings[-1])[:, 1].max() == 100.0


def test_an_empty_room_gives_no_false_alarm_in_an_hour():
    """At 10 Hz; the measured module had none in 7 hours."""
    parameters = part("LD2410")
    count = 36_000
    alone = Scene().answer(0, np.zeros((1800, 3)), *rays_of(parameters), 24.125, 0.1)
    found = PresenceRadar().sense(parameters, updates_of(np.arange(count), alone))
    assert not found.active.any() and not found.fields["moving"].any()
    energy = np.array([gate_energies(text) for text in found.fields["gates"][:2000]])
    floors = [17.6, 13.2, 4.35, 2.88, 5.29, 3.06, 3.87, 3.33, 4.41]
    assert energy[..., 0].mean(axis=0) == pytest.approx(floors, abs=0.2)
    assert energy[:, 1, 0].std() == pytest.approx(2.7, rel=0.1)


def rays_of(parameters):
    beams = radar_beams(parameters, POSE)
    return beams.directions, beams.length


def updates_of(numbers, found, rate=10.0):
    """Return updates at which the scene always gives the same echoes."""

    def answer(*question, indices=None):
        return Answers([found], np.zeros(len(numbers), np.intp))

    return Updates(
        numbers, numbers / rate, np.ones(len(numbers), bool), POSE, {ECHOES: answer},
        lambda block: generator(0, "radar", block), lambda: generator(0, "radar", 0),
    )  # fmt: skip


@pytest.mark.parametrize(("degrees", "present"), [(0, True), (45, True), (75, True), (120, False)])
def test_presence_by_angle_is_that_of_a_measured_module(degrees, present):
    """Who sways 1 m away, with a farthest gate of 1.5 m."""
    scene = walker(1.0)
    scene.bodies = [Person(polar(1.0, degrees), breathing=0.005)]
    readings = run(scene, part("LD2410", range_max=1.5), updates=50)
    assert {one.active for one in readings} == {present}


# Walls


def test_a_wall_of_plasterboard_weakens_by_its_loss_twice():
    person = Person((0.0, 5.0, 0.0), velocity=(0.0, 0.3, 0.0))
    parameters = RadarParameters(**QUIET)
    free = energies(run(Scene([person]), parameters)[-1])[6, 0]
    through = energies(run(Scene([person], [Wall(1.5)]), parameters)[-1])[6, 0]
    loss = 2.0 * attenuation("PLASTERBOARD", 0.025, parameters.frequency)
    assert through == pytest.approx(free * 10.0 ** (-loss / 20.0), abs=0.8), "rounded"
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
    assert fields["distance_m"] == pytest.approx(math.hypot(0.5, 2.5) - 0.2, abs=0.15)
    assert numbers(fields["speed_mps"]) == [0.0] and fields["targets"] == 1
    still = last(Scene([Person((0.5, 2.5, 0.0))]), tracker())
    assert not still["presence"], "furniture does not breathe"


def test_a_threshold_of_0_switches_a_gate_off():
    """Still energies of gates 0 and 1 are always 0; gate 2 holds who is nearer."""
    fields = last(Scene([Person((0.0, 0.9, 0.0), breathing=0.005)]), part("LD2410"), updates=20)
    still = np.array(gate_energies(fields["gates"]))[:, 1]
    assert still[:2].tolist() == [0.0, 0.0] and still[2] == 100.0 and fields["presence"]


def test_movement_starts_presence_and_breathing_only_keeps_it():
    person = Person((0.0, 2.3, 0.0), breathing=0.005)
    parameters = part("LD2410", hold_time=1.0)
    scene, model = Scene([]), PresenceRadar()
    run(scene, parameters, updates=1, model=model)
    scene.bodies = [person]
    waiting = run(scene, parameters, updates=100, model=model, first=1)
    assert not any(one.active for one in waiting)
    assert energies(waiting[-1])[:, 1].max() == 100.0 and waiting[-1].value == 6.0
    scene.bodies = [replace(person, velocity=AWAY)]
    scene.bodies[0] = replace(scene.bodies[0], centre=(0.0, 2.3 - 10.1, 0.0))
    run(scene, parameters, updates=2, model=model, first=101)
    scene.bodies = [person]
    kept = run(scene, parameters, updates=200, model=model, first=103)
    assert all(one.active for one in kept) and not kept[-1].fields["moving"]
    both = replace(parameters, movement_starts=False)
    model = PresenceRadar()
    run(Scene([]), both, updates=1, model=model)
    found = run(scene, both, updates=50, model=model, first=1)
    assert found[-1].active


def test_who_sleeps_when_a_run_begins_is_present():
    readings = run(Scene([Person((0.0, 2.3, 0.0), breathing=0.005)]), part("LD2410"), updates=50)
    assert all(one.active for one in readings)
    assert energies(readings[0])[3, 1] == 100.0, "as if it had been there before"


def test_still_energies_are_a_leaky_mean_of_seconds():
    """They outlast who leaves, and the hold time starts after that."""
    parameters = part("LD2410", **QUIET)
    scene, model = walker(2.0), PresenceRadar()
    run(scene, parameters, updates=50, model=model)
    scene.bodies = []
    after = run(scene, parameters, updates=250, model=model, first=50)
    active = [one.active for one in after]
    released = active.index(False) / 10.0
    still = np.array([energies(one)[:, 1] for one in after])
    needed = np.array([np.inf, np.inf, 40.0, 40.0, 30.0, 30.0, 20.0, 20.0, 20.0])
    above = np.flatnonzero((still > needed).any(axis=1))[-1] / 10.0
    assert released - above == pytest.approx(5.0, abs=0.15), "the hold time"
    assert 10.0 < released < 16.0 and not any(active[active.index(False) :])
    falling = still[60:90, 3] - 5.0
    assert falling[10:] / falling[:-10] == pytest.approx(math.exp(-0.5), rel=0.08)


def test_a_leaky_mean_is_that_of_its_difference_equation():
    rng = np.random.default_rng(0)
    times = np.cumsum(rng.uniform(0.05, 0.5, 2000))
    times[1000:] += 1e5
    values = rng.uniform(0.0, 100.0, (2000, 2, 3))
    found = LeakyMean().run(times, values, 2.0)
    mean = values[0]
    for i in range(2000):
        if i:
            new = 1.0 - math.exp(-(times[i] - times[i - 1]) / 2.0)
            mean = mean + new * (values[i] - mean)
        assert found[i] == pytest.approx(mean, rel=1e-9)
    parts = LeakyMean()
    cuts = [0, 1, 2, 70, 900, 1001, 2000]
    again = [parts.run(times[a:b], values[a:b], 2.0) for a, b in pairwise(cuts)]
    assert np.array_equal(np.concatenate(again), found), "to the bit"


@pytest.mark.parametrize("constants", [(1.0, 2.0), (2.0, 1.0), (0.01, 10.0)])
def test_the_leaky_mean_goes_on_when_its_time_constant_changes(constants):
    mean, time, expected = LeakyMean(), 0.0, 10.0
    for constant in constants * 3:
        times = time + 0.1 * np.arange(1, 631)
        found = mean.run(times, np.full((630, 1), 10.0 + constant), constant)[:, 0]
        if time == 0.0:
            expected = 10.0 + constant
        decay = np.exp(-(times - time) / constant)
        if time:
            assert found == pytest.approx(10.0 + constant + (expected - 10.0 - constant) * decay)
        expected, time = float(found[-1]), float(times[-1])


@pytest.mark.parametrize("name, value", [("range_max", 3.0), ("gate_length", 0.3)])
def test_gates_can_be_animated(name, value):
    scene = Scene([Person((0.0, 2.0, 0.0), breathing=0.005)])
    model, changed = PresenceRadar(), replace(part("LD2410"), **{name: value})
    for parameters, first in ((part("LD2410"), 0), (changed, 20), (part("LD2410"), 40)):
        found = run(scene, parameters, updates=20, model=model, first=first)
        assert {len(gate_energies(one.fields["gates"])) for one in found} == {parameters.gates}
        assert all(one.active for one in found)


# Time


def test_presence_holds_and_keeps_the_last_distance():
    scene = Scene([Person((0.0, 2.2, 0.0), velocity=(0.0, 1.0, 0.0))])
    parameters = tracker(hold_time=1.0, still_thresholds="100", **QUIET)
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


@pytest.mark.parametrize("parameters", [tracker(hold_time=0.3), part("LD2410"), part("LD2450")])
def test_many_updates_at_once_give_the_readings_of_one_at_a_time(parameters):
    """Also over the blocks of random numbers; the last echoes are those of a still scene."""
    count, moving = 150, 6
    parameters = replace(parameters, energy_noise=1.0, range_noise=0.02, angle_noise=0.01)

    def scene():
        return Scene([Person((0.0, 2.0, 0.0), velocity=(0.0, 0.4, 0.0), breathing=0.004)])

    def answers(*question, indices=None):
        one = scene()
        table = [one.at(k / 10.0).answer(*question) for k in range(moving)]
        still = one.at((moving - 1) / 10.0).answer(*question)
        rows = np.minimum(np.arange(count), moving)
        return Answers([*table, still], rows if indices is None else rows[indices])

    def updates(first, last):
        numbers = np.arange(first, last)

        def part_of(*question, indices=None):
            found = answers(*question)
            return Answers(found.table, found.rows[first:last])

        return Updates(
            numbers, numbers / 10.0, np.ones(len(numbers), bool), POSE, {ECHOES: part_of},
            lambda block: generator(0, "radar", block), lambda: generator(0, "radar", 0),
        )  # fmt: skip

    together = PresenceRadar().sense(parameters, updates(0, count))
    for cuts in ([0, 1, 2, 3, 7, 64, 65, 128, count], [*range(count), count]):
        model, found = PresenceRadar(), []
        for first, last_one in pairwise(cuts):
            readings = model.sense(parameters, updates(first, last_one))
            found += [readings[i] for i in range(len(readings))]
        assert [one.fields for one in found] == [together[i].fields for i in range(count)]
        assert [one.value for one in found] == together.value.tolist()
    assert together[count - 1].fields["presence"]


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
    parameters = tracker(**QUIET)
    near = echoes(np.full(len(radar_beams(parameters, POSE).length), distance), speed=1.0)
    fields = last(Answer(near), parameters)
    assert is_finite(fields) and fields["moving"] and fields["targets"] == 1
    assert fields["distance_m"] == pytest.approx(distance, abs=0.06)


def test_one_ray_is_enough():
    fields = last(
        Scene([Person((0.0, 2.0, 0.0), velocity=(0.0, 0.4, 0.0))]),
        tracker(rays_across=1, rays_up=1),
    )
    assert fields["targets"] == 1 and numbers(fields["x_m"]) == [0.0] and is_finite(fields)


def test_nearer_than_range_min_or_beyond_the_last_gate_nothing_is_seen():
    parameters = RadarParameters(range_min=0.4)
    ranges = np.array([0.3999, 0.4001, 6.3749, 6.3751])
    seen = echo_powers(parameters, np.ones(4), echoes(ranges)) > 0.0
    assert seen.tolist() == [False, True, True, False], "to the middle of the last gate and a half"


def test_a_module_can_report_longer_distances_than_the_true_ones():
    parameters = RadarParameters(
        range_scale=1.05, tail_share=0.0, rays_across=1, rays_up=1, **QUIET
    )
    for at in (1.5, 3.0, 4.6):
        fields = last(Answer(echoes(at, speed=1.0)), parameters)
        assert fields["distance_m"] == pytest.approx(1.05 * at, rel=0.02)
    assert last(Answer(echoes(6.05, speed=1.0)), parameters)["distance_m"] == 6.0


def test_a_threshold_of_100_or_0_switches_a_gate_off():
    person = Person((0.0, 1.7, 0.0), velocity=(0.0, 0.4, 0.0))
    for thresholds, found in (("100", False), ("100 100 99 100", True), ("0", False)):
        parameters = RadarParameters(
            moving_thresholds=thresholds, still_thresholds="100", hold_time=0.0, **QUIET
        )
        assert last(Scene([person]), parameters)["presence"] == found


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"moving_thresholds": "40 x"}, ["moving_thresholds", "40 x"]),
        ({"still_thresholds": ""}, ["still_thresholds", "0 to 100"]),
        ({"still_thresholds": "40 101"}, ["still_thresholds"]),
        ({"moving_thresholds": "nan"}, ["moving_thresholds"]),
        ({"moving_floors": "-1"}, ["moving_floors"]),
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


def test_targets_fade_as_the_energies_do():
    person = Person((0.0, 6.0, 0.0), velocity=(0.0, 0.1, 0.0))
    for values in ({}, {"fading": False, "energy_noise": 8.0}):
        parameters = tracker(still_thresholds="100", moving_range=5.0, **values)
        found = [reading.fields for reading in run(Scene([person]), parameters, updates=35)]
        assert {one["presence"] for one in found} == {True, False}
        assert all(one["presence"] == bool(one["targets"]) for one in found[1:])


@pytest.mark.parametrize(("speed", "moves"), [(9.9, True), (10.1, False), (-47.9, False)])
def test_what_jumps_does_not_count_as_moving(speed, moves):
    seen = received(RadarParameters(), echoes(2.0, speed=speed))
    assert bool(seen.powers[0].any()) == moves == (abs(speed) <= FASTEST)


def test_thresholds_that_no_energy_exceeds_are_advised_on():
    never = RadarParameters(moving_thresholds="100", still_thresholds="100, 0")
    assert "never goes on" in never.unreachable()[0].problem
    assert RadarParameters(moving_thresholds="100").unreachable() == []
    starts = RadarParameters(moving_thresholds="100", movement_starts=True)
    assert "All moving thresholds are 100" in starts.unreachable()[0].problem


def test_a_floor_above_its_threshold_is_advised_on():
    low = RadarParameters(moving_thresholds="15", moving_floors="17.6 13.2")
    assert "floor of gate 0 is above" in low.unreachable()[0].problem
    assert not any(part(name).unreachable() for name in PRESETS)


def test_noise_scatters_and_repeats():
    person = Person((0.0, 3.0, 0.0), breathing=0.005)
    parameters = tracker(
        range_noise=0.05, angle_noise=math.radians(2), energy_noise=3.0, still_range=4.0, **QUIET
    )
    one, two = (run(Scene([person]), parameters, updates=200) for _ in range(2))
    assert [reading.fields for reading in one] == [reading.fields for reading in two]
    y = np.array([numbers(reading.fields["y_m"])[0] for reading in one])
    assert y.std() == pytest.approx(0.05, rel=0.2)
    energy = np.array([energies(reading)[9, 1] for reading in one])
    assert energy.mean() < 90.0 and energy.std() == pytest.approx(3.0, rel=0.2)
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
    assert covered("LD2410", 4.0, "STEP") > 1.0 and covered("LD2410", 7.5, "STEP") == 0.0
    assert covered("LD2410", 3.0, "STILL") > 1.0
    assert covered("LD2410", 1.4, "ARM", heading=0.0) > 1.0
    assert covered("LD2410", 3.0, "CRAWL") > covered("LD2410", 3.0, "CAT")
    assert covered("LD2410", 3.0, "STEP", degrees=130.0) == 0.0, "behind the board"
    assert covered("LD2410", 3.0, "STILL", walls=[Wall(2.0, "CONCRETE", 0.2, True)]) == 0.0


def test_a_map_counts_a_wall_twice_and_only_in_front_of_the_body():
    values = {"still_floors": "0"}
    free = covered("LD2410", 3.0, "STILL", **values)
    behind = covered("LD2410", 3.0, "STILL", walls=[Wall(1.5)], **values)
    loss = attenuation("PLASTERBOARD", 0.025, 24.125)
    assert behind == pytest.approx(free * 10.0 ** (-0.1 * loss)), "in amplitude"
    assert covered("LD2410", 3.0, "STILL", walls=[Wall(3.5)], **values) == free


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
    parameters = part("LD2410", rays_across=200, rays_up=100, tail_share=0.0)
    still, known = MOTIONS["STILL"], calibration(parameters)
    scene = Scene([Person((0.0, 3.0, 0.925 - 1.0), half=0.325, breathing=0.005)])
    beams = radar_beams(parameters, POSE)
    seen = sweep(
        parameters,
        known,
        beams,
        scene.answer(0, beams.origins, beams.directions, beams.length, 24.125, 0.1),
    )
    ratio = ((seen.profile.gates[1] + known.floors[1]) / known.thresholds[1]).max()
    assert (still.bottom, still.top) == (0.6, 1.25)
    assert covered("LD2410", 3.0, "STILL", tail_share=0.0) == pytest.approx(ratio, rel=0.02)
