# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads MCAP files as `mcap.py` writes them: uncompressed chunks of ROS 2 messages."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from pathlib import Path

from ..log.event_log import Event, told
from . import mcap, ros2
from .read import ParsedLog, since_epoch


def read(path: Path) -> ParsedLog:
    """The changes on the topics whose metadata name a sensor."""
    found = ParsedLog([], in_utc=True)
    schemas: dict[int, str] = {}
    topics: dict[int, tuple[str, dict[str, str]]] = {}
    for kind, content in _records(path.read_bytes()[len(mcap.MAGIC) :]):
        if kind == mcap.SCHEMA:
            (number,) = struct.unpack_from("<H", content)
            schemas[number] = _text(content, 2)[0]
        elif kind == mcap.CHANNEL:
            number, schema = struct.unpack_from("<HH", content)
            end = _text(content, _text(content, 4)[1])[1]
            topics[number] = schemas[schema], _map(content, end)
        elif kind == mcap.MESSAGE:
            number, _, time = struct.unpack_from("<HIQ", content)
            schema_name, about = topics[number]
            if "sensor" in about:
                value = told(ros2.value_of(schema_name, content[22:]))
                clock, sensor = since_epoch(time // 1000), about["sensor"]
                change = Event(clock, sensor, about["field"], 0.0, about["kind"], value)
                found.changes.append(change)
                found.rooms[sensor] = about["room"]
            found.has_activities |= about.get("holds") == mcap.ACTIVITIES
    return found


def _records(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Type and content of each record before the summary, records in chunks included."""
    at = 0
    while at < len(data):
        kind, length = struct.unpack_from("<BQ", data, at)
        content = data[at + 9 : at + 9 + length]
        if len(content) < length:
            raise ValueError("the file is truncated")
        at += 9 + length
        if kind == mcap.DATA_END:
            return
        if kind != mcap.CHUNK:
            yield kind, content
            continue
        compression, start = _text(content, 28)
        if compression:
            raise ValueError(f"its chunks are compressed ({compression})")
        yield from _records(content[start + 8 :])


def _text(data: bytes, at: int) -> tuple[str, int]:
    """The text at a position, and the position after it."""
    (length,) = struct.unpack_from("<I", data, at)
    return data[at + 4 : at + 4 + length].decode(), at + 4 + length


def _map(data: bytes, at: int) -> dict[str, str]:
    (length,) = struct.unpack_from("<I", data, at)
    found, at, end = {}, at + 4, at + 4 + length
    while at < end:
        key, at = _text(data, at)
        found[key], at = _text(data, at)
    return found
