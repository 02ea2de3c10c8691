# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory of this process that nothing uses any more."""

from __future__ import annotations

import ctypes
import sys
from contextlib import suppress


def give_back() -> None:
    """Gives what was freed back to the system, where the C library can be told to (glibc's): after
    a day it keeps some 100 MB, a little more after each."""
    if sys.platform == "linux":
        with suppress(AttributeError, OSError):
            ctypes.CDLL(None).malloc_trim(0)
