# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are written apart, beside where they belong, and land there together at the end.

In each folder a locked file says that the parts there are being written. A process that is killed
loses the lock, so that the next one that writes there knows what it may remove.
"""

from __future__ import annotations

import importlib
import os
import re
import secrets
from pathlib import Path
from typing import IO, Any

# On Windows a file that is open cannot be removed, which is as good as a lock.
fcntl: Any = importlib.import_module("fcntl") if os.name == "posix" else None

# Blender adds an @ while it saves; names of eight letters are those of earlier versions.
OURS = re.compile(r"\.angen-(\w{8,12})(?:-\d+)?\.(?:part|blend|lock)@?")


class Parts:
    """Parts of files: `new` names one for a target, `land` puts all in place; as a context, whose
    end removes what did not land. Raises OSError."""

    def __init__(self) -> None:
        self._claims: dict[Path, tuple[str, IO[bytes]]] = {}
        self._waiting: list[tuple[Path, Path]] = []
        self._count = 0

    def __enter__(self) -> Parts:
        return self

    def __exit__(self, *_: object) -> None:
        for part, _target in self._waiting:
            _remove(part)
            _remove(part.with_name(f"{part.name}@"))
        self._waiting.clear()
        for folder, (token, lock) in self._claims.items():
            _remove(_lock_path(folder, token))
            lock.close()
            # Windows: not before.
            _remove(_lock_path(folder, token))
        self._claims.clear()

    def new(self, target: Path, suffix: str = ".part") -> Path:
        """A path beside `target`, links followed, for what will take its place."""
        target = target.resolve()
        if target.parent not in self._claims:
            sweep(target.parent)
            self._claims[target.parent] = _claim(target.parent)
        token, _ = self._claims[target.parent]
        part = target.with_name(f".angen-{token}-{self._count}{suffix}")
        self._count += 1
        self._waiting.append((part, target))
        return part

    def land(self) -> None:
        """Puts all parts where they belong, in the order in which they were made."""
        mask = umask()
        for part, _target in self._waiting:
            part.chmod(0o666 & ~mask)
        while self._waiting:
            part, target = self._waiting[0]
            try:
                os.replace(part, target)
            except OSError as error:
                # The part is there: it is the target that cannot be taken.
                raise OSError(error.errno, error.strerror, str(target)) from None
            self._waiting.pop(0)


def sweep(folder: Path) -> None:
    """Removes parts in `folder` that were left by processes which are no more."""
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
        lock = open(path, "xb")  # noqa: SIM115  (it is open for as long as the parts are written)
        # Another process may sweep between these two steps.
        if _locked(lock, otherwise=True) and path.exists():
            return token, lock
        lock.close()


def _is_left(path: Path) -> bool:
    """Whether the process of this lock is no more; then the lock is removed."""
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
    # Windows: not before it is closed here, and not while it is open elsewhere.
    return _remove(path)


def _locked(lock: IO[bytes], otherwise: bool) -> bool:
    """Locks the file; False where another process has it. `otherwise`: where nothing can lock."""
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
    """The permissions that new files of this process do not get."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
