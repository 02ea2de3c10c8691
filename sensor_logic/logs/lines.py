# SPDX-License-Identifier: GPL-3.0-or-later
"""Read JSON and TOML, and find the line of each value, which Python's readers do not report."""

from __future__ import annotations

import json
import re
import tomllib
from bisect import bisect
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .error import InputError

KeyPath = tuple[str | int, ...]
BLANK = re.compile(r"(?:\s|#[^\n]*)*")
STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|' + r"'''.*?'{3,5}|" + r'"(?:\\.|[^"\\])*"|' + r"'[^']*'", re.DOTALL
)
NAME = re.compile(rf"{STRING.pattern}|[\w-]+", re.DOTALL)
VALUE = re.compile(rf"{STRING.pattern}|[\[{{]|[^,\]}}\n#]+", re.DOTALL)
# The position in the text of a TOMLDecodeError.
TOML_AT = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)$")
NO_NUMBERS = ("NaN", "Infinity", "-Infinity")


def read_json(text: str, name: str) -> tuple[Any, dict[KeyPath, int]]:
    """Return the value of a JSON text, and the line (from 1) of each value inside it, by path.

    A path has the keys and indices that lead to a value. `name` is the name of the file, for
    errors. Raise InputError if the text is no valid JSON or has a key twice in one object.
    """
    with _at_line(text, name):
        value = json.loads(text)
        lines = _Lines(text, name)
        lines.value(())
    return value, lines.found


def read_toml(text: str, name: str) -> tuple[dict[str, Any], dict[KeyPath, int]]:
    """Return the table of a TOML text, and the line (from 1) of each value inside it, by path.

    A path has the keys and indices that lead to a value. `name` is the name of the file, for
    errors. Raise InputError if the text is no valid TOML.
    """
    with _at_line(text, name):
        values = tomllib.loads(text)
        lines = _Lines(text, name)
        lines.document()
    return values, lines.found


@contextmanager
def _at_line(text: str, name: str) -> Iterator[None]:
    """Context manager: raise parse errors as InputError, with the file's name and the line."""
    line = 1
    try:
        yield
        return
    except json.JSONDecodeError as error:
        line, why = error.lineno, f"not valid JSON at column {error.colno}: {error.msg}"
    except tomllib.TOMLDecodeError as error:
        at = TOML_AT.search(str(error))
        line = int(at.group(1) or text.count("\n") + 1) if at else 1
        why = TOML_AT.sub("", str(error))
    except RecursionError:
        why = "its brackets are nested too deeply"
    except ValueError:
        # Python rejects a whole number of more than 4300 digits.
        why = "a number in it has too many digits"
    raise _error(name, line, why)


def _error(name: str, line: int, why: str) -> InputError:
    return InputError(f"{name}, line {line}: {why}")


def line_of(lines: dict[KeyPath, int], path: KeyPath) -> int:
    """Return the line of the value at a path, such as ("plan", 1, "entries", 0, "at").

    If there is no such value, return the line of the innermost table or array on the path.
    """
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path, 1)


class _Lines:
    """A parser of a valid text that stores in `found` the line at which each value begins."""

    def __init__(self, text: str, name: str) -> None:
        self.found: dict[KeyPath, int] = {}
        self._name = name
        self._text, self._at, self._line = text, 0, 1
        self._ends = [end.start() for end in re.finditer("\n", text)]

    def value(self, path: KeyPath) -> None:
        """Parse the next value, at `path`, and store the lines of all values in it."""
        token = self._next(VALUE)
        assert token, "the text is valid"
        self.found[path] = self._line
        if token == "[":
            index = 0
            while not self._next("]"):
                self.value((*path, index))
                self._next(",")
                index += 1
        elif token == "{":
            while not self._next("}"):
                self._pair(path)
                self._next(",")
        elif token.strip() in NO_NUMBERS:
            raise _error(self._name, self._line, f"{token.strip()} is no number")

    def document(self) -> None:
        """Parse a TOML text, and store the lines of all values in it."""
        counts: dict[KeyPath, int] = {}
        path: KeyPath = ()
        while self._start() < len(self._text):
            brackets = self._next(r"\[\[?")
            if not brackets:
                self._pair(path)
                continue
            path = ()
            names = self._names()
            for depth, name in enumerate(names, 1):
                path = (*path, name)
                self.found.setdefault(path, self._line)
                if brackets == "[[" and depth == len(names):
                    counts[path] = counts.get(path, -1) + 1
                if path in counts:
                    path = (*path, counts[path])
            self.found[path] = self._line
            self._next(r"\]\]?")

    def _pair(self, table: KeyPath) -> None:
        """Parse a key and its value in `table`, and store their lines.

        A key with dots also makes tables, whose lines are stored too.
        """
        names = self._names()
        line = self._line
        self._next("[:=]")
        for depth in range(1, len(names)):
            self.found.setdefault((*table, *names[:depth]), line)
        if (*table, *names) in self.found:
            raise _error(self._name, line, f"'{names[-1]}' is given twice")
        self.value((*table, *names))

    def _names(self) -> list[str]:
        """Return the parts of a key: `a."b.c"` has two parts."""
        names = [_plain(self._next(NAME))]
        while self._next(r"\."):
            names.append(_plain(self._next(NAME)))
        return names

    def _start(self) -> int:
        """Return the position of the next character that is not blank and not in a comment."""
        blank = BLANK.match(self._text, self._at)
        return blank.end() if blank else self._at

    def _next(self, pattern: str | re.Pattern[str]) -> str:
        """Return the next text if it matches `pattern`, and move behind it; "" if not."""
        start = self._start()
        found = re.compile(pattern).match(self._text, start)
        if found is None:
            return ""
        self._at, self._line = found.end(), bisect(self._ends, start) + 1
        return found.group()


def _plain(name: str) -> str:
    if name.startswith('"'):
        try:
            return str(json.loads(name))
        except ValueError:
            pass  # An escape sequence of TOML that JSON does not have.
    return name.strip("\"'")
