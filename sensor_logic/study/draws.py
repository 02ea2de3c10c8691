# SPDX-License-Identifier: GPL-3.0-or-later
"""The runs of a study: which values each of them has."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..error import InputError
from ..model import Array
from .study import MOST_RUNS, Range, Study, Value

Setting = dict[str, Value]


class Run(NamedTuple):
    """A run: its number from 1, what varies, and the seed."""

    number: int
    setting: Setting
    seed: int


def count(study: Study) -> int:
    """How many runs it has. Raises InputError where they are too many."""
    if study.draw in ("random", "sobol"):
        settings = study.runs
    elif study.draw == "list":
        settings = len(next(iter(study.vary.values()), (0,)))  # type: ignore[arg-type]
    else:
        settings = math.prod(len(_steps(values)) for values in study.vary.values())
    total = settings * len(study.seeds)
    if total > MOST_RUNS:
        raise InputError(f"{study.name}: {total} runs are more than {MOST_RUNS}")
    return total


def runs(study: Study) -> Iterator[Run]:
    """All runs in order: each setting with every seed. Raises InputError."""
    number = itertools.count(1)
    for setting in _settings(study):
        for seed in study.seeds:
            yield Run(next(number), setting, seed)


def _settings(study: Study) -> Iterator[Setting]:
    names = list(study.vary)
    if study.draw == "grid":
        rows: Iterator[tuple[Value, ...]] = itertools.product(
            *(_steps(values) for values in study.vary.values())
        )
    elif study.draw == "list":
        # Lists alone: that was looked at as the file was read.
        rows = zip(*(_steps(values) for values in study.vary.values()), strict=True)
    else:
        ways = list(study.vary.values())
        rows = (
            tuple(_drawn(values, share) for values, share in zip(ways, shares, strict=True))
            for shares in _shares(study, len(ways)).tolist()
        )
    for row in rows:
        yield dict(zip(names, row, strict=True))


def _steps(values: Sequence[Value] | Range) -> Sequence[Value]:
    """The values of a grid."""
    if not isinstance(values, Range):
        return values
    found = [values.at(step / (values.steps - 1)) for step in range(values.steps)]
    # A whole number that two steps come to counts once.
    return list(dict.fromkeys(round(value) for value in found)) if values.whole else found


def _drawn(values: Sequence[Value] | Range, share: float) -> Value:
    """The value that a random share, from 0 to below 1, stands for."""
    if not isinstance(values, Range):
        return values[min(int(share * len(values)), len(values) - 1)]
    if not values.whole:
        return values.at(share)
    # Each whole number as likely as the others, the ends too.
    wide = Range(values.first - 0.5, values.last + 0.5, log=values.log)
    return int(min(max(round(wide.at(share)), values.first), values.last))


def _shares(study: Study, dimensions: int) -> Array:
    """(runs, dimensions) from 0 to below 1. Raises InputError."""
    if study.draw == "random":
        return np.random.default_rng(study.draw_seed).random((study.runs, dimensions))
    sobol: Any = _qmc().Sobol(dimensions, scramble=True, rng=study.draw_seed)
    # All the points of a power of two, of which the first are taken.
    return np.asarray(sobol.random_base2(max(study.runs - 1, 0).bit_length()))[: study.runs]


def _qmc() -> Any:
    try:
        from scipy.stats import qmc
    except ImportError as error:
        raise InputError(
            f'draw = "sobol" needs scipy ({error}): pip install "angen-sensors[sweep]"'
        ) from None
    return qmc
