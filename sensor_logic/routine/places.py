# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads TOML, and finds the line of a value, which Python's reader does not tell."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from typing import Any

_HEADER = re.compile(r"^\s*(\[\[?)\s*([^\]#]+?)\s*\]\]?")


_AT = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)$")


def parse_toml(text: str, name: str) -> dict[str, Any]:
    """Return the values in the text of the file `name`. Raises ValueError, which names the line."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        at = _AT.search(str(error))
        line = int(at.group(1) or text.count("\n") + 1) if at else 1
        raise ValueError(f"{name}, line {line}: {_AT.sub('', str(error))}") from None
    except RecursionError:
        raise ValueError(f"{name} is nested too deeply") from None


def line_of(text: str, path: Sequence[str | int]) -> int:
    """The line, from 1, of the value at a path such as ("plan", 1, "entries", 0, "at"); of what
    holds it where it is not found itself."""
    lines = text.splitlines()
    table, first, depth = _table(lines, path)
    if depth == len(path):
        return table + 1
    for number in range(first, len(lines)):
        if _HEADER.match(lines[number]) and not lines[number].lstrip().startswith("[{"):
            break
        named = _names(lines[number], path[depth:])
        if named:
            return number + 1 + _rows_into(lines[number:], path[depth + named :])
    return table + 1


def _names(line: str, path: Sequence[str | int]) -> int:
    """How much of the path the key of a line takes; 0 where it is another one."""
    for count in range(len(path), 0, -1):
        key = r"\s*\.\s*".join(rf"[\"']?{re.escape(str(name))}[\"']?" for name in path[:count])
        # A table may be given by its keys alone: `sensors.of = …`.
        within = r"(\s*\.[^=]+)?" if count == len(path) else ""
        if re.match(rf"\s*{key}{within}\s*=", line):
            return count
    return 0


def _table(lines: Sequence[str], path: Sequence[str | int]) -> tuple[int, int, int]:
    """The header of the longest table that the path begins with: its line, the one after it, and
    how much of the path it takes."""
    found = 0, 0, 0
    counts: dict[str, int] = {}
    for number, line in enumerate(lines):
        header = _HEADER.match(line)
        if header is None:
            continue
        names = [name.strip().strip("\"'") for name in header.group(2).split(".")]
        if header.group(1) == "[[":
            counts[".".join(names)] = counts.get(".".join(names), -1) + 1
        taken: list[str | int] = []
        for depth, name in enumerate(names, 1):
            taken.append(name)
            if (key := ".".join(names[:depth])) in counts:
                taken.append(counts[key])
        if len(taken) > found[2] and list(path[: len(taken)]) == taken:
            found = number, number + 1, len(taken)
    return found


def _rows_into(lines: Sequence[str], path: Sequence[str | int]) -> int:
    """How many lines below the first the entry of an array begins that the path goes on with."""
    if not path or not isinstance(path[0], int):
        return 0
    wanted, depth, count = path[0], 0, 0
    for number, line in enumerate(lines):
        quoted = re.sub(r"\"[^\"]*\"|'[^']*'", "_", line).partition("#")[0]
        if number == 0:
            quoted = quoted.partition("=")[2]
        for sign in quoted:
            if sign in "[{":
                depth += 1
            elif sign in "]}":
                depth -= 1
                if depth == 0:
                    return 0
            elif sign == "," and depth == 1:
                count += 1
                continue
            if not sign.isspace() and sign != "[" and depth >= 1 and count == wanted:
                return number
    return 0
