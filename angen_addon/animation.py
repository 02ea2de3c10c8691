# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds an object's F-curves and drivers, in every version of Blender."""

from __future__ import annotations

from typing import Any


def action_curves(action: Any, slot: Any) -> list[Any]:
    """The F-curves of an action. From Blender 4.4 on it can hold those of several datablocks,
    each in its slot (None: in no slot, so that nothing plays); before, it has one list."""
    if action is None:
        return []
    if not hasattr(action, "slots"):
        return list(action.fcurves)
    if slot is None:
        return []
    bags = [strip.channelbag(slot) for layer in action.layers for strip in layer.strips]
    return [curve for bag in bags if bag is not None for curve in bag.fcurves]


def curves(obj: Any, paths: set[str]) -> list[Any]:
    """The object's own F-curves of these data paths."""
    animation = obj.animation_data
    if animation is None:
        return []
    found = action_curves(animation.action, getattr(animation, "action_slot", None))
    return [curve for curve in found if curve.data_path in paths]


def is_animated(obj: Any, path: str) -> bool:
    """Whether keys or a driver set this data path."""
    animation = obj.animation_data
    if animation is None:
        return False
    return bool(curves(obj, {path})) or any(d.data_path == path for d in animation.drivers)
