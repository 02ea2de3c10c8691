# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors that all modules raise.

The text of an error is one line: what is wrong, where it is, and what would work. A subclass exists
only for errors that some caller handles in a different way.
"""

from __future__ import annotations

import codecs
import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class AngenError(Exception):
    """An error to show to the user; `status` is the exit status of the command line."""

    status = 1


class InputError(AngenError):
    """Invalid input from the user: an argument of the command line, a file, a name, a date."""

    status = 2


@contextmanager
def explained(
    where: str, *kinds: type[Exception], raised: type[Exception] = InputError
) -> Iterator[None]:
    """Context manager: raise errors of the types `kinds` as `raised`, with `where` in front.

    For an OSError, the text is only its reason, such as "No such file or directory".
    """
    try:
        yield
    except kinds as error:
        why = error.strerror if isinstance(error, OSError) else error
        # Windows calls it a lack of permission if a folder is opened as a file.
        if isinstance(error, PermissionError) and error.filename is not None:
            folder = os.path.isdir(error.filename) and os.access(error.filename, os.R_OK)
            why = os.strerror(errno.EISDIR) if folder else why
        raise raised(f"{where}: {why}") from None


@contextmanager
def decoded(path: Path) -> Iterator[None]:
    """Context manager: raise InputError if the file that is read here is not a text in UTF-8."""
    try:
        yield
    except UnicodeDecodeError as error:
        check_mark(path, error.object)
        raise InputError(
            f"{path} is not a text file in UTF-8: save it as such (in Excel as CSV UTF-8)"
        ) from None


def check_mark(path: Path, begin: bytes) -> None:
    """Raise InputError if the first bytes of a file say that it is in UTF-16."""
    if begin[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        raise InputError(
            f"{path} is in UTF-16, as > in Windows PowerShell writes: save it as UTF-8, or write "
            "it by an option such as --events or --out"
        ) from None


@contextmanager
def replaced(
    text: str, *kinds: type[Exception], raised: type[Exception] = InputError
) -> Iterator[None]:
    """Context manager: raise errors of the types `kinds` as `raised`, with the text `text`."""
    try:
        yield
    except kinds:
        raise raised(text) from None
