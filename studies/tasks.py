# SPDX-License-Identifier: GPL-3.0-or-later
"""The data that a worker receives and returns, and a worker's files and versions.

The driver, which has no Blender, imports this module too.
"""

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

from ..angen_addon.process.version import extension_version
from ..sensor_logic.logs.error import AngenError
from .settings import Settings

# Paths of received files by digest, for a worker that cannot read the driver's disk.
_received: dict[str, Path] = {}


def digest_of(facts: Mapping[str, Any]) -> str:
    """Return a digest of plain data, as 24 hexadecimal digits.

    The digest depends on the order of lists, but not on the order of keys.
    """
    text = json.dumps(facts, sort_keys=True, ensure_ascii=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def digest_of_bytes(content: bytes) -> str:
    """Return the SHA-256 digest of bytes."""
    return f"sha256:{hashlib.sha256(content).hexdigest()}"


@dataclass(frozen=True)
class File:
    """A file that runs need: its path on the driver's machine, and the digest of its content."""

    path: str
    digest: str

    @property
    def name(self) -> str:
        """The file's name without its folder."""
        return Path(self.path).name


@dataclass(frozen=True)
class Task:
    """All data that a worker needs for a run.

    Attributes
    ----------
    digest : str
        Identifies the run.
    home, routine : File
        The blend file, and the routine's file or None.
    seed : int
        The seed of the run.
    settings, shared_settings : dict
        The values that the run sets, by sensor and parameter. The shared ones can affect the
        readings of other sensors.
    measure, functions : tuple
        The names of the built-in measures, and the user's own functions as (label, name, source).
    keep : tuple of str
        The logs to store, such as "events".
    versions : dict of str to str
        The versions of the software that all workers of the study have.
    frames : tuple of 2 ints, or None
        The first and last frame of a run without a routine.
    start, days : str and int
        The date of the first day, and the number of days.
    empty_for : float
        For false alarms: how long before and after an alarm its room must be empty, s.
    days_in : str
        The driver's folder for the simulated days of unfinished runs.
    """

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
    shared_settings: Settings = field(default_factory=dict)
    days_in: str = ""


@dataclass(frozen=True)
class RunResult:
    """The result of a run.

    Attributes
    ----------
    digest : str
        Identifies the run.
    values : dict
        The value of each column of the results.
    seconds : float
        The time that the simulation took, s.
    error : str
        The errors of the measures that failed, or "".
    files : dict of str to str
        The text of each log to store, by file name.
    """

    digest: str
    values: dict[str, Any]
    seconds: float
    error: str = ""
    files: dict[str, str] = field(default_factory=dict)


# Cached for the process, which removes it: without the cache each file would get a folder.
@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """Return the folder for files that this worker receives."""
    return tempfile.TemporaryDirectory(prefix="angen-study-")


class FilesOfStudy(distributed.WorkerPlugin):
    """A Dask plugin that copies files to each worker that cannot read the driver's disk."""

    def __init__(self, name: str, files: Mapping[File, bytes]) -> None:
        self.name = name
        self._files = dict(files)

    def setup(self, worker: Any) -> None:
        """Store the files on a worker that has just connected, if it cannot read them."""
        for file, content in self._files.items():
            try:
                local_path(file)
            except AngenError:
                path = Path(_folder().name) / f"{file.digest.rpartition(':')[2][:16]}-{file.name}"
                path.write_bytes(content)
                _received[file.digest] = path


def local_path(file: File) -> Path:
    """Return the path of a file on this machine.

    Raise `AngenError` if the file is missing, or if its content differs from the driver's file.
    """
    path = Path(file.path)
    if path.is_file() and _digest(path, path.stat().st_mtime_ns) == file.digest:
        return path
    if file.digest not in _received:
        raise AngenError(
            f"on {platform.node()}, the file {file.path} is missing or is not the same as at the "
            "start of the study"
        )
    return _received[file.digest]


# Cached for the process: without the cache each run takes 1 ms a megabyte more.
@cache
def _digest(path: Path, changed: int) -> str:
    """Return the digest of a file; `changed`, its time stamp, makes the cache notice a change."""
    return digest_of_bytes(path.read_bytes())


# Cached for the process: without the cache each run takes 11 ms more.
@cache
def versions(_: None = None) -> dict[str, str]:
    """Return the versions of this package, Blender, numpy and Python, on which results depend.

    Raise `AngenError` if Blender's Python module is missing.
    """
    try:
        import bpy
        import numpy
    except ImportError as error:
        raise AngenError(
            f"{platform.node()} lacks Blender's Python module ({error}): install it there with "
            "pip install bpy"
        ) from None
    return {
        "angen_sensors": f"{extension_version()}+{_code()}",
        "blender": bpy.app.version_string,
        "numpy": numpy.__version__,
        "python": ".".join(map(str, sys.version_info[:3])),
    }


def _code() -> str:
    """Return a digest of the package's source code."""
    # During development, the code changes without a new version number.
    root = Path(__file__).resolve().parents[1]
    found = hashlib.sha256()
    for folder in ("sensor_logic", "angen_addon", "residents", "studies"):
        for path in sorted((root / folder).rglob("*.py")):
            found.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return found.hexdigest()[:12]


def differences(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """Return a text that lists the versions that differ, or "" if all are equal."""
    return ", ".join(
        f"{name} {ours.get(name)} and {theirs.get(name)}"
        for name in sorted({*ours, *theirs})
        if ours.get(name) != theirs.get(name)
    )
