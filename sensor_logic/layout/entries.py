# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a layout, and check what can be checked without the blend file of the home.

A layout is a list of sensors, or an object with such a list under the key `sensors`. A key without
a value keeps the value of an existing sensor, and gives a new sensor the default. `others_enabled`
switches on or off all sensors of the home that are not in the layout. `marks` say what residents do
at objects.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ..kind import Kind
from ..kinds import KINDS
from ..logs.error import InputError
from ..logs.files import read_text
from ..logs.lines import KeyPath, read_json
from ..logs.wording import hint
from ..parameters import FormerChoice, Spec, defaults, former_choice, specs

# The key that switches on or off all sensors that the layout does not name.
OTHERS = "others_enabled"
# The key of the marks of objects, by the names of the objects.
MARKS = "marks"
# The largest numbers that Blender stores: in single precision, and as an integer.
LARGEST = 3.4028234e38
LARGEST_WHOLE = 2**31 - 1


def _name(value: Any) -> str:
    if not isinstance(value, str) or not value:
        return "must be a text that is not empty"
    return _text(value)


def _text(value: Any) -> str:
    if not isinstance(value, str):
        return "must be a text"
    try:
        value.encode()
    except UnicodeEncodeError:
        return "has an incomplete character (a lone surrogate)"
    return ""


def _no_or_name(value: Any) -> str:
    return "" if value is None else _name(value)


def _yes_or_no(value: Any) -> str:
    return "" if isinstance(value, bool) else "must be true or false"


def _number(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "must be a number"
    return "" if abs(value) <= LARGEST else "is too large a number"


def _whole(value: Any) -> str:
    if problem := _number(value):
        return problem
    if value != int(value):
        return "must be a whole number"
    return "" if abs(value) <= LARGEST_WHOLE else "is too large a number"


def _vector(value: Any) -> str:
    if not isinstance(value, list) or len(value) != 3:
        return "must be a list of three numbers, x, y and z"
    return next(filter(None, map(_number, value)), "")


def _direction(value: Any) -> str:
    return _vector(value) or (
        "" if any(value) else "is not a direction: at least one of x, y and z must not be 0"
    )


def _bounds(value: Any) -> str:
    if value is None:
        return ""
    if not isinstance(value, list) or len(value) != 2 or any(map(_vector, value)):
        return "must be null, or a list of two corners, each a list of x, y and z"
    sound = all(low <= high for low, high in zip(*value, strict=True))
    return "" if sound else "must have the corner with the smallest x, y and z first"


def _kind(value: Any) -> str:
    if isinstance(value, str) and value in KINDS:
        return ""
    return f"is unknown: {hint(str(value), KINDS)}"


def _object(value: Any) -> str:
    return "" if isinstance(value, dict) else "must be an object in { }"


def _anything(value: Any) -> str:
    return ""


def _empty(value: Any) -> str:
    """Return the problem of the description of an empty ("" if valid)."""
    if not isinstance(value, dict):
        return f'{_object(value)}, such as {{"location": [0, 0, 1]}}'
    for key, given in value.items():
        if key not in EMPTY_KEYS:
            return f"has the unknown key '{key}': {hint(key, EMPTY_KEYS)}"
        if problem := KEYS[key](given):
            return f"has a wrong {key}: it {problem}"
    if "relative_to" in value and "location" not in value:
        return "has relative_to without a location"
    return ""


def _lines(value: Any) -> str:
    if not isinstance(value, list):
        return "must be a list of its lines"
    problem = next(filter(None, map(_text, value)), "")
    return f"has a line that {problem}" if problem else ""


def _by_name(problem_of: Callable[[Any], str]) -> Callable[[Any], str]:
    """Return a function for the problem of an object in { } whose values `problem_of` checks."""

    def problem_of_all(value: Any) -> str:
        if not isinstance(value, dict):
            return "must be an object in { } with a name for each"
        for name, one in value.items():
            if problem := _name(name):
                return f"has a name that {problem}"
            if problem := problem_of(one):
                return f"'{name}' {problem}"
        return ""

    return problem_of_all


# The keys of a sensor, each with a function that returns the problem of a value ("" if valid).
KEYS: dict[str, Callable[[Any], str]] = {
    "name": _name,
    "kind": _kind,
    "room": _text,
    "enabled": _yes_or_no,
    "update_rate": _number,
    "location": _vector,
    "rotation": _vector,
    "look": _direction,
    "relative_to": _name,
    "parent": _no_or_name,
    "collection": _no_or_name,
    "bounds": _bounds,
    "preset": _text,
    "parameters": _object,
    "empties": _by_name(_empty),
    "texts": _by_name(_lines),
    "library": _text,
    # Written by `list --json` and ignored here.
    "simulated": _anything,
    "reading": _anything,
    "units": _anything,
}
# The keys of an empty, such as the magnet of a door contact.
EMPTY_KEYS = ("location", "relative_to", "parent", "collection")


@dataclass(frozen=True)
class LayoutEntry:
    """A sensor in a layout.

    Attributes
    ----------
    file
        The path of the layout file, as the user gave it.
    values
        The values of the sensor's keys, which are in KEYS.
    lines
        The line of each value in the file, by the path of keys that leads to the value.
    """

    file: str
    values: Mapping[str, Any]
    lines: Mapping[KeyPath, int]

    @property
    def name(self) -> str:
        """The name of the sensor."""
        return str(self.values["name"])

    def where(self, *key: str) -> str:
        """Return the file, the line of the value at the path `key`, and the sensor's name."""
        line, name = self.lines.get(key, self.lines[()]), self.values.get("name")
        return f"{self.file}, line {line}" + (f": '{name}'" if isinstance(name, str) else "")

    def error(self, text: str, *key: str) -> InputError:
        """Return an error whose text names the line of the value at the path `key`."""
        return InputError(f"{self.where(*key)}: {text}")

    @property
    def empties(self) -> list[LayoutEntry]:
        """The empties that the sensor refers to, as entries without a solid."""
        return [
            self.inside({"name": name, "bounds": None, **values}, "empties", name)
            for name, values in self.values.get("empties", {}).items()
        ]

    @property
    def texts(self) -> dict[str, str]:
        """The texts that the sensor refers to, by name."""
        given = self.values.get("texts", {})
        return {name: "".join(f"{line}\n" for line in lines) for name, lines in given.items()}

    def inside(self, values: Mapping[str, Any], *key: str) -> LayoutEntry:
        """Return an entry with the lines below the path `key` of this entry."""
        depth = len(key)
        lines = {path[depth:]: line for path, line in self.lines.items() if path[:depth] == key}
        return LayoutEntry(self.file, values, lines)

    def settings(self, kind: Kind) -> dict[str, Any]:
        """Return the parameters that the keys `preset` and `parameters` set, by name.

        Values have the types of the kind's parameters. Raise InputError for an unknown preset or
        parameter, or for an invalid value.
        """
        found: dict[str, Any] = {}
        preset = self.values.get("preset")
        if preset is not None:
            known = {preset.identifier: preset for preset in kind.presets}
            if preset not in known:
                raise self.error(f"preset '{preset}' is unknown: {hint(preset, known)}", "preset")
            found |= known[preset].values
        types, known_specs = defaults(kind.parameters), specs(kind.parameters)
        for name, value in self.values.get("parameters", {}).items():
            if name not in known_specs:
                text = f"{kind.identifier} has no parameter '{name}': {hint(name, known_specs)}"
                raise self.error(text, "parameters", name)
            former = former_choice(known_specs[name], value)
            value = value if former is None else former.now
            problem = _type_problem(types[name], known_specs[name], value)
            if problem:
                raise self.error(f"{name} {problem}", "parameters", name)
            found[name] = type(types[name])(value) if _is_number(types[name]) else value
        return found

    def former_choices(self, kind: Kind) -> list[tuple[str, str, FormerChoice]]:
        """Return the removed choices in `parameters`, as arguments of `former_text`.

        `settings` replaces these choices.
        """
        known, given = specs(kind.parameters), self.values.get("parameters", {})
        found = ((name, former_choice(known[name], value)) for name, value in given.items())
        return [(self.name, name, former) for name, former in found if former is not None]


def _is_number(default: Any) -> bool:
    return isinstance(default, (int, float)) and not isinstance(default, bool)


def _type_problem(default: Any, spec: Spec, value: Any) -> str:
    """Return why a value is not valid for this parameter; "" if it is valid."""
    if spec.pointer:
        return _no_or_name(value)
    if spec.choices:
        known = [choice.identifier for choice in spec.choices]
        return "" if value in known else f"is {value!r}: {hint(str(value), known)}"
    if isinstance(default, bool):
        return _yes_or_no(value)
    if isinstance(default, int):
        return _whole(value)
    return _number(value) if isinstance(default, float) else _text(value)


@dataclass(frozen=True)
class Layout:
    """The content of a layout.

    Attributes
    ----------
    sensors
        An entry for each sensor.
    others
        An entry without a name, for all sensors of the home that are not in `sensors`. If it is
        None, these sensors stay as they are.
    marks
        An entry for each marked object, with its name and the properties of its mark. None if the
        layout says nothing of marks.
    """

    sensors: list[LayoutEntry]
    others: LayoutEntry | None = None
    marks: list[LayoutEntry] | None = None


def read_layout(path: Path) -> Layout:
    """Read a layout file, and check each sensor on its own. Raise InputError if it is not valid."""
    name = str(path)
    found, lines = read_json(read_text(path), name)
    top: KeyPath = ()
    others = marks = None
    if isinstance(found, dict):
        unknown = [key for key in found if key not in ("$schema", "sensors", OTHERS, MARKS)]
        if unknown or "sensors" not in found:
            line = lines[tuple(unknown[:1])]
            problem = f"'{unknown[0]}' is unknown" if unknown else "'sensors' is missing"
            raise InputError(
                f"{name}, line {line}: {problem}: give a list of sensors, or "
                '{"$schema": …, "sensors": [ … ]}'
            )
        if OTHERS in found:
            others = LayoutEntry(name, {"enabled": found[OTHERS]}, {(): lines[(OTHERS,)]})
            if problem := _yes_or_no(found[OTHERS]):
                raise others.error(f"{OTHERS} {problem}")
        if MARKS in found:
            marks = _marks(LayoutEntry(name, found, lines))
        found, top = found["sensors"], ("sensors",)
    if not isinstance(found, list):
        raise InputError(f"{name}, line {lines[top]}: sensors must be a list in [ ]")
    depth = len(top)
    entry_lines: list[dict[KeyPath, int]] = [{} for _ in found]
    for key, line in lines.items():
        if key[:depth] == top and len(key) > depth:
            entry_lines[int(key[depth])][key[depth + 1 :]] = line
    entries = [
        _check_entry(LayoutEntry(name, *pair)) for pair in zip(found, entry_lines, strict=True)
    ]
    _check_names(entries)
    return Layout(entries, others, marks)


def _marks(top: LayoutEntry) -> list[LayoutEntry]:
    """Return the marks of a layout, given as the entry of the whole file."""
    problem = _by_name(_object)(top.values[MARKS])
    if problem:
        raise InputError(f"{top.file}, line {top.lines[(MARKS,)]}: {MARKS} {problem}")
    return [
        top.inside({**values, "name": name}, MARKS, name)
        for name, values in top.values[MARKS].items()
    ]


def _check_entry(entry: LayoutEntry) -> LayoutEntry:
    """Return the entry, or raise InputError if it is not valid."""
    if not isinstance(entry.values, dict):
        raise LayoutEntry(entry.file, {}, entry.lines).error("a sensor must be an object in { }")
    for key, value in entry.values.items():
        if key not in KEYS:
            raise entry.error(f"'{key}' is unknown: {_key_hint(key, entry.values)}", key)
        problem = KEYS[key](value)
        if problem:
            shown = f" '{value}'" if key == "kind" else ""
            raise entry.error(f"{key}{shown} {problem}", key)
    if "name" not in entry.values:
        raise entry.error("a sensor must have a name")
    if "look" in entry.values and "rotation" in entry.values:
        raise entry.error("look and rotation both set its rotation: give one of them", "look")
    if "relative_to" in entry.values and not entry.values.keys() & {"location", "rotation", "look"}:
        raise entry.error("relative_to needs a location, rotation or look", "relative_to")
    kind = entry.values.get("kind")
    if kind is not None:
        entry.settings(KINDS[kind])
    return entry


def _key_hint(key: str, values: Mapping[str, Any]) -> str:
    """Return a hint for an unknown key of a sensor: where parameters belong, or a similar key."""
    kinds = [KINDS[values["kind"]]] if values.get("kind") in KINDS else list(KINDS.values())
    known = {name: None for kind in kinds for name in specs(kind.parameters)}
    near = [key] if key in known else get_close_matches(key, known, 1)
    if near and not get_close_matches(key, KEYS, 1):
        return f'parameters belong under "parameters": {{"{near[0]}": … }}'
    return hint(key, KEYS)


def _check_names(entries: Iterable[LayoutEntry]) -> None:
    """Raise InputError if two entries name the same sensor."""
    seen: dict[tuple[str, str], LayoutEntry] = {}
    entries = list(entries)
    for entry in entries:
        key = entry.name, entry.values.get("library", "")
        if key in seen:
            raise entry.error(
                f"line {seen[key].lines[()]} has the same sensor: remove one of the "
                "two, or give it another name"
            )
        seen[key] = entry
    made: dict[str, tuple[LayoutEntry, Any]] = {}
    for entry in entries:
        texts = ((name, entry, "texts", lines) for name, lines in entry.texts.items())
        empties = ((one.name, one, "empties", one.values) for one in entry.empties)
        for name, where, key_of, value in (*texts, *empties):
            other = made.setdefault(f"{key_of}/{name}", (where, value))[1]
            if other != value:
                raise where.error(f"the layout describes '{name}' twice, in two ways", key_of, name)
            if (name, "") in seen and key_of == "empties":
                raise where.error("a sensor of the layout has this name: give the empty another")
