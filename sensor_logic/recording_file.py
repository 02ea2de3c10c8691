# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording as bytes, for keeping it in a file: small, exact, and with a checksum.

After a line of text that says what it is, its version and its checksum, come a header in JSON and
the columns. Frames and times are not stored where the clock gives them; of floats, which are few
different ones as a rule, the different ones and which is where; everything is compressed.
"""

from __future__ import annotations

import json
import zlib
from array import array
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .clock import Clock
from .kinds import KINDS
from .recording import Recording, Track

TITLE = b"Recording of Angen Sensors"
VERSION = 1
# Of zlib: higher ones take many times as long and gain little.
LEVEL = 3


class RecordingFileError(ValueError):
    """The bytes are no recording that this version can read; the text says why."""


def to_bytes(recording: Recording, facts: dict[str, Any]) -> bytes:
    """The recording, with `facts` (plain values) that the caller wants back."""
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


def from_bytes(data: bytes) -> tuple[Recording, dict[str, Any]]:
    """The recording and the facts. Raises RecordingFileError."""
    title, _, body = data.partition(b"\n")
    if not title.startswith(TITLE + b" "):
        raise RecordingFileError("it is not a recording")
    try:
        version, checksum = (int(word) for word in title[len(TITLE) :].split())
    except ValueError:
        raise RecordingFileError("it is damaged") from None
    if version > VERSION:
        raise RecordingFileError(
            f"it was written by a newer version of the extension (format {version}, this one "
            f"reads {VERSION}): update the extension"
        )
    if zlib.crc32(body) != checksum:
        raise RecordingFileError("it is damaged")
    try:
        return _read(body)
    except RecordingFileError:
        raise
    except (ValueError, KeyError, IndexError, TypeError, AttributeError, zlib.error) as error:
        raise RecordingFileError(f"it is damaged ({type(error).__name__})") from None


class _Writer:
    def __init__(self) -> None:
        self.data = bytearray()

    def add(self, raw: bytes) -> int:
        """Returns how many bytes it takes."""
        packed = zlib.compress(raw, LEVEL)
        self.data += packed
        return len(packed)


class _Reader:
    def __init__(self, data: bytes, start: int) -> None:
        self._data = data
        self._at = start

    def take(self, count: int) -> bytes:
        self._at += count
        return zlib.decompress(self._data[self._at - count : self._at])


def _tracks(recording: Recording) -> list[Track]:
    for name, track in recording.tracks.items():
        if name != track.sensor:
            raise ValueError(f"the track of '{track.sensor}' is kept as '{name}'")
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
    """The steps of the clock at which the updates were; None where it does not tell them."""
    if clock is None:
        return None
    frames, times = np.array(track.frames), np.array(track.times)
    steps: NDArray[np.int64] = np.rint((frames - clock.frame_start) * clock.substeps).astype(
        np.int64
    )
    again = _frames_and_times(steps, clock)
    same = np.array_equal(frames, again[0]) and np.array_equal(times, again[1])
    return steps if same else None


def _frames_and_times(
    steps: NDArray[np.int64], clock: Clock
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    rate = clock.steps_per_second
    return clock.frame_start + steps / clock.substeps, steps * rate.denominator / rate.numerator


def _same(column: Any, other: Any) -> bool:
    return (
        isinstance(column, array)
        and isinstance(other, array)
        and column.typecode == other.typecode
        and column.tobytes() == other.tobytes()
    )


def _column(column: Any, out: _Writer) -> dict[str, Any]:
    """Adds a column; returns what its reader needs to know."""
    if not isinstance(column, array):
        texts = sorted(set(column))
        number = {text: i for i, text in enumerate(texts)}
        numbers = np.array([number[text] for text in column], np.uint32)
        return {"as": "texts", "texts": texts, "size": out.add(numbers.tobytes())}
    if column.typecode == "b":
        return {"as": "b", "size": out.add(column.tobytes())}
    # Compared bit by bit: a negative zero, or what is not a number, comes back as it was.
    bits = np.frombuffer(column, np.uint64)
    found, which = np.unique(bits, return_inverse=True)
    code = column.typecode
    for size in (np.uint8, np.uint16):
        if len(found) <= np.iinfo(size).max and len(found) * 4 <= len(bits):
            raw = found.tobytes() + which.astype(size).tobytes()
            return {"as": code, "found": len(found), "size": out.add(raw)}
    # Bytes of like weight side by side pack better.
    raw = bits.view(np.uint8).reshape(-1, 8).T.tobytes()
    return {"as": code, "found": 0, "size": out.add(raw)}


def _read(body: bytes) -> tuple[Recording, dict[str, Any]]:
    size = int.from_bytes(body[:4], "little")
    header = json.loads(zlib.decompress(body[4 : 4 + size]))
    reader = _Reader(body, 4 + size)
    clock = Clock(*header["clock"]) if header["clock"] else None
    first, last = header["frames"]
    recording = Recording({}, clock, first, last)
    for track in header["tracks"]:
        recording.tracks[track["sensor"]] = _read_track(track, clock, reader)
    return recording, header["facts"]


def _read_track(header: dict[str, Any], clock: Clock | None, reader: _Reader) -> Track:
    kind = KINDS.get(header["kind"])
    if kind is None or [f.name for f in kind.samples] != header["fields"]:
        raise RecordingFileError("it was written by another version of the extension")
    count = header["count"]
    columns = list(header["columns"])
    track = Track(header["sensor"], header["kind"])
    track.steps = dict(header["steps"])
    if columns[0]["as"] == "steps":
        if clock is None:
            raise RecordingFileError("it is damaged (no clock)")
        differences = np.frombuffer(reader.take(columns.pop(0)["size"]), np.int64)
        frames, times = _frames_and_times(np.cumsum(differences), clock)
        track.frames, track.times = array("d", frames.tobytes()), array("d", times.tobytes())
    else:
        track.frames = _read_column(columns.pop(0), count, reader, {})
        track.times = _read_column(columns.pop(0), count, reader, {})
    known: dict[str, Any] = {}
    for name in (*header["fields"], "active", "value"):
        column = _read_column(columns.pop(0), count, reader, known)
        known["=" + name] = column
        if name in header["fields"]:
            track.columns[name] = column
    track.active, track.value = known["=active"], known["=value"]
    lengths = {len(column) for column in (track.frames, track.times, *known.values())}
    if lengths != {count}:
        raise RecordingFileError("it is damaged (columns of different lengths)")
    return track


def _read_column(facts: dict[str, Any], count: int, reader: _Reader, known: Any) -> Any:
    kind = facts["as"]
    if kind.startswith("="):
        twin = known[kind]
        return array(twin.typecode, twin)
    raw = reader.take(facts["size"])
    if kind == "texts":
        return [facts["texts"][i] for i in np.frombuffer(raw, np.uint32)]
    if kind == "b":
        return array("b", raw)
    found = facts["found"]
    if not found:
        return array(kind, np.frombuffer(raw, np.uint8).reshape(8, -1).T.tobytes())
    table = np.frombuffer(raw[: 8 * found], np.uint64)
    size = np.uint8 if len(raw) == 8 * found + count else np.uint16
    return array(kind, table[np.frombuffer(raw[8 * found :], size)].tobytes())
