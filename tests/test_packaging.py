# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's manifest, its zip, and what the repository must not hold."""

import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import build_zip

ROOT = build_zip.ROOT
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
SHIPPED_FILES = {"__init__.py", "blender_manifest.toml", "LICENSE", "README.md"}
SHIPPED_FOLDERS = ("angen_addon", "operators", "panels", "sensor_logic")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The zip, built and validated by Blender's own tool."""
    try:
        return build_zip.build(tmp_path_factory.mktemp("zip"))
    except build_zip.NoBlenderError as error:
        pytest.skip(str(error))


def test_the_manifest_says_what_users_rely_on() -> None:
    assert MANIFEST["id"] == "angen_sensors"
    assert MANIFEST["name"] == "Ängen Sensors"
    assert MANIFEST["blender_version_min"] == "4.2.0"
    assert MANIFEST["license"] == ["SPDX:GPL-3.0-or-later"]
    assert set(MANIFEST["permissions"]) == {"files"}
    assert "wheels" not in MANIFEST


def test_the_license_is_whole() -> None:
    text = (ROOT / "LICENSE").read_text(encoding="utf-8")
    assert text.lstrip().startswith("GNU GENERAL PUBLIC LICENSE\n")
    assert "Version 3, 29 June 2007" in text
    assert len(text.splitlines()) > 600


def test_the_zip_holds_what_runs_and_nothing_else(built: Path) -> None:
    runs = SHIPPED_FILES | {
        path.relative_to(ROOT).as_posix()
        for folder in SHIPPED_FOLDERS
        for path in (ROOT / folder).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    names = zipfile.ZipFile(built).namelist()
    assert set(names) == runs


INSTALLED = """
import os, sys
import bpy, addon_utils
addon = addon_utils.enable("bl_ext.user_default.angen_sensors", default_set=True)
assert addon and os.path.realpath(addon.__file__).startswith(os.path.realpath(sys.argv[1]))
from bl_ext.user_default.angen_sensors.angen_addon.command_line import run_command
bpy.ops.wm.open_mainfile(filepath=sys.argv[2])
status = run_command(["simulate", "--frames", "1:24", "--events", sys.argv[1] + "/events.csv"])
addon_utils.disable("bl_ext.user_default.angen_sensors")
assert not hasattr(bpy.types.Object, "angen_sensor")
sys.exit(status)
"""


def test_the_zip_runs_in_an_empty_blender(built: Path, tmp_path: Path) -> None:
    pytest.importorskip("bpy", reason="needs Blender's Python module (bpy)")
    zipfile.ZipFile(built).extractall(tmp_path / "extensions/user_default/angen_sensors")
    done = subprocess.run(
        [sys.executable, "-c", INSTALLED, str(tmp_path), str(ROOT / "sample_blends/angen.blend")],
        env={"PATH": "", "HOME": str(tmp_path), "BLENDER_USER_RESOURCES": str(tmp_path)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert len((tmp_path / "events.csv").read_text(encoding="utf-8").splitlines()) > 1


# Written apart, so that this file does not hold what it looks for.
MACHINE = re.compile(
    rb"(?<![\w.~-])/(?:work|farm|root|home/\w+|opt/v\d+|tmp/\w+)/"
    rb"|\b(?:pypi|pythonhosted|npmjs|debian|ubuntu)\." + rb"(?:org|com)\b"
)


def test_no_tracked_file_names_a_machine_or_a_registry() -> None:
    if not shutil.which("git") or not (ROOT / ".git").exists():
        pytest.skip("needs a git checkout")
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    found = [
        f"{name}: {match.group().decode()}"
        for name in listed.stdout.decode().split("\0")
        if name and (ROOT / name).is_file() and name != "LICENSE"
        for match in MACHINE.finditer((ROOT / name).read_bytes())
    ]
    assert not found
