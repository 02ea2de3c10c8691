# SPDX-License-Identifier: GPL-3.0-or-later
"""The standard streams and the memory of this process."""

from __future__ import annotations

import contextlib
import ctypes
import io
import os
import sys
from collections.abc import Iterator
from contextlib import suppress

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
