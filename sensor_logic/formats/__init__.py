# SPDX-License-Identifier: GPL-3.0-or-later
"""Event logs in the formats of other tools. A new format is a module here and an entry below."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from . import casas, events, home_assistant, influx, mcap, mcap_reader, ocel, parquet, pyadlml, xes
from .log import Log
from .read import ParsedLog
from .written import FormatError, FormatFiles

__all__ = ["FORMATS", "Format", "FormatError", "FormatFiles", "Log"]


@dataclass(frozen=True)
class Format:
    """A format: how to write a log, and how to read one. `is_folder`: it is several files in a
    folder, else one file. `needs`: a package that must be installed. `begins`: a pattern of the
    first bytes of its file, or of the file names in its folder, by which it is recognised."""

    name: str
    extension: str
    tip: str
    write: Callable[[Log], FormatFiles]
    read: Callable[[Path], ParsedLog] | None = None
    begins: bytes = rb"(?!)"
    is_folder: bool = False
    needs: str = ""


FORMATS = {
    format.name: format
    for format in (
        # Its reader, in reading.py, also reads folders of days.
        Format("events", ".csv", "The event log itself", events.write, begins=events.BEGINS),
        Format(
            "casas",
            ".txt",
            "CASAS text, as Aruba and Milan have it",
            casas.write_text,
            casas.read,
            casas.BEGINS,
        ),
        # The reader of `casas` reads it too.
        Format("casas-csv", ".csv", "CASAS with commas, as released in 2025", casas.write_csv),
        Format(
            "pyadlml",
            "",
            "A folder for pyadlml's load_act_assist",
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
            mcap_reader.read,
            re.escape(mcap.MAGIC),
        ),
        Format("xes", ".xes", "XES, for process mining", xes.write, xes.read, xes.BEGINS),
        Format(
            "ocel",
            ".json",
            "OCEL 2.0, object-centric process mining",
            ocel.write,
            ocel.read,
            ocel.BEGINS,
        ),
        Format(
            "influx", ".lp", "InfluxDB's line protocol", influx.write, influx.read, influx.BEGINS
        ),
        Format(
            "home-assistant",
            ".jsonl",
            "MQTT messages for Home Assistant",
            home_assistant.write,
            home_assistant.read,
            rb"\{[^\n]*\"topic\"",
        ),
        Format(
            "parquet",
            ".parquet",
            "A table for pandas",
            parquet.write,
            parquet.read,
            rb"PAR1",
            needs="pyarrow",
        ),
    )
}
