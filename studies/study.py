# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a study from a TOML file, and make the list of its runs.

Errors in the file are reported with their line.
"""

from __future__ import annotations

import ast
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..sensor_logic.choice import ALL_SENSORS, SensorChoice
from ..sensor_logic.logs.error import InputError
from ..sensor_logic.logs.files import read_text
from ..sensor_logic.logs.toml_table import (
    TomlTable,
    calendar_date,
    flag,
    number,
    read_table,
    suggestion,
    text,
    texts,
)
from ..sensor_logic.model import Array

Value = bool | int | float | str | tuple[str, ...]
DRAWS = ("grid", "list", "random", "sobol")
# The measures and their columns. Some also have a column for each sensor, such as "events NAME".
TRUTH_COLUMNS = (
    "noticed",
    "missed_per_day",
    "delay_s",
    "false_alarms_per_day",
    "activities_per_day",
)
MEASURES: dict[str, tuple[str, ...]] = {"events": ("events",), "active": ("active",)}
MEASURES |= {"coverage": ("coverage",), "light_error": ("light_error",), "truth": TRUTH_COLUMNS}
# Columns of all tables.
COLUMNS = ("run", "seed", "sensors_on", "seconds", "digest", "error")
KEPT = ("events",)
# Keys of [vary] and [set] that are not parameters of sensors, and so have no dot.
SENSORS, HOME, ROUTINE = "sensors", "home", "routine"
WITHOUT_DOT = (SENSORS, HOME, ROUTINE)
MOST_RUNS = 10_000_000
# The most choices of sensors, because all are listed.
MOST_CHOICES = 10_000
SEEDS = 2**31


@dataclass(frozen=True)
class Range:
    """A range of numbers, from which a study takes the values of a parameter.

    Attributes
    ----------
    first, last : float
        The smallest and the largest number.
    steps : int
        How many numbers a grid takes, limits included.
    log : bool
        Whether the numbers are evenly spaced on a logarithmic scale instead of a linear one.
    whole : bool
        Whether only whole numbers are taken.
    """

    first: float
    last: float
    steps: int = 0
    log: bool = False
    whole: bool = False

    def at(self, fraction: float) -> float:
        """Return the number at a fraction of the range: `first` at 0, `last` at 1."""
        # Exactly the last number, without rounding errors.
        if fraction == 1.0:
            return self.last
        if self.log:
            return float(self.first * (self.last / self.first) ** fraction)
        return self.first + fraction * (self.last - self.first)

    def values(self) -> list[Value]:
        """Return `steps` evenly spaced numbers, the values for a grid."""
        found = [self.at(step / (self.steps - 1)) for step in range(self.steps)]
        # Rounding can give the same whole number twice.
        return list(dict.fromkeys(map(round, found))) if self.whole else list(found)

    def drawn(self, fraction: float) -> Value:
        """Return the value that a random number `fraction`, from 0 to below 1, selects."""
        if not self.whole:
            return self.at(fraction)
        # All whole numbers are equally likely, also the ends.
        wide = Range(self.first - 0.5, self.last + 0.5, log=self.log)
        return int(min(max(round(wide.at(fraction)), self.first), self.last))


@dataclass(frozen=True)
class Function:
    """A user's own Python function that computes results from a run.

    `file` defines the function, and `source` is the text of the file.
    """

    file: Path
    name: str
    source: str

    @property
    def label(self) -> str:
        """The function as "FILE:NAME", without the file's folder."""
        return f"{self.file.name}:{self.name}"


@dataclass(frozen=True)
class Study:
    """A study as read from its file: which runs to simulate, and what to measure in each.

    The file has a table [vary] of varied parameters, and a table [set] of parameters with the same
    value in all runs. Each parameter has a key, such as "PIR*.hold_time".

    Attributes
    ----------
    name : str
        The name of the study's file.
    homes, routines : tuple of Path
        The files of the homes and routines, as absolute paths.
    start : date or None
        With routines: the date at whose midnight each run begins.
    days : int
        With routines: how many days each run simulates.
    vary : dict
        For each key of [vary], the values as a tuple or a `Range`.
    fixed : dict
        For each key of [set], the value.
    lines : dict of str to str
        For each key, its position in the file, for error messages.
    measure, functions : tuple
        The names of the built-in measures, and the user's own functions.
    draw : str
        How runs combine the values: "grid", "list", "random" or "sobol".
    runs, draw_seed : int
        For random and Sobol draws: the number of combinations, and the seed.
    seeds : tuple of int
        The seeds with which each combination is run.
    frames : tuple of 2 ints, or None
        Without routines: the first and last frame, or None for the scene's range.
    keep : tuple of str
        The logs to store for each run, such as "events".
    best : tuple of 2 str, or None
        The measure that ranks the results, and whether "most" or "least" of it is best.
    empty_for : float
        For false alarms: how long before and after an alarm its room must be empty, s.
    together : bool
        Whether runs that differ only in their sensors share one simulation.
    choice : SensorChoice
        The sensors to use. All others are disabled in all runs.
    """

    name: str
    homes: tuple[Path, ...]
    routines: tuple[Path, ...]
    start: date | None
    days: int
    vary: dict[str, tuple[Value, ...] | Range]
    fixed: dict[str, Value]
    lines: dict[str, str]
    measure: tuple[str, ...]
    functions: tuple[Function, ...]
    draw: str
    runs: int
    draw_seed: int
    seeds: tuple[int, ...]
    frames: tuple[int, int] | None
    keep: tuple[str, ...]
    best: tuple[str, str] | None
    empty_for: float
    together: bool
    choice: SensorChoice = ALL_SENSORS

    def where(self, key: str) -> str:
        """Return the position of a key of [vary] or [set] in the file, for error messages."""
        return self.lines.get(key, self.name)


def read(path: Path) -> Study:
    """Read a study from a file; raise `InputError` if it is invalid."""
    return _study(read_table(read_text(path), str(path)), path.resolve().parent)


def _study(top: TomlTable, folder: Path) -> Study:
    """Return the study in a TOML table whose paths are relative to `folder`."""
    homes = top.take("home", lambda value: _files(value, folder))
    routines = top.take("routine", lambda value: _files(value, folder), ())
    measure, functions = top.take(
        "measure", lambda value: _measures(value, folder), (("events",), ())
    )
    if "truth" in measure and not routines:
        raise top.error(
            "truth can be measured only for days: give a routine, start and days", "measure"
        )
    if "light_error" in measure and routines:
        raise top.error("light_error can be measured only without a routine", "measure")
    best = top.take("best", _best, None)
    if best is not None and not functions and not _is_measured(best[0], measure):
        known = [column for name in measure for column in MEASURES[name]]
        raise top.error(
            f"{best[0]!r} is not among the measures of this study; {suggestion(best[0], known)}",
            "best",
        )
    keys = {name: _keys(top, name) for name in ("vary", "set")}
    vary = {key: _values(keys["vary"], key) for key in keys["vary"].values}
    fixed = {key: _value(keys["set"], key) for key in keys["set"].values}
    for key in vary.keys() & fixed.keys():
        raise keys["set"].error(f"{key!r} also varies", key)
    if len(homes) > 1:
        vary = {HOME: tuple(map(str, homes)), **vary}
    if len(routines) > 1:
        vary = {**vary, ROUTINE: tuple(map(str, routines))}
    draw = top.one_of("draw", DRAWS, "grid")
    found = Study(
        name=top.name,
        homes=homes,
        routines=routines,
        start=top.take("start", calendar_date) if routines else None,
        days=top.take("days", _whole(1, 100_000)) if routines else 0,
        vary=vary,
        fixed=fixed,
        lines={key: table.where(key) for table in keys.values() for key in table.values},
        measure=measure,
        functions=functions,
        draw=draw,
        runs=top.take("runs", _whole(1, MOST_RUNS)) if draw in ("random", "sobol") else 0,
        draw_seed=top.take("draw_seed", _whole(0, SEEDS - 1), 0),
        seeds=top.take("seeds", _seeds, (0,)),
        frames=None if routines else top.take("frames", _frames, None),
        keep=top.take("keep", _keep, ()),
        best=best,
        empty_for=top.take("empty_for", number(0, 3600), 30.0),
        together=top.take("together", flag, True),
    )
    top.finish()
    _check_ranges(found)
    return found


def _keys(top: TomlTable, name: str) -> TomlTable:
    """Return the table [vary] or [set]; its keys must be like "PIR*.hold_time", or "sensors"."""
    table = top.below(top.take(name, dict, {}), name)
    for key in table.values:
        if "." not in key and key != SENSORS:
            raise table.error(
                f'{key!r} is not a parameter: write "SENSOR.parameter", such as "PIR*.hold_time", '
                "in quotation marks",
                key,
            )
    return table


def _values(table: TomlTable, key: str) -> tuple[Value, ...] | Range:
    """Return the values of a key of [vary], as a tuple or a `Range`."""
    found = table.values[key]
    if isinstance(found, dict):
        below = table.below(found, key)
        return _choices(below) if key == SENSORS else _range(below)
    if not isinstance(found, list) or not found:
        raise table.error(
            f"{key}: give a list of values, [1, 2, 3], or {{ from = 1, to = 3, steps = 3 }}", key
        )
    one = _names if key == SENSORS else _scalar
    return table.take(key, lambda values: tuple(map(one, values)))


def _value(table: TomlTable, key: str) -> Value:
    """Return the value of a key of [set]."""
    return table.take(key, _names if key == SENSORS else _scalar)


def _scalar(value: Any) -> Value:
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{value} is no number")
    if not isinstance(value, (bool, int, float, str)):
        raise ValueError(f"{value!r} is not a number, a text, true or false")
    return value


def _names(value: Any, what: str = "") -> tuple[str, ...]:
    """Return one text, or the texts of a list, as a tuple.

    `what` is the noun for an error about an empty list; "" allows an empty list.
    """
    found = (text(value),) if isinstance(value, str) else texts(value)
    if what and not found:
        raise ValueError(f"it names no {what}")
    return found


def _choices(table: TomlTable) -> tuple[tuple[str, ...], ...]:
    """Return all sets of `least` to `most` of the named sensors, small sets first."""
    names = table.take("of", texts)
    if not names:
        raise table.error("it names no sensor", "of")
    for name in names:
        if names.count(name) > 1:
            raise table.error(f"{name!r} is given twice", "of")
    least = table.take("least", _whole(1, len(names)), 1)
    most = table.take("most", _whole(1, len(names)), len(names))
    table.finish()
    if most < least:
        raise table.error(f"'most' ({most}) must be at least 'least' ({least})", "most")
    counts = range(least, most + 1)
    total = sum(math.comb(len(names), count) for count in counts)
    if total > MOST_CHOICES:
        raise table.error(
            f"there are {total} combinations of sensors, more than {MOST_CHOICES}: give fewer "
            "sensors, or 'least' and 'most' (sensors in a combination) closer together",
            "of",
        )
    return tuple(chosen for count in counts for chosen in itertools.combinations(names, count))


def _range(table: TomlTable) -> Range:
    any_number = number(-1e12, 1e12)
    found = Range(
        table.take("from", any_number),
        table.take("to", any_number),
        table.take("steps", _whole(2, MOST_RUNS), 0),
        table.take("log", flag, False),
        table.take("whole", flag, False),
    )
    table.finish()
    if found.last <= found.first:
        raise table.error("'to' must be above 'from'", "to")
    if found.log and found.first <= 0:
        raise table.error("with log = true 'from' must be above 0", "from")
    return found


def _check_ranges(study: Study) -> None:
    """Raise `InputError` for a range without steps in a grid, or for lists of unequal length."""
    lists = {key: values for key, values in study.vary.items() if not isinstance(values, Range)}
    for key, values in study.vary.items():
        if isinstance(values, Range) and study.draw == "list":
            raise InputError(
                f'{study.where(key)}: draw = "list" needs lists such as [1, 2, 3], not ranges'
            )
        if isinstance(values, Range) and study.draw == "grid" and not values.steps:
            raise InputError(
                f'{study.where(key)}: draw = "grid" needs steps in each range, such as steps = 5'
            )
    lengths = {len(values) for values in lists.values()}
    if study.draw == "list" and len(lengths) > 1:
        lengths_text = ", ".join(f"{key} has {len(values)}" for key, values in lists.items())
        where = study.where(next(iter(lists)))
        raise InputError(f'{where}: draw = "list" needs lists of the same length: {lengths_text}')


def _files(value: Any, folder: Path) -> tuple[Path, ...]:
    found = tuple((folder / name).resolve() for name in _names(value, "file"))
    for path in found:
        if not path.is_file():
            raise ValueError(f"the file {path} does not exist")
    if len(set(found)) < len(found):
        raise ValueError("a file is given twice")
    return found


def _measures(value: Any, folder: Path) -> tuple[tuple[str, ...], tuple[Function, ...]]:
    names, functions = _names(value, "measure"), []
    for name in names:
        if ".py:" in name:
            functions.append(_function(name, folder))
        elif name not in MEASURES:
            raise ValueError(
                f"{name!r} is not a measure; {suggestion(name, MEASURES)} Write your own measure "
                'as "file.py:function"'
            )
    return tuple(name for name in names if ".py:" not in name), tuple(functions)


def _function(name: str, folder: Path) -> Function:
    file, _, called = name.rpartition(":")
    path = (folder / file).resolve()
    try:
        source = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ValueError(f"cannot read {path}: {error.strerror}") from None
    try:
        body = ast.parse(source).body
    except (SyntaxError, ValueError) as error:
        raise ValueError(f"{path.name} is not valid Python: {error}") from None
    names = [node.name for node in body if isinstance(node, ast.FunctionDef)]
    if called not in names:
        raise ValueError(f"{path.name} has no function {called!r}; {suggestion(called, names)}")
    return Function(path, called, source)


def _keep(value: Any) -> tuple[str, ...]:
    names = _names(value)
    for name in names:
        if name not in KEPT:
            raise ValueError(f"{name!r} cannot be kept; {suggestion(name, KEPT)}")
    return names


def _best(value: Any) -> tuple[str, str]:
    which, _, measure = text(value).partition(" ")
    if which not in ("most", "least") or not measure:
        raise ValueError(f'{value!r} is not "most MEASURE" or "least MEASURE"')
    return measure.strip(), which


def _is_measured(column: str, measure: tuple[str, ...]) -> bool:
    columns = {*COLUMNS, *(column for name in measure for column in MEASURES[name])}
    return column in columns or column.partition(" ")[0] in {"events", "active"} & {*measure}


def _seeds(value: Any) -> tuple[int, ...]:
    """Return the seeds of a list or, for a number n, the seeds from 1 to n."""
    if isinstance(value, list):
        found = tuple(map(_whole(0, SEEDS - 1), value))
        if not found or len(set(found)) < len(found):
            raise ValueError("give at least one seed, and each seed only once")
        return found
    return tuple(range(1, _whole(1, 100_000)(value) + 1))


def _frames(value: Any) -> tuple[int, int]:
    whole = _whole(-1_048_574, 1_048_574)
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"{value!r} is not [first, last], such as [1, 240]")
    first, last = map(whole, value)
    if last < first:
        raise ValueError(f"the first frame, {first}, is after the last, {last}")
    return first, last


def _whole(low: int, high: int) -> Any:
    """Return a function that checks that a value is a whole number from `low` to `high`."""

    def read_whole(value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise ValueError(f"{value!r} is not a whole number from {low} to {high}")
        return value

    return read_whole


# The runs.

Setting = dict[str, Value]


class Run(NamedTuple):
    """A run of a study: its number from 1, the values of the varied parameters, and its seed."""

    number: int
    setting: Setting
    seed: int


def count_of(study: Study) -> int:
    """Return how many runs a study has; raise `InputError` if there are too many."""
    if study.draw in ("random", "sobol"):
        settings = study.runs
    elif study.draw == "list":
        settings = len(_values_of(next(iter(study.vary.values()), (0,))))
    else:
        settings = math.prod(len(_values_of(way)) for way in study.vary.values())
    total = settings * len(study.seeds)
    if total > MOST_RUNS:
        raise InputError(f"{study.name}: {total} runs are more than {MOST_RUNS}")
    return total


def runs_of(study: Study) -> Iterator[Run]:
    """Yield all runs in order: each combination of varied values with each of the seeds."""
    number = itertools.count(1)
    for setting in _settings(study):
        for seed in study.seeds:
            yield Run(next(number), setting, seed)


def _settings(study: Study) -> Iterator[Setting]:
    """Yield each combination of values of the varied parameters, by key."""
    ways = list(study.vary.values())
    rows: Iterable[tuple[Value, ...]]
    if study.draw == "grid":
        rows = itertools.product(*map(_values_of, ways))
    elif study.draw == "list":
        # `_check_ranges` has checked that these are lists of one length.
        rows = zip(*map(_values_of, ways), strict=True)
    else:
        rows = (tuple(map(_drawn, ways, row)) for row in _fractions(study, len(ways)).tolist())
    for row in rows:
        yield dict(zip(study.vary, row, strict=True))


def _values_of(values: Sequence[Value] | Range) -> Sequence[Value]:
    """Return the values of a tuple, or the values that a grid takes from a range."""
    return values.values() if isinstance(values, Range) else values


def _drawn(values: Sequence[Value] | Range, fraction: float) -> Value:
    """Return the value that a random number, from 0 to below 1, selects."""
    return (
        values.drawn(fraction) if isinstance(values, Range) else values[int(fraction * len(values))]
    )


def _fractions(study: Study, dimensions: int) -> Array:
    """Return random or Sobol numbers from 0 to below 1, shape (runs, dimensions)."""
    if study.draw == "random":
        return np.random.default_rng(study.draw_seed).random((study.runs, dimensions))
    from scipy.stats import qmc

    sobol: Any = qmc.Sobol(dimensions, scramble=True, rng=study.draw_seed)
    # Sobol points come in powers of two; the first ones are used.
    return np.asarray(sobol.random_base2(max(study.runs - 1, 0).bit_length()))[: study.runs]
