# SPDX-License-Identifier: GPL-3.0-or-later
"""Translate the keys of a study to parameters of a home's sensors, and check the values.

A key, such as "PIR*.hold_time", names some sensors and one of their parameters.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, cast

from ..sensor_logic.choice import ALL_SENSORS, SensorChoice, fitting, not_found
from ..sensor_logic.kind import Kind
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.logs.error import InputError, explained
from ..sensor_logic.logs.wording import hint
from ..sensor_logic.parameters import defaults, specs
from .study import SENSORS, WITHOUT_DOT, Range, Study, Value
from .study_file import BETWEEN, COMMON, POSE

PRESET = "preset"
# Values by sensor and parameter.
Settings = dict[str, dict[str, Any]]


@dataclass(frozen=True)
class StudiedHome:
    """Data about a home that a study needs before it simulates the home.

    Attributes
    ----------
    name : str
        The name of the home's file.
    kinds : mapping of str to str
        The kind of each sensor, by the sensor's name and in the order of sensors.
    digest : str
        A digest of the file and of all files that it links.
    frame_start : int
        The scene's first frame.
    independent : frozenset of str
        The sensors whose parameters affect the readings of no other sensor.
    """

    name: str
    kinds: Mapping[str, str]
    digest: str
    frame_start: int = 1
    independent: frozenset[str] = frozenset()

    def fitting(self, pattern: str) -> list[str]:
        """Return the names of the sensors that match `pattern`, or several patterns joined by "; ".

        Return an empty list if one of several patterns matches no sensor.
        """
        if pattern in self.kinds:
            return [pattern]
        found: set[str] = set()
        for part in pattern.split(BETWEEN):
            fit = fitting(part, self.kinds)
            if not fit:
                return []
            found.update(fit)
        return [name for name in self.kinds if name in found]


def check(study: Study, homes: Iterable[StudiedHome]) -> None:
    """Raise `InputError` if a study does not fit its homes.

    Each key, such as "PIR*.hold_time", must name sensors of each home and a parameter of theirs.
    Each value must be within the limits of its parameter.
    """
    for home in homes:
        with explained(home.name, InputError):
            study.choice.of(home.kinds)
        if study.frames is not None and study.frames[1] < home.frame_start:
            raise InputError(
                f"{study.name}: frames end before the first frame of {home.name}, "
                f"{home.frame_start}"
            )
        fixed = {key: (value,) for key, value in study.fixed.items()}
        for key, values in (study.vary | fixed).items():
            if key == SENSORS:
                for pattern in itertools.chain.from_iterable(cast(Any, values)):
                    if not home.fitting(pattern):
                        raise _no_sensor(study, home, SENSORS, pattern)
            elif key not in WITHOUT_DOT:
                _check_key(study, home, key, values)


def _no_sensor(study: Study, home: StudiedHome, key: str, pattern: str) -> InputError:
    found = not_found(pattern, home.kinds, f" of {home.name}")
    return InputError(f"{study.where(key)}: {found}")


def _check_key(
    study: Study, home: StudiedHome, key: str, values: tuple[Value, ...] | Range
) -> None:
    """Raise `InputError` if a home has no such sensor or parameter, or if a value is invalid."""
    pattern, _, parameter = key.rpartition(".")
    names = home.fitting(pattern)
    if not names:
        raise _no_sensor(study, home, key, pattern)
    ends = (values.first, values.last) if isinstance(values, Range) else values
    for kind in {home.kinds[name]: KINDS[home.kinds[name]] for name in names}.values():
        known = (*specs(kind.parameters), *COMMON, *POSE, PRESET)
        if parameter not in known:
            sensor = next(name for name in names if home.kinds[name] == kind.identifier)
            raise InputError(
                f"{study.where(key)}: '{sensor}' has no parameter '{parameter}'; "
                f"{hint(parameter, known)}"
            )
        for value in ends:
            whole = isinstance(values, Range) and not values.whole
            problem = _problem(kind, parameter, value, whole)
            if problem:
                raise InputError(f"{study.where(key)}: {parameter} {problem}")


def _problem(kind: Kind, parameter: str, value: Value, is_range: bool) -> str:
    """Return why a value, or a limit of a range, is not valid for a parameter; "" if it is."""
    if parameter == PRESET:
        known = [preset.identifier for preset in kind.presets]
        return "" if value in known else f"'{value}' is unknown: {hint(str(value), known)}"
    own = defaults(kind.parameters)
    # An example of the parameter's type.
    like = {"enabled": True, "update_rate": 1.0, **dict.fromkeys(POSE, 0.0), **own}[parameter]
    if isinstance(like, int) and not isinstance(like, bool) and is_range:
        return "must be a whole number: add whole = true to its range"
    if wanted := _wanted(like, value, parameter == "update_rate"):
        return f"is {value!r}: it must be {wanted}"
    if parameter not in own or specs(kind.parameters)[parameter].pointer:
        return ""
    problems = kind.parameters(**{parameter: value}).problems()
    prefix = f"{parameter} "
    return next((text.removeprefix(prefix) for text in problems if text.startswith(prefix)), "")


def _wanted(like: Any, value: Any, is_positive: bool) -> str:
    """Return what a value must be, such as "a number"; "" if it has the type of `like`."""
    if isinstance(like, bool):
        return "" if isinstance(value, bool) else "true or false"
    if not isinstance(like, (int, float)):
        return "" if isinstance(value, str) else "a text"
    if is_positive:
        return "" if _is_number(value) and value > 0 else "a number above 0"
    if not _is_number(value):
        return "a number"
    return "a whole number" if isinstance(like, int) and value != int(value) else ""


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def settings_of(
    home: StudiedHome, values: Mapping[str, Value], choice: SensorChoice = ALL_SENSORS
) -> Settings:
    """Return the values that a run sets, by sensor and parameter.

    `values` has the run's value for each key, such as "PIR*.hold_time". If two keys set the same
    parameter, the later one counts. Sensors that are not in the value of the key `sensors`, or not
    in `choice`, are disabled.
    """
    found: Settings = {}
    on = values.get(SENSORS)
    if isinstance(on, tuple):
        present = {name for pattern in on for name in home.fitting(pattern)}
        for name in home.kinds:
            found[name] = {"enabled": name in present}
    for key, value in values.items():
        if key in WITHOUT_DOT:
            continue
        pattern, _, parameter = key.rpartition(".")
        for name in home.fitting(pattern):
            kind = KINDS[home.kinds[name]]
            found.setdefault(name, {}).update(_values_of(kind, parameter, value))
    for name in sorted(home.kinds.keys() - choice.of(home.kinds)):
        found.setdefault(name, {})["enabled"] = False
    return found


def _values_of(kind: Kind, parameter: str, value: Value) -> dict[str, Any]:
    """Return the parameters, with their values, that one key sets; a preset sets several."""
    if parameter == PRESET:
        preset = next(p for p in kind.presets if p.identifier == value)
        return {**preset.values, **({"update_rate": preset.rate} if preset.rate else {})}
    if parameter in specs(kind.parameters) and _is_number(value):
        default = defaults(kind.parameters)[parameter]
        return {parameter: type(default)(value)}
    return {parameter: value}


def shared_settings(home: StudiedHome, settings: Mapping[str, Mapping[str, Any]]) -> Settings:
    """Return the settings of a run that can affect the readings of other sensors.

    These are the poses of sensors, because housings block rays, and all settings of sensors that
    are not in `home.independent`.
    """
    found = {
        name: {
            parameter: value
            for parameter, value in values.items()
            if name not in home.independent or (parameter in POSE and value)
        }
        for name, values in settings.items()
    }
    return {name: values for name, values in found.items() if values}
