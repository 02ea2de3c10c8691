# SPDX-License-Identifier: GPL-3.0-or-later
"""`scripts/dev.py`, which makes environments and runs the checks on any system."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import dev

ROOT = dev.ROOT


def run(*arguments: object, **variables: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "scripts/dev.py", *map(str, arguments)]
    given = {**os.environ, **variables}
    return subprocess.run(command, cwd=ROOT, env=given, capture_output=True, text=True)


def test_a_verb_that_does_not_exist_is_told_what_there_is() -> None:
    done = run("tset")
    assert (done.returncode, done.stdout) == (1, "") and "the quick tests" in done.stderr


def test_without_a_suitable_python_it_says_what_to_install(tmp_path: Path) -> None:
    done = run("venv", tmp_path / "made", "test", PYTHON="no-such-python")
    assert done.returncode == 1 and not (tmp_path / "made").exists()
    first, *rest = done.stderr.splitlines()
    assert first == (
        "dev: No suitable Python here (PYTHON=no-such-python): it must be 3.13 or 3.11."
    )
    for system in ("Debian", "Windows", "macOS"):
        assert any(system in line for line in rest)


def test_the_python_of_a_version_is_found() -> None:
    version = "{}.{}".format(*sys.version_info)
    done = run("python", version, PYTHON=sys.executable)
    assert done.stdout.strip() and dev.version_of(done.stdout.strip()) == version
    assert run("python", "2.5", PYTHON=sys.executable).returncode == 1


@pytest.mark.skipif(sys.platform != "linux", reason="Python may not run by a link")
def test_the_python_of_a_user_whose_name_has_an_umlaut_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Windows installs Python into the user's folder, and prints its path in Windows-1252."""
    python = tmp_path / "Jörg" / "python"
    python.parent.mkdir()
    python.symlink_to(sys.executable)
    monkeypatch.setenv("PYTHON", str(python))
    monkeypatch.setenv("PYTHONIOENCODING", "cp1252")
    assert dev.find_python(["{}.{}".format(*sys.version_info)]) == str(python)


def test_an_environment_that_is_complete_is_left_alone_and_another_recipe_makes_it_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = tmp_path / "an environment"
    own = dev.python_of(made)
    own.parent.mkdir(parents=True)
    (made / "ready").write_text(dev.stamp_of("lint", ""), encoding="utf-8")
    found = {str(own): "3.13"}
    monkeypatch.setattr(dev, "version_of", lambda command: found.get(command, ""))
    monkeypatch.delenv("PYTHON", raising=False)
    assert dev.make_venv(made, "lint") == own

    def looks(versions: list[str]) -> str:
        raise dev.NoPython

    monkeypatch.setattr(dev, "find_python", looks)
    (made / "ready").write_text("lint  another recipe", encoding="utf-8")
    with pytest.raises(SystemExit, match=r"it must be 3\.13 or 3\.12 or 3\.11 or 3\.14\."):
        dev.make_venv(made, "lint")


def test_a_link_to_a_folder_shows_its_files(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "file").write_text("text", encoding="utf-8")
    dev.link_folder(tmp_path / "link", tmp_path / "folder")
    assert (tmp_path / "link" / "file").read_text(encoding="utf-8") == "text"


def test_make_calls_it_for_tests_and_environments() -> None:
    """So that both ways do the same."""
    recipes = (ROOT / "Makefile").read_text(encoding="utf-8")
    for verb in ("test", "test-all", "lint", "demo", "zip", "venv"):
        assert f"$(DEV) {verb}" in recipes
    assert "-m venv" not in recipes and "bin/python -m pytest -n auto" not in recipes
