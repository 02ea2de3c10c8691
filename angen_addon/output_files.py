# SPDX-License-Identifier: GPL-3.0-or-later
"""What a command writes: checked before a long run, written whole or not at all after it."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

import bpy

from ..sensor_logic.files import OutputError, check_folder, umask, write_files
from .quiet import standard_output_silenced


def check_outputs(
    events: Path | None, samples: Path | None, save: Path | None, report: Path | None = None
) -> None:
    """Raises OutputError where the results of a run could not be written."""
    for path, flag in ((events, "--events"), (save, "--save"), (report, "--report")):
        if path is not None:
            _check_file(path, flag)
    if save is not None and save.exists() and not save.is_file():
        raise OutputError(f"--save: {save} is not a plain file")
    if events is not None and save is not None and events.resolve() == save.resolve():
        raise OutputError(f"--events and --save both name {save}: give two files")
    for path, flag in ((events, "--events"), (save, "--save")):
        if path is not None and report is not None and path.resolve() == report.resolve():
            raise OutputError(f"{flag} and --report both name {report}: give two files")
    if samples is not None:
        try:
            folder = samples if samples.exists() or samples.is_symlink() else samples.parent
        except OSError as error:
            raise OutputError(f"--samples: {samples}: {error.strerror}") from None
        check_folder(folder, "--samples")


def _check_file(path: Path, flag: str) -> None:
    try:
        is_folder = path.is_dir()
        path.exists()
    except OSError as error:
        raise OutputError(f"{flag}: {path}: {error.strerror}") from None
    if is_folder:
        raise OutputError(f"{flag}: {path} is a folder, not a file name")
    check_folder(path.parent, flag)


def write(texts: dict[Path, str], folder: Path | None) -> None:
    """Writes all files, or none and no new folder either. Raises OutputError."""
    new_folder = folder if folder and not folder.exists() else None
    try:
        if new_folder:
            new_folder.mkdir()
        write_files(texts)
    except BaseException as error:
        if new_folder and new_folder.exists():
            new_folder.rmdir()
        if isinstance(error, OSError):
            raise OutputError(f"cannot make {folder}: {error.strerror}") from None
        raise


def save_blend(path: Path) -> None:
    """Saves a copy of the open file, whole or not at all. Raises OutputError."""
    path = path.resolve()
    part = None
    try:
        # Beside the target, so that relative paths in the file come out right.
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=".angen-", suffix=".blend")
        os.close(handle)
        part = Path(name)
        # Of a file that exists Blender would keep a backup.
        part.unlink()
        with standard_output_silenced():
            bpy.ops.wm.save_as_mainfile(filepath=name, copy=True, check_existing=False)
        part.chmod(0o666 & ~umask())
        part.replace(path)
    except (OSError, RuntimeError) as error:
        raise OutputError(f"cannot save {path}: {error}") from None
    finally:
        if part is not None:
            part.unlink(missing_ok=True)
