# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a recording as bytes for a file: small, exact, and with a checksum.

The first line has a title, the version and the checksum; a header in JSON and the columns follow.
Frames and times are not stored where the clock gives them. A column of few different floats is
stored as a table of them and indices into it. Header and columns are compressed.
"""

from __future__ import annotations

import json
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..clock import Clock
from ..error import AngenError
from .columns import CODES, Column
from .reader import BYTES, TOO_MANY, VALUES, WRONG, frames_and_times, read, size_of
from .tracks import Recording, Track

TITLE = b"Recording of Angen Sensors"
VERSION = 1
# zlib's level: higher ones take many times as long and save little.
LEVEL = 3


def to_bytes(recording: Recording, facts: dict[str, Any]) -> bytes:
    """The bytes of the recording and of `facts` (plain values), which `from_bytes` returns. Raises
    AngenError where the recording is too large."""
    if size_of(recording) > VALUES or sum(t.nbytes for t in _tracks(recording)) > BYTES:
        raise AngenError(TOO_MANY)
    out = _Writer()
    header = {
        "clock": _clock_fields(recording.clock),
        "frames": [recording.frame_start, recording.frame_end],
        "tracks": [_track_header(track, recording.clock, out) for track in _tracks(recording)],
        "facts": facts,
    }
    packed = zlib.compress(json.dumps(header, ensure_ascii=False).encode(), 6)
    body = len(packed).to_bytes(4, "little") + packed + out.data
    return b"%s %d %d\n" % (TITLE, VERSION, zlib.crc32(body)) + body


def from_bytes(data: bytes, values: int = VALUES) -> tuple[Recording, dict[str, Any]]:
    """The recording and the facts, if it has at most so many `values`. Raises
    AngenError."""
    title, _, body = data.partition(b"\n")
    if not title.startswith(TITLE + b" "):
        raise AngenError("it is not a recording")
    try:
        version, checksum = (int(word) for word in title[len(TITLE) :].split())
    except ValueError:
        raise AngenError("it is damaged") from None
    if version > VERSION:
        raise AngenError(
            f"it was written by a newer version of the extension (format {version}, this one "
            f"reads {VERSION}): update the extension"
        )
    if zlib.crc32(body) != checksum:
        raise AngenError("it is damaged")
    try:
        return read(body, values)
    except AngenError:
        raise
    except WRONG as error:
        raise AngenError(f"it is damaged ({type(error).__name__})") from None


class _Writer:
    def __init__(self) -> None:
        self.data = bytearray()

    def add(self, raw: bytes) -> int:
        """Adds bytes; returns their compressed size."""
        packed = zlib.compress(raw, LEVEL)
        self.data += packed
        return len(packed)


def _tracks(recording: Recording) -> list[Track]:
    for name, track in recording.tracks.items():
        if name != track.sensor:
            raise ValueError(f"the track of '{track.sensor}' has the key '{name}'")
    return list(recording.tracks.values())


def _clock_fields(clock: Clock | None) -> list[Any] | None:
    if clock is None:
        return None
    return [clock.frame_start, clock.fps, clock.fps_base, clock.substeps]


def _track_header(track: Track, clock: Clock | None, out: _Writer) -> dict[str, Any]:
    columns: list[dict[str, Any]] = []
    steps = _steps(track, clock)
    if steps is not None:
        columns.append({"as": "steps", "size": out.add(np.diff(steps, prepend=0).tobytes())})
    else:
        columns += [_column(track.frames, out), _column(track.times, out)]
    known: dict[str, Any] = {}
    for name, column in (*track.columns.items(), ("active", track.active), ("value", track.value)):
        twin = next((n for n, other in known.items() if _same(column, other)), None)
        columns.append({"as": twin, "size": 0} if twin is not None else _column(column, out))
        known.setdefault("=" + name, column)
    return {
        "sensor": track.sensor,
        "kind": track.kind_name,
        "count": len(track),
        "steps": track.steps,
        "fields": list(track.columns),
        "columns": columns,
    }


def _steps(track: Track, clock: Clock | None) -> NDArray[np.int64] | None:
    """The clock's steps of the updates; None where they do not give the exact frames and times."""
    if clock is None:
        return None
    frames, times = np.asarray(track.frames), np.asarray(track.times)
    steps: NDArray[np.int64] = np.rint((frames - clock.frame_start) * clock.substeps).astype(
        np.int64
    )
    again = frames_and_times(steps, clock)
    same = np.array_equal(frames, again[0]) and np.array_equal(times, again[1])
    return steps if same else None


def _same(one: Column, other: Column) -> bool:
    return one.type is other.type is not str and one == other


def _column(column: Column, out: _Writer) -> dict[str, Any]:
    """Adds a column; returns its entry in the header."""
    values = column.numbers()
    if column.type is str:
        texts = sorted(column.texts)
        order = np.array([texts.index(text) for text in column.texts], np.uint32)
        return {"as": "texts", "texts": texts, "size": out.add(order[values].tobytes())}
    code = CODES[column.type]
    if code == "b":
        return {"as": "b", "size": out.add(values.tobytes())}
    # By their bits, so that negative zeros and NaNs come back unchanged.
    bits = values.view(np.uint64)
    found, which = np.unique(bits, return_inverse=True)
    for size in (np.uint8, np.uint16):
        if len(found) <= np.iinfo(size).max and len(found) * 4 <= len(bits):
            raw = found.tobytes() + which.astype(size).tobytes()
            return {"as": code, "found": len(found), "size": out.add(raw)}
    # Bytes of equal significance side by side compress better.
    raw = bits.view(np.uint8).reshape(-1, 8).T.tobytes()
    return {"as": code, "found": 0, "size": out.add(raw)}
