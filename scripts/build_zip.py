# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the extension's zip with Blender's own tool, and has it validated: build_zip.py FOLDER.

The tool is a part of Blender's Python module; where that is missing, a Blender program runs it
(the one that BLENDER names, or the one on PATH).
"""

import importlib.util
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TOOL = "*/scripts/addons_core/bl_pkg/cli/blender_ext.py"


class NoBlenderError(Exception):
    """There is nothing here to build with."""


def extension_tool() -> list[str]:
    """The command line, up to its verb, of Blender's tool for extensions."""
    module = importlib.util.find_spec("bpy")
    if module and module.submodule_search_locations:
        found = sorted(Path(module.submodule_search_locations[0]).glob(TOOL))
        return [sys.executable, str(found[-1])]
    blender = os.environ.get("BLENDER") or shutil.which("blender")
    if not blender:
        raise NoBlenderError("needs Blender's Python module, or a Blender program (BLENDER=PATH)")
    return [blender, "--factory-startup", "--command", "extension"]


def build(folder: Path) -> Path:
    """Validates the manifest, writes the zip into a folder, validates it, and gives its path."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    target = folder.resolve() / f"{manifest['id']}-{manifest['version']}.zip"
    folder.mkdir(parents=True, exist_ok=True)
    tool = extension_tool()
    for arguments in (
        ["validate", str(ROOT)],
        ["build", "--source-dir", str(ROOT), "--output-filepath", str(target)],
        ["validate", str(target)],
    ):
        done = subprocess.run([*tool, *arguments], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ValueError(f"{arguments[0]} failed\n{done.stdout}{done.stderr}")
    return target


if __name__ == "__main__":
    try:
        print(build(Path(sys.argv[1])))
    except (NoBlenderError, ValueError) as error:
        sys.exit(f"build_zip: {error}")
