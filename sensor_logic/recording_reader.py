# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what `recording_file` writes, which may come from a stranger: nothing is unpacked beyond
what its own counts allow, no more is taken than `VALUES`, and each thing is what it should be."""

from __future__ import annotations

import json
import math
import zlib
from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .clock import Clock
from .kinds import KINDS
from .recording import Recording, Track

MIB = 2**20
# Unpacked; one that names 100,000 objects takes some 12 MiB.
HEADER_BYTES = 32 * MIB
# Of all columns of a file: 256 MiB.
VALUES = 2**25
MOST_SUBSTEPS = 10_000
LARGEST_FRAME = 2**31
CODES = {bool: "b", int: "q", float: "d", str: "texts"}
# What values that are not as they should be can lead to.
WRONG = (
    ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError,
    ValueError, zlib.error,
)  # fmt: skip


class RecordingFileError(ValueError):
    """The bytes are no recording that this version can read; the text says why."""


def read(body: bytes, values: int) -> tuple[Recording, dict[str, Any]]:
    """The recording and the facts in what follows the line with the checksum; of at most so many
    `values`. Raises RecordingFileError, or one of `WRONG`."""
    size = int.from_bytes(body[:4], "little")
    unpacker = zlib.decompressobj()
    text = unpacker.decompress(body[4 : 4 + size], HEADER_BYTES)
    if not unpacker.eof:
        raise RecordingFileError("it is damaged, or names more than a file keeps")
    header = json.loads(text)
    reader = _Reader(body, 4 + size)
    clock = _read_clock(header["clock"]) if header["clock"] else None
    first, last = (_whole(frame, -LARGEST_FRAME, LARGEST_FRAME) for frame in header["frames"])
    recording = Recording({}, clock, first, last)
    for facts in header["tracks"]:
        kind = KINDS.get(facts["kind"])
        if kind is None or [f.name for f in kind.samples] != facts["fields"]:
            raise RecordingFileError("it was written by another version of the extension")
        values -= _whole(facts["count"], 0) * (4 + len(kind.samples))
        if values < 0:
            raise RecordingFileError("it has more readings than a file keeps")
        recording.tracks[_of(str, facts["sensor"])] = _read_track(facts, clock, reader)
    return recording, _of(dict, header["facts"])


def size_of(recording: Recording) -> int:
    """How many values a recording has."""
    return sum(len(track) * (4 + len(track.columns)) for track in recording.tracks.values())


def frames_and_times(
    steps: NDArray[np.int64], clock: Clock
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rate = clock.steps_per_second
    return clock.frame_start + steps / clock.substeps, steps * rate.denominator / rate.numerator


class _Reader:
    def __init__(self, data: bytes, start: int) -> None:
        self._data = data
        self._at = start

    def take(self, packed: Any, size: int) -> bytes:
        """The next `packed` bytes, which must unpack to `size` bytes."""
        self._at += _whole(packed, 0)
        unpacker = zlib.decompressobj()
        raw = unpacker.decompress(self._data[self._at - packed : self._at], size + 1)
        if len(raw) != size or not unpacker.eof:
            raise RecordingFileError("it is damaged (a column of another size)")
        return raw


def _whole(value: Any, least: int, most: int = 2**62) -> int:
    if type(value) is not int or not least <= value <= most:
        raise ValueError
    return value


def _number(value: Any) -> float:
    if type(value) not in (int, float) or not math.isfinite(value) or value < 0:
        raise ValueError
    return float(value)


def _of(kind: type, value: Any) -> Any:
    if type(value) is not kind:
        raise TypeError
    return value


def _read_clock(fields: Any) -> Clock:
    start, fps, base, substeps = fields
    if not (1e-6 <= _number(fps) <= 1e6 and 1e-6 <= _number(base) <= 1e6):
        raise ValueError
    start = _whole(start, -LARGEST_FRAME, LARGEST_FRAME)
    return Clock(start, fps, base, _whole(substeps, 1, MOST_SUBSTEPS))


def _read_track(header: dict[str, Any], clock: Clock | None, reader: _Reader) -> Track:
    count, columns = header["count"], list(header["columns"])
    track = Track(header["sensor"], header["kind"])
    track.steps = {_of(str, name): _number(step) for name, step in header["steps"].items()}
    if columns[0]["as"] == "steps":
        if clock is None:
            raise RecordingFileError("it is damaged (no clock)")
        raw = reader.take(columns.pop(0)["size"], 8 * count)
        frames, times = frames_and_times(np.cumsum(np.frombuffer(raw, np.int64)), clock)
        track.frames, track.times = array("d", frames.tobytes()), array("d", times.tobytes())
    else:
        track.frames = _read_column(columns.pop(0), "d", count, reader, {})
        track.times = _read_column(columns.pop(0), "d", count, reader, {})
    if not (np.isfinite(track.frames).all() and np.isfinite(track.times).all()):
        raise ValueError
    codes = {f.name: CODES[f.type] for f in track.kind.samples} | {"active": "b", "value": "d"}
    known: dict[str, Any] = {}
    for name, facts in zip(codes, columns, strict=True):
        known["=" + name] = _read_column(facts, codes[name], count, reader, known)
    track.columns = {f.name: known["=" + f.name] for f in track.kind.samples}
    track.active, track.value = known["=active"], known["=value"]
    return track


def _read_column(facts: dict[str, Any], code: str, count: int, reader: _Reader, known: Any) -> Any:
    kind, packed = facts["as"], facts["size"]
    if kind.startswith("="):
        twin = known[kind]
        if twin.typecode != code:
            raise TypeError
        return array(code, twin)
    if kind != code:
        raise TypeError
    if kind == "texts":
        texts = [_of(str, text) for text in facts["texts"]]
        return [texts[i] for i in np.frombuffer(reader.take(packed, 4 * count), np.uint32)]
    if kind == "b":
        raw = reader.take(packed, count)
        if raw.strip(b"\0\1"):
            raise ValueError
        return array("b", raw)
    found = _whole(facts["found"], 0, count)
    if not found:
        raw = reader.take(packed, 8 * count)
        return array(kind, np.frombuffer(raw, np.uint8).reshape(8, -1).T.tobytes())
    size = np.uint8 if found <= np.iinfo(np.uint8).max else np.uint16
    raw = reader.take(packed, 8 * found + count * size().itemsize)
    table = np.frombuffer(raw[: 8 * found], np.uint64)
    return array(kind, table[np.frombuffer(raw[8 * found :], size)].tobytes())
