# SPDX-License-Identifier: GPL-3.0-or-later
"""Warmth left in a seat: the slab against closed forms, and prints of bodies that come and go."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic import warmth_left
from angen_sensors.sensor_logic.warmth_left import (
    CELL,
    EFFUSIVITY,
    OF_CONTACT,
    OF_ROOM,
    Imprint,
    Print,
    WarmthLeft,
    ages,
    layers_after,
    no_layers,
    start_of,
    surface_of,
)

FREE = np.array([np.nan])
SKIN = np.array([10.0])
PLACE = 1, 2


def still_share(transfer, seconds):
    """Return the excess that a half-space has left in a cold medium (Carslaw & Jaeger 2.7)."""
    x = transfer * math.sqrt(seconds) / EFFUSIVITY
    return math.exp(x * x) * math.erfc(x)


@pytest.mark.parametrize("seconds", [1.0, 10.0, 100.0, 1000.0])
def test_contact_warms_a_half_space_as_in_closed_form(seconds):
    state = layers_after(no_layers(1), seconds, SKIN)
    share = 1.0 - still_share(OF_CONTACT, seconds)
    assert surface_of(state, SKIN)[0] / 10.0 == pytest.approx(share, abs=0.006)


@pytest.mark.parametrize("seconds", [1.0, 10.0, 100.0, 1000.0])
def test_a_seat_warmed_through_cools_as_in_closed_form(seconds):
    state = layers_after(no_layers(1) + 10.0, seconds, FREE)
    assert surface_of(state, FREE)[0] / 10.0 == pytest.approx(
        still_share(OF_ROOM, seconds), abs=0.004
    )


@pytest.mark.parametrize("after", [2.0, 10.0, 40.0])
def test_without_loss_a_constant_flux_leaves_the_difference_of_roots(after, monkeypatch):
    """Of a poor contact, a constant flux, √(t + t_c) − √t over √t_c is left (C. & J. 2.9)."""
    monkeypatch.setattr(warmth_left, "OF_CONTACT", 0.01)
    monkeypatch.setattr(warmth_left, "OF_ROOM", 1e-9)
    stay = 10.0
    state = layers_after(no_layers(1), stay, SKIN)
    there = surface_of(state, SKIN)
    left = surface_of(layers_after(state, after, FREE), FREE)
    share = (math.sqrt(after + stay) - math.sqrt(after)) / math.sqrt(stay)
    assert left[0] / there[0] == pytest.approx(share, abs=0.01)


def test_two_steps_are_one():
    state = layers_after(no_layers(1), 5.0, SKIN)
    assert layers_after(state, 7.0, SKIN) == pytest.approx(layers_after(no_layers(1), 12.0, SKIN))


def seat(source=10.0, height=0.0):
    """Return a contact that covers 6 × 4 cells."""
    x, y = np.meshgrid(np.arange(6) + 0.5, np.arange(4) + 0.5)
    points = np.stack([x.ravel() * CELL, y.ravel() * CELL, np.full(24, height)], axis=1)
    return Imprint(points, np.full(24, source))


def seen(left, x, y, time, height=0.0):
    """Return the excess in K that a ray to (x, y) in cells sees."""
    one = left.prints.get(PLACE)
    if one is None:
        return 0.0
    spots = one.spots(np.array([0]), np.array([[x * CELL, y * CELL, height]]))
    return float((one.excess(time)[spots.cell] * spots.weight).sum())


def test_the_print_is_where_the_body_was_with_a_smooth_edge():
    left = WarmthLeft()
    left.touch(0.0, {PLACE: seat()})
    left.touch(60.0, {})
    middle = seen(left, 3.0, 2.0, 60.0)
    assert middle > 5.0
    assert seen(left, 0.0, 2.0, 60.0) == pytest.approx(middle / 2.0, rel=0.01)
    assert seen(left, -1.0, 2.0, 60.0) == 0.0
    assert seen(left, 3.0, 2.0, 60.0, height=0.2) == 0.0, "not on what is above or below"


@pytest.mark.parametrize("angle", [0.0, 0.3, math.pi / 4])
def test_a_print_has_no_holes_at_any_angle(angle):
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    contact = seat()
    points = contact.points.copy()
    points[:, :2] = points[:, :2] @ turn.T
    left = WarmthLeft()
    left.touch(0.0, {PLACE: Imprint(points, contact.source)})
    left.touch(60.0, {})
    inner = [turn @ (x, y) for x in np.linspace(1.0, 5.0, 9) for y in np.linspace(1.0, 3.0, 5)]
    values = [seen(left, x, y, 60.0) for x, y in inner]
    assert min(values) > 0.9 * max(values)


def test_who_sits_down_again_finds_the_seat_warm():
    once, twice = WarmthLeft(), WarmthLeft()
    for left, stays in ((once, [(90.0, 120.0)]), (twice, [(0.0, 60.0), (90.0, 120.0)])):
        for begin, end in stays:
            left.touch(begin, {PLACE: seat()})
            left.touch(end, {})
    assert seen(twice, 3, 2, 180.0) > 1.2 * seen(once, 3, 2, 180.0) > 0.0


def test_a_colder_body_and_a_forgotten_print():
    left = WarmthLeft()
    left.touch(0.0, {PLACE: seat(source=0.0)})
    left.touch(60.0, {})
    assert not left.prints
    left.touch(60.0, {PLACE: seat()})
    left.touch(70.0, {})
    assert left.prints
    left.touch(7200.0, {})
    assert not left.prints, "colder than a device can tell"


def test_a_warm_body_that_moves_all_day_leaves_no_more_cells_than_are_warm():
    left, robot = WarmthLeft(), np.array([[x, y, 0.0] for x in (0, 0.05) for y in (0, 0.05)])
    cells = []
    for second in range(0, 40_000, 10):
        points = robot + [0.05 * (second / 10 % 200), 0.05 * (second // 2000), 0.0]
        left.touch(float(second), {PLACE: Imprint(points, np.full(4, 5.0))})
        cells.append(len(left.prints[PLACE].excess(second)))
    assert cells[500] > 4 and max(cells[500:]) < 2 * cells[500], "not one more at each step"
    assert (left.prints[PLACE].excess(second) > 0.02).all()


def test_intervals_change_the_excess_by_little_and_are_few():
    one = Print(0.0)
    one.touch(0.0, seat())
    one.touch(3600.0, None)
    times = 3600.0 + np.arange(0.0, 8 * 3600.0, 0.125)
    numbers = ages(times, one.since)
    assert numbers[-1] < 400
    for time, number in list(zip(times, numbers, strict=True))[:: len(times) // 50]:
        taken = one.excess(start_of(int(number), one.since))
        assert taken == pytest.approx(one.excess(time), abs=0.02 * 10.0)


def test_looks_do_not_depend_on_how_updates_are_grouped():
    times = np.arange(100) / 7.0
    together = WarmthLeft().looks(times)
    left = WarmthLeft()
    apart = np.concatenate([left.looks(part) for part in np.split(times, [1, 20, 33, 70])])
    assert np.array_equal(together, apart)
    assert together[0] and np.count_nonzero(together) == 15
