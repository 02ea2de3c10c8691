# SPDX-License-Identifier: GPL-3.0-or-later
"""Icons with small pictures of pixels, such as the frame of a sensor, for panels.

Blender keeps them in memory. They are no part of a file.
"""

from __future__ import annotations

from typing import Any

import bpy.utils.previews
import numpy as np

from ...sensor_logic.model import Array

# The side of an icon in pixels. Each pixel of a picture becomes a block, because Blender blurs
# icons that it enlarges.
SIDE = 256
# The most pictures; then the oldest are removed.
MOST = 32


class _Pictures:
    """The pictures by key; drawing one again takes 1 µs, making it 3 ms."""

    def __init__(self) -> None:
        self.previews: Any = None
        self.shown: dict[str, Any] = {}


_PICTURES = _Pictures()


def icon_of(key: str, source: Any, colours: Array) -> int:
    """Return the number of an icon with a picture.

    Parameters
    ----------
    key
        Identifies the place that shows the picture, such as a sensor.
    source
        What the colours were computed from. The icon changes only if it has changed.
    colours
        The colours (rows, columns, 3) as sRGB from 0 to 1; the first row is the upper one.
    """
    pictures = _PICTURES
    if pictures.previews is None:
        pictures.previews = bpy.utils.previews.new()
    if key not in pictures.previews:
        if len(pictures.shown) >= MOST:
            oldest = next(iter(pictures.shown))
            del pictures.previews[oldest], pictures.shown[oldest]
        pictures.previews.new(key)
    preview = pictures.previews[key]
    if pictures.shown.get(key) != source:
        pictures.shown[key] = source
        pixels = blocks(colours)
        for name in ("image", "icon"):
            setattr(preview, f"{name}_size", pixels.shape[1::-1])
            getattr(preview, f"{name}_pixels_float").foreach_set(pixels.ravel())
    icon: int = preview.icon_id
    return icon


def blocks(colours: Array) -> Array:
    """Return the picture as pixels (SIDE, SIDE, 4) of an icon, from its lower left.

    The pixels of the picture are squares. What they do not fill is transparent.
    """
    rows, columns = colours.shape[:2]
    block = max(SIDE // max(rows, columns), 1)
    found = np.zeros((max(SIDE, block * rows), max(SIDE, block * columns), 4), np.float32)
    large = np.repeat(np.repeat(colours[::-1], block, axis=0), block, axis=1)
    top, left = (found.shape[0] - len(large)) // 2, (found.shape[1] - large.shape[1]) // 2
    place = found[top : top + len(large), left : left + large.shape[1]]
    place[..., :3], place[..., 3] = large, 1.0
    return found


def register() -> None:
    """Do nothing: the pictures are made when they are first drawn."""


def unregister() -> None:
    """Remove all pictures."""
    if _PICTURES.previews is not None:
        bpy.utils.previews.remove(_PICTURES.previews)
    _PICTURES.previews = None
    _PICTURES.shown.clear()
