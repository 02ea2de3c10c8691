# SPDX-License-Identifier: GPL-3.0-or-later
"""Output files that are written whole or not at all."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from .temporary_files import TemporaryFiles

# Names that Windows reserves for devices, with any suffix.
DEVICES = re.compile(r"CON|PRN|AUX|NUL|(?:COM|LPT)[0-9¹²³]", re.IGNORECASE)
# A file's content; an iterable of texts is read once, while the file is written.
Content = str | bytes | Iterable[str]


class OutputError(Exception):
    """A file cannot be written; the text says which and why."""


def check_folder(folder: Path, what: str) -> None:
    """Raises OutputError where no file can be written in `folder`, before a long run."""
    if not folder.exists():
        raise OutputError(f"{what}: the folder {folder} does not exist; make it first")
    if not folder.is_dir():
        raise OutputError(f"{what}: {folder} is not a folder")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OutputError(f"{what}: cannot write in {folder}: {error.strerror}") from None


def write_files(texts: Mapping[Path, Content]) -> None:
    """Writes all of `texts`, or, where one fails, none of them. Raises OutputError.

    Links are followed; a device or a pipe is written to, not replaced.
    """
    with TemporaryFiles() as files:
        stage(texts, files)
        commit(texts, files)


def stage(texts: Mapping[Path, Content], files: TemporaryFiles) -> None:
    """Writes `texts` into temporary files beside their targets. Raises OutputError."""
    for path, text in texts.items():
        try:
            if path.is_dir():
                raise OutputError(f"cannot write {path}: it is a folder")
            if _is_special(path):
                continue
            with open(files.new(path), "xb") as file:
                file.writelines(_encoded(text))
                file.flush()
                os.fsync(file.fileno())
        except UnicodeEncodeError:
            raise OutputError(f"cannot write {path}: a name in it is not text in UTF-8") from None
        except OSError as error:
            raise OutputError(f"cannot write {path}: {error.strerror}") from None


def commit(texts: Mapping[Path, Content], files: TemporaryFiles) -> None:
    """Writes those of `texts` that go into pipes and devices, then puts the temporary files in
    place. Raises OutputError."""
    path = Path()
    try:
        for path in filter(_is_special, texts):
            with open(path, "wb") as file:
                file.writelines(_encoded(texts[path]))
        path = Path()
        files.commit()
    except OSError as error:
        what = path if path.name else error.filename
        raise OutputError(f"cannot write {what}: {error.strerror}") from None


def _encoded(content: Content) -> Iterator[bytes]:
    if isinstance(content, bytes):
        yield content
    else:
        pieces = [content] if isinstance(content, str) else content
        yield from (piece.encode() for piece in pieces)


def _is_special(path: Path) -> bool:
    """Whether the path exists and is not a plain file: a device or a pipe such as /dev/null."""
    return path.exists() and not path.is_file()


def file_names(sensors: Iterable[str]) -> dict[str, str]:
    """Sensor → its sample file: its name, with `_` for characters that file systems reject.

    Where two sensors would get the same file (ignoring case), the later one by name gets a number;
    sensors whose name needs no change come first.
    """
    sensors = list(sensors)
    found: dict[str, str] = {}
    taken: set[str] = set()
    for sensor in sorted(sensors, key=lambda name: (_stem(name) != name, name)):
        stem, number = _stem(sensor), 1
        while stem.casefold() in taken:
            number += 1
            stem = f"{_stem(sensor)}-{number}"
        taken.add(stem.casefold())
        found[sensor] = f"{stem}.csv"
    return {sensor: found[sensor] for sensor in sensors}


def _stem(sensor: str) -> str:
    stem = re.sub(r'[<>:"/\\|?*\x00-\x1f]', "_", sensor).strip(" .") or "_"
    return f"{stem}_" if DEVICES.fullmatch(stem.partition(".")[0].strip()) else stem
