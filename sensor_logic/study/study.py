# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a study from TOML. Everything that is wrong is told with its line."""

from __future__ import annotations

import ast
import math
from dataclasses import dataclass
from datetime import date, datetime
from itertools import combinations
from pathlib import Path
from typing import Any, Literal

from ..choice import ALL_SENSORS, SensorChoice
from ..error import InputError
from ..toml_table import TomlTable, number, read_table, suggestion, text, texts

Value = bool | int | float | str | tuple[str, ...]
DRAWS = ("grid", "list", "random", "sobol")
# The measures, and the columns of the table that each fills; of a sensor's own as well, as
# "events NAME".
OF_TRUTH = ("noticed", "missed_per_day", "delay_s", "false_alarms_per_day", "activities_per_day")
MEASURES: dict[str, tuple[str, ...]] = {"events": ("events",), "active": ("active",)}
MEASURES |= {"coverage": ("coverage",), "light_error": ("light_error",), "truth": OF_TRUTH}
# Columns of every table.
COLUMNS = ("run", "seed", "sensors_on", "seconds", "digest", "error")
KEPT = ("events",)
# Keys of [vary] and [set] that are no parameter of a sensor, and so have no dot.
SENSORS, HOME, ROUTINE = "sensors", "home", "routine"
WITHOUT_DOT = (SENSORS, HOME, ROUTINE)
MOST_RUNS = 10_000_000
# Choices of sensors, all of which are written out.
MOST_CHOICES = 10_000
SEEDS = 2**31


@dataclass(frozen=True)
class Range:
    """Numbers from `first` to `last`: evenly, or by factors where it is `log`; `whole` ones alone;
    `steps` of them in a grid."""

    first: float
    last: float
    steps: int = 0
    log: bool = False
    whole: bool = False

    def at(self, share: float) -> float:
        """The number at a share from 0 to 1."""
        if self.log:
            found = self.first * (self.last / self.first) ** share
        else:
            found = self.first + share * (self.last - self.first)
        # A share of 1 is the last number itself, without rounding.
        return self.last if share == 1.0 else found


@dataclass(frozen=True)
class Function:
    """A function of a user's own that measures: `source` is the text of its file."""

    file: Path
    name: str
    source: str

    @property
    def label(self) -> str:
        return f"{self.file.name}:{self.name}"


@dataclass(frozen=True)
class Days:
    """What is lived in each run: `days` from midnight of `start` on, by one of the routines."""

    start: date
    days: int


@dataclass(frozen=True)
class Study:
    """A study as its file has it. Paths are absolute. `vary`: the values of each key, or a range;
    `fixed`: what all runs have in common. `empty_for` (s): a sensor that goes on
    in a room that is empty for so long before and after gives a false alarm. `best`: the measure
    that matters, and whether most of it is wanted. `together`: whether runs that differ in their
    sensors alone live the home once. `choice`: the other sensors are switched off in all runs."""

    name: str
    homes: tuple[Path, ...]
    seeds: tuple[int, ...]
    vary: dict[str, tuple[Value, ...] | Range]
    fixed: dict[str, Value]
    draw: str = "grid"
    runs: int = 0
    draw_seed: int = 0
    frames: tuple[int, int] | None = None
    measure: tuple[str, ...] = ("events",)
    functions: tuple[Function, ...] = ()
    keep: tuple[str, ...] = ()
    best: tuple[str, Literal["most", "least"]] | None = None
    routines: tuple[Path, ...] = ()
    days: Days | None = None
    empty_for: float = 30.0
    together: bool = True
    lines: tuple[tuple[str, str], ...] = ()
    choice: SensorChoice = ALL_SENSORS

    def where(self, key: str) -> str:
        """File and line of a key of [vary] or [set]."""
        return dict(self.lines).get(key, self.name)


def read(path: Path) -> Study:
    """The study in a file. Raises InputError."""
    try:
        content = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from None
    except ValueError:
        raise InputError(f"{path.name} is not a text file in UTF-8") from None
    return _study(read_table(content, path.name), path.resolve().parent)


def _study(top: TomlTable, folder: Path) -> Study:
    homes = top.take("home", lambda value: _files(value, folder))
    routines = top.take("routine", lambda value: _files(value, folder), ())
    days = None
    if routines:
        days = Days(top.take("start", _date), top.take("days", _whole(1, 100_000)))
    draw = top.one_of("draw", DRAWS, "grid")
    drawn = draw in ("random", "sobol")
    measure, functions = top.take(
        "measure", lambda value: _measures(value, folder), (("events",), ())
    )
    if "truth" in measure and not routines:
        raise top.error("truth is known of days alone: give a routine, start and days", "measure")
    if "light_error" in measure and routines:
        raise top.error("light_error is measured without a routine alone", "measure")
    best = top.take("best", _best, None)
    if best is not None and not functions and not _is_measured(best[0], measure):
        known = [column for name in measure for column in MEASURES[name]]
        raise top.error(f"{best[0]!r} is not measured; {suggestion(best[0], known)}", "best")
    vary = {key: _values(table, key) for table, key in _keys(top, "vary")}
    fixed = {key: _value(table, key) for table, key in _keys(top, "set")}
    for key in vary.keys() & fixed.keys():
        raise top.below(fixed, "set").error(f"{key!r} also varies", key)
    if len(homes) > 1:
        vary = {HOME: tuple(str(home) for home in homes), **vary}
    if len(routines) > 1:
        vary = {**vary, ROUTINE: tuple(str(routine) for routine in routines)}
    found = Study(
        top.name,
        homes,
        top.take("seeds", _seeds, (0,)),
        vary,
        fixed,
        draw,
        top.take("runs", _whole(1, MOST_RUNS)) if drawn else 0,
        top.take("draw_seed", _whole(0, SEEDS - 1), 0),
        None if routines else top.take("frames", _frames, None),
        measure,
        functions,
        top.take("keep", _kept, ()),
        best,
        routines,
        days,
        top.take("empty_for", number(0, 3600), 30.0),
        top.take("together", _flag, True),
        tuple(
            (key, _place(table, key)) for name in ("vary", "set") for table, key in _keys(top, name)
        ),
    )
    top.finish()
    _check_ranges(found)
    return found


def _keys(top: TomlTable, name: str) -> list[tuple[TomlTable, str]]:
    table = top.below(top.take(name, dict, {}), name)
    for key in table.values:
        if "." not in key and key != SENSORS:
            raise table.error(
                f'{key!r} is no parameter: write "SENSOR.parameter", such as "PIR*.hold_time", '
                "in quotation marks",
                key,
            )
    return [(table, key) for key in table.values]


def _place(table: TomlTable, key: str) -> str:
    return str(table.error("", key)).removesuffix(": ")


def _values(table: TomlTable, key: str) -> tuple[Value, ...] | Range:
    """What a key of [vary] takes. Raises InputError."""
    found = table.values[key]
    if isinstance(found, dict) and key == SENSORS:
        return _choices(table.below(found, key))
    if isinstance(found, dict):
        return _range(table.below(found, key))
    if not isinstance(found, list) or not found:
        raise table.error(
            f"{key}: give a list of values, [1, 2, 3], or {{ from = 1, to = 3, steps = 3 }}", key
        )
    one = _one_set if key == SENSORS else _scalar
    return table.take(key, lambda values: tuple(map(one, values)))


def _value(table: TomlTable, key: str) -> Value:
    return table.take(key, _one_set if key == SENSORS else _scalar)


def _scalar(value: Any) -> Value:
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"{value} is no number")
    if not isinstance(value, (bool, int, float, str)):
        raise ValueError(f"{value!r} is not a number, a text, true or false")
    return value


def _one_set(value: Any) -> tuple[str, ...]:
    """Names or patterns of sensors."""
    return (text(value),) if isinstance(value, str) else texts(value)


def _choices(table: TomlTable) -> tuple[tuple[str, ...], ...]:
    """Every choice of `least` to `most` of some sensors, the small ones first. Raises
    InputError."""
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
        raise table.error(f"'most', {most}, is below 'least', {least}", "most")
    counts = range(least, most + 1)
    total = sum(math.comb(len(names), count) for count in counts)
    if total > MOST_CHOICES:
        raise table.error(
            f"these are {total} choices, more than {MOST_CHOICES}: give fewer sensors, or another "
            "'least' or 'most'",
            "of",
        )
    return tuple(chosen for count in counts for chosen in combinations(names, count))


def _range(table: TomlTable) -> Range:
    any_number = number(-1e12, 1e12)
    found = Range(
        table.take("from", any_number),
        table.take("to", any_number),
        table.take("steps", _whole(2, MOST_RUNS), 0),
        table.take("log", _flag, False),
        table.take("whole", _flag, False),
    )
    table.finish()
    if found.last <= found.first:
        raise table.error("'to' must be above 'from'", "to")
    if found.log and found.first <= 0:
        raise table.error("with log = true 'from' must be above 0", "from")
    return found


def _check_ranges(study: Study) -> None:
    """Raises InputError where what varies does not go with how it is drawn."""
    lists = {key: values for key, values in study.vary.items() if not isinstance(values, Range)}
    for key, values in study.vary.items():
        if isinstance(values, Range) and study.draw == "list":
            raise InputError(f'{study.where(key)}: draw = "list" takes lists, [1, 2, 3], alone')
        if isinstance(values, Range) and study.draw == "grid" and not values.steps:
            raise InputError(f"{study.where(key)}: a grid needs steps, such as steps = 5")
    lengths = {len(values) for values in lists.values()}
    if study.draw == "list" and len(lengths) > 1:
        told = ", ".join(f"{key} has {len(values)}" for key, values in lists.items())
        where = study.where(next(iter(lists)))
        raise InputError(f'{where}: draw = "list" takes lists of one length: {told}')


def _files(value: Any, folder: Path) -> tuple[Path, ...]:
    names = (text(value),) if isinstance(value, str) else texts(value)
    if not names:
        raise ValueError("it names no file")
    found = tuple((folder / name).resolve() for name in names)
    for path in found:
        if not path.is_file():
            raise ValueError(f"there is no file {path}")
    if len(set(found)) < len(found):
        raise ValueError("it names a file twice")
    return found


def _measures(value: Any, folder: Path) -> tuple[tuple[str, ...], tuple[Function, ...]]:
    names = (text(value),) if isinstance(value, str) else texts(value)
    functions = []
    if not names:
        raise ValueError("it names no measure")
    for name in names:
        if ".py:" in name:
            functions.append(_function(name, folder))
        elif name not in MEASURES:
            raise ValueError(
                f"{name!r} is no measure; {suggestion(name, MEASURES)} One of your own is "
                '"file.py:function"'
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
        raise ValueError(f"{path.name} is no Python: {error}") from None
    names = [node.name for node in body if isinstance(node, ast.FunctionDef)]
    if called not in names:
        raise ValueError(f"{path.name} has no function {called!r}; {suggestion(called, names)}")
    return Function(path, called, source)


def _kept(value: Any) -> tuple[str, ...]:
    names = (text(value),) if isinstance(value, str) else texts(value)
    for name in names:
        if name not in KEPT:
            raise ValueError(f"{name!r} cannot be kept; {suggestion(name, KEPT)}")
    return names


def _best(value: Any) -> tuple[str, Literal["most", "least"]]:
    which, _, measure = text(value).partition(" ")
    if which == "most" and measure:
        return measure.strip(), "most"
    if which == "least" and measure:
        return measure.strip(), "least"
    raise ValueError(f'{value!r} is not "most MEASURE" or "least MEASURE"')


def _is_measured(column: str, measure: tuple[str, ...]) -> bool:
    columns = {*COLUMNS, *(column for name in measure for column in MEASURES[name])}
    return column in columns or column.partition(" ")[0] in {"events", "active"} & {*measure}


def _seeds(value: Any) -> tuple[int, ...]:
    """A number of seeds, from 1 on, or the seeds themselves."""
    if isinstance(value, list):
        found = tuple(map(_whole(0, SEEDS - 1), value))
        if not found or len(set(found)) < len(found):
            raise ValueError("give each seed once, and one at least")
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
    def read_whole(value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
            raise ValueError(f"{value!r} is no whole number from {low} to {high}")
        return value

    return read_whole


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{value!r} is neither true nor false")
    return value


def _date(value: Any) -> date:
    if isinstance(value, datetime) or not isinstance(value, date):
        raise ValueError(f"{value!r} is not a date such as 2026-03-02")
    return value
