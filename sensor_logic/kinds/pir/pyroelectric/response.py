# SPDX-License-Identifier: GPL-3.0-or-later
"""From the power on the elements to the signal at the comparator, as an exact solution.

The element and its two amplifier stages are a chain of first-order filters:

    V/P = [sτE/(1+sτE)] · [1/(1+sτT)] · [s/(s+ωh)] · [1/(1+s/ωl)]²

with the electrical and the thermal time constant τE and τT of the element and the amplifier's
pass band from ωh to ωl. The whole chain is integrated at once, for power that changes linearly
from one update to the next (a first-order hold): one exponential of the augmented matrix, after
Van Loan, "Computing integrals involving the matrix exponential", IEEE Trans. Automatic Control
23 (1978). It is stable and exact for steps of any length; a step by Euler's rule is neither.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ....model import Array

STATES = 5
# s: the signal is sampled at least this often between two updates, so that no peak is missed.
SAMPLE_EVERY = 0.02
# Coefficients of the [13/13] Padé approximant, and the largest 1-norm for which it is exact to
# double precision: Higham, "The scaling and squaring method for the matrix exponential
# revisited", SIAM J. Matrix Anal. Appl. 26 (2005), table 2.3.
PADE = (
    64764752532480000.0,
    32382376266240000.0,
    7771770303897600.0,
    1187353796428800.0,
    129060195264000.0,
    10559470521600.0,
    670442572800.0,
    33522128640.0,
    1323241920.0,
    40840800.0,
    960960.0,
    16380.0,
    182.0,
    1.0,
)
LARGEST_NORM = 5.371920351148152


@dataclass(frozen=True)
class Response:
    """The filter chain: `electrical` and `thermal` time constants in s; the amplifier's pass band
    from `low_cut` to `high_cut` in Hz. All are above 0."""

    electrical: float
    thermal: float
    low_cut: float
    high_cut: float

    def at(self, hertz: float) -> complex:
        """The transfer function V/P at a frequency."""
        s = 2j * math.pi * hertz
        low, high = 2 * math.pi * self.low_cut, 2 * math.pi * self.high_cut
        element = s * self.electrical / (1 + s * self.electrical) / (1 + s * self.thermal)
        return complex(element * s / (s + low) / (1 + s / high) ** 2)

    def matrices(self) -> tuple[Array, Array]:
        """A (5, 5) and B (5,) of dx/dt = A x + B P. The last state is the signal; the first
        follows the power, so that at rest x = (P, 0, 0, 0, 0)."""
        e, t = 1.0 / self.electrical, 1.0 / self.thermal
        low, high = 2 * math.pi * self.low_cut, 2 * math.pi * self.high_cut
        a = np.array(
            [
                [-e, 0.0, 0.0, 0.0, 0.0],
                [-t, -t, 0.0, 0.0, 0.0],
                [0.0, low, -low, 0.0, 0.0],
                [0.0, high, -high, -high, 0.0],
                [0.0, 0.0, 0.0, high, -high],
            ]
        )
        return a, np.array([e, t, 0.0, 0.0, 0.0])


class StepMatrices(NamedTuple):
    """The matrices of one time step: x after = `carry` (5, 5) x before + `level` (5,) P before +
    `change` (5,) (P after − P before)."""

    carry: Array
    level: Array
    change: Array


def expm(matrix: Array) -> Array:
    """The exponential of a square matrix: scaling and squaring with the [13/13] Padé
    approximant (Higham 2005)."""
    norm = float(np.abs(matrix).sum(axis=0).max())
    squarings = max(0, math.ceil(math.log2(norm / LARGEST_NORM))) if norm > 0.0 else 0
    a = matrix / 2.0**squarings
    b, one = PADE, np.eye(len(a))
    a2 = a @ a
    a4 = a2 @ a2
    a6 = a4 @ a2
    odd = a6 @ (b[13] * a6 + b[11] * a4 + b[9] * a2)
    odd = a @ (odd + b[7] * a6 + b[5] * a4 + b[3] * a2 + b[1] * one)
    even = a6 @ (b[12] * a6 + b[10] * a4 + b[8] * a2)
    even = even + b[6] * a6 + b[4] * a4 + b[2] * a2 + b[0] * one
    result: Array = np.asarray(np.linalg.solve(even - odd, even + odd), np.float64)
    for _ in range(squarings):
        result = result @ result
    return result


def step(response: Response, dt: float) -> StepMatrices:
    """The matrices of a step of `dt` s in which the power changes linearly."""
    a, b = response.matrices()
    augmented = np.zeros((STATES + 2, STATES + 2))
    augmented[:STATES, :STATES] = a * dt
    augmented[:STATES, STATES] = b * dt
    augmented[STATES, STATES + 1] = 1.0
    done = expm(augmented)
    return StepMatrices(done[:STATES, :STATES], done[:STATES, STATES], done[:STATES, STATES + 1])


def filtered(response: Response, power: Array, dt: float) -> Array:
    """The signals (k, …) for powers (k, …) at intervals of `dt` s, from the steady state at the
    first."""
    once, flat = step(response, dt), power.reshape(len(power), -1)
    state = np.zeros((STATES, flat.shape[1]))
    state[0] = flat[0]
    signal = np.zeros_like(flat)
    driven = once.level[:, None] * flat[:-1, None] + once.change[:, None] * np.diff(
        flat[:, None], axis=0
    )
    for k, drive in enumerate(driven, 1):
        state = once.carry @ state + drive
        signal[k] = state[-1]
    return signal.reshape(power.shape)


class Chain:
    """One detector's element and amplifier, which start in the steady state of the first power."""

    def __init__(self, response: Response) -> None:
        self.response = response
        # x, the power at that time, and a place for its change.
        self._state: Array | None = None

    def advance(self, power: Array, dt: Array) -> Array:
        """The signals (n,) of the largest size within the last `dt` (n,) s, in which the power
        changed linearly to `power` (n,)."""
        peaks = np.zeros(len(power))
        state = np.zeros(STATES + 2) if self._state is None else self._state
        for k, (now, seconds) in enumerate(zip(power.tolist(), dt.tolist(), strict=True)):
            if self._state is None or seconds <= 0.0:
                state[:] = 0.0
                state[0] = now
                self._state = state
            else:
                state[STATES + 1] = now - state[STATES]
                found = _samples(self.response, seconds) @ state
                state[:STATES] = found[:STATES]
                peaks[k] = max(found[STATES:].tolist(), key=abs)
            state[STATES] = now
        return peaks


# One entry per response and interval; without the cache 0.3 ms more per update.
@lru_cache(maxsize=256)
def _samples(response: Response, dt: float) -> Array:
    """(5 + n, 7): maps x, the power before and its change over `dt` s to x after it, and to the
    signals at n times until then."""
    parts = max(1, math.ceil(dt / SAMPLE_EVERY - 1e-9))
    # Rounded, because the rounding errors of frame times would make every interval different.
    once = step(response, round(dt / parts, 12))
    state, signals = np.eye(STATES, STATES + 2), []
    level, change = np.eye(2, STATES + 2, STATES)
    for part in range(parts):
        before = level + change * (part / parts)
        state = once.carry @ state
        state += np.outer(once.level, before) + np.outer(once.change, change / parts)
        signals.append(state[-1])
    return np.concatenate([state, signals])
