# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads JSON together with the line of each value."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

JsonPath = tuple[str | int, ...]
TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[\[\]{}:,]|[^\s\[\]{}:,"]+')
NO_NUMBERS = ("NaN", "Infinity", "-Infinity")


class LineError(ValueError):
    """A problem in a text, and its line."""

    def __init__(self, line: int, text: str) -> None:
        super().__init__(text)
        self.line = line


def read_json(text: str) -> tuple[Any, dict[JsonPath, int]]:
    """The value in a JSON text, and the line (from 1) of each value in it by its path: the keys
    and indices that lead to it. Raises LineError, also for a key that is given twice."""
    try:
        value = json.loads(text)
        lines: dict[JsonPath, int] = {}
        _note_lines(_tokens(text), (), lines)
    except json.JSONDecodeError as error:
        raise LineError(error.lineno, f"no JSON at column {error.colno}: {error.msg}") from None
    except RecursionError:
        raise LineError(1, "its brackets are nested too deep") from None
    except ValueError as error:
        if isinstance(error, LineError):
            raise
        # Python reads no whole number of more than 4300 digits.
        raise LineError(1, "it has a number of too many digits") from None
    return value, lines


def _tokens(text: str) -> Iterator[tuple[str, int]]:
    line, at = 1, 0
    for token in TOKEN.finditer(text):
        line += text.count("\n", at, token.start())
        at = token.start()
        yield token.group(), line


def _note_lines(
    tokens: Iterator[tuple[str, int]], path: JsonPath, lines: dict[JsonPath, int]
) -> str:
    """Notes the line of the next value and of the values in it; returns its first token. The text
    must be valid JSON."""
    token, lines[path] = next(tokens)
    if token in NO_NUMBERS:
        raise LineError(lines[path], f"{token} is no number")
    if token == "[":
        index = 0
        while _note_lines(tokens, (*path, index), lines) != "]":
            index += 1
            if next(tokens)[0] == "]":
                return token
        del lines[*path, index]
    elif token == "{":
        for key, line in tokens:
            if key == "}":
                break
            name = json.loads(key)
            if (*path, name) in lines:
                raise LineError(line, f"'{name}' is given twice")
            next(tokens)
            _note_lines(tokens, (*path, name), lines)
            if next(tokens)[0] == "}":
                break
    return token
