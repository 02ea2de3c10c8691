# SPDX-License-Identifier: GPL-3.0-or-later
"""A file is read in one sitting, a function on one screen: no file over 400 lines, no function
over 60."""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = (
    "angen_addon", "benchmarks", "operators", "panels", "sample_blends", "scripts",
    "sensor_logic", "tests",
)  # fmt: skip
LINES, FUNCTION_LINES = 400, 60


def sizes(path: Path) -> dict[str, int]:
    """The file's lines that are more than they should be, and its functions'."""
    text, name = path.read_text(encoding="utf-8"), path.relative_to(ROOT).as_posix()
    found = {name: text.count("\n") - LINES}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            length = (node.end_lineno or 0) - node.lineno + 1
            found[f"{name} {node.name}"] = length - FUNCTION_LINES
    return {what: over for what, over in found.items() if over > 0}


def test_files_and_functions_are_short() -> None:
    files = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")]
    assert len(files) > 800
    longer = {what: over for path in files for what, over in sizes(path).items()}
    assert longer == {}
