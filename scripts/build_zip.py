# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the extension's zip: build_zip.py FOLDER. Needs Python 3.11 or later and nothing else.

The same source gives the same bytes on each system. Blender's own tool checks
the zip and builds one of the same files if it is installed: in a Blender as a Python module (of
this interpreter or of an environment of the project), or in a Blender program (the one that BLENDER
names, or the one on PATH).
"""

import fnmatch
import glob
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
MANIFEST = "blender_manifest.toml"
TOOL = "*/scripts/addons_core/bl_pkg/cli/blender_ext.py"
NEEDED = {
    "schema_version": r"1\.0\.0",
    "id": r"[a-z][a-z0-9_]*",
    "version": r"\d+\.\d+\.\d+",
    "name": r".+",
    "tagline": r".{1,63}[\w)]",
    "maintainer": r".+",
    "type": r"add-on",
    "blender_version_min": r"4\.\d+\.\d+",
}
# The earliest time that a zip can store.
TIME = (1980, 1, 1, 0, 0, 0)


def extension_tool() -> list[str] | None:
    """Return the command line, up to its verb, of Blender's extension tool; None without it."""
    module = importlib.util.find_spec("bpy")
    folders = list(module.submodule_search_locations or ()) if module else []
    for packages in ("lib/python3.*/site-packages", "Lib/site-packages"):
        folders += glob.glob(f"{ROOT}/.venv*/{packages}/bpy")
    for folder in folders:
        found = sorted(Path(folder).glob(TOOL))
        if found:
            return [sys.executable, str(found[-1])]
    blender = os.environ.get("BLENDER") or shutil.which("blender")
    return [blender, "--factory-startup", "--command", "extension"] if blender else None


def build(folder: Path, tool: list[str] | None) -> Path:
    """Write the zip into a folder, check it, also with the tool if there is one, return its path.

    Raises
    ------
    ValueError
        The manifest or the zip is not valid, or the tool packs other files.
    """
    manifest = tomllib.loads((ROOT / MANIFEST).read_text(encoding="utf-8"))
    check(manifest)
    target = folder.resolve() / f"{manifest['id']}-{manifest['version']}.zip"
    folder.mkdir(parents=True, exist_ok=True)
    pack(target, shipped(manifest))
    check_zip(target)
    if tool is not None:
        _check_with(tool, target)
    return target


def _check_with(tool: list[str], target: Path) -> None:
    """Raise `ValueError` if Blender's tool refuses the zip, or packs other files."""
    with tempfile.TemporaryDirectory() as folder:
        built = Path(folder, target.name)
        for arguments in (
            ["validate", str(ROOT)],
            ["build", "--source-dir", str(ROOT), "--output-filepath", str(built)],
            ["validate", str(target)],
        ):
            done = subprocess.run(
                [*tool, *arguments],
                capture_output=True,
                encoding="utf-8",
                errors="replace",
                check=False,
            )
            if done.returncode != 0:
                raise ValueError(f"{arguments[0]} failed\n{done.stdout}{done.stderr}")
        ours, theirs = contents(target), contents(built)
    differ = sorted({name for name, _ in ours.items() ^ theirs.items()})
    if differ:
        raise ValueError(f"{target}: Blender's tool packs {', '.join(differ)} otherwise")


def contents(packed: Path) -> dict[str, bytes]:
    """Return the content of each file in a zip."""
    with zipfile.ZipFile(packed) as opened:
        names = [name for name in opened.namelist() if not name.endswith("/")]
        return {name: opened.read(name) for name in names}


def check(manifest: dict[str, Any]) -> None:
    """Raise `ValueError` if Blender would reject the manifest."""
    for key, pattern in NEEDED.items():
        if not re.fullmatch(pattern, str(manifest.get(key, ""))):
            raise ValueError(f"{MANIFEST}: {key} is {manifest.get(key)!r}")
    if not manifest.get("license") or not all(s.startswith("SPDX:") for s in manifest["license"]):
        raise ValueError(f"{MANIFEST}: license must be a list of SPDX:…")
    for permission, reason in manifest.get("permissions", {}).items():
        if not 0 < len(reason) <= 64 or reason.endswith("."):
            raise ValueError(f"{MANIFEST}: the reason of the permission '{permission}'")


def shipped(manifest: dict[str, Any]) -> list[str]:
    """Return the files of the zip, by the manifest's patterns, which work as in .gitignore."""
    patterns = manifest["build"]["paths_exclude_pattern"]
    found = []
    for folder, folders, names in os.walk(ROOT):
        at = Path(folder).relative_to(ROOT)
        folders[:] = sorted(
            f for f in folders if not _is_excluded(f"{(at / f).as_posix()}/", patterns)
        )
        found += [
            path for name in names if not _is_excluded(path := (at / name).as_posix(), patterns)
        ]
    return sorted(found)


def _is_excluded(path: str, patterns: list[str]) -> bool:
    """Return whether a file, or a folder (ending with /), matches one of the patterns."""
    for pattern in patterns:
        if pattern.endswith("/") != path.endswith("/") and pattern.endswith("/"):
            continue
        bare, plain = path.rstrip("/"), pattern.strip("/")
        name = bare if "/" in pattern.rstrip("/") else bare.rpartition("/")[2]
        # A star stays within its folder.
        if name.count("/") == plain.count("/") and fnmatch.fnmatchcase(name, plain):
            return True
    return False


def pack(target: Path, names: list[str], root: Path = ROOT, compress: bool = False) -> None:
    """Pack files of a folder, by their names there with `/`, in this order.

    No time, system or right of this machine gets into the zip; with `compress` its zlib does, which
    is zlib-ng in Windows's Python 3.14, for example.
    """
    with zipfile.ZipFile(target, "w", compresslevel=9) as packed:
        for name in names:
            facts = zipfile.ZipInfo(name, TIME)
            # As on Unix, also on Windows.
            facts.create_system, facts.external_attr = 3, 0o644 << 16
            facts.compress_type = zipfile.ZIP_DEFLATED if compress else zipfile.ZIP_STORED
            packed.writestr(facts, (root / name).read_bytes())


def check_zip(target: Path) -> None:
    """Raise `ValueError` if the zip cannot be installed."""
    with zipfile.ZipFile(target) as packed:
        broken = packed.testzip()
        lacks = {MANIFEST, "__init__.py", "LICENSE"} - set(packed.namelist())
    if broken or lacks:
        raise ValueError(f"{target}: {broken or ', '.join(sorted(lacks))} is missing or broken")


if __name__ == "__main__":
    try:
        tool = extension_tool()
        print(build(Path(sys.argv[1]), tool))
        if tool is None:
            print("packed without Blender's extension tool: it is not installed", file=sys.stderr)
    except ValueError as error:
        sys.exit(f"build_zip: {error}")
