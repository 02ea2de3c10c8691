# SPDX-License-Identifier: GPL-3.0-or-later
"""The one error of the Python package; importing it needs no Blender."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class AngenError(Exception):
    """A call failed; the text says in one line why, and what would work."""


@contextmanager
def raised_as_angen_error(*errors: type[Exception]) -> Iterator[None]:
    """Turns errors whose text is one clear line into `AngenError`."""
    try:
        yield
    except errors as error:
        raise AngenError(str(error)) from error
