# SPDX-License-Identifier: GPL-3.0-or-later
"""A home's own keys and strips put aside, and its camera: a day has its own story."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

import bpy

from ..scene.animation import all_animated

# Of constraints, those that ask for the scene's camera.
THROUGH_CAMERA = ("CAMERA_SOLVER", "FOLLOW_TRACK", "OBJECT_SOLVER")


@contextmanager
def put_aside(scene: Any, but: Collection[Any] = ()) -> Iterator[None]:
    """Everything stands as at the scene's first frame, until the end; drivers, constraints and
    modifiers go on. `but`: datablocks that keep their keys. What is linked keeps its own too."""
    scene.frame_set(scene.frame_start)
    before = []
    for owner in list(all_animated()):
        data = owner.animation_data
        if owner.library is None and owner not in but and (data.action or data.nla_tracks):
            before.append((owner, data.action, getattr(data, "action_slot", None), data.use_nla))
            data.action, data.use_nla = None, False
    camera = scene.camera
    if not _is_asked_for_camera():
        # There Blender's sound listens. It keeps its place at every frame from 0 on, and copies all
        # of them at each new one: milliseconds late in a day.
        scene.camera = None
    try:
        yield
    finally:
        scene.camera = camera
        for owner, action, slot, use_nla in before:
            data = owner.animation_data_create()
            data.action, data.use_nla = action, use_nla
            if slot is not None:
                data.action_slot = slot


def _is_asked_for_camera() -> bool:
    """Whether anything may depend on which camera is the scene's."""
    drivers = [curve.driver for owner in all_animated() for curve in owner.animation_data.drivers]
    targets = (t for driver in drivers for variable in driver.variables for t in variable.targets)
    nodes = (node for tree in bpy.data.node_groups for node in tree.nodes)
    constraints = (one for obj in bpy.data.objects for one in obj.constraints)
    return (
        any("camera" in driver.expression for driver in drivers)
        or any("camera" in target.data_path for target in targets)
        or any(node.bl_idname == "GeometryNodeInputActiveCamera" for node in nodes)
        or any(one.type in THROUGH_CAMERA for one in constraints)
    )
