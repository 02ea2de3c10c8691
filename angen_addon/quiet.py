# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps Blender's messages out of what a command writes to standard output."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator


@contextlib.contextmanager
def standard_output_silenced() -> Iterator[None]:
    """Keeps Blender's own chatter out of the events on standard output."""
    sys.stdout.flush()
    saved = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(saved, 1)
        os.close(saved)
        os.close(nowhere)
