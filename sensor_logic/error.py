# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors of all layers. Each text is one line that says what is wrong, where, and what would
work; a subclass exists only where a caller acts on it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class AngenError(Exception):
    """Something cannot be done. `status`: the exit status of the command line."""

    status = 1


class InputError(AngenError):
    """What the user gave is wrong: a word of the command line, a file, a name, a date."""

    status = 2


@contextmanager
def explained(
    where: str, *kinds: type[Exception], raised: type[Exception] = InputError
) -> Iterator[None]:
    """Raise errors of these kinds, such as OSError, as `raised`, with `where` before what they
    say."""
    try:
        yield
    except kinds as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise raised(f"{where}: {why}") from None


@contextmanager
def replaced(
    text: str, *kinds: type[Exception], raised: type[Exception] = InputError
) -> Iterator[None]:
    """Raise errors of these kinds as `raised` with this text."""
    try:
        yield
    except kinds:
        raise raised(text) from None
