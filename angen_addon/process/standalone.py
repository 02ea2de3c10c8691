# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions that load the extension and open a file in a process without Blender's window.

They keep Blender's messages out of standard output.
"""

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
    """Import and return the extension's root package `angen_sensors`, without registering it."""
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
    """Return a text on why `file` cannot be a blend file; empty if it can be one.

    Only the first bytes of the file are checked. This function does not need Blender.
    """
    try:
        with open(file, "rb") as opened:
            start = opened.read(7)
    except IsADirectoryError:
        return f"{file} is a folder; give a blend file"
    except OSError as error:
        return f"cannot read {file}: {error.strerror}"
    if not start:
        return f"{file} is empty: give a blend file"
    # Plain, gzip and Zstandard blend files.
    if not (start == b"BLENDER" or start[:2] == b"\x1f\x8b" or start[:4] == b"\x28\xb5\x2f\xfd"):
        return f"{file} is not a blend file: give one"
    return ""


def open_file(file: Path, trusted: bool) -> str:
    """Open `file` in Blender, and return the error as one line; empty without an error.

    `trusted` says whether drivers and scripts in the file may run Python.
    """
    import bpy

    try:
        path = str(file.absolute())
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=trusted)
    except RuntimeError as error:
        reason = " ".join(str(error).removeprefix("Error:").split())
        return f"cannot open {file}: {reason}"
    return ""


# Standard output carries the events alone: Blender's messages are silenced.


def fill_closed_streams() -> None:
    """Open the null device for each closed standard stream: input, output or error.

    A shell closes standard output by `>&-`, for example. Without this function, the next file that
    the process opens would get the free file descriptor, and with it the texts for standard output.
    """
    for handle in range(3):
        try:
            os.fstat(handle)
        except OSError:
            # The system assigns the lowest free number.
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:
        # Without it, print(file=sys.stderr) would write to standard output.
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # type: ignore[unreachable]  # noqa: SIM115


@contextlib.contextmanager
def standard_output_silenced() -> Iterator[None]:
    """Context manager: send standard output to the null device until exit."""
    fill_closed_streams()
    output = sys.stdout
    if output is not None:
        output.flush()
        # Blender prints reports of operators through Python.
        sys.stdout = io.StringIO()
    saved = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        sys.stdout = output
        os.dup2(saved, 1)
        os.close(saved)
        os.close(nowhere)


# The memory of the process.


def release_memory() -> None:
    """Return freed memory to the operating system, if the C library has a function for it (glibc).

    Without this call, a process keeps some 100 MB after simulating a day, and a little more after
    each further day.
    """
    if sys.platform == "linux":
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).malloc_trim(0)
