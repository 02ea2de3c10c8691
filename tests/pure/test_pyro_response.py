# SPDX-License-Identifier: GPL-3.0-or-later
"""Element and amplifier of the pyroelectric detector, against SciPy and closed form."""

import math

import numpy as np
import pytest
from angen_sensors.sensor_logic.kinds.pir.pyroelectric import Chain, Response, expm, filtered, step
from scipy import linalg, signal

USUAL = Response(electrical=1.0, thermal=0.15, low_cut=0.3, high_cut=8.0)
OTHER = Response(electrical=4.0, thermal=0.02, low_cut=0.1, high_cut=10.0)


def polynomials(r):
    """Numerator and denominator of V/P, multiplied out from its factors."""
    low, high = 2 * math.pi * r.low_cut, 2 * math.pi * r.high_cut
    above = [r.electrical, 0.0, 0.0]  # sτE · s
    below = np.polymul([r.electrical, 1.0], [r.thermal, 1.0])
    below = np.polymul(below, [1.0, low])
    below = np.polymul(below, np.polymul([1 / high, 1.0], [1 / high, 1.0]))
    return above, below


@pytest.mark.parametrize("scale", [0.0, 1e-6, 0.3, 5.3, 5.4, 40.0, 700.0])
@pytest.mark.parametrize("seed", range(5))
def test_the_exponential_is_scipys(scale, seed):
    a = np.random.default_rng(seed).normal(size=(7, 7))
    a *= scale / np.abs(a).sum(axis=0).max()
    expected = linalg.expm(a)
    # Both lose digits in squaring, in proportion to the norm.
    np.testing.assert_allclose(
        expm(a), expected, atol=1e-13 * max(1.0, scale) * abs(expected).max()
    )


def test_the_exponential_of_a_rotation_and_of_a_nilpotent_matrix():
    turn = np.array([[0.0, -100.0], [100.0, 0.0]])
    c, s = math.cos(100.0), math.sin(100.0)
    np.testing.assert_allclose(expm(turn), [[c, -s], [s, c]], atol=1e-12)
    np.testing.assert_allclose(expm(np.array([[0.0, 3.0], [0.0, 0.0]])), [[1, 3], [0, 1]])


@pytest.mark.parametrize("response", [USUAL, OTHER])
@pytest.mark.parametrize("rate", [1, 10, 24, 25, 30, 60, 120, 240])
def test_piecewise_linear_power_gives_what_lsim_gives(response, rate):
    dt, n = 1.0 / rate, 200
    power = np.random.default_rng(1).normal(size=n).cumsum()
    power[0] = 0.0
    system = signal.lti(*polynomials(response))
    times = np.arange(n) * dt
    _, expected, _ = signal.lsim(system, power, times, interp=True)
    found = filtered(response, power, dt)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("rate", [1, 7, 10, 24, 60, 240])
def test_the_chain_ends_each_step_where_lsim_does_and_misses_no_peak(rate):
    """`advance` tells the largest signal within the step: that of a much finer lsim."""
    dt, n, fine = 1.0 / rate, 40, 600
    power = np.random.default_rng(2).normal(size=n)
    power[0] = 0.0
    chain = Chain(USUAL)
    peaks = chain.advance(power, np.full(n, dt))
    times = np.arange((n - 1) * fine + 1) * (dt / fine)
    between = np.interp(times, np.arange(n) * dt, power)
    _, exact, _ = signal.lsim(signal.lti(*polynomials(USUAL)), between, times)
    assert peaks[0] == 0.0
    largest = np.abs(exact).max()
    for k in range(1, n):
        part = exact[(k - 1) * fine + 1 : k * fine + 1]
        assert abs(peaks[k]) <= np.abs(part).max() + 1e-9 * largest
        assert abs(peaks[k]) >= abs(part[-1]) - 1e-9 * largest
    # Looked at every 20 ms: between two looks a peak can hide a little.
    assert max(map(abs, peaks)) == pytest.approx(largest, rel=0.02)


@pytest.mark.parametrize("response", [USUAL, OTHER])
@pytest.mark.parametrize("hertz", [0.05, 0.3, 1.0, 3.0, 8.0])
def test_a_sine_comes_out_as_the_transfer_function_says(response, hertz):
    dt = 1 / (hertz * 60)
    settled = 12 * (response.electrical + 1 / (2 * math.pi * response.low_cut))
    turn = 2 * math.pi * hertz * dt * np.arange(int((5 + settled * hertz) * 60))
    out = filtered(response, np.sin(turn), dt)[-240:]
    waves = np.stack([np.sin(turn[-240:]), np.cos(turn[-240:])], axis=1)
    amplitude = np.linalg.norm(np.linalg.lstsq(waves, out, rcond=None)[0])
    above, below = polynomials(response)
    s = 2j * math.pi * hertz
    expected = abs(np.polyval(above, s) / np.polyval(below, s))
    assert abs(response.at(hertz)) == pytest.approx(expected, rel=1e-12)
    assert amplitude == pytest.approx(expected, rel=2e-3)


def test_rest_is_rest():
    chain = Chain(USUAL)
    peaks = chain.advance(np.full(100, 447.3), np.full(100, 0.1))
    assert peaks == pytest.approx(np.zeros(100), abs=1e-9)
    assert np.abs(filtered(USUAL, np.full(100, -3.0), 0.04)).max() < 1e-12


def test_a_step_of_any_length_is_stable():
    chain = Chain(USUAL)
    chain.advance(np.zeros(1), np.zeros(1))
    peaks = chain.advance(np.arange(100) % 2.0, np.full(100, 10.0))
    assert np.abs(peaks).max() < 1.0
    assert np.abs(np.linalg.eigvals(step(USUAL, 10.0).carry)).max() < 1.0


def test_eulers_rule_would_explode_at_24_frames_a_second():
    """Why the chain is not integrated so: it looks right at 60 and explodes at 24."""

    def euler(rate):
        a, b = USUAL.matrices()
        x, peak = np.zeros(5), 0.0
        for k in range(rate * 10):
            x = x + (a @ x + b * (k > 2)) / rate
            peak = max(peak, abs(x[-1]))
        return peak

    def exact(rate):
        power = (np.arange(rate * 10) > 2).astype(float)
        return np.abs(filtered(USUAL, power, 1 / rate)).max()

    assert euler(60) == pytest.approx(exact(60), rel=0.15)
    assert euler(24) > 1e6
    assert exact(24) == pytest.approx(exact(240), rel=0.05)
