# SPDX-License-Identifier: GPL-3.0-or-later
"""The choice of detectors against the best of all choices, tried one by one."""

import itertools
import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.coverage.grid import choose
from hypothesis import given
from hypothesis import strategies as st


@st.composite
def instances(draw):
    m, n = draw(st.integers(1, 9)), draw(st.integers(1, 14))
    rng = np.random.default_rng(draw(st.integers(0, 2**31)))
    sets = rng.random((m, n)) < draw(st.floats(0.05, 0.7))
    weights = rng.integers(0, 5, n).astype(float)
    return sets, draw(st.integers(1, 4)), weights


def best_of_all(sets, count, weights):
    choices = itertools.combinations(range(len(sets)), min(count, len(sets)))
    return max(weights[sets[list(chosen)].any(axis=0)].sum() for chosen in choices)


@given(instances(), st.integers(0, 5))
def test_greedy_swaps_and_bounds_against_the_best(instance, seed):
    sets, count, weights = instance
    best = best_of_all(sets, count, weights)
    found = choose(sets, count, weights, seed)
    assert found.covered == weights[sets[list(found.chosen)].any(axis=0)].sum()
    assert found.greedy >= (1 - 1 / math.e) * best - 1e-9
    assert found.covered >= found.greedy, "a swap never makes it worse"
    assert found.covered <= best + 1e-9 <= found.bound + 2e-9
    assert found.assured <= found.covered / best + 1e-9 if best else found.assured == 1.0
    assert len(set(found.chosen)) == len(found.chosen) <= count
    assert found == choose(sets, count, weights, seed), "the same again"


def test_a_swap_finds_what_greed_misses():
    # Greed takes the large middle first and then needs a third to cover all.
    sets = np.array(
        [
            [1, 1, 1, 0, 0, 0],
            [0, 0, 0, 1, 1, 1],
            [0, 1, 1, 1, 1, 0],
        ],
        bool,
    )
    found = choose(sets, 2)
    assert found.greedy == 5 and found.covered == 6 and found.swaps == 1
    assert sorted(found.chosen) == [0, 1] and found.assured == 1.0


def test_the_worst_case_of_greed_is_known_to_the_bound():
    # k sets of a partition against overlapping ones: greed gets about 1 − (1 − 1/k)^k.
    found = choose(np.eye(6, dtype=bool), 3)
    assert found.covered == 3 and found.bound == 3


def test_equal_sets_are_chosen_by_the_seed():
    sets = np.ones((8, 3), bool)
    picked = {choose(sets, 1, seed=seed).chosen for seed in range(40)}
    assert len(picked) > 3 and all(len(c) == 1 for c in picked)


def test_nothing_is_chosen_that_adds_nothing():
    found = choose(np.array([[1, 1], [1, 0], [0, 0]], bool), 3)
    assert found.chosen == (0,) and found.covered == found.bound == 2
    none = choose(np.zeros((2, 3), bool), 1)
    assert none.chosen == () and none.assured == 1.0


def test_what_makes_no_sense_is_told():
    with pytest.raises(ValueError, match="at least 1"):
        choose(np.ones((2, 2), bool), 0)
    with pytest.raises(ValueError, match="weights"):
        choose(np.ones((2, 2), bool), 1, np.array([1.0, -1.0]))
