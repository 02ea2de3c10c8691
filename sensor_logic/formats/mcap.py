# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes MCAP files with ROS 2 messages, which `ros2 bag`, Foxglove and rosbags read.

https://mcap.dev/spec: records of a type byte, a length and content; messages in chunks with an
index and CRCs, a summary at the end. Each field of a sensor is a topic, `/angen/pir_hall/moved`.
"""

from __future__ import annotations

import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from ..kind import RAYS
from ..kinds import KINDS
from ..parameters import defaults
from . import ros2
from .log import Change, Channel, Log
from .names import slug, unique
from .written import FormatFiles

MAGIC = b"\x89MCAP0\r\n"
CHUNK_BYTES = 1 << 20
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = 0x0B, 0x0C, 0x0D, 0x0E, 0x0F
# Times in message headers are signed 32-bit seconds, and the file's are not negative.
SECONDS = 0, 2**31 - 1
RANGE = "sensor_msgs/msg/Range"
BY_QUANTITY = {
    "distance": RANGE,
    "illuminance": "sensor_msgs/msg/Illuminance",
    "force": "geometry_msgs/msg/WrenchStamped",
}
BY_TYPE = {bool: "std_msgs/msg/Bool", str: "std_msgs/msg/String"}
NUMBER = "std_msgs/msg/Float32"
ACTIVITY = "std_msgs/msg/String"
ACTIVITIES = "activities"


@dataclass(frozen=True)
class _Message:
    """The bytes of a message on a topic, with its time in nanoseconds since 1970; `about`: the
    metadata of the topic."""

    time: int
    topic: str
    schema: str
    data: bytes
    about: Mapping[str, str]


@dataclass
class _Chunk:
    """The position and content of a chunk, for the chunk index."""

    first: int
    last: int
    offset: int
    length: int
    index_offsets: dict[int, int]
    index_length: int
    size: int


@dataclass
class _File:
    """The file while it is written: schemas and channels by name, chunks, message counts."""

    data: bytearray = field(default_factory=lambda: bytearray(MAGIC))
    schemas: dict[str, int] = field(default_factory=dict)
    channels: dict[str, tuple[int, str, Mapping[str, str]]] = field(default_factory=dict)
    chunks: list[_Chunk] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=lambda: defaultdict(int))


def write(log: Log) -> FormatFiles:
    """All changes, initial states included, and all activities as text."""
    file = _File()
    file.data += _record(HEADER, _text("ros2") + _text("angen-sensors"))
    waiting: list[_Message] = []
    size = 0
    for message in sorted(_messages(log), key=lambda m: m.time):
        waiting.append(message)
        size += len(message.data)
        if size > CHUNK_BYTES:
            _add_chunk(file, waiting)
            waiting, size = [], 0
    if waiting:
        _add_chunk(file, waiting)
    about = {"start": log.start.isoformat(), **log.about}
    metadata_offset = len(file.data)
    file.data += _record(METADATA, _text("angen") + _map(about))
    metadata = (metadata_offset, len(file.data) - metadata_offset)
    file.data += _record(DATA_END, struct.pack("<I", zlib.crc32(file.data)))
    _add_summary(file, metadata)
    return FormatFiles({"": bytes(file.data)})


def _messages(log: Log) -> Iterator[_Message]:
    topics = unique((sensor.name for sensor in log.sensors), slug)
    greatest: dict[Channel, float] = {}
    for change in log.changes:
        if change.channel.quantity == "distance":
            value = float(change.value)
            greatest[change.channel] = max(value, greatest.get(change.channel, value))
    for change in log.changes:
        yield from _of_change(log, topics, change, greatest.get(change.channel, 0.0))
    for activity in log.activities:
        topic = f"/angen/people/{slug(activity.person)}/activity"
        for time, text in ((activity.start, activity.activity), (activity.end, "")):
            data = ros2.string_message(text)
            about = {"holds": ACTIVITIES}
            yield _Message(log.epoch_us(time) * 1000, topic, ACTIVITY, data, about)


def _of_change(
    log: Log, topics: Mapping[str, str], change: Change, greatest: float
) -> Iterator[_Message]:
    channel, time = change.channel, log.epoch_us(change.time)
    frame = topics[channel.sensor.name]
    topic = f"/angen/{frame}/{channel.field}"
    schema = BY_QUANTITY.get(channel.quantity) or BY_TYPE.get(channel.type, NUMBER)
    data = _bytes(schema, time, frame, change, greatest)
    yield _Message(time * 1000, topic, schema, data, _about(channel))
    if channel.quantity == "opening" and KINDS[channel.sensor.kind].requires(RAYS):
        data = ros2.beam_message(time, frame, bool(change.value), _parameter(channel, "range_max"))
        # Our reader takes the sensor's changes from its own topic.
        about = {"holds": "beam"}
        yield _Message(time * 1000, f"/angen/{frame}/range", RANGE, data, about)


def _bytes(schema: str, time: int, frame: str, change: Change, greatest: float) -> bytes:
    value = change.value
    if isinstance(value, str):
        return ros2.string_message(value)
    write: dict[str, Callable[[], bytes]] = {
        "std_msgs/msg/Bool": lambda: ros2.bool_message(bool(value)),
        "sensor_msgs/msg/Illuminance": lambda: ros2.illuminance_message(time, frame, value),
        RANGE: lambda: ros2.range_message(
            time,
            frame,
            value,
            _parameter(change.channel, "horizontal_fov"),
            _parameter(change.channel, "range_min"),
            _range_max(change.channel, greatest),
        ),
        "geometry_msgs/msg/WrenchStamped": lambda: ros2.force_message(time, frame, value),
        NUMBER: lambda: ros2.float_message(value),
    }
    return write[schema]()


def _parameter(channel: Channel, name: str) -> float:
    """A parameter of the channel's sensor; its kind's default if it is not known."""
    default = defaults(KINDS[channel.sensor.kind].parameters).get(name, 0.0)
    value = channel.sensor.parameters.get(name, default)
    return float(value) if isinstance(value, (int, float)) else 0.0


def _range_max(channel: Channel, greatest: float) -> float:
    """The greatest distance that the channel's sensor measures, which is also its value without a
    target. If it is not known: the kind's default, or where the `greatest` value in the log exceeds
    that, the next one of the kind's presets."""
    found = _parameter(channel, "range_max")
    if "range_max" in channel.sensor.parameters or greatest <= found:
        return found
    presets = (p.values.get("range_max", 0.0) for p in KINDS[channel.sensor.kind].presets)
    return min((most for most in presets if most >= greatest), default=greatest)


def _add_chunk(file: _File, messages: list[_Message]) -> None:
    """Appends messages as a chunk, new schemas and channels first, and its indexes."""
    records = bytearray()
    index: dict[int, list[tuple[int, int]]] = defaultdict(list)
    for message in messages:
        if message.topic not in file.channels:
            records += _new_channel(file, message)
        channel = file.channels[message.topic][0]
        index[channel].append((message.time, len(records)))
        times = struct.pack("<HIQQ", channel, file.counts[channel], message.time, message.time)
        records += _record(MESSAGE, times + message.data)
        file.counts[channel] += 1
    first, last = messages[0].time, messages[-1].time
    offset = len(file.data)
    content = struct.pack("<QQQI", first, last, len(records), zlib.crc32(records))
    file.data += _record(CHUNK, content + _text("") + struct.pack("<Q", len(records)) + records)
    length, offsets = len(file.data) - offset, {}
    for channel, entries in index.items():
        offsets[channel] = len(file.data)
        packed = b"".join(struct.pack("<QQ", *entry) for entry in entries)
        file.data += _record(MESSAGE_INDEX, struct.pack("<HI", channel, len(packed)) + packed)
    index_length = len(file.data) - offset - length
    file.chunks.append(_Chunk(first, last, offset, length, offsets, index_length, len(records)))


def _new_channel(file: _File, message: _Message) -> bytes:
    records = b""
    if message.schema not in file.schemas:
        file.schemas[message.schema] = len(file.schemas) + 1
        records += _schema_record(file, message.schema)
    file.channels[message.topic] = (len(file.channels), message.schema, message.about)
    return records + _channel_record(file, message.topic)


def _about(channel: Channel) -> dict[str, str]:
    """The metadata of a topic: the names in their original spelling, room and unit."""
    sensor = channel.sensor
    return {
        "sensor": sensor.name,
        "kind": sensor.kind,
        "field": channel.field,
        "room": sensor.room,
        "unit": channel.unit,
    }


def _schema_record(file: _File, name: str) -> bytes:
    definition = ros2.DEFINITIONS[name].encode()
    number = struct.pack("<H", file.schemas[name])
    return _record(SCHEMA, number + _text(name) + _text("ros2msg") + _sized(definition))


def _channel_record(file: _File, topic: str) -> bytes:
    number, schema, about = file.channels[topic]
    numbers = struct.pack("<HH", number, file.schemas[schema])
    return _record(CHANNEL, numbers + _text(topic) + _text("cdr") + _map(about))


def _add_summary(file: _File, metadata: tuple[int, int]) -> None:
    """Appends the summary, which repeats schemas and channels and has statistics and indexes."""
    start = len(file.data)
    groups = (
        (SCHEMA, [_schema_record(file, name) for name in file.schemas]),
        (CHANNEL, [_channel_record(file, topic) for topic in file.channels]),
        (STATISTICS, [_statistics(file)]),
        (CHUNK_INDEX, [_chunk_index(chunk) for chunk in file.chunks]),
        (METADATA_INDEX, [_record(METADATA_INDEX, struct.pack("<QQ", *metadata) + _text("angen"))]),
    )
    offsets = b""
    for kind, records in groups:
        if records:
            where, length = len(file.data), sum(map(len, records))
            offsets += _record(SUMMARY_OFFSET, struct.pack("<BQQ", kind, where, length))
            file.data += b"".join(records)
    offset_start = len(file.data)
    file.data += offsets
    footer = struct.pack("<BQQQ", FOOTER, 20, start, offset_start)
    file.data += footer + struct.pack("<I", zlib.crc32(file.data[start:] + footer)) + MAGIC


def _statistics(file: _File) -> bytes:
    counts = b"".join(struct.pack("<HQ", *pair) for pair in sorted(file.counts.items()))
    totals = struct.pack(
        "<QHIIIIQQ",
        sum(file.counts.values()),
        len(file.schemas),
        len(file.channels),
        0,
        1,
        len(file.chunks),
        min((chunk.first for chunk in file.chunks), default=0),
        max((chunk.last for chunk in file.chunks), default=0),
    )
    return _record(STATISTICS, totals + _sized(counts))


def _chunk_index(chunk: _Chunk) -> bytes:
    offsets = b"".join(struct.pack("<HQ", *pair) for pair in chunk.index_offsets.items())
    where = struct.pack("<QQQQ", chunk.first, chunk.last, chunk.offset, chunk.length)
    sizes = struct.pack("<QQ", chunk.size, chunk.size)
    index_length = struct.pack("<Q", chunk.index_length)
    return _record(CHUNK_INDEX, where + _sized(offsets) + index_length + _text("") + sizes)


def _record(kind: int, content: bytes) -> bytes:
    return struct.pack("<BQ", kind, len(content)) + content


def _sized(data: bytes) -> bytes:
    return struct.pack("<I", len(data)) + data


def _text(text: str) -> bytes:
    return _sized(text.encode())


def _map(pairs: Mapping[str, str]) -> bytes:
    return _sized(b"".join(_text(key) + _text(value) for key, value in pairs.items()))
