# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads the extension from its folder, and opens a file, where no window of Blender does it; keeps
Blender's messages out of standard output."""

from __future__ import annotations

import contextlib
import ctypes
import importlib.util
import io
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from types import ModuleType

PACKAGE = "angen_sensors"


def load_extension() -> ModuleType:
    """The extension's root package, as `angen_sensors`; call its `register()`."""
    if PACKAGE in sys.modules:
        return sys.modules[PACKAGE]
    root = Path(__file__).resolve().parents[2]
    spec = importlib.util.spec_from_file_location(
        PACKAGE, root / "__init__.py", submodule_search_locations=[str(root)]
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[PACKAGE] = module
    spec.loader.exec_module(module)
    return module


def unreadable(file: Path) -> str:
    """Why `file` cannot be a blend file, as far as that shows without Blender."""
    try:
        with open(file, "rb") as opened:
            start = opened.read(7)
    except IsADirectoryError:
        return f"{file} is a folder; give a blend file"
    except OSError as error:
        return f"cannot read {file}: {error.strerror}"
    if not start:
        return f"{file} is empty"
    # Plain, gzip and Zstandard blend files.
    if not (start == b"BLENDER" or start[:2] == b"\x1f\x8b" or start[:4] == b"\x28\xb5\x2f\xfd"):
        return f"{file} is not a blend file"
    return ""


def open_file(file: Path, trusted: bool) -> str:
    """Opens `file`, with its Python if it is trusted; returns why that failed, in a line."""
    import bpy

    try:
        path = str(file.absolute())
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=trusted)
    except RuntimeError as error:
        reason = " ".join(str(error).removeprefix("Error:").split())
        return f"cannot open {file}: {reason}"
    return ""


# Keeps Blender's messages out of standard output, where the events go.


def fill_closed_streams() -> None:
    """Opens the null device in place of a closed standard input, output or error (`>&-`): else the
    next file that the process opens would get its number, and then what is printed."""
    for handle in range(3):
        try:
            os.fstat(handle)
        except OSError:
            # The system assigns the lowest free number.
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:
        # Without it, print(file=sys.stderr) would write to standard output.
        sys.stderr = open(os.devnull, "w")  # type: ignore[unreachable]  # noqa: SIM115


@contextlib.contextmanager
def standard_output_silenced() -> Iterator[None]:
    """Sends standard output to the null device while Blender works."""
    fill_closed_streams()
    own = sys.stdout
    if own is not None:
        own.flush()
        # Blender prints reports of operators through Python.
        sys.stdout = io.StringIO()
    saved = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        sys.stdout = own
        os.dup2(saved, 1)
        os.close(saved)
        os.close(nowhere)


# Memory of this process that nothing uses any more.


def give_back() -> None:
    """Gives what was freed back to the system, where the C library can be told to (glibc's): after
    a day it keeps some 100 MB, a little more after each."""
    if sys.platform == "linux":
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).malloc_trim(0)
