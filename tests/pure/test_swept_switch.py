# SPDX-License-Identifier: GPL-3.0-or-later
"""What a swept switch makes of what went through its beam between two updates."""

from dataclasses import replace

import numpy as np
import pytest
from angen_sensors.sensor_logic.geometry.sweep import RayCrossings
from angen_sensors.sensor_logic.kind import CROSSINGS
from angen_sensors.sensor_logic.kinds.optical_switch import OpticalSwitchParameters, SlottedSwitch

ONE = OpticalSwitchParameters(swept=True)
FIVE = replace(ONE, aperture_rays=5, aperture=0.001)
FREE, BROKEN = 0.499, 0.019


def passed(*rows, thing=3):
    """Passes of (rays, begin, end, distance from range_min)."""
    flat = [(ray, b, e, d, d) for rays, b, e, d in rows for ray in rays]
    table = np.array(flat, float).reshape(-1, 5)
    things = np.full(len(table), thing, np.int64)
    return RayCrossings(table[:, 0].astype(np.intp), *table[:, 1:].T, things)


def none():
    return passed()


def swept(update, through):
    """The update with an answer of what passed."""
    return replace(update, scene={**update.scene, CROSSINGS: through})


@pytest.fixture
def lived(stage):
    """Runs (what is ahead, what passed) of updates; of a triple, what was seen at a step between
    it and the update before."""

    def run(parameters, *steps, model=None):
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
        return [(int(r.fields["open"]), round(r.value, 9)) for r in made]

    return run


def test_a_break_between_two_updates_is_told_at_the_second(lived):
    assert lived(
        ONE, (FREE, None), (FREE, none()), (FREE, passed(([0], 0.4, 0.6, 0.024))), (FREE, none())
    ) == [(1, 0.5), (1, 0.5), (0, 0.025), (1, 0.5)]


def test_unswept_it_is_not_asked_for(stage):
    """`sweep` of the stage's updates raises."""
    readings = stage.run(SlottedSwitch(), OpticalSwitchParameters(), [0.5, 0.02, 0.5])
    assert [r.fields["open"] for r in readings] == [True, False, True]


def test_a_flag_that_leaves_opens_without_delay(lived):
    """No new edge came: what was told before is not told again."""
    assert lived(
        ONE, (BROKEN, None), (FREE, passed(([0], 0.0, 0.3, 0.019)))
    ) == [(0, 0.02), (1, 0.5)]  # fmt: skip


def test_one_that_comes_back_and_leaves_again_is_told(lived):
    through = passed(([0], 0.0, 0.2, 0.019), ([0], 0.5, 0.6, 0.029))
    assert lived(ONE, (BROKEN, None), (FREE, through)) == [(0, 0.02), (0, 0.02)]


def test_one_that_stays_reads_what_it_reads_unswept(lived):
    through = passed(([0], 0.7, 1.0, 0.009))
    assert lived(ONE, (FREE, None), (BROKEN, through)) == [(1, 0.5), (0, 0.02)]


def test_what_is_beyond_the_threshold_breaks_nothing(lived):
    assert lived(ONE, (FREE, None), (FREE, passed(([0], 0.4, 0.6, 0.1)))) == [(1, 0.5)] * 2


@pytest.mark.parametrize(
    "rays, state", [(range(5), 0), (range(3), 0), (range(2), 1)], ids=["all", "0.4", "0.6"]
)
def test_an_aperture_closes_where_less_than_0_45_passes(lived, rays, state):
    found = lived(FIVE, (FREE, None), (FREE, passed((list(rays), 0.4, 0.6, 0.02))))
    assert found[1][0] == state


def test_a_flag_thinner_than_the_slit_never_covers_it(lived):
    """It goes from ray to ray, through all of them, one at a time."""
    through = passed(*(([ray], ray / 5, (ray + 1) / 5, 0.02) for ray in range(5)))
    assert lived(FIVE, (FREE, None), (FREE, through)) == [(1, 0.5)] * 2


def test_hysteresis_holds_between_updates_too(lived):
    """It closes at 0.4 of the light, and 0.4 and none of it are one break; at the end 0.6 opens."""
    half = np.array([BROKEN, BROKEN, FREE, FREE, FREE])
    through = passed(([0, 1], 0.1, 1.0, 0.019), ([2], 0.2, 0.3, 0.019))
    # Closed at 0.2; 0.6 of the light opens it again at 0.3: an edge, told once.
    assert [s for s, _ in lived(FIVE, (FREE, None), (half, through), (half, none()))] == [1, 0, 1]


def test_what_was_seen_at_the_frames_between_is_told(lived):
    """A person, who changes shape and is not swept, at one frame between two updates."""
    model = SlottedSwitch()
    steps = [(FREE, none()), (BROKEN, none()), (FREE, none()), (FREE, none())]
    assert lived(ONE, (FREE, None), steps, (FREE, none()), model=model) == [
        (1, 0.5), (0, 0.02), (1, 0.5),
    ]  # fmt: skip


def test_what_was_caught_is_known(lived):
    model = SlottedSwitch()
    steps = [(FREE, none()), (FREE, passed(([0], 0.25, 0.5, 0.024), thing=9)), (FREE, none())]
    lived(ONE, (FREE, None), steps, model=model)
    assert model.latched_break.solid == 9
    assert model.latched_break.range == pytest.approx(0.025)
    assert model.latched_break.steps == pytest.approx(1.75)
    lived(ONE, (BROKEN, none()), model=model)
    assert model.latched_break is None


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
    """One draw an update: what nothing passes reads the same to the bit."""
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
