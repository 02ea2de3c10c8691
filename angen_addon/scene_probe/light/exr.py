# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the plain OpenEXR files that the sensors' renders write: scan lines, not compressed.

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
TYPES = {0: "<u4", 1: "<f2", 2: "<f4"}


def read_rgb(path: Path) -> NDArray[np.float64]:
    """Pixels (height, width, 3). Raises ValueError where it is not such a file."""
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
    pixels = {name: np.empty((height, width)) for name, _ in channels}
    at += 8 * height
    for _ in range(height):
        row, _ = struct.unpack_from("<ii", data, at)
        at += 8
        for name, kind in channels:
            values = np.frombuffer(data, kind, width, at)
            pixels[name][row - y0] = values
            at += values.nbytes
    return np.stack([pixels[name] for name in "RGB"], axis=-1)


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


def _channels(data: bytes) -> list[tuple[str, str]]:
    found, at = [], 0
    while data[at] != 0:
        name, at = _text(data, at)
        (kind,) = struct.unpack_from("<i", data, at)
        found.append((name.rpartition(".")[2], TYPES[kind]))
        at += 16
    return found


def _text(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(0, at)
    return data[at:end].decode(), end + 1
