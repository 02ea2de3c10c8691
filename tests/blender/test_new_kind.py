# SPDX-License-Identifier: GPL-3.0-or-later
"""A kind of sensor is one file: with nothing else changed it is in every place (new_kinds/).

One kind is that of CONTRIBUTING.md's tutorial, unchanged, and casts rays; the other casts none.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
EXTENSION = ("angen_addon", "operators", "panels", "residents", "sensor_logic")


@pytest.fixture
def copy(tmp_path):
    """Copy the extension with two more kinds, and the tests of every place."""
    for folder in EXTENSION:
        leave = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=leave)
    (tmp_path / "tests" / "blender").mkdir(parents=True)
    (tmp_path / "scripts").mkdir()
    for name in (
        "__init__.py",
        "parts.py",
        "blender_manifest.toml",
        "pyproject.toml",
        "scripts/dev.py",
        "tests/conftest.py",
        "tests/imitated_windows.py",
    ):
        shutil.copy(ROOT / name, tmp_path / name)
    for name in ("conftest.py", "lived_home.py", "pressure_scenes.py", "panel_layout.py"):
        shutil.copy(TESTS / "blender" / name, tmp_path / "tests" / "blender" / name)
    shutil.copy(TESTS / "blender/new_kinds/inclinometer.py", tmp_path / "sensor_logic/kinds")
    shutil.copy(TESTS / "blender/new_kinds/every_place.py", tmp_path / "tests/blender")
    tutorial = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    files = re.findall(r"`([\w/]+/ranger\.py)`:\n+```python\n(.*?)```", tutorial, re.DOTALL)
    assert [name for name, _ in files] == [
        "sensor_logic/kinds/ranger.py",
        "angen_addon/kinds/ranger.py",
    ]
    for name, code in files:
        (tmp_path / name).write_text(code, encoding="utf-8")
    return tmp_path


def test_a_kind_in_one_file_is_everywhere(copy):
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:xdist", "tests/blender/every_place.py"],
        cwd=copy,
        env={key: value for key, value in os.environ.items() if not key.startswith("PYTEST")},
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]
    assert " passed" in done.stdout and "skipped" not in done.stdout
