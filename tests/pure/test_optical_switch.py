# SPDX-License-Identifier: GPL-3.0-or-later
"""The slotted switch: single ray, rays across the aperture, hysteresis, and swept beams."""

import itertools
import math
import random
from dataclasses import replace

import numpy as np
import pytest
from angen_sensors.sensor_logic.geometry.sweep import RayCrossings
from angen_sensors.sensor_logic.kind import CROSSINGS
from angen_sensors.sensor_logic.kinds.optical_switch import (
    OpticalSwitchParameters,
    SlottedSwitch,
    aperture_offsets,
)


def opened(readings):
    return [int(reading.fields["open"]) for reading in readings]


def flag(edge):
    """Return a flag in the gap, 3 mm away, that covers the aperture below x = edge (m)."""

    def cast(bundle, origins, directions, length):
        return np.where(origins[:, 0] < edge, 0.003 - 0.001, length)

    return cast


def test_a_single_ray_is_open_at_the_threshold_and_has_no_memory(stage):
    below = math.nextafter(0.05, 0.0)
    parameters = OpticalSwitchParameters(range_min=0.0, threshold=0.05)

    def exactly(distance):
        return lambda bundle, origins, directions, length: np.array([distance])

    worlds = [exactly(d) for d in (0.05, below, 0.05, below, below, 0.5, 0.01)]
    readings = stage.run(SlottedSwitch(), parameters, worlds)
    assert opened(readings) == [1, 0, 1, 0, 0, 1, 0]


def test_range_is_published_within_range_min_and_max_along_minus_z(stage):
    asked = []

    def cast(bundle, origins, directions, length):
        asked.append((*origins.tolist(), *directions.tolist(), *length.tolist()))
        return length

    parameters = OpticalSwitchParameters(range_min=0.001, range_max=0.5)
    readings = stage.run(SlottedSwitch(), parameters, [0.2, 9.0, 0.0, cast])
    found = [0.2, 0.5, 0.001, 0.5]
    assert [r.fields["range_m"] for r in readings] == pytest.approx(found, abs=1e-12)
    assert [r.value for r in readings] == [r.fields["range_m"] for r in readings]
    assert asked == [([0, 0, -0.001], [0, 0, -1], pytest.approx(0.499))]


@pytest.mark.parametrize("rays", [1, 2, 3, 9, 17, 33])
def test_light_is_within_half_a_ray_of_the_open_share(rays):
    aperture = 0.001
    offsets = aperture_offsets(OpticalSwitchParameters(aperture_rays=rays, aperture=aperture))
    assert len(offsets) == rays
    assert np.abs(offsets).max() <= aperture / 2
    for edge in np.linspace(-0.6, 0.6, 1201) * aperture:
        analytic = min(1.0, max(0.0, 0.5 - edge / aperture))
        share = float(np.mean(offsets >= edge))
        assert abs(share - analytic) <= 1 / (2 * rays) + 1e-9


def covered(rays, blocked):
    """Return a caster in which `blocked` of the rays are stopped."""

    def cast(bundle, origins, directions, length):
        ranges = length.copy()
        ranges[:blocked] = 0.002
        return ranges

    return cast


@pytest.mark.parametrize(
    ("rays", "hysteresis", "opens_at", "closes_at"),
    # ceil(0.60 k) rays must pass to open; it closes where fewer than 0.45 k do.
    [(5, 0.15, 3, 2), (20, 0.15, 12, 8), (100, 0.15, 60, 44), (9, 0.15, 6, 4)]
    # Without hysteresis both levels are in the middle.
    + [(200, 0.0, 105, 104)],
)
def test_opens_at_0_60_and_closes_below_0_45(stage, rays, hysteresis, opens_at, closes_at):
    hysteresis = float(f"{np.float32(hysteresis):.9g}")  # as Blender stores it
    parameters = OpticalSwitchParameters(aperture_rays=rays, aperture=0.001, hysteresis=hysteresis)
    for passing, states in (
        ([0, opens_at - 1, opens_at], [0, 0, 1]),
        ([rays, closes_at + 1, closes_at], [1, 1, 0]),
    ):
        worlds = [covered(rays, rays - n) for n in passing]
        assert opened(stage.run(SlottedSwitch(), parameters, worlds)) == states


def test_a_vibrating_edge_toggles_one_ray_and_not_nine(stage, figure):
    """A flag's edge in the middle of a 1 mm slit vibrates by ± 0.04 mm."""
    shake = random.Random(1)
    worlds = [flag(shake.uniform(-4e-5, 4e-5)) for _ in range(400)]
    changes = []
    for rays in (1, 9):
        parameters = OpticalSwitchParameters(aperture_rays=rays, aperture=0.001)
        states = opened(stage.run(SlottedSwitch(), parameters, worlds))
        changes.append(sum(a != b for a, b in itertools.pairwise(states)))
    figure(f"{changes[0]} and {changes[1]} changes in 400 looks")
    assert changes[0] > 100
    assert changes[1] <= 1, "once, from its start"


# Swept: objects that cross the beam between two updates

ONE = OpticalSwitchParameters(swept=True)
FIVE = replace(ONE, aperture_rays=5, aperture=0.001)
FREE, BROKEN = 0.499, 0.019


def passed(*rows, thing=3):
    """Return passes of (rays, begin, end, distance from range_min)."""
    flat = [(ray, b, e, d, d) for rays, b, e, d in rows for ray in rays]
    table = np.array(flat, float).reshape(-1, 5)
    things = np.full(len(table), thing, np.int64)
    return RayCrossings(table[:, 0].astype(np.intp), *table[:, 1:].T, things)


def none():
    return passed()


def swept(update, through):
    """Return the update with an answer on the passes."""
    scene = {**update.scene, CROSSINGS: through}
    return replace(update, scene=scene, name_of=lambda number: f"thing {number}" if number else "")


@pytest.fixture
def lived(stage):
    """Run updates of (range ahead, passes); a triple has a step in between with its own range."""

    def run(parameters, *steps, model=None, evidence=None):
        model = model or SlottedSwitch()
        made = []
        for number, step in enumerate(steps):
            for look in step if isinstance(step, list) else [step]:
                ahead, through = look
                ranges = np.broadcast_to(ahead, parameters.aperture_rays).astype(float)
                seen = stage.update(number, lambda *_, r=ranges: r)
                update = swept(seen, lambda *_, p=through: p)
                if isinstance(step, list) and look is not step[-1]:
                    model.watch(parameters, update)
                else:
                    made.append(model.update(parameters, update))
        if evidence is not None:
            evidence.extend(r.evidence for r in made)
        return [(int(r.fields["open"]), round(r.value, 9)) for r in made]

    return run


OPEN, SHUT = (1, 0.5), (0, 0.02)
THROUGH = passed(([0], 0.4, 0.6, 0.024))
AGAIN = passed(([0], 0.0, 0.2, 0.019), ([0], 0.5, 0.6, 0.029))
# A person, who changes shape and is not swept, at one frame between two updates.
LOOKS = [(FREE, none()), (BROKEN, none()), (FREE, none()), (FREE, none())]
# From ray to ray, through all of them, one at a time.
THIN = passed(*(([ray], ray / 5, (ray + 1) / 5, 0.02) for ray in range(5)))
HALF = np.array([BROKEN, BROKEN, FREE, FREE, FREE])
TO_AND_FRO = passed(([0, 1], 0.1, 1.0, 0.019), ([2], 0.2, 0.3, 0.019))
LIVED = {
    "told at the second update": (
        ONE,
        [(FREE, none()), (FREE, THROUGH), (FREE, none())],
        [OPEN, (0, 0.025), OPEN],
    ),
    # No new edge came: an event is not repeated.
    "a flag that leaves opens without delay": (
        ONE,
        [(BROKEN, none()), (FREE, passed(([0], 0.0, 0.3, 0.019)))],
        [SHUT, OPEN],
    ),
    "comes back and leaves again": (ONE, [(BROKEN, none()), (FREE, AGAIN)], [SHUT, SHUT]),
    "one that stays reads as unswept": (ONE, [(BROKEN, passed(([0], 0.7, 1.0, 0.009)))], [SHUT]),
    "beyond the threshold": (ONE, [(FREE, passed(([0], 0.4, 0.6, 0.1)))], [OPEN]),
    "between two updates": (ONE, [LOOKS, (FREE, none())], [SHUT, OPEN]),
    "all of five rays": (FIVE, [(FREE, passed((range(5), 0.4, 0.6, 0.019)))], [SHUT]),
    "0.4 of the light": (FIVE, [(FREE, passed((range(3), 0.4, 0.6, 0.019)))], [SHUT]),
    "0.6 of the light": (FIVE, [(FREE, passed((range(2), 0.4, 0.6, 0.019)))], [OPEN]),
    "thinner than the slit": (FIVE, [(FREE, THIN)], [OPEN]),
    # It closes at 0.4 of the light; 0.4 and none of it are one break; 0.6 opens it again.
    "hysteresis": (FIVE, [(HALF, TO_AND_FRO), (HALF, none())], [SHUT, (1, None)]),
}


@pytest.mark.parametrize(("parameters", "steps", "told"), LIVED.values(), ids=LIVED)
def test_what_goes_through_between_two_updates(lived, parameters, steps, told):
    found = lived(parameters, (FREE, None), *steps)
    assert found[0] == OPEN
    for (state, value), (expected, read) in zip(found[1:], told, strict=True):
        assert state == expected and (read is None or value == read)


def test_what_was_caught_is_known(lived):
    model, told = SlottedSwitch(), []
    steps = [(FREE, none()), (FREE, passed(([0], 0.25, 0.5, 0.024), thing=9)), (FREE, none())]
    _, caught = lived(ONE, (FREE, None), steps, model=model, evidence=told)
    assert caught == (0, pytest.approx(0.025))
    assert told[-1] == {"object": "thing 9", "light": 1.0, "steps_ago": pytest.approx(1.75)}
    lived(ONE, (BROKEN, none()), model=model, evidence=told)
    assert told[-1]["light"] == 0.0 and math.isnan(told[-1]["steps_ago"])


@pytest.mark.parametrize("gap", [None, "off"])
def test_after_a_jump_nothing_before_it_is_told(lived, stage, gap):
    model = SlottedSwitch()
    jump = (FREE, None) if gap is None else (FREE, none())
    steps = [(FREE, passed(([0], 0.4, 0.6, 0.024))), jump, (FREE, none())]
    lived(ONE, (FREE, None), model=model)
    if gap is None:
        assert lived(ONE, steps, model=model) == [(1, 0.5)]
        return
    # Switched off in between.
    free = stage.update(1, lambda *_: np.array([FREE]))
    broken = swept(free, lambda *_: passed(([0], 0.4, 0.6, 0.024)))
    model.watch(ONE, broken)
    model.watch(replace(ONE, swept=False), free)
    assert model.update(ONE, swept(free, lambda *_: none())).active


def test_another_number_of_rays_is_another_beam(lived, stage):
    model = SlottedSwitch()
    lived(FIVE, (FREE, None), model=model)
    free = stage.update(1, lambda *_: np.full(5, FREE))
    model.watch(FIVE, swept(free, lambda *_: passed((range(5), 0.4, 0.6, 0.024))))
    assert lived(replace(FIVE, aperture_rays=2), (FREE, none()), model=model) == [(1, 0.5)]


def test_noise_is_the_same_as_unswept_and_on_what_passes_too(stage):
    """One draw per update: without a pass the reading is the same to the bit."""
    noisy = replace(ONE, noise_sigma=0.01)
    updates = [stage.update(k, lambda *_: np.array([0.2])) for k in range(50)]
    model, plain = SlottedSwitch(), SlottedSwitch()
    for update in updates:
        reading = model.update(noisy, swept(update, lambda *_: none()))
        assert reading == plain.update(replace(noisy, swept=False), update)
    found = []
    for update in updates:
        through = passed(([0], 0.4, 0.6, 0.024))
        reading = model.update(noisy, swept(update, lambda *_, p=through: p))
        found.append(reading.value)
    assert np.std(found) == pytest.approx(0.01, rel=0.3)
    assert np.mean(found) == pytest.approx(0.025, abs=0.006)
