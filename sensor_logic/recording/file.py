# SPDX-License-Identifier: GPL-3.0-or-later
"""Convert a recording to bytes for a file and back: small, exact, and with a checksum.

The first line has a title, the version and the checksum. A header in JSON follows, then the
columns. Header and columns are compressed. Frames and times are not stored if they follow from the
clock and the steps of the updates. A column with few different floats is stored as a table of these
floats, with an index into the table for each value.
"""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..clock import Clock
from ..kind import Kind
from ..kinds import KINDS
from ..logs.error import AngenError, replaced
from ..parameters import defaults
from .columns import CODES, Column
from .tracks import PARAMETERS, Recording, Track

# The bytes to read are untrusted. The reader unpacks no more than the header's counts and `VALUES`
# allow, and checks the type of each value.

MIB = 2**20
# The largest unpacked header. A header with the names of 100,000 objects has some 12 MiB.
HEADER_BYTES = 32 * MIB
# The most values in all columns of a file, and the most memory of the compressed columns.
VALUES = 2**27
BYTES = 256 * MIB
MOST_SUBSTEPS = 10_000
# Of a sensor whose animation gives it more different parameters, a file has no evidence.
MOST_PARAMETERS = 4096
LARGEST_FRAME = 2**31
# The exceptions that invalid values can raise.
WRONG = (
    ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError,
    ValueError, zlib.error,
)  # fmt: skip


TOO_MANY = "it has more readings than a file can hold"


def read(body: bytes, values: int) -> tuple[Recording, dict[str, Any]]:
    """Read a recording, and the data about it that `to_bytes` got, from the bytes after line 1.

    Raise AngenError, also if the recording has more than `values` values. Damaged bytes can also
    raise one of the errors in `WRONG`.
    """
    size = int.from_bytes(body[:4], "little")
    unpacker = zlib.decompressobj()
    text = unpacker.decompress(body[4 : 4 + size], HEADER_BYTES)
    if not unpacker.eof:
        raise AngenError("it is damaged, or its header is too large")
    header = json.loads(text)
    reader = _Reader(body, 4 + size)
    clock = _read_clock(header["clock"]) if header["clock"] else None
    first, last = (_whole(frame, -LARGEST_FRAME, LARGEST_FRAME) for frame in header["frames"])
    recording, room = Recording({}, clock, first, last), BYTES
    for facts in header["tracks"]:
        kind = KINDS.get(facts["kind"])
        if kind is None or [f.name for f in kind.samples] != facts["fields"]:
            raise AngenError("it was written by another version of the extension")
        rows = facts["evidence"]["rows"] if "evidence" in facts else 0
        values -= _values_of(kind, _whole(facts["count"], 0), _whole(rows, 0))
        if values < 0:
            raise AngenError(TOO_MANY)
        track = _read_track(facts, clock, reader)
        recording.tracks[_typed(str, track.sensor)] = track
        room -= track.nbytes
        if room < 0:
            raise AngenError(TOO_MANY)
    return recording, _typed(dict, header["facts"])


def size_of(recording: Recording) -> int:
    """Return the number of values in a recording, in all columns together."""
    return sum(_values_of(t.kind, len(t), _rows_of(t)) for t in recording.tracks.values())


def _rows_of(track: Track) -> int:
    """Return how many rows of evidence a file has of a track."""
    is_told = track.has_evidence and len(track.parameters) <= MOST_PARAMETERS
    return len(track.evidence.starts) if is_told else 0


def _values_of(kind: Kind, count: int, rows: int) -> int:
    """Return the number of values of a track with `count` readings and `rows` of evidence."""
    return count * (4 + len(kind.samples)) + rows * (2 + len(kind.evidence))


def frames_and_times(
    steps: NDArray[np.int64], clock: Clock
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the frames (n,) and the times (n,) in s of the clock's steps (n,)."""
    rate = clock.steps_per_second
    return clock.frame_start + steps / clock.substeps, steps * rate.denominator / rate.numerator


class _Reader:
    def __init__(self, data: bytes, start: int) -> None:
        self._data = data
        self._at = start

    def take(self, packed: Any, size: int) -> bytes:
        """Return the next bytes, decompressed from `packed` bytes to exactly `size` bytes."""
        self._at += _whole(packed, 0)
        unpacker = zlib.decompressobj()
        raw = unpacker.decompress(self._data[self._at - packed : self._at], size + 1)
        if len(raw) != size or not unpacker.eof:
            raise AngenError("it is damaged (a column of another size)")
        return raw


def _whole(value: Any, least: int, most: int = 2**62) -> int:
    if type(value) is not int or not least <= value <= most:
        raise ValueError
    return value


def _number(value: Any) -> float:
    if type(value) not in (int, float) or not math.isfinite(value) or value < 0:
        raise ValueError
    return float(value)


def _typed(kind: type, value: Any) -> Any:
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
    track = Track(header["sensor"], header["kind"], clock=clock)
    track.warm_up = _number(header.get("warm_up", 0.0))
    track.steps = {_typed(str, name): _number(step) for name, step in header["steps"].items()}
    if columns[0]["as"] == "steps":
        if clock is None:
            raise AngenError("it is damaged (no clock)")
        raw = reader.take(columns.pop(0)["size"], 8 * count)
        frames, times = frames_and_times(np.cumsum(np.frombuffer(raw, np.int64)), clock)
    else:
        frames, times = (_read_values(columns.pop(0), "d", count, reader) for _ in range(2))
    if not (np.isfinite(frames).all() and np.isfinite(times).all()):
        raise ValueError
    track.frames.extend(frames)
    track.times.extend(times)
    known: dict[str, Column] = {}
    parts = {**track.columns, "active": track.active, "value": track.value}
    for (name, column), facts in zip(parts.items(), columns, strict=True):
        if facts["as"].startswith("="):
            twin = known[facts["as"]]
            if twin.type is not column.type:
                raise TypeError
            column.extend(twin)
        else:
            _read_column(column, facts, count, reader)
        known["=" + name] = column
    if "evidence" in header:
        # A recording of before version 2 has no evidence.
        _read_evidence(track, header["evidence"], reader)
    return track


def _read_evidence(track: Track, header: dict[str, Any], reader: _Reader) -> None:
    """Read the evidence of all updates of a track."""
    rows, evidence = header["rows"], track.evidence
    for column, facts in zip(evidence.all_columns(), header["columns"], strict=True):
        _read_column(column, facts, rows, reader)
    known = _read_parameters(track.kind, header["parameters"])
    track.parameters = {one: number for number, one in enumerate(known)}
    evidence.updates = len(track)
    starts, numbers = evidence.starts.numbers(), evidence.columns[PARAMETERS].numbers()
    if len(track) and (starts[0] != 0 or (np.diff(starts) <= 0).any() or starts[-1] >= len(track)):
        raise ValueError
    if not ((numbers >= 0) & (numbers < len(track.parameters))).all():
        raise IndexError


def _read_column(column: Column, facts: dict[str, Any], count: int, reader: _Reader) -> None:
    """Read the values (count,) of a column, of which the file's header has the `facts`."""
    if column.type is str:
        column.extend(_read_texts(facts, count, reader))
    else:
        column.extend(_read_values(facts, CODES[column.type], count, reader))


def _read_parameters(kind: Kind, entries: Any) -> Iterator[Any]:
    """Yield the parameters in the header; names that this version does not know are left out."""
    usual = defaults(kind.parameters)
    for entry in _typed(list, entries):
        values = {name: value for name, value in _typed(dict, entry).items() if name in usual}
        if not all(isinstance(v, (bool, int, float, str, type(None))) for v in values.values()):
            raise TypeError
        yield kind.parameters(**values)


def _read_texts(facts: dict[str, Any], count: int, reader: _Reader) -> list[str]:
    if facts["as"] != "texts":
        raise TypeError
    texts = [_typed(str, text) for text in facts["texts"]]
    return [texts[i] for i in np.frombuffer(reader.take(facts["size"], 4 * count), np.uint32)]


def _read_values(facts: dict[str, Any], code: str, count: int, reader: _Reader) -> NDArray[Any]:
    packed = facts["size"]
    if facts["as"] != code:
        raise TypeError
    if code == "b":
        raw = reader.take(packed, count)
        if raw.strip(b"\0\1"):
            raise ValueError
        return np.frombuffer(raw, np.int8)
    found = _whole(facts["found"], 0, count)
    if not found:
        raw = reader.take(packed, 8 * count)
        return np.frombuffer(raw, np.uint8).reshape(8, -1).T.copy().view(code).ravel()
    size = np.uint8 if found <= np.iinfo(np.uint8).max else np.uint16
    raw = reader.take(packed, 8 * found + count * size().itemsize)
    table = np.frombuffer(raw[: 8 * found], code)
    return np.asarray(table[np.frombuffer(raw[8 * found :], size)])


TITLE = b"Recording of Angen Sensors"
VERSION = 2
# The level of zlib: higher levels take many times as long and save little.
LEVEL = 3


def to_bytes(recording: Recording, facts: dict[str, Any]) -> bytes:
    """Return a recording, with the data `facts` about it, as bytes for a file.

    `facts` has plain values by name, as in JSON. Raise AngenError if the recording is too large.
    """
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
    """Return the recording and the data about it, from bytes that `to_bytes` returned.

    Raise AngenError if the bytes are damaged, or if the recording has more than `values` values.
    """
    title, _, body = data.partition(b"\n")
    if not title.startswith(TITLE + b" "):
        raise AngenError("it is not a recording")
    with replaced("it is damaged", ValueError, raised=AngenError):
        version, checksum = (int(word) for word in title[len(TITLE) :].split())
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
        """Compress bytes, append them, and return their compressed size."""
        packed = zlib.compress(raw, LEVEL)
        self.data += packed
        return len(packed)


def _tracks(recording: Recording) -> list[Track]:
    for name, track in recording.tracks.items():
        if name != track.sensor:
            raise ValueError(f"the track of '{track.sensor}' is stored under the name '{name}'")
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
    parts = {**track.columns, "active": track.active, "value": track.value}
    for name, column in parts.items():
        twin = next((n for n, other in known.items() if _same(column, other)), None)
        columns.append({"as": twin, "size": 0} if twin is not None else _column(column, out))
        known.setdefault("=" + name, column)
    found = {
        "sensor": track.sensor,
        "kind": track.kind_name,
        "count": len(track),
        "steps": track.steps,
        "warm_up": track.warm_up,
        "fields": list(track.columns),
        "columns": columns,
    }
    if rows := _rows_of(track):
        found["evidence"] = {
            "parameters": [asdict(one) for one in track.parameters],
            "rows": rows,
            "columns": [_column(column, out) for column in track.evidence.all_columns()],
        }
    return found


def _steps(track: Track, clock: Clock | None) -> NDArray[np.int64] | None:
    """Return the clock's steps (n,) of the updates; None if frames or times do not match these."""
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
    """Append a column to the file's data, and return its entry in the header."""
    values = column.numbers()
    if column.type is str:
        texts = sorted(column.texts)
        places = {text: i for i, text in enumerate(texts)}
        order = np.array([places[text] for text in column.texts], np.uint32)
        return {"as": "texts", "texts": texts, "size": out.add(order[values].tobytes())}
    code = CODES[column.type]
    if code == "b":
        return {"as": "b", "size": out.add(values.tobytes())}
    # Compared by their bits, so that negative zeros and NaNs stay unchanged.
    bits = values.view(np.uint64)
    found, which = np.unique(bits, return_inverse=True)
    for size in (np.uint8, np.uint16):
        if len(found) <= np.iinfo(size).max and len(found) * 4 <= len(bits):
            raw = found.tobytes() + which.astype(size).tobytes()
            return {"as": code, "found": len(found), "size": out.add(raw)}
    # Bytes of equal significance compress better next to each other.
    raw = bits.view(np.uint8).reshape(-1, 8).T.tobytes()
    return {"as": code, "found": 0, "size": out.add(raw)}
