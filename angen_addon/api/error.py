# SPDX-License-Identifier: GPL-3.0-or-later
"""The one error of the Python package. It can be named without Blender."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class AngenError(Exception):
    """What was asked for cannot be done; the text says why, and what would work, in one line."""


@contextmanager
def raised_as_angen_error(*errors: type[Exception]) -> Iterator[None]:
    """Turns errors whose text is one clear line into `AngenError`."""
    try:
        yield
    except errors as error:
        raise AngenError(str(error)) from error
