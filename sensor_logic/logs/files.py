# SPDX-License-Identifier: GPL-3.0-or-later
"""Output files that are written completely or not at all, also if a run writes several."""

from __future__ import annotations

import contextlib
import importlib
import os
import re
import tempfile
import time
import unicodedata
import zlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Self

from .error import AngenError, InputError, decoded, explained, replaced

# Windows has no `fcntl`, but on Windows an open file cannot be removed, which serves as the lock.
SYSTEM = os.name
fcntl: Any = importlib.import_module("fcntl") if SYSTEM == "posix" else None

# The names of temporary files. Blender adds an @ while it saves.
OURS = re.compile(r"(\.angen-\w{8,12})(?:-\d+)?\.(?:part|blend|lock)@?")
# Names that Windows reserves for devices, with any suffix.
DEVICES = re.compile(r"CON|PRN|AUX|NUL|(?:COM|LPT)[0-9¹²³]", re.IGNORECASE)
# The greatest length of a file's name without suffix and number, in bytes: file systems take 255.
LONGEST = 240
# How often and how long (s) to wait for a program that has a new file open.
PATIENCE_TRIES, PATIENCE_S = 10, 0.1
# The content of a file. An iterable of its parts is consumed once, while the file is written.
Content = str | bytes | Iterable[str] | Iterable[bytes]


class InUseError(AngenError):
    """Another program has the file open, so that Windows does not replace it."""


def check_folder(folder: Path, what: str) -> None:
    """Raise AngenError if no file can be written in `folder`.

    Call this before a long run. The message begins with `what`.
    """
    if not folder.exists():
        raise InputError(f"{what}: the folder {folder} does not exist; make it first")
    if not folder.is_dir():
        raise InputError(f"{what}: {folder} is not a folder")
    # The name is as long as the longest temporary one, since systems limit the length of a path.
    with explained(f"{what}: cannot write in {folder}", OSError):
        tempfile.NamedTemporaryFile(prefix=".angen-", suffix="-999.blend@", dir=folder).close()


def check_target(path: Path, what: str) -> None:
    """Raise AngenError if `path` is a file that cannot be replaced; `InUseError` if it is open.

    Windows replaces no file that another program has open in the usual way, as Excel does, and
    no file that is read-only. The message begins with `what`.
    """
    if not path.is_file():
        return
    try:
        # To its own name: this needs the right to replace the file, and changes nothing.
        target = path.resolve()
        target.rename(target)
    except PermissionError:
        raise InUseError(
            f"{what}: another program has {path} open: close it there, or give another name"
        ) from None
    if SYSTEM == "nt" and not os.access(path, os.W_OK):
        raise AngenError(f"{what}: {path} is read-only: give another name")


def is_same_file(one: Path, other: Path) -> bool:
    """Return whether two paths lead to one file, also through links.

    On macOS and Windows, the letters of the paths can differ in case.
    """
    if one.exists() and other.exists():
        return one.samefile(other)
    return one.resolve() == other.resolve()


def read_text(path: Path) -> str:
    """Return the text of a file that a user named. Raise InputError if it cannot be read."""
    with (
        explained(f"cannot read {path}", OSError),
        decoded(path),
    ):
        return path.read_text(encoding="utf-8-sig")


def write_files(texts: Mapping[Path, Content]) -> None:
    """Write all of `texts`. If one cannot be written, write none and raise AngenError."""
    with WholeFiles() as files:
        for path, content in texts.items():
            files.add(path, content)
        files.commit()


class WholeFiles:
    """Context manager: several files that `commit` moves to their targets together.

    Before `commit`, each is a temporary file in the folder of its target. On exit, temporary files
    that were not moved are removed. In each folder, a locked file shows that this process is
    running. If a process was killed, the next process that writes to the folder removes its
    temporary files.
    """

    def __init__(self) -> None:
        self._locks: dict[Path, tuple[int, Path]] = {}
        self._waiting: list[tuple[Path, Path]] = []
        self._streams: dict[Path, Content] = {}
        self._count = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for part, _target in self._waiting:
            _remove(part, part.with_name(f"{part.name}@"))
        for handle, lock in self._locks.values():
            os.close(handle)
            _remove(lock)

    def new(self, target: Path, suffix: str = ".part") -> Path:
        """Return the path of a temporary file that `commit` will move to `target`. Raise OSError.

        If `target` is a link, the file that it points to is replaced.
        """
        target = target.resolve()
        if target.parent not in self._locks:
            _remove_leftovers(target.parent)
            self._locks[target.parent] = _lock(target.parent)
        lock = self._locks[target.parent][1]
        part = lock.with_name(f"{lock.stem}-{self._count}{suffix}")
        self._count += 1
        self._waiting.append((part, target))
        return part

    def add(self, path: Path, content: Content) -> None:
        """Write `content` to a temporary file that `commit` will move to `path`. Raise AngenError.

        If `path` is a pipe or a device such as /dev/null, nothing is written before `commit`.
        """
        with _named_errors(path):
            if path.is_dir():
                raise AngenError(f"cannot write {path}: it is a folder")
            if path.exists() and not path.is_file():
                self._streams[path] = content
                return
            with open(self.new(path), "xb") as file:
                file.writelines(_encoded(content))
                file.flush()
                os.fsync(file.fileno())

    def check_targets(self) -> None:
        """Raise AngenError if a target is a file that cannot be replaced."""
        for _part, target in self._waiting:
            with _named_errors(target):
                check_target(target, "nothing was written")

    def commit(self) -> None:
        """Move the files to their targets, in the order in which they were added.

        If one of the targets cannot be replaced, move none and raise AngenError.
        """
        self.check_targets()
        for path, content in self._streams.items():
            with _named_errors(path), open(path, "wb") as file:
                file.writelines(_encoded(content))
        while self._waiting:
            part, target = self._waiting[0]
            with _named_errors(target):
                _move(part, target)
            del self._waiting[0]


def _move(part: Path, target: Path) -> None:
    """Move a new file to its target.

    On Windows, virus scanners and programs that synchronise folders open a new file for a moment,
    in which it cannot be moved.
    """
    for _ in range(PATIENCE_TRIES if SYSTEM == "nt" else 0):
        with contextlib.suppress(PermissionError):
            os.replace(part, target)
            return
        time.sleep(PATIENCE_S)
    os.replace(part, target)


@contextlib.contextmanager
def _named_errors(path: Path) -> Iterator[None]:
    why = f"cannot write {path}"
    no_text = f"{why}: a name in it is not valid UTF-8"
    with (
        explained(why, OSError, raised=AngenError),
        replaced(no_text, UnicodeEncodeError, raised=AngenError),
    ):
        yield


def _encoded(content: Content) -> Iterable[bytes]:
    if isinstance(content, bytes):
        return [content]
    pieces = [content] if isinstance(content, str) else content
    return (piece.encode() if isinstance(piece, str) else piece for piece in pieces)


def gzipped(texts: Iterable[str]) -> Iterator[bytes]:
    """Yield a gzip file of `texts` in parts. It has no date: equal texts give equal bytes."""
    # 16 more than the usual window makes zlib write the header and the end of a gzip file.
    packer = zlib.compressobj(wbits=16 + zlib.MAX_WBITS)
    for text in texts:
        yield packer.compress(text.encode())
    yield packer.flush()


def _lock(folder: Path) -> tuple[int, Path]:
    """Return the handle and the path of a new lock file in `folder`, locked by this process."""
    while True:
        handle, name = tempfile.mkstemp(".lock", ".angen-", folder)
        # On a file system without locks, `_remove_leftovers` removes nothing.
        with contextlib.suppress(OSError):
            if fcntl is not None:
                fcntl.flock(handle, fcntl.LOCK_EX)
        # Another process can remove the file before it is locked.
        if os.path.exists(name):
            return handle, Path(name)
        os.close(handle)


def _remove_leftovers(folder: Path) -> None:
    """Remove the temporary files in `folder` of processes that have ended."""
    parts = [path for path in folder.glob(".angen-*") if OURS.fullmatch(path.name)]
    for stem in {OURS.sub(r"\1", part.name) for part in parts}:
        lock = folder / f"{stem}.lock"
        with contextlib.suppress(OSError), contextlib.ExitStack() as opened:
            if fcntl is not None and lock.exists():
                file = opened.enter_context(open(lock, "r+b"))
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            lock.unlink(missing_ok=True)
            _remove(*(part for part in parts if OURS.sub(r"\1", part.name) == stem))


def _remove(*paths: Path) -> None:
    for path in paths:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)


def file_names(sensors: Iterable[str]) -> dict[str, str]:
    """Return the name of the sample file of each sensor.

    It is the sensor's name, with `_` in place of characters that file systems reject, and without
    the end of a name that is too long. If two files would be the same one on some system, one of
    them gets a number: macOS and Windows ignore case, and macOS how accents are encoded. A sensor
    whose name needed no change gets no number.
    """
    sensors = list(sensors)
    found: dict[str, str] = {}
    taken: set[str] = set()
    for sensor in sorted(sensors, key=lambda name: (_stem(name) != name, name)):
        stem, number = _stem(sensor), 1
        while _folded(stem) in taken:
            number += 1
            stem = f"{_stem(sensor)}-{number}"
        taken.add(_folded(stem))
        found[sensor] = f"{stem}.csv"
    return {sensor: found[sensor] for sensor in sensors}


def _stem(sensor: str) -> str:
    stem = re.sub(r'[<>:"/\\|?*\x00-\x1f]', "_", sensor)
    stem = stem.encode(errors="surrogatepass")[:LONGEST].decode(errors="ignore").strip(" .") or "_"
    return f"{stem}_" if DEVICES.fullmatch(stem.partition(".")[0].strip()) else stem


def _folded(stem: str) -> str:
    """Return a text that is equal for all stems that name one file on some system."""
    return unicodedata.normalize("NFC", unicodedata.normalize("NFD", stem).casefold())
