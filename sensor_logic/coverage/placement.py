# SPDX-License-Identifier: GPL-3.0-or-later
"""Chooses detectors that together cover the most: greedily, then by swaps, with a proven bound.

The coverage of k sets is submodular. So the greedy choice reaches at least 1 − 1/e of the optimum
(Nemhauser, Wolsey, Fisher 1978). A tighter bound for the given sets: the optimum covers at most the
coverage of any choice plus the k largest gains beyond it (Minoux 1978; Leskovec et al. 2007).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import Array

# Rounds of swaps. Each round improves the choice, so that they end long before.
MOST_ROUNDS = 100
# Gains closer than this are equal.
TIE = 1e-9

Sets = NDArray[np.bool_]


@dataclass(frozen=True)
class ChosenPlaces:
    """The rows `chosen` in the order of their gains; the weight that they cover (`covered`), that
    which the greedy choice covered (`greedy`), and a `bound` that no choice of as many exceeds."""

    chosen: tuple[int, ...]
    covered: float
    greedy: float
    bound: float
    swaps: int

    @property
    def assured(self) -> float:
        """A lower bound of the share of the optimum that is reached."""
        return self.covered / self.bound if self.bound > 0.0 else 1.0


def choose(sets: Sets, count: int, weights: Array | None = None, seed: int = 0) -> ChosenPlaces:
    """Chooses at most `count` of the sets (m, n), which cover items (n,) of `weights`. The seed
    decides between equally good sets. Raises ValueError."""
    if count < 1:
        raise ValueError(f"a number of {count}: at least 1 must be chosen")
    worth = np.ones(sets.shape[1]) if weights is None else np.asarray(weights, np.float64)
    if (worth < 0.0).any():
        raise ValueError("weights must be 0 or more")
    order = np.random.default_rng(seed).permutation(len(sets))
    shuffled = sets[order]
    bounds = [float(worth[sets.any(axis=0)].sum())]
    bounds.append(_online_bound(shuffled, [], count, worth))
    chosen = _greedy(shuffled, count, worth, bounds)
    greedy = _value(shuffled, chosen, worth)
    chosen, swaps = _swapped(shuffled, chosen, worth)
    bounds.append(_online_bound(shuffled, chosen, count, worth))
    covered = _value(shuffled, chosen, worth)
    ranked = _ranked(shuffled, chosen, worth)
    rows = tuple(int(order[i]) for i in ranked)
    return ChosenPlaces(rows, covered, greedy, max(min(bounds), covered), swaps)


def _value(sets: Sets, chosen: list[int], worth: Array) -> float:
    return float(worth[sets[chosen].any(axis=0)].sum())


def _gains(sets: Sets, taken: NDArray[np.bool_], worth: Array) -> Array:
    gains: Array = sets @ np.where(taken, 0.0, worth)
    return gains


def _best(gains: Array) -> int:
    """The first set of the largest gain."""
    return int(np.flatnonzero(gains >= gains.max() - TIE)[0])


def _greedy(sets: Sets, count: int, worth: Array, bounds: list[float]) -> list[int]:
    """The sets of the largest gain, one after the other; adds the bound of each step to
    `bounds`."""
    taken = np.zeros(sets.shape[1], bool)
    chosen: list[int] = []
    while len(chosen) < min(count, len(sets)):
        gains = _gains(sets, taken, worth)
        best = _best(gains)
        if gains[best] <= TIE:
            break
        chosen.append(best)
        taken |= sets[best]
        bounds.append(_online_bound(sets, chosen, count, worth))
    return chosen


def _online_bound(sets: Sets, chosen: list[int], count: int, worth: Array) -> float:
    taken: Sets = np.asarray(sets[chosen].any(axis=0))
    gains = np.sort(_gains(sets, taken, worth))[::-1]
    return float(worth[taken].sum() + gains[:count].sum())


def _swapped(sets: Sets, chosen: list[int], worth: Array) -> tuple[list[int], int]:
    """The choice after swapping single sets as long as that covers more, and the number of
    swaps."""
    chosen = list(chosen)
    swaps = 0
    for _ in range(MOST_ROUNDS):
        better = False
        for place in range(len(chosen)):
            others = chosen[:place] + chosen[place + 1 :]
            taken: Sets = np.asarray(sets[others].any(axis=0))
            gains = _gains(sets, taken, worth)
            best = _best(gains)
            if gains[best] > gains[chosen[place]] + TIE:
                chosen[place] = best
                swaps += 1
                better = True
        if not better:
            break
    return chosen, swaps


def _ranked(sets: Sets, chosen: list[int], worth: Array) -> list[int]:
    """The chosen sets in the order of their gains."""
    left, ranked = list(chosen), []
    taken = np.zeros(sets.shape[1], bool)
    while left:
        gains = _gains(sets[left], taken, worth)
        best = left.pop(_best(gains))
        taken |= sets[best]
        ranked.append(best)
    return ranked
