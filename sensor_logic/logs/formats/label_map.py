# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a map of names: what a log's activities and sensors are called elsewhere.

A TOML file has a table `[labels]`, with lines such as `"Spare_Time/TV" = "Watching television"`,
and a table `[sensors]`, with lines such as `"Seat Living" = "Pad sofa"`. Either can be missing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..files import read_text
from ..toml_table import TomlTable, read_table, text


@dataclass(frozen=True)
class NameMap:
    """Other names of a log's activities and sensors, by their names in the log."""

    labels: Mapping[str, str] = field(default_factory=dict)
    sensors: Mapping[str, str] = field(default_factory=dict)


def read_map(path: Path) -> NameMap:
    """Read a map of names. Raise InputError if it is not valid, or OSError."""
    top = read_table(read_text(path), str(path))
    found = NameMap(_names(top, "labels"), _names(top, "sensors"))
    top.finish()
    if not found.labels and not found.sensors:
        raise top.error("give a table [labels] or [sensors], with lines such as Bed = 'Pad bed'")
    return found


def _names(top: TomlTable, key: str) -> dict[str, str]:
    table = top.below(top.take(key, dict, {}), key)
    return {name: table.take(name, text) for name in table.values}
