# SPDX-License-Identifier: GPL-3.0-or-later
"""The output files of a command: paths are checked before a long run, and at its end all files are
written together, or none."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import bpy

from ...sensor_logic.files import Content, OutputError, check_folder, commit, stage
from ...sensor_logic.temporary_files import TemporaryFiles

MIB = 2**20


def check_outputs(
    files: Mapping[str, Path | None], samples: Path | None = None, names: Iterable[str] = ()
) -> None:
    """Raises OutputError where a result could not be written, or would overwrite a file that is
    read or another result. `files`: option → path; `names`: the files in the folder `samples`.
    """
    asked = {flag: path for flag, path in files.items() if path is not None}
    for flag, path in asked.items():
        _check_file(path, flag)
    if samples is not None:
        try:
            folder = samples if samples.exists() or samples.is_symlink() else samples.parent
        except OSError as error:
            raise OutputError(f"--samples: {samples}: {error.strerror}") from None
        check_folder(folder, "--samples")
    known = _inputs()
    outputs = list(asked.items())
    outputs += [("--samples", samples)] if samples is not None else []
    outputs += [(f"--samples ({name})", samples / name) for name in names] if samples else []
    for flag, path in outputs:
        _check_apart(path, flag, known)
        known.update(dict.fromkeys(_keys(path), flag))


def check_not_read(paths: Iterable[Path]) -> None:
    """Raises OutputError where a path is the open file, or a file that the open file reads."""
    known = _inputs()
    for path in paths:
        _check_apart(path, "", known)


def _check_file(path: Path, flag: str) -> None:
    try:
        is_folder = path.is_dir()
        path.exists()
    except OSError as error:
        raise OutputError(f"{flag}: {path}: {error.strerror}") from None
    if is_folder:
        raise OutputError(f"{flag}: {path} is a folder, not a file name")
    if flag == "--save" and path.exists() and not path.is_file():
        raise OutputError(f"{flag}: {path} is not a plain file")
    check_folder(path.parent, flag)


def _check_apart(path: Path, flag: str, known: Mapping[Any, str]) -> None:
    """Raises OutputError where `path` is in `known`."""
    for other in (known[key] for key in _keys(path) if key in known):
        if not other.startswith("--"):
            named = f"{flag}: " if flag else ""
            raise OutputError(f"{named}{path} is {other}, which would be lost: give another file")
        raise OutputError(f"{other} and {flag} both name {path}: give two files")


def _inputs() -> dict[Any, str]:
    """The files that the open file consists of: key (see `_keys`) → what it is."""
    paths = dict.fromkeys(bpy.utils.blend_paths(absolute=True), "read by the open file")
    libraries = [bpy.path.abspath(library.filepath) for library in bpy.data.libraries]
    paths |= dict.fromkeys(libraries, "a linked library of the open file")
    if bpy.data.filepath:
        paths[bpy.data.filepath] = "the open file itself"
    files = {Path(path): told for path, told in paths.items() if os.path.isfile(path)}
    return {key: told for path, told in files.items() for key in _keys(path)}


def _keys(path: Path) -> list[Any]:
    """Keys that identify a file, however its path is spelt or linked; none for a device."""
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            return []
        keys: list[Any] = [os.path.normcase(path.resolve())]
        if path.exists():
            facts = path.stat()
            keys.append((facts.st_dev, facts.st_ino))
    except (OSError, ValueError, RuntimeError):
        return []
    return keys


def _is_whole(saved: BinaryIO) -> bool:
    """Whether a blend file is complete: a plain one ends with the block ENDB, a compressed one with
    its seek table."""
    packed = saved.read(4) != b"BLEN"
    saved.seek(-min(64, os.fstat(saved.fileno()).st_size), os.SEEK_END)
    end = saved.read()
    return end.endswith(b"\xb1\xea\x92\x8f") if packed else b"ENDB" in end


def _why_unsaved(part: Path, error: Exception) -> str:
    """Why a file could not be saved. On a full disk Blender reports a missing file, so this writes
    as much data to the same path to find the true reason."""
    try:
        with open(part, "wb") as file:
            for _ in range(1 + os.path.getsize(bpy.data.filepath) // MIB):
                file.write(bytes(MIB))
            os.fsync(file.fileno())
    except OSError as reason:
        return str(reason.strerror)
    if isinstance(error, OSError):
        return str(error.strerror)
    return " ".join(str(error).removeprefix("Error:").split())


def write(texts: Mapping[Path, Content], folder: Path | None) -> None:
    """Writes all files, or none and no new folder either. Raises OutputError."""
    outputs = Outputs()
    outputs.texts.update(texts)
    outputs.folders = [folder] if folder else []
    with outputs:
        outputs.commit()


class Outputs:
    """The outputs of a command: `texts` by path, new `folders`, a saved blend file, and `said`, the
    text for standard output. Leaving the context removes what was not committed."""

    def __init__(self) -> None:
        self.texts: dict[Path, Content] = {}
        self.folders: list[Path] = []
        self.said = ""
        self._files = TemporaryFiles()
        self._new_folders: list[Path] = []

    def __enter__(self) -> Outputs:
        return self

    def __exit__(self, *_: object) -> None:
        self._files.__exit__()
        for folder in self._new_folders:
            with contextlib.suppress(OSError):
                folder.rmdir()

    def save_blend(self, path: Path) -> None:
        """Saves a copy of the open file, which `commit` puts in place. Raises OutputError."""
        try:
            # Beside the target, so that relative paths in the file come out right.
            part = self._files.new(path, ".blend")
        except OSError as error:
            raise OutputError(f"cannot save {path}: {error.strerror}") from None
        try:
            bpy.ops.wm.save_as_mainfile(filepath=str(part), copy=True, check_existing=False)
            with open(part, "rb") as saved:
                os.fsync(saved.fileno())
                if not _is_whole(saved):
                    # Blender 5.2 does not notice that the disk is full.
                    raise OSError(errno.EIO, "Blender wrote only a part of it")
        except (RuntimeError, OSError) as error:
            raise OutputError(f"cannot save {path}: {_why_unsaved(part, error)}") from None

    def commit(self) -> None:
        """Puts all outputs in place, or none where one fails. Raises OutputError, or OSError where
        standard output fails."""
        check_not_read(self.texts)
        for folder in self.folders:
            if not folder.exists():
                try:
                    folder.mkdir()
                except OSError as error:
                    raise OutputError(f"cannot make {folder}: {error.strerror}") from None
                self._new_folders.append(folder)
        stage(self.texts, self._files)
        if self.said and sys.stdout is not None:
            sys.stdout.write(self.said)
            sys.stdout.flush()
        commit(self.texts, self._files)
        self._new_folders = []
