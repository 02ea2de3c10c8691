# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of the formats' writers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class FormatFiles:
    """The contents of a format's files, and notes, a sentence each, about what was left out.

    A format of one file has it under the key "", and files beside it under suffixes of its name
    (".sensors.csv"); a format that is a folder has its files' names as keys.
    """

    files: Mapping[str, str | bytes]
    notes: tuple[str, ...] = ()
