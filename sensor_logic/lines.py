# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads JSON and TOML together with the line of each value, which Python's readers do not tell."""

from __future__ import annotations

import json
import re
import tomllib
from bisect import bisect
from typing import Any

from .error import InputError

KeyPath = tuple[str | int, ...]
BLANK = re.compile(r"(?:\s|#[^\n]*)*")
STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|' + r"'''.*?'{3,5}|" + r'"(?:\\.|[^"\\])*"|' + r"'[^']*'", re.DOTALL
)
NAME = re.compile(rf"{STRING.pattern}|[\w-]+", re.DOTALL)
VALUE = re.compile(rf"{STRING.pattern}|[\[{{]|[^,\]}}\n#]+", re.DOTALL)
# Where Python's reader says that TOML is wrong.
TOML_AT = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)$")
NO_NUMBERS = ("NaN", "Infinity", "-Infinity")


class LineError(InputError):
    """A problem in a text, and its line."""

    def __init__(self, line: int, text: str) -> None:
        super().__init__(text)
        self.line = line


def read_json(text: str) -> tuple[Any, dict[KeyPath, int]]:
    """The value in a JSON text, and the line (from 1) of each value in it by its path: the keys
    and indices that lead to it. Raises LineError, also for a key that is given twice."""
    try:
        value = json.loads(text)
        lines = _Lines(text)
        lines.value(())
    except json.JSONDecodeError as error:
        raise LineError(error.lineno, f"no JSON at column {error.colno}: {error.msg}") from None
    except RecursionError:
        raise LineError(1, "its brackets are nested too deep") from None
    except ValueError as error:
        if isinstance(error, LineError):
            raise
        # Python reads no whole number of more than 4300 digits.
        raise LineError(1, "it has a number of too many digits") from None
    return value, lines.found


def read_toml(text: str) -> tuple[dict[str, Any], dict[KeyPath, int]]:
    """The table in a TOML text, and the line (from 1) of each value in it, as `read_json`. Raises
    LineError."""
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        at = TOML_AT.search(str(error))
        line = int(at.group(1) or text.count("\n") + 1) if at else 1
        raise LineError(line, TOML_AT.sub("", str(error))) from None
    except RecursionError:
        raise LineError(1, "its brackets are nested too deep") from None
    except ValueError as error:
        # Python reads no whole number of more than 4300 digits.
        raise LineError(1, str(error)) from None
    lines = _Lines(text)
    lines.document()
    return values, lines.found


def line_of(lines: dict[KeyPath, int], path: KeyPath) -> int:
    """The line of the value at a path such as ("plan", 1, "entries", 0, "at"); of what holds it
    where it is not found itself."""
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path, 1)


class _Lines:
    """Walks through a valid text and notes in `found` at which line each value begins."""

    def __init__(self, text: str) -> None:
        self.found: dict[KeyPath, int] = {}
        self._text, self._at, self._line = text, 0, 1
        self._ends = [end.start() for end in re.finditer("\n", text)]

    def value(self, path: KeyPath) -> None:
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
            raise LineError(self._line, f"{token.strip()} is no number")

    def document(self) -> None:
        """Notes the lines of a TOML text."""
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
        """Notes the lines of a key and its value, and of the tables that a dotted key makes."""
        names = self._names()
        line = self._line
        self._next("[:=]")
        for depth in range(1, len(names)):
            self.found.setdefault((*table, *names[:depth]), line)
        if (*table, *names) in self.found:
            raise LineError(line, f"'{names[-1]}' is given twice")
        self.value((*table, *names))

    def _names(self) -> list[str]:
        """The names of a key: two of `a."b.c"`."""
        names = [_plain(self._next(NAME))]
        while self._next(r"\."):
            names.append(_plain(self._next(NAME)))
        return names

    def _start(self) -> int:
        """Where the text goes on after blanks and comments."""
        blank = BLANK.match(self._text, self._at)
        return blank.end() if blank else self._at

    def _next(self, pattern: str | re.Pattern[str]) -> str:
        """Passes what matches the pattern; "" where the text goes on with something else."""
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
            pass  # An escape that TOML alone has.
    return name.strip("\"'")
