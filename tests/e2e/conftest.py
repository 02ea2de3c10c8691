# SPDX-License-Identifier: GPL-3.0-or-later
"""A real Blender program with the built zip installed in it.

BLENDER names the program; where Blender's Python module is missing, the one on PATH is used.
"""

import importlib.util
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import build_zip

ROOT = build_zip.ROOT
Angen = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="session")
def blender() -> str:
    """Return the program as an absolute path."""
    name = os.environ.get("BLENDER") or (
        None if importlib.util.find_spec("bpy") else shutil.which("blender")
    )
    if not name:
        pytest.skip("needs a Blender program: BLENDER=PATH")
    path = shutil.which(name)
    assert path, f"BLENDER={name} is no program"
    return str(Path(path).absolute())


@pytest.fixture(scope="session")
def run_blender(
    blender: str, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[list[str]], subprocess.CompletedProcess[str]]:
    """Run the program with arguments; its folders were empty before the zip was installed."""
    resources = tmp_path_factory.mktemp("blender_resources")

    def run(arguments: list[str]) -> subprocess.CompletedProcess[str]:
        environment = {**os.environ, "BLENDER_USER_RESOURCES": str(resources)}
        return subprocess.run(
            [blender, *arguments],
            cwd=ROOT,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=600,
        )

    # The program itself validates the zip, and builds one of the same files.
    tool = [blender, "--factory-startup", "--command", "extension"]
    zip_path = build_zip.build(tmp_path_factory.mktemp("zip"), tool)
    install = ["--command", "extension", "install-file", "-r", "user_default", "-e", str(zip_path)]
    done = run(install)
    assert done.returncode == 0, done.stdout + done.stderr
    return run


@pytest.fixture(scope="session")
def angen(run_blender: Callable[[list[str]], subprocess.CompletedProcess[str]]) -> Angen:
    """Run the extension's command on a file: angen("home.blend", "list", "--json")."""
    return lambda file, *arguments: run_blender([str(file), "--command", "angen", *arguments])
