# SPDX-License-Identifier: GPL-3.0-or-later
"""The tutorials that need only Blender; tests/readers has those that need other packages too."""

import shutil
import sys
from pathlib import Path

import pytest
from tutorials import ROOT, run_page

import command_tables


@pytest.mark.parametrize("name", ["first_sensor", pytest.param("ci", marks=pytest.mark.slow)])
def test_a_tutorial_runs_as_it_stands(name: str, tmp_path: Path) -> None:
    if name == "ci":
        shutil.copy(ROOT / "sample_blends" / "angen.blend", tmp_path / "home.blend")
    run_page(ROOT / "docs" / "tutorials" / f"{name}.md", tmp_path, sys.executable, sys.executable)
    if name == "first_sensor":
        # Pasted into Blender, it writes into a folder that exists and can be written.
        assert (tmp_path / "own home" / "events.csv").is_file()
        assert not (tmp_path / "events.csv").exists()


def test_the_page_of_the_command_line_has_all_verbs_and_options() -> None:
    written = command_tables.PAGE.read_text(encoding="utf-8")
    assert written == command_tables.page(), "run: python scripts/command_tables.py"
    assert written.count("\n## angen ") == 16
