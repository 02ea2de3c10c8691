# SPDX-License-Identifier: GPL-3.0-or-later
"""Event logs in the formats of other tools. A new one is a file here and an entry below."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from . import casas, events, home_assistant, influx, mcap, ocel, parquet, pyadlml, xes
from .log import Log
from .written import FormatError, Written

__all__ = ["FORMATS", "Format", "FormatError", "Log", "Written"]


@dataclass(frozen=True)
class Format:
    """A way to write a log. `is_folder`: it is several files in a folder, else one file. `needs`:
    a package that must be installed."""

    name: str
    extension: str
    tip: str
    write: Callable[[Log], Written]
    is_folder: bool = False
    needs: str = ""


FORMATS = {
    format.name: format
    for format in (
        Format("events", ".csv", "The event log itself", events.write),
        Format("casas", ".txt", "CASAS text, as Aruba and Milan have it", casas.write_text),
        Format("casas-csv", ".csv", "CASAS with commas, as released in 2025", casas.write_csv),
        Format("pyadlml", "", "A folder for pyadlml's load_act_assist", pyadlml.write, True),
        Format("mcap", ".mcap", "MCAP with ROS 2 messages", mcap.write),
        Format("xes", ".xes", "XES, for process mining", xes.write),
        Format("ocel", ".json", "OCEL 2.0, object-centric process mining", ocel.write),
        Format("influx", ".lp", "InfluxDB's line protocol", influx.write),
        Format(
            "home-assistant", ".jsonl", "MQTT messages for Home Assistant", home_assistant.write
        ),
        Format("parquet", ".parquet", "A table for pandas", parquet.write, needs="pyarrow"),
    )
}
