# SPDX-License-Identifier: GPL-3.0-or-later
"""The output files of a command.

Their paths are checked before a long run. At the end of the run, either all files are written, or
none if one of them fails. `Exports` are the files in formats of other tools.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any, BinaryIO

import bpy

from ...sensor_logic.logs.error import AngenError, InputError, explained
from ...sensor_logic.logs.files import Content, WholeFiles, check_folder, check_target
from ...sensor_logic.logs.formats import FORMATS, Log
from ...sensor_logic.logs.formats.log import DEFAULT_START
from ...sensor_logic.logs.formats.outputs import check_out, output_files


def check_outputs(
    files: Mapping[str, Path | None], samples: Path | None = None, names: Iterable[str] = ()
) -> None:
    """Raise AngenError if an output file cannot be written, or would overwrite a file in use.

    Files in use are the open file, the files that it reads, and the other outputs.

    Parameters
    ----------
    files
        The path of each output file by the option that names it; None if the option is not given.
    samples
        The folder for the samples files; None if there is none.
    names
        The names of the samples files in that folder.
    """
    outputs = [(flag, path) for flag, path in files.items() if path is not None]
    for flag, path in outputs:
        with explained(f"{flag}: {path}", OSError):
            if path.is_dir():
                raise InputError(f"{flag}: {path} is a folder: give a file name")
            if flag == "--save" and path.exists() and not path.is_file():
                raise InputError(f"{flag}: {path} is not a plain file: give another name")
            check_folder(path.parent, flag)
    if samples is not None:
        with explained(f"--samples: {samples}", OSError):
            made = samples.exists() or samples.is_symlink()
            check_folder(samples if made else samples.parent, "--samples")
        outputs.append(("--samples", samples))
        outputs += [(f"--samples ({name})", samples / name) for name in names]
    known = _inputs()
    for flag, path in outputs:
        _check_apart(path, flag, known)
        with explained(f"{flag}: {path}", OSError):
            check_target(path, flag)
        known[_key(path)] = flag


def check_not_read(paths: Iterable[Path]) -> None:
    """Raise AngenError if any of the paths is the open file, or a file that the open file reads."""
    known = _inputs()
    for path in paths:
        _check_apart(path, "", known)


def _check_apart(path: Path, flag: str, known: Mapping[Any, str]) -> None:
    """Raise AngenError if `path` is one of the files in use.

    `flag` is the option that names the path. `known` has a text on each file in use, by the `_key`
    of the file: the option of an output, or a description of an input.
    """
    key = _key(path)
    if key is None or key not in known:
        return
    if known[key].startswith("--"):
        raise InputError(f"{known[key]} and {flag} both name {path}: give different files")
    named = f"{flag}: " if flag else ""
    raise InputError(f"{named}{path} would be overwritten, and is {known[key]}: give another file")


def _inputs() -> dict[Any, str]:
    """Return texts on the open file and on each file that it reads, by the `_key` of the file."""
    paths = dict.fromkeys(bpy.utils.blend_paths(absolute=True), "read by the open file")
    libraries = [bpy.path.abspath(library.filepath) for library in bpy.data.libraries]
    paths |= dict.fromkeys(libraries, "a linked library of the open file")
    paths[bpy.data.filepath] = "the open file itself"
    return {_key(Path(path)): text for path, text in paths.items() if os.path.isfile(path)}


def _key(path: Path) -> Any:
    """Return a value that is equal for all paths to the same file, also through links.

    Return None for a device, such as the null device, and for an invalid path.
    """
    try:
        if path.is_file() or path.is_dir():
            return path.stat().st_dev, path.stat().st_ino
        return None if path.exists() else os.path.normcase(path.resolve())
    except (OSError, ValueError, RuntimeError):
        return None


def _is_whole(saved: BinaryIO) -> bool:
    """Return whether the blend file `saved` is complete.

    An uncompressed file ends with the block ENDB, a compressed one with its seek table.
    """
    packed = saved.read(4) != b"BLEN"
    saved.seek(-min(64, os.fstat(saved.fileno()).st_size), os.SEEK_END)
    end = saved.read()
    return end.endswith(b"\xb1\xea\x92\x8f") if packed else b"ENDB" in end


def write(texts: Mapping[Path, Content], folder: Path | None = None) -> None:
    """Write all texts to their paths, in the new `folder` if one is given.

    If one cannot be written, write none, make no folder, and raise AngenError.
    """
    with Outputs() as outputs:
        outputs.texts.update(texts)
        outputs.folders = [folder] if folder else []
        outputs.commit()


class Outputs(WholeFiles):
    """Context manager: the outputs of a command, which `commit` writes.

    On exit, temporary files and new folders are removed unless `commit` was called.

    Attributes
    ----------
    texts
        The content of each file to write, by path.
    folders
        The folders to make.
    printed
        The text for standard output.
    """

    def __init__(self) -> None:
        super().__init__()
        self.texts: dict[Path, Content] = {}
        self.folders: list[Path] = []
        self.printed = ""
        self._new_folders: list[Path] = []

    def __exit__(self, *_: object) -> None:
        super().__exit__()
        for folder in self._new_folders:
            with contextlib.suppress(OSError):
                folder.rmdir()

    def save_blend(self, path: Path) -> None:
        """Save a copy of the open file under a temporary name, which `commit` renames to `path`.

        Raise AngenError if the file cannot be saved.
        """
        try:
            # Beside the target, so that relative paths in the file come out right.
            part = self.new(path, ".blend")
            bpy.ops.wm.save_as_mainfile(filepath=str(part), copy=True, check_existing=False)
            # Windows flushes no file that is open for reading only.
            with open(part, "r+b") as saved:
                os.fsync(saved.fileno())
                # Blender 5.2 does not notice that the disk is full.
                if not _is_whole(saved):
                    raise RuntimeError("Blender wrote only a part of it")
        except OSError as error:
            raise AngenError(f"cannot save {path}: {error.strerror}") from None
        except RuntimeError as error:
            why = " ".join(str(error).removeprefix("Error:").split()).replace(str(part), str(path))
            part.unlink(missing_ok=True)
            # On a full disk Blender 4.2 and 4.5 report a missing file.
            if shutil.disk_usage(part.parent).free < os.path.getsize(bpy.data.filepath):
                why = "no space left on the disk"
            raise AngenError(f"cannot save {path}: {why}") from None

    def commit(self) -> None:
        """Write all files and folders, and print the text; if one fails, write none.

        Raise AngenError if a file cannot be written, or OSError if standard output fails.
        """
        check_not_read(self.texts)
        for folder in self.folders:
            if not folder.exists():
                with explained(f"cannot make {folder}", OSError, raised=AngenError):
                    folder.mkdir()
                self._new_folders.append(folder)
        for path, content in self.texts.items():
            self.add(path, content)
        self.check_targets()
        if self.printed and sys.stdout is not None:
            sys.stdout.write(self.printed)
            sys.stdout.flush()
        super().commit()
        self._new_folders = []


# Formats of other tools, written beside the event log.


class Exports:
    """The logs that a command writes in formats of other tools.

    `names` are the formats, and `outs` the path for each. Raise AngenError if one of the paths
    cannot be written.
    """

    def __init__(self, names: Sequence[str], outs: Sequence[Path]) -> None:
        if len(names) != len(outs):
            raise InputError(
                f"{len(names)} --format and {len(outs)} --out: give an --out with each --format"
            )
        self._targets = [(FORMATS[name], out) for name, out in zip(names, outs, strict=True)]
        for target, out in self._targets:
            check_out(target, out)

    def check_dates(self, start: datetime | None, seconds: float) -> None:
        """Raise InputError if a format cannot hold the dates of a run.

        The run begins at `start` (by default a fixed date) and lasts `seconds`.
        """
        for target, _ in self._targets:
            target.check_dates(start or DEFAULT_START, 0.0, seconds)

    @property
    def files(self) -> dict[str, Path | None]:
        """The paths of formats that are single files, by the text that names each in messages."""
        return {
            f"--out {number} ({target.name})": out
            for number, (target, out) in enumerate(self._targets, start=1)
            if not target.is_folder
        }

    def add_to(self, outputs: Outputs, log: Log) -> Iterator[str]:
        """Add the log to the outputs in each format.

        Yield sentences for the user on data that a format cannot hold. Raise AngenError if a format
        cannot hold the log at all.
        """
        for target, out in self._targets:
            written = target.write(log)
            if target.is_folder:
                outputs.folders.append(out)
            outputs.texts |= output_files(target, out, written)
            yield from written.notes
