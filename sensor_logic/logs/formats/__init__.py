# SPDX-License-Identifier: GPL-3.0-or-later
"""Event logs in the formats of other tools.

A new format is a module in this folder and an entry in `FORMATS` below.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime, timedelta
from importlib.util import find_spec
from pathlib import Path

from ..error import InputError, replaced
from ..log import moment
from . import (
    casas,
    events,
    home_assistant,
    home_assistant_history,
    influx,
    mcap,
    ocel,
    parquet,
    pyadlml,
    xes,
)
from .log import FormatFiles, Log
from .source import EPOCH, ParsedLog

__all__ = ["FORMATS", "Format", "FormatFiles", "InputError", "Log"]


@dataclass(frozen=True)
class Format:
    """A file format of another tool: how to write a log, and how to read one.

    Attributes
    ----------
    extension
        The end of the name of its file.
    tip
        Its description in help texts.
    writer
        A function that returns the contents of the files for a log; None if it is only read.
    read
        A function that reads a file or folder; None if the format is not read.
    begins
        A pattern that recognises the format. It is matched with the first bytes of a file, or with
        the file names in a folder. Empty if the format is not read.
    is_folder
        The format is a folder of files.
    needs
        A package that must be installed.
    seconds
        The first and the last second since 1970 that the format can hold; None means all dates.
    """

    name: str
    extension: str
    tip: str
    writer: Callable[[Log], FormatFiles] | None
    read: Callable[[Path], ParsedLog] | None = None
    begins: bytes = b""
    is_folder: bool = False
    needs: str = ""
    seconds: tuple[int, int] | None = None

    @property
    def is_installed(self) -> bool:
        """Whether the package that the format needs is installed."""
        return not self.needs or find_spec(self.needs) is not None

    def write(self, log: Log) -> FormatFiles:
        """Return the contents of the files for a log in this format.

        Raise InputError if the format cannot hold the log's dates.
        """
        first, last = log.span()
        self.check_dates(log.start, first / 1e6, last / 1e6)
        assert self.writer is not None
        return self.writer(log)

    def check_dates(self, start: datetime, first: float, last: float) -> None:
        """Raise InputError unless the format can hold the dates between two times.

        The times `first` and `last` are in seconds since `start`.
        """
        why = "the log's dates are not all between the years 1 and 9999: give another start"
        with replaced(why, OverflowError):
            begin = moment(start, timedelta(seconds=first))
            end = moment(start, timedelta(seconds=last))
        if self.seconds is None:
            return
        zero = Log((), start).epoch_us(0) / 1e6
        if not self.seconds[0] <= zero + first <= zero + last < self.seconds[1] + 1:
            earliest, latest = (EPOCH + timedelta(seconds=second) for second in self.seconds)
            raise InputError(
                f"{self.name} holds dates from {earliest} to {latest} (UTC), but the log's are "
                f"{begin} to {end}: give another start, or choose another format"
            )


FORMATS = {
    format.name: format
    for format in (
        # Its reader, in reading.py, also reads folders of days.
        Format("events", ".csv", "The event log itself", events.write, begins=events.BEGINS),
        Format(
            "casas",
            ".txt",
            "CASAS text, as in the data sets Aruba and Milan",
            casas.write_text,
            casas.read,
            casas.BEGINS,
        ),
        # The reader of `casas` also reads this format.
        Format("casas-csv", ".csv", "CASAS with commas, as released in 2025", casas.write_csv),
        Format(
            "pyadlml",
            "",
            "Folder that pyadlml reads with load_act_assist",
            pyadlml.write,
            pyadlml.read,
            rb"(?m)^device(_map|_mapping|s)\.csv$",
            is_folder=True,
        ),
        Format(
            "mcap",
            ".mcap",
            "MCAP with ROS 2 messages",
            mcap.write,
            seconds=mcap.SECONDS,
        ),
        Format("xes", ".xes", "XES, for process mining", xes.write),
        Format(
            "ocel",
            ".json",
            "OCEL 2.0, object-centric process mining",
            ocel.write,
        ),
        Format(
            "influx",
            ".lp",
            "InfluxDB's line protocol",
            influx.write,
            seconds=influx.SECONDS,
        ),
        Format(
            "home-assistant",
            ".jsonl",
            "MQTT messages for Home Assistant",
            home_assistant.write,
            home_assistant_history.read,
            home_assistant_history.BEGINS,
        ),
        Format(
            "parquet",
            ".parquet",
            "A table for pandas",
            parquet.write,
            needs="pyarrow",
        ),
    )
}
