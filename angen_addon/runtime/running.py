# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a run is changing the frame. Blender's handlers do nothing meanwhile."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ..scene.memory import forgets_at_undo

# The number of runs that are changing the frame, one within the other.
_count = 0
_is_publishing = False


def is_running() -> bool:
    """Return whether a run, or other work of this extension, is changing the frame."""
    return _count > 0


@contextmanager
def running() -> Iterator[None]:
    """Context manager: in between, handlers do nothing, because the frame changes for a run."""
    global _count
    _count += 1
    try:
        yield
    finally:
        # Undo may have ended it.
        _count = max(_count - 1, 0)


def is_publishing() -> bool:
    """Return whether the run is evaluating the drivers that read outputs."""
    return _is_publishing


@contextmanager
def publishing() -> Iterator[None]:
    """Context manager: in between, the run evaluates the drivers that read outputs."""
    global _is_publishing
    _is_publishing = True
    try:
        yield
    finally:
        _is_publishing = False


@forgets_at_undo
def _end() -> None:
    global _count
    _count = 0
