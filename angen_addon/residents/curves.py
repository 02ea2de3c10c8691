# SPDX-License-Identifier: GPL-3.0-or-later
"""F-curves of one datablock, written as whole arrays."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import ArrayLike

# Numbers of Blender's interpolations.
CONSTANT, LINEAR = 0, 1


class Curves:
    """The F-curves of a datablock's own action, the actions of 4.2 and the layered ones since."""

    def __init__(self, owner: bpy.types.ID, name: str) -> None:
        action = bpy.data.actions.new(name)
        data = owner.animation_data_create()
        data.action = action
        self.curves: Any
        if hasattr(action, "slots"):
            slot = action.slots.new(owner.id_type, owner.name)
            strip = action.layers.new("Story").strips.new(type="KEYFRAME")
            self.curves = strip.channelbag(slot, ensure=True).fcurves
            data.action_slot = slot
        else:
            self.curves = action.fcurves
        self.action = action
        self.count = 0

    def write(
        self, path: str, index: int, frames: ArrayLike, values: ArrayLike,
        interpolation: ArrayLike = LINEAR,
    ) -> None:  # fmt: skip
        """Replaces the keys of a curve; frames must increase. `interpolation`: one number for all
        keys, or one for each."""
        at = np.stack([np.asarray(frames, np.float32), np.asarray(values, np.float32)], 1)
        curve = self.curves.find(path, index=index) or self.curves.new(path, index=index)
        points = curve.keyframe_points
        if len(points) != len(at):
            points.clear()
            points.add(len(at))
        points.foreach_set("co", at.ravel())
        points.foreach_set("interpolation", np.full(len(at), interpolation, np.int32))
        curve.update()
        self.count += len(at)
