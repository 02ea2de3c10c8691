# SPDX-License-Identifier: GPL-3.0-or-later
"""Temporary files beside their targets, which replace the targets together at the end.

A lock file in each folder says that its temporary files are being written. A process that is killed
loses the lock, so the next process that writes there knows which files it may remove.
"""

from __future__ import annotations

import importlib
import os
import re
import secrets
from pathlib import Path
from typing import IO, Any

# Windows has no `fcntl`; there an open file cannot be removed, which serves as the lock.
fcntl: Any = importlib.import_module("fcntl") if os.name == "posix" else None

# Blender adds an @ while it saves; earlier versions used names of eight letters.
OURS = re.compile(r"\.angen-(\w{8,12})(?:-\d+)?\.(?:part|blend|lock)@?")


class TemporaryFiles:
    """Temporary files of one write: `new` names one for a target, `commit` replaces the targets by
    them. Leaving the context removes those that were not committed. Raises OSError."""

    def __init__(self) -> None:
        self._claims: dict[Path, tuple[str, IO[bytes]]] = {}
        self._waiting: list[tuple[Path, Path]] = []
        self._count = 0

    def __enter__(self) -> TemporaryFiles:
        return self

    def __exit__(self, *_: object) -> None:
        for part, _target in self._waiting:
            _remove(part)
            _remove(part.with_name(f"{part.name}@"))
        self._waiting.clear()
        for folder, (token, lock) in self._claims.items():
            _remove(_lock_path(folder, token))
            lock.close()
            # Windows cannot remove it while it is open.
            _remove(_lock_path(folder, token))
        self._claims.clear()

    def new(self, target: Path, suffix: str = ".part") -> Path:
        """The path of a temporary file beside `target` (links are followed)."""
        target = target.resolve()
        if target.parent not in self._claims:
            sweep(target.parent)
            self._claims[target.parent] = _claim(target.parent)
        token, _ = self._claims[target.parent]
        part = target.with_name(f".angen-{token}-{self._count}{suffix}")
        self._count += 1
        self._waiting.append((part, target))
        return part

    def commit(self) -> None:
        """Replaces each target by its temporary file, in the order in which they were made."""
        mask = umask()
        for part, _target in self._waiting:
            part.chmod(0o666 & ~mask)
        while self._waiting:
            part, target = self._waiting[0]
            try:
                os.replace(part, target)
            except OSError as error:
                # The temporary file exists: it is the target that cannot be replaced.
                raise OSError(error.errno, error.strerror, str(target)) from None
            self._waiting.pop(0)


def sweep(folder: Path) -> None:
    """Removes the temporary files in `folder` whose process has ended."""
    try:
        names = [name for name in os.listdir(folder) if OURS.fullmatch(name)]
    except OSError:
        return
    tokens: dict[str, list[str]] = {}
    for name in names:
        tokens.setdefault(OURS.sub(r"\1", name), []).append(name)
    for token, parts in tokens.items():
        if _is_left(_lock_path(folder, token)):
            for name in parts:
                _remove(folder / name)


def _lock_path(folder: Path, token: str) -> Path:
    return folder / f".angen-{token}.lock"


def _claim(folder: Path) -> tuple[str, IO[bytes]]:
    while True:
        token = secrets.token_hex(6)
        path = _lock_path(folder, token)
        lock = open(path, "xb")  # noqa: SIM115  (open as long as the temporary files are written)
        # Another process may sweep between these two steps.
        if _locked(lock, otherwise=True) and path.exists():
            return token, lock
        lock.close()


def _is_left(path: Path) -> bool:
    """Whether the process that made this lock has ended; if so, removes the lock."""
    try:
        lock = open(path, "rb")  # noqa: SIM115  (closed below)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    with lock:
        if not _locked(lock, otherwise=fcntl is None):
            return False
        if _remove(path):
            return True
    # Windows cannot remove it before it is closed here, or while another process has it open.
    return _remove(path)


def _locked(lock: IO[bytes], otherwise: bool) -> bool:
    """Locks the file; False where another process holds the lock. `otherwise` is the answer where
    the system or the file system has no locks."""
    if fcntl is None:
        return otherwise
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return otherwise
    return True


def _remove(path: Path) -> bool:
    try:
        path.unlink(missing_ok=True)
    except OSError:
        return False
    return True


def umask() -> int:
    """The permission bits that this process removes from new files."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
