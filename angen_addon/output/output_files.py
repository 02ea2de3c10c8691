# SPDX-License-Identifier: GPL-3.0-or-later
"""What a command writes: checked before a long run; whole, together and last, or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import bpy

from ...sensor_logic.files import Content, OutputError, check_folder, land, stage
from ...sensor_logic.parts import Parts

MIB = 2**20


def check_outputs(
    files: Mapping[str, Path | None], samples: Path | None = None, names: Iterable[str] = ()
) -> None:
    """Raises OutputError where results could not be written, or would take the place of what is
    read or of one another. `files`: what each option names; `names`: those in the folder `samples`.
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
    """Raises OutputError where a path is the open file, or another that this one reads."""
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
    """Raises OutputError where `path` is one of those that are `known`."""
    for other in (known[key] for key in _keys(path) if key in known):
        if not other.startswith("--"):
            named = f"{flag}: " if flag else ""
            raise OutputError(f"{named}{path} is {other}, which would be lost: give another file")
        raise OutputError(f"{other} and {flag} both name {path}: give two files")


def _inputs() -> dict[Any, str]:
    """What the open file is made of, by what tells files apart."""
    paths = dict.fromkeys(bpy.utils.blend_paths(absolute=True), "read by the open file")
    libraries = [bpy.path.abspath(library.filepath) for library in bpy.data.libraries]
    paths |= dict.fromkeys(libraries, "a linked library of the open file")
    if bpy.data.filepath:
        paths[bpy.data.filepath] = "the open file itself"
    files = {Path(path): told for path, told in paths.items() if os.path.isfile(path)}
    return {key: told for path, told in files.items() for key in _keys(path)}


def _keys(path: Path) -> list[Any]:
    """What tells a file from all others, however it is spelt or linked; nothing for a device."""
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
    """Whether a blend file has its end: plain ones a block for it, packed ones a table of parts."""
    packed = saved.read(4) != b"BLEN"
    saved.seek(-min(64, os.fstat(saved.fileno()).st_size), os.SEEK_END)
    end = saved.read()
    return end.endswith(b"\xb1\xea\x92\x8f") if packed else b"ENDB" in end


def _why_unsaved(part: Path, error: Exception) -> str:
    """Why a file could not be saved: Blender says that there is no such file where in truth there
    is no space, which writing as much to the same place brings to light."""
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
        outputs.land()


class Outputs:
    """What a command will write: `texts` by path, perhaps into new `folders`, a saved blend file,
    and what it says on standard output. As a context, whose end removes what did not land."""

    def __init__(self) -> None:
        self.texts: dict[Path, Content] = {}
        self.folders: list[Path] = []
        self.said = ""
        self._parts = Parts()
        self._new_folders: list[Path] = []

    def __enter__(self) -> Outputs:
        return self

    def __exit__(self, *_: object) -> None:
        self._parts.__exit__()
        for folder in self._new_folders:
            with contextlib.suppress(OSError):
                folder.rmdir()

    def save_blend(self, path: Path) -> None:
        """Saves a copy of the open file, which lands with the rest. Raises OutputError."""
        try:
            # Beside the target, so that relative paths in the file come out right.
            part = self._parts.new(path, ".blend")
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

    def land(self) -> None:
        """Puts all in place; nothing where one of them fails. Raises OutputError; OSError of
        standard output."""
        check_not_read(self.texts)
        for folder in self.folders:
            if not folder.exists():
                try:
                    folder.mkdir()
                except OSError as error:
                    raise OutputError(f"cannot make {folder}: {error.strerror}") from None
                self._new_folders.append(folder)
        stage(self.texts, self._parts)
        if self.said and sys.stdout is not None:
            sys.stdout.write(self.said)
            sys.stdout.flush()
        land(self.texts, self._parts)
        self._new_folders = []
