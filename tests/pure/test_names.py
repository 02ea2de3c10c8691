# SPDX-License-Identifier: GPL-3.0-or-later
"""A name means one thing: no two classes of the product are called the same."""

import ast
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = ("angen_addon", "operators", "panels", "sensor_logic")
# The class of the Python package that users hold, and that of the core which it shows.
TWICE = {"Recording"}


def test_no_two_classes_are_called_the_same() -> None:
    found = defaultdict(list)
    for folder in PRODUCT:
        for path in (ROOT / folder).rglob("*.py"):
            for node in ast.parse(path.read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                    found[node.name].append(path.relative_to(ROOT).as_posix())
    assert len(found) > 400
    assert {name: files for name, files in found.items() if len(files) > 1}.keys() == TWICE
