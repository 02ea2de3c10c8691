# SPDX-License-Identifier: GPL-3.0-or-later
"""Random numbers for routines: a stream of its own for each seed, person, date and purpose, so that
another day, person or entry changes nothing else. The same in every version of Python."""

from __future__ import annotations

import hashlib
import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from statistics import NormalDist

_NORMAL = NormalDist()
# Days are counted from here: any date does, and another one changes all that was ever drawn.
ORIGIN = date(2026, 3, 2)


class Stream:
    def __init__(self, seed: int, person: str, day: int, purpose: str) -> None:
        key = repr((seed, person, day, purpose)).encode()
        # Of Random, only random() is promised to be the same in all versions.
        self._uniform = random.Random(int.from_bytes(hashlib.sha256(key).digest()[:16])).random

    def uniform(self) -> float:
        """A number from 0 to below 1."""
        return self._uniform()

    def normal(self) -> float:
        """Standard normal, within ±4."""
        value = _NORMAL.inv_cdf(min(max(self._uniform(), 1e-9), 1 - 1e-9))
        return min(max(value, -4.0), 4.0)

    def log_normal(self, median: float, varies: float) -> float:
        return median * math.exp(varies * self.normal())

    def poisson(self, mean: float) -> int:
        """A Poisson number, by multiplication of uniforms (Knuth); for small means."""
        limit, product, count = math.exp(-mean), self._uniform(), 0
        while product > limit:
            product *= self._uniform()
            count += 1
        return count

    def geometric(self, mean: float) -> int:
        """1, 2 …, with a mean of 1 or more."""
        if mean <= 1.0:
            return 1
        return 1 + int(math.log(1.0 - self._uniform()) / math.log(1.0 - 1.0 / mean))

    def chosen(self, weights: Sequence[float]) -> int:
        """An index, by weight."""
        point = self._uniform() * sum(weights)
        for index, weight in enumerate(weights):
            point -= weight
            if point < 0:
                return index
        return max(index for index, weight in enumerate(weights) if weight > 0)


@dataclass(frozen=True)
class Draws:
    """The streams of a seed, for days that are numbered from the date `first`."""

    seed: int
    first: date

    def stream(self, person: str, day: int, purpose: str) -> Stream:
        return Stream(self.seed, person, day_number(self.first) + day, purpose)


def day_number(of: date) -> int:
    """The same for a date, whichever day a run begins with; below 0 before `ORIGIN`."""
    return (of - ORIGIN).days
