# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the plain OpenEXR files that the sensors' renders write: scan lines of 32-bit floats, not
compressed, in one part.

Loading them as images would leave traces in the user's file.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

MAGIC = 0x01312F76
# Flags of tiled, deep and multi-part files.
OTHER_KINDS = 0x1A00
FLOAT = 2


def read_layers(path: Path) -> dict[str, NDArray[np.float64]]:
    """Pixels (height, width, 3) by the name of the layer and pass, such as "ViewLayer.Combined";
    those of a file without layers by "". Raises ValueError where it is not such a file."""
    data = path.read_bytes()
    magic, version = struct.unpack_from("<II", data)
    if magic != MAGIC or version & OTHER_KINDS:
        raise ValueError(f"{path.name} is not a plain OpenEXR file")
    header, at = _header(data, 8)
    if header["compression"][0] != 0:
        raise ValueError(f"{path.name} is compressed")
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = _channels(header["channels"])
    if any(kind != FLOAT for _, kind in channels):
        raise ValueError(f"{path.name} has channels that are not 32-bit floats")
    # After a table of offsets, each row has its number, its size, and the channels one by one.
    row = 8 + 4 * width * len(channels)
    rows = np.frombuffer(data, np.uint8, height * row, at + 8 * height).reshape(height, row)[:, 8:]
    planes = np.ascontiguousarray(rows).view("<f4").reshape(height, len(channels), width)
    found: dict[str, NDArray[np.float64]] = {}
    for number, (name, _) in enumerate(channels):
        layer, _, channel = name.rpartition(".")
        if channel in "RGB":
            pixels = found.setdefault(layer, np.empty((height, width, 3)))
            pixels[..., "RGB".index(channel)] = planes[:, number]
    return found


def _header(data: bytes, at: int) -> tuple[dict[str, bytes], int]:
    """Attributes by name, and where they end."""
    found = {}
    while data[at] != 0:
        name, at = _text(data, at)
        _, at = _text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        found[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    return found, at + 1


def _channels(data: bytes) -> list[tuple[str, int]]:
    found, at = [], 0
    while data[at] != 0:
        name, at = _text(data, at)
        (kind,) = struct.unpack_from("<i", data, at)
        found.append((name, kind))
        at += 16
    return found


def _text(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(0, at)
    return data[at:end].decode(), end + 1
