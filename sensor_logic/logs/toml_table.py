# SPDX-License-Identifier: GPL-3.0-or-later
"""Read values from the tables of a TOML file; errors name the line in the file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from datetime import date, datetime
from difflib import get_close_matches
from typing import Any, TypeVar

from .error import InputError, explained
from .lines import KeyPath, line_of, read_toml

T = TypeVar("T")
_MISSING = object()


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return a hint for an unknown name: the most similar known name, or else all known names."""
    names = sorted(known)
    near = get_close_matches(name, names, 1)
    if near:
        return f"did you mean {near[0]!r}?"
    return f"known: {', '.join(map(repr, names[:20]))}" if names else "there is none"


def read_table(content: str, name: str) -> TomlTable:
    """Return the top-level table of a TOML text. Raise InputError if the text is not valid.

    `name` is the name of the file, for errors.
    """
    values, lines = read_toml(content, name)
    return TomlTable(name, lines, values)


class TomlTable:
    """A table in the TOML file `name`.

    Attributes
    ----------
    values
        The values of the table by key.
    lines
        The line of each value in the file, by its path of keys and indices.
    path
        The path of this table.
    """

    def __init__(
        self, name: str, lines: dict[KeyPath, int], values: Any, path: KeyPath = ()
    ) -> None:
        self.name, self.lines, self.path = name, lines, path
        if not isinstance(values, Mapping):
            raise self.error("this must be a table, { … }")
        self.values = values
        self._taken: set[str] = set()

    def where(self, *keys: str | int) -> str:
        """Return the file and the line of this table, or of the value at the path `keys` in it."""
        return f"{self.name}, line {line_of(self.lines, (*self.path, *keys))}"

    def below(self, values: Any, *keys: str | int) -> TomlTable:
        """Return the `TomlTable` with `values`, which are at the path `keys` inside this table."""
        return TomlTable(self.name, self.lines, values, (*self.path, *keys))

    def error(self, text: str, key: str | None = None) -> InputError:
        """Return an error that names the line of this table, or of the value of `key` in it."""
        return InputError(f"{self.where(*([] if key is None else [key]))}: {text}")

    def take(self, key: str, read: Callable[[Any], T], default: Any = _MISSING) -> T:
        """Return `read(value)` for the value of `key`; `default` if the table has no such key.

        Raise InputError if `read` raises a ValueError, or if the key is missing and there is no
        default.
        """
        self._taken.add(key)
        if key not in self.values:
            if default is _MISSING:
                raise self.error(f"{key!r} is missing")
            result: T = default
            return result
        with explained(f"{self.where(key)}: {key}", ValueError):
            return read(self.values[key])

    def one_of(self, key: str, known: Iterable[str], default: Any = _MISSING) -> str:
        """Return the value of `key`, which must be one of the `known` names.

        Raise InputError if it is not, or if the key is missing and there is no default.
        """
        names = set(known)

        def read(value: Any) -> str:
            if value not in names:
                raise ValueError(f"{value!r} is unknown; {suggestion(str(value), names)}")
            return str(value)

        return self.take(key, read, default)

    def tables(self, key: str) -> Iterator[TomlTable]:
        """Yield the tables in the array that is the value of `key`."""
        found = self.take(key, _array, [])
        for number, values in enumerate(found):
            yield self.below(values, key, number)

    def named(self, key: str) -> Iterator[tuple[str, TomlTable]]:
        """Yield the name and the `TomlTable` of each sub-table of the table `key`."""
        self._taken.add(key)
        below = self.below(self.values.get(key, {}), key)
        for name, values in below.values.items():
            yield name, below.below(values, name)

    def finish(self) -> None:
        """Raise InputError if the table has a key that was not read by any other method."""
        for key in self.values:
            if key not in self._taken:
                hint = suggestion(key, self._taken)
                raise self.error(f"the key {key!r} is unknown here; {hint}", key)


def _array(value: Any) -> list[Any]:
    if not isinstance(value, list):
        raise ValueError("this must be an array, [ … ]")
    return value


def text(value: Any) -> str:
    """Return `value` if it is a text and not blank, else raise ValueError."""
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f"{value!r} is no text")
    return value


def texts(value: Any) -> tuple[str, ...]:
    """Return `value` as a tuple if it is a list of texts, else raise ValueError."""
    return tuple(text(item) for item in _array(value))


def flag(value: Any) -> bool:
    """Return `value` if it is true or false, else raise ValueError."""
    if not isinstance(value, bool):
        raise ValueError(f"{value!r} is neither true nor false")
    return value


def calendar_date(value: Any) -> date:
    """Return `value` if it is a date without a time, else raise ValueError."""
    if isinstance(value, datetime) or not isinstance(value, date):
        raise ValueError(f"{value!r} is not a date such as 2026-03-02")
    return value


def number(low: float, high: float) -> Callable[[Any], float]:
    """Return a function that returns its argument if it is a number from `low` to `high`.

    For any other argument, the function raises ValueError.
    """

    def read(value: Any) -> float:
        if (
            isinstance(value, bool)
            or not isinstance(value, int | float)
            or not low <= value <= high
        ):
            raise ValueError(f"{value!r} is not a number from {low:g} to {high:g}")
        return float(value)

    return read
