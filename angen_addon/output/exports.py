# SPDX-License-Identifier: GPL-3.0-or-later
"""The formats in which a run is written beside its event log."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path

from ...sensor_logic.error import InputError
from ...sensor_logic.formats import FORMATS, Log
from ...sensor_logic.formats.log import DEFAULT_START
from ...sensor_logic.formats.outputs import check_out, output_files
from .output_files import Outputs


class Exports:
    """Formats, each with its path. Raises AngenError where one could not be written."""

    def __init__(self, names: Sequence[str], outs: Sequence[Path]) -> None:
        if len(names) != len(outs):
            raise InputError(
                f"{len(names)} --format and {len(outs)} --out: give an --out with each --format"
            )
        self._targets = [(FORMATS[name], out) for name, out in zip(names, outs, strict=True)]
        for target, out in self._targets:
            check_out(target, out)

    def check_dates(self, start: datetime | None, seconds: float) -> None:
        """Raises InputError where a format cannot hold the dates of a run of so many seconds."""
        for target, _ in self._targets:
            target.check_dates(start or DEFAULT_START, 0.0, seconds)

    @property
    def files(self) -> dict[str, Path | None]:
        """The paths that are files, not folders, by their names in messages."""
        return {
            f"--out {number} ({target.name})": out
            for number, (target, out) in enumerate(self._targets, start=1)
            if not target.is_folder
        }

    def add_to(self, outputs: Outputs, log: Log) -> Iterator[str]:
        """Adds the files to the outputs; yields notes on what a format cannot hold. Raises
        AngenError."""
        for target, out in self._targets:
            written = target.write(log)
            if target.is_folder:
                outputs.folders.append(out)
            outputs.texts |= output_files(target, out, written)
            yield from written.notes
