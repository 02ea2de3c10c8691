# SPDX-License-Identifier: GPL-3.0-or-later
"""Event logs in the formats of other tools. A new one is a file here and an entry below."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from . import casas, events, home_assistant, influx, mcap, mcap_reader, ocel, parquet, pyadlml, xes
from .log import Log
from .read import Read
from .written import FormatError, Written

__all__ = ["FORMATS", "Format", "FormatError", "Log", "Written"]


@dataclass(frozen=True)
class Format:
    """A way to write a log, and to read one. `is_folder`: it is several files in a folder, else
    one file. `needs`: a package that must be installed. `begins`: a pattern of the bytes with
    which its files begin, or of the names in its folder."""

    name: str
    extension: str
    tip: str
    write: Callable[[Log], Written]
    read: Callable[[Path], Read] | None = None
    begins: bytes = rb"(?!)"
    is_folder: bool = False
    needs: str = ""


FORMATS = {
    format.name: format
    for format in (
        Format("events", ".csv", "The event log itself", events.write),
        Format(
            "casas",
            ".txt",
            "CASAS text, as Aruba and Milan have it",
            casas.write_text,
            casas.read,
            casas.BEGINS,
        ),
        # It is read as `casas` is.
        Format("casas-csv", ".csv", "CASAS with commas, as released in 2025", casas.write_csv),
        Format(
            "pyadlml",
            "",
            "A folder for pyadlml's load_act_assist",
            pyadlml.write,
            pyadlml.read,
            rb"device_map\.csv",
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
