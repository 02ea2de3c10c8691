# SPDX-License-Identifier: GPL-3.0-or-later
"""What commands say to their user, on standard error: out of the way of the events."""

from __future__ import annotations

import contextlib
import sys
from typing import TextIO


def note(text: str) -> None:
    """A line for the user."""
    tell(f"angen: {' '.join(text.split())}\n")


def tell(text: str, stream: TextIO | None = None) -> None:
    """Writes to `stream`, or standard error. Where that is closed, or its disk is full, there is
    nobody to tell, and the results do not depend on it."""
    stream = stream or sys.stderr
    if stream is not None:
        with contextlib.suppress(OSError, ValueError):
            stream.write(text)
            stream.flush()
