# SPDX-License-Identifier: GPL-3.0-or-later
"""Reduces a track to the columns of a drawing without losing what is narrower than a column.

A reading holds until the next one, or for one period where the next one is missing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Array
from ..recording.tracks import Track
from .figures import invalid, quantity

# A smaller share of a column's time is a rounding error.
ROUNDING = 1e-6


@dataclass(frozen=True)
class Columns:
    """n equal parts of the time. `known` (n,): the share in which the sensor was simulated;
    `active`, `invalid` (n,): the shares of `known` in which it was active or invalid; `low`,
    `high`, `last` (n,): the least, greatest and last value, NaN without one; `top`: the greatest
    valid value of all; `quantity`: the field of the values."""

    known: Array
    active: Array
    invalid: Array
    low: Array
    high: Array
    last: Array
    quantity: str
    top: float

    @property
    def sometimes(self) -> NDArray[np.bool_]:
        """The columns in which it was active at least for a moment."""
        return self.active > ROUNDING

    @property
    def throughout(self) -> NDArray[np.bool_]:
        """The columns in which it was active throughout."""
        return self.active > 1.0 - ROUNDING


def columns(track: Track, period: float, step: float, span: tuple[float, float], n: int) -> Columns:
    """The track over `span` (s) in `n` columns; `period` (s): the time between updates, which are
    at most one `step` (s) of the run late."""
    times = np.array(track.times, np.float64)
    if not len(times):
        none, unmeasured = np.zeros(n), np.full(n, np.nan)
        return Columns(none, none, none, unmeasured, unmeasured, unmeasured, "", np.nan)
    ends = np.append(times[1:], np.inf)
    held = np.where(ends - times > 1.5 * period + step, times + period, ends)
    held = np.minimum(held, max(span[1], float(times[-1])))
    edges = np.linspace(*span, n + 1)
    width = (span[1] - span[0]) / n

    def share(mask: NDArray[np.bool_]) -> Array:
        """The share (n,) of each column during which the masked readings hold."""
        durations = np.where(mask, held - times, 0.0)
        total = np.concatenate([[0.0], np.cumsum(durations)])
        moments = np.stack([times, held], axis=1).ravel()
        amounts = np.stack([total[:-1], total[1:]], axis=1).ravel()
        return np.diff(np.interp(edges, moments, amounts)) / width

    known = share(np.ones(len(times), bool))
    of = np.maximum(known, ROUNDING)
    bad = invalid(track)
    name, values = quantity(track)
    low = high = last = np.full(n, np.nan)
    top = np.nan
    if name:
        low, high, last = _envelope(times, held, values, edges)
        good = values[~bad & np.isfinite(values)]
        top = float(good.max()) if len(good) else np.nan
    active = np.asarray(track.active, dtype=np.int8) != 0
    return Columns(known, share(active) / of, share(bad) / of, low, high, last, name, top)


def _envelope(times: Array, held: Array, values: Array, edges: Array) -> tuple[Array, Array, Array]:
    """The least, greatest and last value (n,) between `edges` (n + 1,)."""
    n = len(edges) - 1

    def at(moments: Array, side: str) -> Array:
        """The value that holds at each moment, or just before it (side "left")."""
        index = np.searchsorted(times, moments, "right" if side == "right" else "left") - 1
        there = index >= 0
        reaches = held[index] > moments if side == "right" else held[index] >= moments
        return np.where(there & reaches, values[index], np.nan)

    carried, last = at(edges[:-1], "right"), at(edges[1:], "left")
    low, high = np.fmin(carried, last), np.fmax(carried, last)
    where = np.searchsorted(edges, times, "right") - 1
    inside = (where >= 0) & (where < n) & np.isfinite(values)
    np.fmin.at(low, where[inside], values[inside])
    np.fmax.at(high, where[inside], values[inside])
    return low, high, last


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The first, and one past the last, column of each run where the mask is true."""
    change = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in change.reshape(-1, 2)]
