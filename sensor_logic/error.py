# SPDX-License-Identifier: GPL-3.0-or-later
"""The errors of all layers. Each text is one line that says what is wrong, where, and what would
work; a subclass exists only where a caller acts on it."""

from __future__ import annotations


class AngenError(Exception):
    """Something cannot be done. `status`: the exit status of the command line."""

    status = 1


class InputError(AngenError):
    """What the user gave is wrong: a word of the command line, a file, a name, a date."""

    status = 2
