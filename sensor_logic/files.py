# SPDX-License-Identifier: GPL-3.0-or-later
"""Output files that are written whole or not at all."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Mapping
from pathlib import Path


class OutputError(Exception):
    """A file cannot be written; the text says which and why."""


def check_folder(folder: Path, what: str) -> None:
    """Raises OutputError where `folder` cannot take a file, before any work is done."""
    if not folder.exists():
        raise OutputError(f"{what}: the folder {folder} does not exist; make it first")
    if not folder.is_dir():
        raise OutputError(f"{what}: {folder} is not a folder")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OutputError(f"{what}: cannot write in {folder}: {error.strerror}") from None


def write_files(texts: Mapping[Path, str]) -> None:
    """Writes all of `texts`, or, where one fails, none of them. Raises OutputError."""
    written: list[tuple[str, Path]] = []
    path = Path()
    try:
        for path, text in texts.items():
            handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=".angen-", suffix=".part")
            written.append((temporary, path))
            with open(handle, "w", encoding="utf-8", newline="") as file:
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(temporary, 0o666 & ~_umask())
        while written:
            temporary, path = written[0]
            os.replace(temporary, path)
            written.pop(0)
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from None
    finally:
        for temporary, _ in written:
            Path(temporary).unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def file_name(sensor: str) -> str:
    """The name of a sensor's sample file: its own, without what file systems do not take."""
    return re.sub(r'[<>:"/\\|?*\x00-\x1f]', "_", sensor).strip(" .") or "_"
