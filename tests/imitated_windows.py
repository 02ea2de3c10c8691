# SPDX-License-Identifier: GPL-3.0-or-later
"""Files as Windows has them, for all tests: `ANGEN_WINDOWS=1 make test`, on Linux.

Text files get CR LF as line ends, a folder cannot be opened, a file that is open can be neither
removed nor replaced, and `os.rename` replaces none. It holds for this process, not for those that
tests start.
"""

from __future__ import annotations

import builtins
import contextlib
import io
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

_open = io.open


def imitate() -> None:
    """Replace the functions on files of this process."""
    builtins.open = io.open = _open_as_windows  # type: ignore[assignment]
    for name in ("unlink", "remove", "rename", "replace"):
        setattr(os, name, _guarded(name, getattr(os, name)))


def without_locks() -> None:
    """Let the product see a Windows: it has no `fcntl`. Call it once its modules are loaded."""
    for name, module in list(sys.modules.items()):
        if name.endswith("sensor_logic.logs.files"):
            module.SYSTEM, module.fcntl = "nt", None  # type: ignore[attr-defined]


def _open_as_windows(file: Any, mode: str = "r", *more: Any, **options: Any) -> Any:
    if "opener" not in options and isinstance(file, (str, os.PathLike)) and os.path.isdir(file):
        raise PermissionError(13, "Permission denied", str(file))
    is_plain = options.get("newline") is None and len(more) < 4
    if is_plain and not {"b", "r", "+"} & set(mode):
        given = dict(zip(("buffering", "encoding", "errors"), more, strict=False))
        return _open(file, mode, **{**given, **options, "newline": "\r\n"})
    return _open(file, mode, *more, **options)


def _guarded(name: str, run: Callable[..., Any]) -> Callable[..., Any]:
    moves = name in ("rename", "replace")

    def guarded(*paths: Any, **options: Any) -> Any:
        for path in paths[: 2 if moves else 1]:
            if _is_open(path, options.get("dir_fd")):
                raise PermissionError(13, "Permission denied", str(path))
        if name == "rename" and os.path.exists(paths[1]) and not os.path.samefile(*paths):
            raise FileExistsError(17, "File exists", str(paths[0]), None, str(paths[1]))
        return run(*paths, **options)

    return guarded


def _is_open(path: Any, folder: int | None) -> bool:
    """Return whether this process has a file open; `folder` is the handle of its folder or None."""
    within = os.getcwd() if folder is None else os.readlink(f"/proc/self/fd/{folder}")
    named = Path(within, os.fsdecode(path))
    if named.is_symlink() or not named.is_file():
        return False
    target = str(named.parent.resolve() / named.name)
    for handle in os.listdir("/proc/self/fd"):
        # The handle of this very list is closed by now.
        with contextlib.suppress(OSError):
            if os.readlink(f"/proc/self/fd/{handle}") == target:
                return True
    return False
