# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the hours of a day, coloured by activity, for a bar in the panel Day."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy.utils.previews
import numpy as np
from numpy.typing import NDArray

from ..days.rows import HOUR_S

# Pixels of a picture. Blender draws it at half the size if the interface's scale is 1.
SIZE = 32
# sRGB: Okabe and Ito's colours, then Tol's.
COLOURS = (
    (86, 180, 233), (230, 159, 0), (0, 158, 115), (240, 228, 66), (204, 121, 167), (213, 94, 0),
    (0, 114, 178), (136, 34, 85), (153, 153, 51), (68, 170, 153), (170, 68, 153), (221, 204, 119),
)  # fmt: skip
NOTHING = (60, 60, 60)
# Height of the axis below the colours, its background, and the colour of its numbers.
AXIS, GROUND, INK = 14, (24, 24, 24), (230, 230, 230)
# The ten digits: five rows of three bits, each drawn as 2 × 2 pixels.
DIGITS = (
    (7, 5, 5, 5, 7), (2, 6, 2, 2, 7), (7, 1, 7, 4, 7), (7, 1, 7, 1, 7), (5, 5, 7, 1, 1),
    (7, 4, 7, 1, 7), (7, 4, 7, 5, 7), (7, 1, 1, 2, 2), (7, 5, 7, 5, 7), (7, 5, 7, 1, 7),
)  # fmt: skip

Pixels = NDArray[np.uint8]
# Pictures by their pixels, kept until the extension is switched off: making one takes 0.1 ms, and
# Blender may still draw icons of an earlier redraw.
_made: Any = None


def colours_of(done: Sequence[Any]) -> dict[str, tuple[int, int, int]]:
    """Return the colour of each activity of a day, by name: the same on all days of a routine."""
    return {item.name: COLOURS[item.place % len(COLOURS)] for item in done}


def hour_pixels(
    hour: int, spans: Sequence[tuple[float, float, tuple[int, int, int]]], is_now: bool = False
) -> Pixels:
    """Return the picture of an hour as RGBA, shape (SIZE, SIZE, 4), with the lowest row first.

    Time runs from left to right, above the number of the hour. `spans` are start, end and colour of
    each activity, with times in s since midnight. If `is_now`, the number is highlighted.
    """
    pixels = np.empty((SIZE, SIZE, 4), np.uint8)
    pixels[:AXIS], pixels[AXIS:] = (*(INK if is_now else GROUND), 255), (*NOTHING, 255)
    for start, end, colour in spans:
        ends = (np.clip([start, end], hour * HOUR_S, (hour + 1) * HOUR_S) / HOUR_S - hour) * SIZE
        first, last = (round(float(at)) for at in ends)
        if start < (hour + 1) * HOUR_S and end > hour * HOUR_S:
            # Even the shortest activity gets one column.
            first = min(first, SIZE - 1)
            pixels[AXIS:, first : max(last, first + 1), :3] = colour
    for place, digit in enumerate(f"{hour:02d}"):
        for row, bits in enumerate(DIGITS[int(digit)]):
            for column in range(3):
                if bits >> (2 - column) & 1:
                    y, x = AXIS - 4 - 2 * row, 8 + 8 * place + 2 * column
                    pixels[y : y + 2, x : x + 2, :3] = GROUND if is_now else INK
    return pixels


def plain_pixels(colour: tuple[int, int, int]) -> Pixels:
    """Return the picture of a square in one colour as RGBA, shape (SIZE, SIZE, 4)."""
    pixels = np.zeros((SIZE, SIZE, 4), np.uint8)
    pixels[4:-4, 4:-4] = (*colour, 255)
    return pixels


def icon_of(pixels: Pixels) -> int:
    """Return the number of Blender's icon for a picture."""
    global _made
    if _made is None:
        _made = bpy.utils.previews.new()
    name = pixels.tobytes().hex()
    if name not in _made:
        picture = _made.new(name)
        picture.icon_size = SIZE, SIZE
        picture.icon_pixels_float.foreach_set((pixels.astype(np.float32) / 255).ravel())
    return int(_made[name].icon_id)


def register() -> None:
    pass


def unregister() -> None:
    global _made
    if _made is not None:
        bpy.utils.previews.remove(_made)
        _made = None
