# SPDX-License-Identifier: GPL-3.0-or-later
"""ROS 2 messages: their definitions, and their encoding in CDR (OMG DDSI-RTPS 2.5, chapter 10).

Plain CDR, little endian: a header of four bytes, then each number at a multiple of its own size.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

_TIME = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n")
_HEADER = ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n")
_VECTOR = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n")
_WRENCH = ("geometry_msgs/Wrench", "Vector3 force\nVector3 torque\n")
_ILLUMINANCE = "std_msgs/Header header\nfloat64 illuminance\nfloat64 variance\n"
_RANGE = (
    "uint8 ULTRASOUND=0\nuint8 INFRARED=1\nstd_msgs/Header header\nuint8 radiation_type\n"
    "float32 field_of_view\nfloat32 min_range\nfloat32 max_range\nfloat32 range\n"
)


def _definition(text: str, *parts: tuple[str, str]) -> str:
    """The definition of a message and of those in it, in the encoding `ros2msg`."""
    return text + "".join(f"{'=' * 80}\nMSG: {name}\n{part}" for name, part in parts)


DEFINITIONS = {
    "std_msgs/msg/Bool": "bool data\n",
    "std_msgs/msg/Float32": "float32 data\n",
    "std_msgs/msg/String": "string data\n",
    "sensor_msgs/msg/Illuminance": _definition(_ILLUMINANCE, _HEADER, _TIME),
    "sensor_msgs/msg/Range": _definition(_RANGE, _HEADER, _TIME),
    "geometry_msgs/msg/WrenchStamped": _definition(
        "std_msgs/Header header\nWrench wrench\n", _HEADER, _TIME, _WRENCH, _VECTOR
    ),
}


@dataclass
class Cdr:
    """Encodes one message field by field."""

    data: bytearray = field(default_factory=lambda: bytearray(b"\x00\x01\x00\x00"))

    def number(self, code: str, *values: float) -> Cdr:
        """Adds numbers of one `struct` code, each aligned to its size from the header's end on."""
        size = struct.calcsize(f"<{code}")
        for value in values:
            self.data += b"\x00" * (-(len(self.data) - 4) % size)
            self.data += struct.pack(f"<{code}", value)
        return self

    def text(self, text: str) -> Cdr:
        """Adds a text: its length, UTF-8 and a closing zero."""
        encoded = text.encode() + b"\x00"
        self.number("I", len(encoded))
        self.data += encoded
        return self

    def header(self, epoch_us: int, frame_id: str) -> Cdr:
        """Adds a std_msgs/Header: time and frame."""
        seconds, rest = divmod(epoch_us, 1_000_000)
        return self.number("i", seconds).number("I", rest * 1000).text(frame_id)


def bool_message(value: bool) -> bytes:
    return bytes(Cdr().number("?", value).data)


def float_message(value: float) -> bytes:
    return bytes(Cdr().number("f", value).data)


def string_message(value: str) -> bytes:
    return bytes(Cdr().text(value).data)


def illuminance_message(epoch_us: int, frame_id: str, lux: float) -> bytes:
    """A sensor_msgs/Illuminance; its variance of zero means unknown."""
    return bytes(Cdr().header(epoch_us, frame_id).number("d", lux, 0.0).data)


def beam_message(epoch_us: int, frame_id: str, is_open: bool, reach: float) -> bytes:
    """A sensor_msgs/Range of a beam that only detects whether it is blocked: -inf if it is, else
    +inf. The comment in Range.msg prescribes this, and equal `min_range` and `max_range`, for
    fixed-distance rangers."""
    found = Cdr().header(epoch_us, frame_id).number("B", 1)
    return bytes(found.number("f", 0.0, reach, reach, float("inf" if is_open else "-inf")).data)


def range_message(
    epoch_us: int, frame_id: str, distance: float, view: float, least: float, most: float
) -> bytes:
    """A sensor_msgs/Range: a distance (m), the field of view (rad), and both range limits (m). The
    greatest distance means no target: +inf, as REP 117 prescribes."""
    # Blender stores the greatest distance in single precision.
    distance = distance if distance < most * (1.0 - 1e-6) else float("inf")
    found = Cdr().header(epoch_us, frame_id).number("B", 1)
    return bytes(found.number("f", view, least, most, distance).data)


def force_message(epoch_us: int, frame_id: str, newtons: float) -> bytes:
    """A geometry_msgs/WrenchStamped: the force on the pad, along its -Z."""
    found = Cdr().header(epoch_us, frame_id)
    return bytes(found.number("d", 0.0, 0.0, -newtons, 0.0, 0.0, 0.0).data)


def value_of(schema: str, data: bytes) -> bool | float | str:
    """The value in a sensor's message. Raises ValueError for any other schema."""
    if schema == "std_msgs/msg/Bool":
        return bool(data[4])
    if schema == "std_msgs/msg/Float32":
        # Seven digits, as many as single precision holds.
        return float(f"{struct.unpack_from('<f', data, 4)[0]:.7g}")
    (length,) = struct.unpack_from("<I", data, 4 if schema == "std_msgs/msg/String" else 12)
    if schema == "std_msgs/msg/String":
        return data[8 : 8 + length - 1].decode()
    body = 4 + -(-(12 + length) // 8) * 8
    if schema == "sensor_msgs/msg/Illuminance":
        return float(struct.unpack_from("<d", data, body)[0])
    if schema == "sensor_msgs/msg/Range":
        last = 4 + -(-(13 + length) // 4) * 4 + 12
        most, distance = struct.unpack_from("<ff", data, last - 4)
        # Without a target, the event log has the greatest distance.
        return float(f"{min(distance, most):.7g}")
    if schema == "geometry_msgs/msg/WrenchStamped":
        return -float(struct.unpack_from("<d", data, body + 16)[0])
    raise ValueError(f"{schema} is not a message of a sensor")
