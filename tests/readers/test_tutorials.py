# SPDX-License-Identifier: GPL-3.0-or-later
"""The tutorials that need packages of others; Blender's module is that of the tests."""

import sys
from pathlib import Path

import pytest
from tutorials import ROOT, run_page

from dev import python_of

BPY = python_of(ROOT / ".venv")


@pytest.mark.skipif(not BPY.exists(), reason="make venv: no Blender's module in .venv")
@pytest.mark.parametrize(("name", "package"), [("own_home", "ifcopenshell"), ("week", "sklearn")])
def test_a_tutorial_runs_as_it_stands(name: str, package: str, reader, tmp_path: Path) -> None:
    reader(package)
    run_page(ROOT / "docs" / "tutorials" / f"{name}.md", tmp_path, str(BPY), sys.executable)
