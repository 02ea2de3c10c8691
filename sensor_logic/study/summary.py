# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums up the rows of a study: means over runs, and how sure they are over seeds."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..model import Array
from .study import COLUMNS, SENSORS

# What a row has besides what varied and what was measured.
NOT_MEASURED = ("run", "seed", "digest", "error", "angen_sensors", "blender", "numpy", "python")
CONFIDENCE = 0.95
# Continuous draws are shown in so many parts of equal numbers of runs.
BINS = 8
# More values than this are those of a continuous draw.
FEW = 24


class Mean(NamedTuple):
    """A mean, and half the width of its confidence interval over seeds (NaN: of one seed)."""

    value: float
    half: float


@dataclass
class Results:
    """The rows that measured something, as columns. `varied` (texts), `measured` (numbers, NaN
    where a row has none) and `seeds` are (n,); `errors`: text → how many rows failed with it;
    `partly`: how many of these are among the columns, since not all of their measures failed."""

    varied: dict[str, list[str]]
    measured: dict[str, Array]
    seeds: list[str]
    runs: list[str]
    errors: dict[str, int]
    versions: dict[str, list[str]]
    partly: int = 0

    def __len__(self) -> int:
        return len(self.runs)


def read(path: Path, varied: Sequence[str]) -> Results:
    """Reads results.csv. Raises OSError, ValueError."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = csv.DictReader(file)
        names = rows.fieldnames or []
        missing = [name for name in (*varied, "run", "seed", "error") if name not in names]
        if missing:
            raise ValueError(f"the column {missing[0]!r} is missing")
        measured = [name for name in names if name not in (*varied, *NOT_MEASURED)]
        versions = [name for name in NOT_MEASURED[4:] if name in names]
        found = Results({n: [] for n in varied}, {}, [], [], {}, {n: [] for n in versions})
        numbers: dict[str, list[float]] = {name: [] for name in measured}
        for row in rows:
            if row["error"]:
                found.errors[row["error"]] = found.errors.get(row["error"], 0) + 1
                if not any(row[name] for name in measured if name not in COLUMNS):
                    continue
                found.partly += 1
            for name in varied:
                found.varied[name].append(row[name])
            for name in measured:
                numbers[name].append(_number(row[name]))
            for name in versions:
                if row[name] not in found.versions[name]:
                    found.versions[name].append(row[name])
            found.seeds.append(row["seed"])
            found.runs.append(row["run"])
    found.measured = {name: np.array(values) for name, values in numbers.items()}
    return found


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def numeric(values: Iterable[str]) -> bool:
    """Whether all of them are numbers."""
    return all(math.isfinite(_number(value)) for value in values)


def quantile(count: int) -> float:
    """Student's t for the confidence interval of a mean of `count` values."""
    from scipy.stats import t

    return float(t.ppf(0.5 + CONFIDENCE / 2, count - 1))


def mean_over_seeds(
    values: Array, seeds: Sequence[str], quantile: Callable[[int], float] = quantile
) -> Mean:
    """The mean of `values` (n,); each seed counts once, and their spread is what is not sure."""
    by_seed: dict[str, list[float]] = {}
    for value, seed in zip(values.tolist(), seeds, strict=True):
        if math.isfinite(value):
            by_seed.setdefault(seed, []).append(value)
    if not by_seed:
        return Mean(math.nan, math.nan)
    means = np.array([np.mean(found) for found in by_seed.values()])
    half = math.nan
    if len(means) > 1:
        half = quantile(len(means)) * float(means.std(ddof=1)) / math.sqrt(len(means))
    return Mean(float(means.mean()), half)


class Level(NamedTuple):
    """Rows whose value of a varied key is alike: the label, the place on an axis, their indices."""

    label: str
    at: float
    rows: list[int]


def levels(values: Sequence[str]) -> list[Level]:
    """The values of a varied key in order; those of a continuous draw in bins."""
    if not numeric(values):
        names = list(dict.fromkeys(values))
        return [
            Level(name, float(i), [k for k, v in enumerate(values) if v == name])
            for i, name in enumerate(names)
        ]
    numbers = np.array([float(value) for value in values])
    unique = np.unique(numbers)
    if len(unique) <= FEW:
        return [
            Level(f"{value:.4g}", float(value), np.flatnonzero(numbers == value).tolist())
            for value in unique
        ]
    order = np.argsort(numbers, kind="stable")
    found = []
    for part in np.array_split(order, BINS):
        at = float(numbers[part].mean())
        found.append(Level(f"{at:.3g}", at, part.tolist()))
    return found


class Setting(NamedTuple):
    """All seeds of one setting: the indices of its rows."""

    values: tuple[str, ...]
    rows: list[int]


def settings(results: Results) -> list[Setting]:
    """The settings of a study, in the order of their runs."""
    found: dict[tuple[str, ...], list[int]] = {}
    for index in range(len(results)):
        key = tuple(values[index] for values in results.varied.values())
        found.setdefault(key, []).append(index)
    return [Setting(*item) for item in found.items()]


def main_measures(results: Results, best: str = "") -> list[str]:
    """The measures that a report shows: the best one first; those of single sensors, which have
    its name after a blank, are left to the table."""
    whole = [name for name in results.measured if name == "seconds" or " " not in name]
    whole = [name for name in whole if name != "sensors_on" and name != best]
    return [best] * (best in results.measured) + [n for n in whole if n != "seconds"] + ["seconds"]


def of_sensors(results: Results, measure: str) -> list[str]:
    """The columns of single sensors of a measure."""
    return [name for name in results.measured if name.startswith(f"{measure} ")]


def pictured(results: Results, ranked: Sequence[Setting]) -> Results:
    """The results with what varied as pictures can show it: of many sets of sensors, the first of
    the `ranked` settings with so many sensors on, shown by their number; without other texts of
    which there are many."""
    many = {k for k, v in results.varied.items() if not numeric(v) and len(set(v)) > FEW}
    varied = {key: values for key, values in results.varied.items() if key not in many}
    if SENSORS not in many or "sensors_on" not in results.measured:
        return replace(results, varied=varied)
    sets, counts = results.varied[SENSORS], results.measured["sensors_on"]
    best: dict[float, str] = {}
    for setting in ranked:
        best.setdefault(counts[setting.rows[0]], sets[setting.rows[0]])
    rows = [i for i, chosen in enumerate(sets) if best.get(counts[i]) == chosen]
    varied["sensors on"] = [f"{count:g}" for count in counts]
    return replace(
        results,
        varied={key: [values[i] for i in rows] for key, values in varied.items()},
        measured={name: pick(values, rows) for name, values in results.measured.items()},
        seeds=[results.seeds[i] for i in rows],
        runs=[results.runs[i] for i in rows],
    )


def pick(values: Array, rows: Sequence[int]) -> Array:
    found: Array = values[np.asarray(rows, np.intp)]
    return found
