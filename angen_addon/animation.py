# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds an object's F-curves and drivers, in every version of Blender."""

from __future__ import annotations

from typing import Any


def curves(obj: Any, paths: set[str]) -> list[Any]:
    """The object's own F-curves of these data paths. From Blender 4.4 on an action can hold
    those of several objects, each in its slot; before, it has one list."""
    animation = obj.animation_data
    if animation is None or animation.action is None:
        return []
    if hasattr(animation, "action_slot"):
        slot = animation.action_slot
        bags = [
            strip.channelbag(slot)
            for layer in animation.action.layers
            for strip in layer.strips
            if slot is not None
        ]
        found = [curve for bag in bags if bag is not None for curve in bag.fcurves]
    else:
        found = list(animation.action.fcurves)
    return [curve for curve in found if curve.data_path in paths]


def is_animated(obj: Any, path: str) -> bool:
    """Whether keys or a driver set this data path."""
    animation = obj.animation_data
    if animation is None:
        return False
    return bool(curves(obj, {path})) or any(d.data_path == path for d in animation.drivers)
