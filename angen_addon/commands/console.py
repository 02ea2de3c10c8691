# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages to the user on standard error, apart from the events on standard output."""

from __future__ import annotations

import contextlib
import sys
from typing import TextIO

# Exit statuses.
DONE, FAILED, BAD_INPUT = 0, 1, 2


def note(text: str) -> None:
    """Prints one line for the user."""
    tell(f"angen: {' '.join(text.split())}\n")


def tell(text: str, stream: TextIO | None = None) -> None:
    """Writes to `stream` (default: standard error). Ignores errors, such as a closed stream, so
    that they do not end the run."""
    stream = stream or sys.stderr
    if stream is not None:
        with contextlib.suppress(OSError, ValueError):
            stream.write(text)
            stream.flush()
