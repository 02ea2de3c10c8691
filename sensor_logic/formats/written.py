# SPDX-License-Identifier: GPL-3.0-or-later
"""What a format gives back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Written:
    """The files of a format, and what it could not hold, a sentence each.

    A format of one file has it under "", and beside it files whose names go on from its own
    (".sensors.csv"); a format that is a folder has the names of its files.
    """

    files: Mapping[str, str | bytes]
    notes: tuple[str, ...] = ()


class FormatError(Exception):
    """A log cannot be written in a format; the text says why and what would work."""
