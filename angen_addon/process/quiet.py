# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps Blender's messages out of what a command writes to standard output."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator


def fill_closed_streams() -> None:
    """Opens the null device in place of standard input, output or error that is closed, as by
    `>&-`: else the next file that is opened would take its number, and get what is printed."""
    for handle in range(3):
        try:
            os.fstat(handle)
        except OSError:
            # The lowest number that is free is given out.
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:
        # To Python's print no stream at all means standard output.
        sys.stderr = open(os.devnull, "w")  # type: ignore[unreachable]  # noqa: SIM115


@contextlib.contextmanager
def standard_output_silenced() -> Iterator[None]:
    """Keeps Blender's own chatter out of the events on standard output."""
    fill_closed_streams()
    own = sys.stdout
    if own is not None:
        own.flush()
        # Blender writes what operators report by way of Python.
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
