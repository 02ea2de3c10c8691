# SPDX-License-Identifier: GPL-3.0-or-later
"""Plain keyframes out of one value a frame, with as few keys as the tolerance allows."""

from collections.abc import Sequence

import bpy
import numpy as np


def needed(values: np.ndarray, tolerance: float) -> list[int]:
    """Indices to key, so that straight lines between them miss no value by more than that."""
    keep = {0, len(values) - 1}
    open_spans = [(0, len(values) - 1)]
    while open_spans:
        a, b = open_spans.pop()
        if b - a < 2:
            continue
        line = np.linspace(values[a], values[b], b - a + 1)
        miss = np.abs(values[a : b + 1] - line)
        worst = int(miss.argmax())
        if miss[worst] > tolerance:
            keep.add(a + worst)
            open_spans += [(a, a + worst), (a + worst, b)]
    kept = sorted(keep)
    if len(kept) == 2 and abs(values[kept[1]] - values[kept[0]]) <= tolerance:
        kept = kept[:1]
    return kept


def at_rest(values: np.ndarray, tolerance: float) -> np.ndarray:
    """The values of keys without creep: what differs by no more than that from the key before
    stands still."""
    found = values.copy()
    for number in range(1, len(found)):
        if abs(values[number] - found[number - 1]) <= tolerance:
            found[number] = found[number - 1]
    return found


class Keys:
    """The action of one datablock; works with the actions of 4.2 and the layered ones since."""

    def __init__(self, owner: bpy.types.ID, name: str) -> None:
        action = bpy.data.actions.new(name)
        data = owner.animation_data_create()
        data.action = action
        if hasattr(action, "slots"):
            slot = action.slots.new(owner.id_type, owner.name)
            strip = action.layers.new("Story").strips.new(type="KEYFRAME")
            self._curves = strip.channelbag(slot, ensure=True).fcurves
            data.action_slot = slot
        else:
            self._curves = action.fcurves
        self.count = 0

    def add(
        self, path: str, index: int, frames: Sequence[float], values: Sequence[float],
        interpolation: str = "LINEAR",
    ) -> None:  # fmt: skip
        """Keys at the frames."""
        curve = self._curves.new(path, index=index)
        points = curve.keyframe_points
        points.add(len(frames))
        points.foreach_set("co", np.stack([frames, values], 1).astype(np.float32).ravel())
        for point in points:
            point.interpolation = interpolation
        curve.update()
        self.count += len(frames)

    def bake(self, path: str, index: int, values: np.ndarray, tolerance: float) -> None:
        """Keys for one value a frame, the first at frame 1."""
        kept = needed(values, tolerance)
        self.add(path, index, [k + 1 for k in kept], at_rest(values[kept], tolerance))
