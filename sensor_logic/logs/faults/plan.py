# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a faults file: a seed, and a `[[fault]]` table for each group of sensors."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

from ..error import InputError
from ..fields import LOGGED_KINDS
from ..files import read_text
from ..lines import KeyPath, line_of, read_toml

Range = tuple[float, float]
STATES = ("on", "off", "held")
SEEDS = 2**32
LONGEST_S = 1e9


class _Bounds(NamedTuple):
    """The valid numbers for a parameter in a faults file, with a description for messages.

    If `is_range`, the value can also be a list [lowest, highest].
    """

    low: float
    high: float
    is_range: bool
    text: str


_SHARE = _Bounds(0.0, 1.0, False, "a share from 0 to 1")
_SECONDS = _Bounds(0.0, LONGEST_S, True, "seconds from 0 to 1e9, or [lowest, highest]")
NUMBERS = {
    "lost": _SHARE,
    "late": _SHARE,
    "late_by": _SECONDS,
    "doubled": _SHARE,
    "doubled_after": _SECONDS,
    "clock_offset": _Bounds(
        -LONGEST_S, LONGEST_S, True, "seconds from -1e9 to 1e9, or [lowest, highest]"
    ),
    "clock_drift_ppm": _Bounds(
        -1e5, 1e5, True, "parts per million from -100000 to 100000, or [lowest, highest]"
    ),
    "battery_life": _SECONDS,
    "stuck_from": _SECONDS,
    "stuck_for": _SECONDS,
    "false_alarms_per_day": _Bounds(0.0, 86400.0, False, "a number from 0 to 86400"),
    "false_alarm_lasts": _SECONDS,
}
# A key → the key without which it has no effect.
NEEDS = {
    "late": "late_by",
    "late_by": "late",
    "doubled_after": "doubled",
    "stuck_from": "stuck",
    "stuck_for": "stuck",
    "false_alarms_per_day": "false_alarm_lasts",
    "false_alarm_lasts": "false_alarms_per_day",
}


@dataclass(frozen=True)
class Fault:
    """A `[[fault]]` table: the faults of a group of sensors.

    The group has the sensors whose name matches one of `sensors` and whose kind is in `kinds`. An
    empty `kinds` means any kind. Times are in seconds. For a pair of numbers, a value between them
    is drawn from a uniform distribution. `docs/faults.md` explains each key.
    """

    sensors: tuple[str, ...] = ("*",)
    kinds: tuple[str, ...] = ()
    lost: float = 0.0
    late: float = 0.0
    late_by: Range = (0.0, 0.0)
    doubled: float = 0.0
    doubled_after: Range = (0.0, 0.0)
    clock_offset: Range = (0.0, 0.0)
    clock_drift_ppm: Range = (0.0, 0.0)
    battery_life: Range = (math.inf, math.inf)
    stuck: str = ""
    stuck_from: Range = (0.0, 0.0)
    stuck_for: Range = (math.inf, math.inf)
    false_alarms_per_day: float = 0.0
    false_alarm_lasts: Range = (0.0, 0.0)

    def concerns(self, name: str, kind: str) -> bool:
        """Return whether a sensor with this name and kind belongs to the group."""
        return (not self.kinds or kind in self.kinds) and any(
            _matches(name, pattern) for pattern in self.sensors
        )


@dataclass(frozen=True)
class FaultPlan:
    """The content of a faults file: a seed, and the faults of groups of sensors.

    `places` has, for error messages, the file and line of the key `sensors` of each fault.
    """

    seed: int
    faults: tuple[Fault, ...]
    places: tuple[str, ...]

    def check_names(self, names: Iterable[str]) -> None:
        """Raise InputError if a name or pattern in the plan matches none of a home's sensors.

        `names` are the names of the home's sensors.
        """
        names = sorted(names)
        for fault, place in zip(self.faults, self.places, strict=True):
            for pattern in fault.sensors:
                if not any(_matches(name, pattern) for name in names):
                    raise InputError(
                        f"{place}: no sensor is called '{pattern}'; "
                        f"there are {', '.join(names) or 'none'}"
                    )


def _matches(name: str, pattern: str) -> bool:
    return name == pattern or fnmatchcase(name, pattern)


def read_plan(path: Path) -> FaultPlan:
    """Read a faults file. Raise InputError if it is invalid; the text names file and line."""
    found, lines = read_toml(read_text(path), str(path))
    where = _Places(path, lines)
    for key in found:
        if key not in {"seed", "fault"}:
            raise InputError(
                f"{where.of(key)}: '{key}' is unknown: only seed and tables [[fault]] are allowed"
            )
    seed = found.get("seed", 0)
    if not isinstance(seed, int) or isinstance(seed, bool) or not 0 <= seed < SEEDS:
        raise InputError(
            f"{where.of('seed')}: seed is {seed!r}: it must be a whole number from 0 to 2^32"
        )
    tables = found.get("fault", [])
    if not (isinstance(tables, list) and tables and all(isinstance(t, dict) for t in tables)):
        raise InputError(f"{path} has no table [[fault]]")
    faults = tuple(_fault(where, number, table) for number, table in enumerate(tables))
    return FaultPlan(
        seed, faults, tuple(where.of("sensors", number) for number in range(len(tables)))
    )


class _Places(NamedTuple):
    """The lines of the parameters in a faults file, for error messages."""

    path: Path
    lines: dict[KeyPath, int]

    def of(self, key: str, number: int | None = None) -> str:
        """Return the file and line of a key, given the index of its table if it is in one."""
        path = (key,) if number is None else ("fault", number, key)
        return f"{self.path}: line {line_of(self.lines, path)}"


def _fault(where: _Places, number: int, table: Mapping[str, Any]) -> Fault:
    values: dict[str, Any] = {}
    known = {field.name for field in fields(Fault)}
    for key, value in table.items():
        place = where.of(key, number)
        if key not in known:
            raise InputError(
                f"{place}: '{key}' is unknown: choose one of {', '.join(sorted(known))}"
            )
        if NEEDS.get(key, key) not in table:
            raise InputError(f"{place}: {key} also needs {NEEDS[key]}; give both")
        if key in NUMBERS:
            values[key] = _number(place, key, value)
        elif key == "stuck":
            if value not in STATES:
                raise InputError(f"{place}: stuck is {value!r}, not {' or '.join(STATES)}")
            values[key] = value
        else:
            values[key] = _names(place, key, value)
    for kind in values.get("kinds", ()):
        if kind not in LOGGED_KINDS:
            raise InputError(
                f"{where.of('kinds', number)}: kind '{kind}' is unknown: choose one of "
                f"{', '.join(LOGGED_KINDS)}"
            )
    if not set(table) - {"sensors", "kinds"}:
        raise InputError(
            f"{where.of('sensors', number)}: this table has no fault; add one, such as lost = 0.01"
        )
    return Fault(**values)


def _number(place: str, key: str, value: Any) -> float | Range:
    bounds = NUMBERS[key]
    ends = value if bounds.is_range and isinstance(value, list) else [value, value]
    is_number = [isinstance(end, (int, float)) and not isinstance(end, bool) for end in ends]
    if len(ends) != 2 or not all(is_number):
        raise InputError(f"{place}: {key} is {value!r}, not {bounds.text}")
    if not bounds.low <= ends[0] <= ends[1] <= bounds.high:
        raise InputError(f"{place}: {key} is {value}, not {bounds.text}")
    return (float(ends[0]), float(ends[1])) if bounds.is_range else float(value)


def _names(place: str, key: str, value: Any) -> tuple[str, ...]:
    names = [value] if isinstance(value, str) else value
    if not (isinstance(names, list) and names and all(isinstance(n, str) for n in names)):
        raise InputError(f"{place}: {key} is {value!r}, not a name or a list of names")
    return tuple(names)
