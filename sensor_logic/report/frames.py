# SPDX-License-Identifier: GPL-3.0-or-later
"""Strips of small pictures for fields that hold a picture, such as the frames of an array."""

from __future__ import annotations

import base64
import struct
import zlib

import numpy as np

from ..model import Array
from ..palette import colours, limits
from ..recording.tracks import Track
from .svg import coordinate, safe

# The most pictures of a strip, and their size and distances in px.
MOST, WIDTH, GAP, CAPTION = 8, 1024.0, 10.0, 34.0
# In units of the field: the least difference between the darkest and the brightest colour.
LEAST_SPAN = 5.0


def strip(track: Track, field: str, shape: tuple[int, int]) -> tuple[str, float, str] | None:
    """Return a strip of a sensor's pictures: the SVG, its height in px, and a caption.

    All pictures have the same colours. Return None if the track has no picture of this shape.

    Parameters
    ----------
    track
        The readings of the sensor.
    field
        The field whose texts hold the pictures.
    shape
        The numbers of columns and of rows.
    """
    columns, rows = shape
    found = []
    for index in chosen_rows(track):
        text = track.columns[field][index]
        values = np.array(text.split(";"), np.float64) if text else np.empty(0)
        if values.size == columns * rows:
            found.append((index, values.reshape(rows, columns)))
    if not found:
        return None
    low, high = limits(np.array([values for _, values in found]), LEAST_SPAN)
    unit = track.kind.fields[field].unit
    wide = (WIDTH - GAP * (MOST - 1)) / MOST
    tall = min(wide * rows / columns, wide * 2)
    parts = []
    for number, (index, values) in enumerate(found):
        x = number * (wide + GAP)
        word = track.kind.active_label if track.active[index] else track.kind.idle_label
        about = f"{track.times[index]:.1f} s: {values.min():.1f} to {values.max():.1f} {unit}"
        parts.append(
            f'<g transform="translate({coordinate(x)} 0)"><title>{safe(about)}</title>'
            f'<image width="{coordinate(wide)}" height="{coordinate(tall)}" '
            'preserveAspectRatio="none" style="image-rendering:pixelated" '
            f'href="{png(colours(values, low, high))}"/>'
            f'<text class="small" y="{coordinate(tall + 14)}">{track.times[index]:.1f} s</text>'
            f'<text class="small quiet" y="{coordinate(tall + 28)}">{safe(word)}, '
            f"{values.max():.1f} {safe(unit)}</text></g>"
        )
    caption = (
        f"Black is {low:.1f} {unit}, pale yellow {high:.1f} {unit}. Below each picture: its time, "
        "the state of the sensor, and the highest value."
    )
    return "\n".join(parts), tall + CAPTION, caption.replace(" -", " −")


def chosen_rows(track: Track) -> list[int]:
    """Return the indices of at most MOST readings, in order, that show what the sensor saw.

    They are the first reading, those at which its state changes, the highest one, and readings in
    the middle of the longest gaps. If there are too many, some of the changes are left out.
    """
    count = len(track)
    if not count:
        return []
    active = np.fromiter(track.active, bool, count)
    values = np.fromiter(track.value, np.float64, count)
    highest = int(np.argmax(np.where(np.isfinite(values), values, -np.inf)))
    changes = np.flatnonzero(np.diff(active)) + 1
    room = MOST - 2
    if len(changes) > room:
        changes = changes[np.linspace(0, len(changes) - 1, room).round().astype(int)]
    found = {0, highest, *changes.tolist()}
    while len(found) < min(MOST, count):
        ordered = np.array([*sorted(found), count])
        gaps = np.diff(ordered)
        widest = int(np.argmax(gaps))
        found.add(int(ordered[widest] + (gaps[widest] + (widest == len(gaps) - 1)) // 2))
    return sorted(found)


def png(picture: Array) -> str:
    """Return a picture (rows, columns, 3) of colours from 0 to 1 as a data URI.

    References
    ----------
    PNG (Portable Network Graphics) Specification, W3C: 8 bits, RGB, no filter.
    """
    rows, columns = picture.shape[:2]
    pixels = np.round(np.clip(picture, 0.0, 1.0) * 255.0).astype(np.uint8)
    lines = np.column_stack([np.zeros(rows, np.uint8), pixels.reshape(rows, -1)]).tobytes()
    data = b"\x89PNG\r\n\x1a\n"
    head = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    for name, content in ((b"IHDR", head), (b"IDAT", zlib.compress(lines, 9)), (b"IEND", b"")):
        check = struct.pack(">I", zlib.crc32(name + content))
        data += struct.pack(">I", len(content)) + name + content + check
    return f"data:image/png;base64,{base64.b64encode(data).decode()}"
