# SPDX-License-Identifier: GPL-3.0-or-later
"""What a worker of a study is given and gives back, and the files and versions that it has. The
driver, which has no Blender, loads this module too."""

from __future__ import annotations

import hashlib
import json
import platform
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import distributed

from ..angen_addon.output.version import extension_version
from ..sensor_logic.error import AngenError
from .settings import Settings

# Digest → the file that was sent, where this worker does not see the driver's disk.
_sent: dict[str, Path] = {}


def digest_of(facts: Mapping[str, Any]) -> str:
    """A digest of plain data, by which a run is known: 24 hexadecimal digits. The order of keys
    does not change it, that of lists does."""
    text = json.dumps(facts, sort_keys=True, ensure_ascii=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def digest_of_bytes(content: bytes) -> str:
    return f"sha256:{hashlib.sha256(content).hexdigest()}"


@dataclass(frozen=True)
class File:
    """A file that runs need: its path at the driver, and its digest."""

    path: str
    digest: str

    @property
    def name(self) -> str:
        return Path(self.path).name


@dataclass(frozen=True)
class Task:
    """All that a run needs. Those of the `settings` that change the home are `of_the_home`.
    `functions`: (label, name, source) of those that measure. `versions` are those that all runs of
    the study have. `days_in`: where days are kept, by its path at the driver."""

    digest: str
    home: File
    seed: int
    settings: Settings
    measure: tuple[str, ...]
    functions: tuple[tuple[str, str, str], ...]
    keep: tuple[str, ...]
    versions: dict[str, str]
    frames: tuple[int, int] | None = None
    routine: File | None = None
    start: str = ""
    days: int = 0
    empty_for: float = 30.0
    of_the_home: Settings = field(default_factory=dict)
    days_in: str = ""


@dataclass(frozen=True)
class Done:
    """What came of a run: `values` are measures by name; `error` is empty where all went well, and
    names the measures that failed; `files` are logs to be kept, by name."""

    digest: str
    values: dict[str, Any]
    seconds: float
    error: str = ""
    files: dict[str, str] = field(default_factory=dict)


# One a process, with which it goes; without it each file would get a folder.
@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="angen-study-")


class FilesOfStudy(distributed.WorkerPlugin):
    """Brings files to each worker that does not see the driver's, also to one that comes late."""

    def __init__(self, name: str, files: Mapping[File, bytes]) -> None:
        self.name = name
        self._files = dict(files)

    def setup(self, worker: Any) -> None:
        for file, content in self._files.items():
            try:
                found(file)
            except AngenError:
                path = Path(_folder().name) / f"{file.digest.rpartition(':')[2][:16]}-{file.name}"
                path.write_bytes(content)
                _sent[file.digest] = path


def found(file: File) -> Path:
    """Where a file lies here. Raises AngenError."""
    path = Path(file.path)
    if path.is_file() and _digest(path, path.stat().st_mtime_ns) == file.digest:
        return path
    if file.digest not in _sent:
        raise AngenError(f"{platform.node()} has no file {file.path} as it is at the driver")
    return _sent[file.digest]


# One a file as it is, as long as the process; without it 1 ms a megabyte for each run.
@cache
def _digest(path: Path, changed: int) -> str:
    return digest_of_bytes(path.read_bytes())


# Once a process; without it 11 ms more a run.
@cache
def versions(_: None = None) -> dict[str, str]:
    """Of all that a run depends on here. Raises AngenError where Blender's module is missing."""
    try:
        import bpy
        import numpy
    except ImportError as error:
        raise AngenError(
            f"{platform.node()} lacks Blender's Python module ({error}): pip install bpy there"
        ) from None
    return {
        "angen_sensors": f"{extension_version()}+{_code()}",
        "blender": bpy.app.version_string,
        "numpy": numpy.__version__,
        "python": ".".join(map(str, sys.version_info[:3])),
    }


def _code() -> str:
    """A digest of what simulates: of the same version there are many while it is worked on."""
    root = Path(__file__).resolve().parents[1]
    found = hashlib.sha256()
    for folder in ("sensor_logic", "angen_addon", "residents", "studies"):
        for path in sorted((root / folder).rglob("*.py")):
            found.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return found.hexdigest()[:12]


def differences(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """Which versions differ, in words; empty where none does."""
    return ", ".join(
        f"{name} {ours.get(name)} and {theirs.get(name)}"
        for name in sorted({*ours, *theirs})
        if ours.get(name) != theirs.get(name)
    )
