# SPDX-License-Identifier: GPL-3.0-or-later
"""MCAP files with ROS 2 messages, which `ros2 bag`, Foxglove and rosbags read.

https://mcap.dev/spec: a record is a type byte, a length and the content. Messages are in chunks,
which have an index and CRCs. A summary is at the end. Each field of a sensor is a topic, such as
`/angen/pir_hall/moved`.
"""

from __future__ import annotations

import struct
import zlib
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from ..fields import LOGGED_KINDS
from .log import Change, Channel, FormatFiles, Log, slug, unique

# ROS 2 messages: definitions, and encoding in CDR (OMG DDSI-RTPS 2.5, chapter 10).
#
# Plain CDR, little endian: a header of four bytes, then each number at a multiple of its own size.

_TIME = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n")
_HEADER = ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n")
_VECTOR = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n")
_WRENCH = ("geometry_msgs/Wrench", "Vector3 force\nVector3 torque\n")
_ILLUMINANCE = "std_msgs/Header header\nfloat64 illuminance\nfloat64 variance\n"
_TEMPERATURE = "std_msgs/Header header\nfloat64 temperature\nfloat64 variance\n"
_RANGE = (
    "uint8 ULTRASOUND=0\nuint8 INFRARED=1\nstd_msgs/Header header\nuint8 radiation_type\n"
    "float32 field_of_view\nfloat32 min_range\nfloat32 max_range\nfloat32 range\n"
)


def _definition(text: str, *parts: tuple[str, str]) -> str:
    """Return the definition of a message type in the encoding `ros2msg`.

    `parts` are the names and the definitions of the message types that it contains.
    """
    return text + "".join(f"{'=' * 80}\nMSG: {name}\n{part}" for name, part in parts)


DEFINITIONS = {
    "std_msgs/msg/Bool": "bool data\n",
    "std_msgs/msg/Float32": "float32 data\n",
    "std_msgs/msg/String": "string data\n",
    "sensor_msgs/msg/Illuminance": _definition(_ILLUMINANCE, _HEADER, _TIME),
    "sensor_msgs/msg/Temperature": _definition(_TEMPERATURE, _HEADER, _TIME),
    "sensor_msgs/msg/Range": _definition(_RANGE, _HEADER, _TIME),
    "geometry_msgs/msg/WrenchStamped": _definition(
        "std_msgs/Header header\nWrench wrench\n", _HEADER, _TIME, _WRENCH, _VECTOR
    ),
}


@dataclass
class Cdr:
    """A message in CDR, the binary encoding of ROS 2, to which fields are appended one by one."""

    data: bytearray = field(default_factory=lambda: bytearray(b"\x00\x01\x00\x00"))

    def number(self, code: str, *values: float) -> Cdr:
        """Append numbers with the format character `code` of `struct`.

        Each is aligned to a multiple of its size, counted from the end of the header.
        """
        size = struct.calcsize(f"<{code}")
        for value in values:
            self.data += b"\x00" * (-(len(self.data) - 4) % size)
            self.data += struct.pack(f"<{code}", value)
        return self

    def text(self, text: str) -> Cdr:
        """Append a text: its length, its bytes in UTF-8, and a zero byte."""
        encoded = text.encode() + b"\x00"
        self.number("I", len(encoded))
        self.data += encoded
        return self

    def header(self, epoch_us: int, frame_id: str) -> Cdr:
        """Append a std_msgs/Header: the time, and the name of the coordinate frame."""
        seconds, rest = divmod(epoch_us, 1_000_000)
        return self.number("i", seconds).number("I", rest * 1000).text(frame_id)


def string_message(value: str) -> bytes:
    """Return a std_msgs/String."""
    return bytes(Cdr().text(value).data)


def beam_message(epoch_us: int, frame_id: str, is_open: bool, reach: float) -> bytes:
    """Return a sensor_msgs/Range of a beam: -inf if the beam is blocked, else +inf.

    `reach` is the beam's length in m. The comment in Range.msg prescribes these values, and that
    `min_range` equals `max_range`, for rangers of a fixed distance.
    """
    found = Cdr().header(epoch_us, frame_id).number("B", 1)
    return bytes(found.number("f", 0.0, reach, reach, float("inf" if is_open else "-inf")).data)


def range_message(
    epoch_us: int, frame_id: str, distance: float, view: float, least: float, most: float
) -> bytes:
    """Return a sensor_msgs/Range of a measured distance.

    If the distance is the greatest that the sensor can measure, there is no target. The message
    then has +inf, as REP 117 prescribes.

    Parameters
    ----------
    epoch_us
        The time in microseconds since 1970.
    frame_id
        The name of the coordinate frame.
    distance
        The distance in m.
    view
        The field of view in rad.
    least, most
        The least and the greatest distance in m that the sensor can measure.
    """
    # Blender stores the greatest distance in single precision.
    distance = distance if distance < most * (1.0 - 1e-6) else float("inf")
    found = Cdr().header(epoch_us, frame_id).number("B", 1)
    return bytes(found.number("f", view, least, most, distance).data)


def force_message(epoch_us: int, frame_id: str, newtons: float) -> bytes:
    """Return a geometry_msgs/WrenchStamped of the force on the pad.

    The force has the direction of the pad's -Z.
    """
    found = Cdr().header(epoch_us, frame_id)
    return bytes(found.number("d", 0.0, 0.0, -newtons, 0.0, 0.0, 0.0).data)


MAGIC = b"\x89MCAP0\r\n"
CHUNK_BYTES = 1 << 20
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX = range(1, 9)
STATISTICS, METADATA, METADATA_INDEX, SUMMARY_OFFSET, DATA_END = 0x0B, 0x0C, 0x0D, 0x0E, 0x0F
# Times in message headers are signed 32-bit seconds; times in the file are not negative.
SECONDS = 0, 2**31 - 1
RANGE = "sensor_msgs/msg/Range"
# The messages with a header, a number and its variance.
ILLUMINANCE, TEMPERATURE = MEASURES = "sensor_msgs/msg/Illuminance", "sensor_msgs/msg/Temperature"
BY_QUANTITY = {
    "distance": RANGE,
    "illuminance": ILLUMINANCE,
    "temperature": TEMPERATURE,
    "force": "geometry_msgs/msg/WrenchStamped",
}
BY_TYPE = {bool: "std_msgs/msg/Bool", str: "std_msgs/msg/String"}
NUMBER = "std_msgs/msg/Float32"
ACTIVITY = "std_msgs/msg/String"
ACTIVITIES = "activities"


@dataclass(frozen=True)
class _Message:
    """A message as bytes; `time` is in ns since 1970, `about` is the metadata of its topic."""

    time: int
    topic: str
    schema: str
    data: bytes
    about: Mapping[str, str]


@dataclass
class _Chunk:
    """An entry of the chunk index, with times in ns since 1970, and positions and lengths in bytes.

    `index_offsets` has the position of the message index of each channel.
    """

    first: int
    last: int
    offset: int
    length: int
    index_offsets: dict[int, int]
    index_length: int
    size: int


@dataclass
class _File:
    """The file while it is written, with data for its summary.

    `schemas` has the number of each schema by name. `channels` has the number, the schema and the
    metadata of each channel by topic. `counts` has the number of messages by channel.
    """

    data: bytearray = field(default_factory=lambda: bytearray(MAGIC))
    schemas: dict[str, int] = field(default_factory=dict)
    channels: dict[str, tuple[int, str, Mapping[str, str]]] = field(default_factory=dict)
    chunks: list[_Chunk] = field(default_factory=list)
    counts: dict[int, int] = field(default_factory=lambda: defaultdict(int))


def write(log: Log) -> FormatFiles:
    """Return the log as MCAP: all changes, including initial states, and activities as text."""
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
            data = string_message(text)
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
    if channel.quantity == "opening" and LOGGED_KINDS[channel.sensor.kind].casts_rays:
        data = beam_message(time, frame, bool(change.value), _parameter(channel, "range_max"))
        # The changes themselves are in the topic of the field.
        about = {"holds": "beam"}
        yield _Message(time * 1000, f"/angen/{frame}/range", RANGE, data, about)


def _bytes(schema: str, time: int, frame: str, change: Change, greatest: float) -> bytes:
    value = change.value
    if isinstance(value, str):
        return string_message(value)
    write: dict[str, Callable[[], bytes]] = {
        "std_msgs/msg/Bool": lambda: bytes(Cdr().number("?", bool(value)).data),
        # A variance of zero means unknown.
        **dict.fromkeys(
            MEASURES, lambda: bytes(Cdr().header(time, frame).number("d", value, 0.0).data)
        ),
        RANGE: lambda: range_message(
            time,
            frame,
            value,
            _parameter(change.channel, "horizontal_fov"),
            _parameter(change.channel, "range_min"),
            _range_max(change.channel, greatest),
        ),
        "geometry_msgs/msg/WrenchStamped": lambda: force_message(time, frame, value),
        NUMBER: lambda: bytes(Cdr().number("f", value).data),
    }
    return write[schema]()


def _parameter(channel: Channel, name: str) -> float:
    """Return a parameter of the channel's sensor; the kind's default if it is unknown."""
    default = LOGGED_KINDS[channel.sensor.kind].defaults.get(name, 0.0)
    value = channel.sensor.parameters.get(name, default)
    return float(value) if isinstance(value, (int, float)) else 0.0


def _range_max(channel: Channel, greatest: float) -> float:
    """Return the greatest distance that the channel's sensor measures.

    If this parameter is unknown, return the kind's default. If the log's `greatest` value is above
    the default, return the next larger value of the kind's presets.
    """
    found = _parameter(channel, "range_max")
    if "range_max" in channel.sensor.parameters or greatest <= found:
        return found
    presets = (p.get("range_max", 0.0) for p in LOGGED_KINDS[channel.sensor.kind].presets)
    return min((most for most in presets if most >= greatest), default=greatest)


def _add_chunk(file: _File, messages: list[_Message]) -> None:
    """Append messages as a chunk, followed by the chunk's message indexes."""
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
    """Return the metadata of a topic: the sensor's name, kind and room, the field and its unit."""
    sensor = channel.sensor
    return {
        "sensor": sensor.name,
        "kind": sensor.kind,
        "field": channel.field,
        "room": sensor.room,
        "unit": channel.unit,
    }


def _schema_record(file: _File, name: str) -> bytes:
    definition = DEFINITIONS[name].encode()
    number = struct.pack("<H", file.schemas[name])
    return _record(SCHEMA, number + _text(name) + _text("ros2msg") + _sized(definition))


def _channel_record(file: _File, topic: str) -> bytes:
    number, schema, about = file.channels[topic]
    numbers = struct.pack("<HH", number, file.schemas[schema])
    return _record(CHANNEL, numbers + _text(topic) + _text("cdr") + _map(about))


def _add_summary(file: _File, metadata: tuple[int, int]) -> None:
    """Append the summary: schemas and channels again, then statistics and indexes."""
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
