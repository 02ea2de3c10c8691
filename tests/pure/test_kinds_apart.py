# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared code names no kind of sensor: what a kind is stands in its packages alone."""

import re
from pathlib import Path

import pytest
from angen_sensors.sensor_logic.kinds import KINDS

ROOT = Path(__file__).resolve().parents[2]
IDENTIFIERS, ATTRIBUTES = "|".join(KINDS), "|".join(kind.attribute for kind in KINDS.values())
WORDS = re.compile(
    rf'"(?:{IDENTIFIERS})"'
    rf"|\b(?:settings|angen_sensor|source|target)\.(?:{ATTRIBUTES})\b"
    rf"|kinds\.(?:{ATTRIBUTES})\b"
)
# Blender has these words too: of types of objects and datablocks, and of properties.
BLENDERS = re.compile(
    r'type (?:==|!=|in|not in) [^"\n]*"LIGHT"|"LIGHT", "MATERIAL"|LIGHTLESS \| \{"LIGHT"\}'
    r'|"m": "DISTANCE"|subtype="DISTANCE"|"LIGHT", \d'
)
# Why a file names a kind after all.
ALLOWED = {
    "sensor_logic/coverage/detectors.py": "coverage maps are of motion detectors alone",
    "operators/door.py": "fits a door with a switch, in a fork made for its flag",
    "operators/warmth.py": "writes the lens of a pyroelectric detector into a text",
}


def named(path):
    """The lines of a file that name a kind."""
    text = BLENDERS.sub("", path.read_text(encoding="utf-8"))
    return [line.strip() for line in text.splitlines() if WORDS.search(line)]


def shared():
    for folder in ("angen_addon", "operators", "panels", "sensor_logic"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            name = path.relative_to(ROOT)
            if "kinds" not in name.parts:
                yield name.as_posix(), path


def test_shared_code_names_no_kind():
    found = {name: lines for name, path in shared() if (lines := named(path))}
    assert {name: found[name] for name in found.keys() - ALLOWED.keys()} == {}


@pytest.mark.parametrize("name", ALLOWED)
def test_what_is_allowed_is_needed(name):
    assert named(ROOT / name), f"{name} names no kind any more: {ALLOWED[name]}"
