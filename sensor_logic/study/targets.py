# SPDX-License-Identifier: GPL-3.0-or-later
"""What the keys of a study mean in a home: which parameter of which sensors each of them sets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from ..choice import ALL_SENSORS, SensorChoice, fitting, not_found
from ..error import InputError
from ..kind import Kind
from ..kinds import KINDS
from ..parameters import defaults, specs
from ..wording import hint
from .study import SENSORS, WITHOUT_DOT, Range, Study, Value

# A sensor is moved by metres along the home's axes, and turned by radians about its own.
POSE = ("move_x", "move_y", "move_z", "turn_x", "turn_y", "turn_z")
COMMON = ("enabled", "update_rate")
PRESET = "preset"
# Between the names of a key.
BETWEEN = "; "


@dataclass(frozen=True)
class HomeFacts:
    """What is known of a home before it is simulated: the kinds of its sensors by name, in order,
    the digest of its file and of all that it links, the versions that would simulate it, and which
    sensors are `free`: nothing but they themselves depends on how they are set."""

    name: str
    kinds: Mapping[str, str]
    digest: str
    versions: Mapping[str, str]
    frame_start: int = 1
    free: frozenset[str] = frozenset()

    def fitting(self, pattern: str) -> list[str]:
        """The sensors of a name, or whose name fits a pattern, or one of several; empty where one
        of these fits none."""
        if pattern in self.kinds:
            return [pattern]
        found: set[str] = set()
        for part in pattern.split(BETWEEN):
            fit = fitting(part, self.kinds)
            if not fit:
                return []
            found.update(fit)
        return [name for name in self.kinds if name in found]


def split(key: str) -> tuple[str, str]:
    """Name or pattern of sensors, and the parameter."""
    pattern, _, parameter = key.rpartition(".")
    return pattern, parameter


def check(study: Study, homes: Iterable[HomeFacts]) -> None:
    """Raises InputError for what no sensor of one of the homes has, and values out of limits."""
    for home in homes:
        try:
            study.choice.of(home.kinds)
        except InputError as error:
            raise InputError(f"{home.name}: {error}") from None
        if study.frames is not None and study.frames[1] < home.frame_start:
            raise InputError(
                f"{study.name}: frames end before {home.name} begins, at {home.frame_start}"
            )
        fixed = {key: (value,) for key, value in study.fixed.items()}
        for key, values in (study.vary | fixed).items():
            if key == SENSORS:
                for patterns in values:  # type: ignore[union-attr]
                    _check_sensors(study, home, patterns)  # type: ignore[arg-type]
            elif key not in WITHOUT_DOT:
                _check_key(study, home, key, values)


def _check_sensors(study: Study, home: HomeFacts, patterns: tuple[str, ...]) -> None:
    for pattern in patterns:
        if not home.fitting(pattern):
            raise _no_sensor(study, home, SENSORS, pattern)


def _no_sensor(study: Study, home: HomeFacts, key: str, pattern: str) -> InputError:
    found = not_found(pattern, home.kinds, f" of {home.name}")
    return InputError(f"{study.where(key)}: {found}")


def _check_key(study: Study, home: HomeFacts, key: str, values: tuple[Value, ...] | Range) -> None:
    pattern, parameter = split(key)
    names = home.fitting(pattern)
    if not names:
        raise _no_sensor(study, home, key, pattern)
    ends = (values.first, values.last) if isinstance(values, Range) else values
    for kind in {home.kinds[name]: KINDS[home.kinds[name]] for name in names}.values():
        known = (*specs(kind.parameters), *COMMON, *POSE, PRESET)
        if parameter not in known:
            of = next(name for name in names if home.kinds[name] == kind.identifier)
            raise InputError(
                f"{study.where(key)}: '{of}' has no parameter '{parameter}'; "
                f"{hint(parameter, known)}"
            )
        for value in ends:
            whole = isinstance(values, Range) and not values.whole
            problem = _problem(kind, parameter, value, whole)
            if problem:
                raise InputError(f"{study.where(key)}: {parameter} {problem}")


def _problem(kind: Kind, parameter: str, value: Value, is_range: bool) -> str:
    """Why a value is none of this parameter; empty where it is one."""
    if parameter == PRESET:
        known = [preset.identifier for preset in kind.presets]
        return "" if value in known else f"'{value}' is unknown: {hint(str(value), known)}"
    if parameter in POSE:
        return "" if _is_number(value) else f"is {value!r}: it must be a number"
    if parameter == "update_rate":
        sound = _is_number(value) and float(value) > 0  # type: ignore[arg-type]
        return "" if sound else f"is {value!r}: it must be a number above 0"
    if parameter == "enabled":
        return "" if isinstance(value, bool) else f"is {value!r}: it must be true or false"
    default = defaults(kind.parameters)[parameter]
    problem = _wrong_type(default, value, is_range, parameter)
    if problem or specs(kind.parameters)[parameter].pointer:
        return problem
    told = kind.parameters(**{parameter: value}).problems()
    prefix = f"{parameter} "
    return next((text.removeprefix(prefix) for text in told if text.startswith(prefix)), "")


def _wrong_type(default: Any, value: Value, is_range: bool, parameter: str) -> str:
    if isinstance(default, bool):
        return "" if isinstance(value, bool) else f"is {value!r}: it must be true or false"
    if isinstance(default, (int, float)):
        if not _is_number(value):
            return f"is {value!r}: it must be a number"
        if isinstance(default, int) and is_range:
            return "counts: add whole = true to its range"
        if isinstance(default, int) and float(value) != int(value):  # type: ignore[arg-type]
            return f"is {value!r}: it must be a whole number"
        return ""
    return "" if isinstance(value, str) else f"is {value!r}: it must be a text"


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def settings_of(
    home: HomeFacts, values: Mapping[str, Value], choice: SensorChoice = ALL_SENSORS
) -> dict[str, dict[str, Any]]:
    """What a run sets: sensor → parameter → value. Of two keys that set the same the later one
    holds; sensors that `sensors` does not name, or the `choice` not take, are switched off."""
    found: dict[str, dict[str, Any]] = {}
    on = values.get(SENSORS)
    if isinstance(on, tuple):
        present = {name for pattern in on for name in home.fitting(pattern)}
        for name in home.kinds:
            found[name] = {"enabled": name in present}
    for key, value in values.items():
        if key in WITHOUT_DOT:
            continue
        pattern, parameter = split(key)
        for name in home.fitting(pattern):
            kind = KINDS[home.kinds[name]]
            found.setdefault(name, {}).update(_values_of(kind, parameter, value))
    for name in sorted(home.kinds.keys() - choice.of(home.kinds)):
        found.setdefault(name, {})["enabled"] = False
    return found


def _values_of(kind: Kind, parameter: str, value: Value) -> dict[str, Any]:
    if parameter == PRESET:
        return dict(next(p.values for p in kind.presets if p.identifier == value))
    if parameter in specs(kind.parameters) and _is_number(value):
        default = defaults(kind.parameters)[parameter]
        return {parameter: type(default)(value)}
    return {parameter: value}
