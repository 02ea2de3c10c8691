# SPDX-License-Identifier: GPL-3.0-or-later
"""The output files of a command.

Their paths are checked before a long run. At its end all files are written together, or none.
`Exports` are the files in formats of other tools.
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

from ...sensor_logic.error import AngenError, InputError, explained
from ...sensor_logic.files import Content, WholeFiles, check_folder
from ...sensor_logic.formats import FORMATS, Log
from ...sensor_logic.formats.log import DEFAULT_START
from ...sensor_logic.formats.outputs import check_out, output_files


def check_outputs(
    files: Mapping[str, Path | None], samples: Path | None = None, names: Iterable[str] = ()
) -> None:
    """Raise AngenError if a result cannot be written, or would overwrite a file that is used.

    `files` has the path by option, and `names` are the files in the folder `samples`.
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
        known[_key(path)] = flag


def check_not_read(paths: Iterable[Path]) -> None:
    """Raise AngenError if a path is the open file, or a file that the open file reads."""
    known = _inputs()
    for path in paths:
        _check_apart(path, "", known)


def _check_apart(path: Path, flag: str, known: Mapping[Any, str]) -> None:
    """Raise AngenError if `path` is in `known`."""
    key = _key(path)
    if key is None or key not in known:
        return
    if known[key].startswith("--"):
        raise InputError(f"{known[key]} and {flag} both name {path}: give different files")
    named = f"{flag}: " if flag else ""
    raise InputError(
        f"{named}{path} is {known[key]}, which would be overwritten: give another file"
    )


def _inputs() -> dict[Any, str]:
    """Return the files that the open file consists of: a text on each, by its `_key`."""
    paths = dict.fromkeys(bpy.utils.blend_paths(absolute=True), "read by the open file")
    libraries = [bpy.path.abspath(library.filepath) for library in bpy.data.libraries]
    paths |= dict.fromkeys(libraries, "a linked library of the open file")
    paths[bpy.data.filepath] = "the open file itself"
    return {_key(Path(path)): text for path, text in paths.items() if os.path.isfile(path)}


def _key(path: Path) -> Any:
    """Return what identifies a file, however its path is spelt or linked; None for a device."""
    try:
        if path.is_file() or path.is_dir():
            return path.stat().st_dev, path.stat().st_ino
        return None if path.exists() else os.path.normcase(path.resolve())
    except (OSError, ValueError, RuntimeError):
        return None


def _is_whole(saved: BinaryIO) -> bool:
    """Whether a blend file is complete.

    An uncompressed file ends with the block ENDB, a compressed one with its seek table.
    """
    packed = saved.read(4) != b"BLEN"
    saved.seek(-min(64, os.fstat(saved.fileno()).st_size), os.SEEK_END)
    end = saved.read()
    return end.endswith(b"\xb1\xea\x92\x8f") if packed else b"ENDB" in end


def write(texts: Mapping[Path, Content], folder: Path | None = None) -> None:
    """Write all files, or none and no new folder either. Raise AngenError."""
    with Outputs() as outputs:
        outputs.texts.update(texts)
        outputs.folders = [folder] if folder else []
        outputs.commit()


class Outputs(WholeFiles):
    """The outputs of a command.

    They are `texts` by path, new `folders`, a saved blend file, and `printed`, the text for
    standard output. At the end of the context, outputs that were not committed are removed.
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
        """Save a copy of the open file, which `commit` puts in place. Raise AngenError."""
        try:
            # Beside the target, so that relative paths in the file come out right.
            part = self.new(path, ".blend")
            bpy.ops.wm.save_as_mainfile(filepath=str(part), copy=True, check_existing=False)
            with open(part, "rb") as saved:
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
        """Put all outputs in place, or none if one fails.

        Raise AngenError, or OSError if standard output fails.
        """
        check_not_read(self.texts)
        for folder in self.folders:
            if not folder.exists():
                with explained(f"cannot make {folder}", OSError, raised=AngenError):
                    folder.mkdir()
                self._new_folders.append(folder)
        for path, content in self.texts.items():
            self.add(path, content)
        if self.printed and sys.stdout is not None:
            sys.stdout.write(self.printed)
            sys.stdout.flush()
        super().commit()
        self._new_folders = []


# Formats of other tools, written beside the event log.


class Exports:
    """The logs in other formats that a command writes, each with its path.

    Raise AngenError if one cannot be written.
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
        """Raise InputError if a format cannot hold the dates of a run of this many seconds."""
        for target, _ in self._targets:
            target.check_dates(start or DEFAULT_START, 0.0, seconds)

    @property
    def files(self) -> dict[str, Path | None]:
        """The paths that are files, not folders, by their names in messages."""
        return {
            f"--out {number} ({target.name})": out
            for number, (target, out) in enumerate(self._targets, start=1)
            if not target.is_folder
        }

    def add_to(self, outputs: Outputs, log: Log) -> Iterator[str]:
        """Add the files to the outputs, and yield notes on what a format cannot hold.

        Raise AngenError.
        """
        for target, out in self._targets:
            written = target.write(log)
            if target.is_folder:
                outputs.folders.append(out)
            outputs.texts |= output_files(target, out, written)
            yield from written.notes
