# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps Blender's messages out of standard output, where the events go."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator


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
