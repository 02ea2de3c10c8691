# SPDX-License-Identifier: GPL-3.0-or-later
"""Parquet, through pyarrow: one table, for pandas and other data frames.

For a simulation, the table has a row for each update of each sensor. Its columns are the columns of
the sample files. A column is empty in rows of sensors whose kind does not have it. For an event
log, the table has the rows of the log, with typed times.
"""

from __future__ import annotations

import io
import math
from typing import Any

from ..error import AngenError
from ..fields import LOGGED_KINDS
from ..log import format_value
from .log import FormatFiles, Log

# The columns of a table: {name: (type, values)}.

Columns = dict[str, tuple[type, list[Any]]]


def event_columns(log: Log) -> Columns:
    """Return the columns of the event log; two of them have the value, as text and as a number."""
    changes = log.changes
    numbers = [None if isinstance(c.value, str) else float(c.value) for c in changes]
    return {
        "time_s": (float, [c.time / 1e6 for c in changes]),
        "sensor": (str, [c.channel.sensor.name for c in changes]),
        "kind": (str, [c.channel.sensor.kind for c in changes]),
        "room": (str, [c.channel.sensor.room for c in changes]),
        "field": (str, [c.channel.field for c in changes]),
        "value": (str, [format_value(c.value) for c in changes]),
        "number": (float, numbers),
    }


def sample_columns(log: Log) -> Columns:
    """Return the columns of all updates, with rows sorted by sensor name, then by time."""
    assert log.samples is not None
    found = sorted(log.samples, key=lambda samples: samples.sensor)
    used = {name for samples in found for name in samples.columns}
    types = {
        f.name: f.type for kind in LOGGED_KINDS.values() for f in kind.samples if f.name in used
    }
    columns: Columns = {
        "time_s": (float, []),
        "frame": (float, []),
        "sensor": (str, []),
        "kind": (str, []),
        "room": (str, []),
        **{name: (of, []) for name, of in types.items()},
    }
    rooms = {sensor.name: sensor.room for sensor in log.sensors}
    for samples in found:
        count = len(samples.times)
        columns["time_s"][1].extend(samples.times)
        columns["frame"][1].extend(samples.frames)
        columns["sensor"][1].extend([samples.sensor] * count)
        columns["kind"][1].extend([samples.kind] * count)
        columns["room"][1].extend([rooms.get(samples.sensor, "")] * count)
        for name, of in types.items():
            columns[name][1].extend(_plain(of, samples.columns.get(name), count))
    return columns


def _plain(field_type: type, column: Any, count: int) -> list[Any]:
    """Return a column's values as Python objects; None for values that were not measured."""
    if column is None:
        return [None] * count
    if field_type is float:
        return [None if math.isnan(value) else value for value in column]
    return [field_type(value) for value in column]


TYPES = {bool: "bool_", int: "int64", float: "float64", str: "string"}


def write(log: Log) -> FormatFiles:
    """Return the log as a Parquet file. Raise AngenError if pyarrow is missing."""
    pyarrow = _pyarrow()
    columns = sample_columns(log) if log.samples is not None else event_columns(log)
    about = {f"angen.{key}": value for key, value in log.about.items()}
    about["angen.start"] = log.start.isoformat()
    arrays = {
        name: pyarrow.array(values, getattr(pyarrow, TYPES[of])())
        for name, (of, values) in columns.items()
    }
    clock = pyarrow.timestamp("us", "UTC" if log.start.tzinfo else None)
    stamps = [log.epoch_us(round(seconds * 1e6)) for seconds in columns["time_s"][1]]
    table = pyarrow.table({"time": pyarrow.array(stamps, clock), **arrays})
    out = io.BytesIO()
    pyarrow.parquet.write_table(table.replace_schema_metadata(about), out)
    return FormatFiles({"": out.getvalue()})


def _pyarrow() -> Any:
    """Import pyarrow. Raise AngenError if it is missing."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise AngenError(
            f"parquet needs pyarrow ({error}): pip install pyarrow, or choose another format"
        ) from None
    return pyarrow
