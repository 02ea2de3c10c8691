# SPDX-License-Identifier: GPL-3.0-or-later
"""At which frames references of light stand: the run's first; and in a day, whose sun goes on, the
first of the part of the day that a frame lies in.

Which parts there are is noted in the scene, so that it is the same for whoever asks.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import Any

# Custom property of a scene: the first frames of its parts, from the first to the last.
BEGINS = "angen_light_begins"


def tell_begins(scene: Any, frames: Sequence[int]) -> None:
    scene[BEGINS] = list(frames)


def take_begins(scene: Any) -> None:
    scene.pop(BEGINS, None)


def begins_of(scene: Any, frame: float) -> tuple[int, int]:
    """The frames at which references stand for a frame of a scene: the first of all, and that of
    its part."""
    begins = scene.get(BEGINS, [scene.frame_start])
    return int(begins[0]), int(begins[max(bisect_right(begins, frame) - 1, 0)])
