# SPDX-License-Identifier: GPL-3.0-or-later
"""Read whether the objects that sensors watch are in use."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import bpy

from ...sensor_logic.model import ObjectUse
from ...sensor_logic.parameters import specs
from .animation import curves, is_animated, time_stretch
from .sensors import NotPlaced, Sensor, is_placed

# The data path of whether an object is in use.
PATH = "angen_use.in_use"


def watched_object(sensor: Sensor) -> Any:
    """Return the object whose use a sensor observes: the chosen one, or else its parent.

    Return None without either.
    """
    known = specs(sensor.kind.parameters).items()
    chosen = next(name for name, spec in known if spec.pointer == "Object")
    return getattr(sensor.parameters, chosen) or sensor.object.parent


def may_change(sensor: Sensor) -> bool:
    """Return whether keyframes or a driver change the use of the object that a sensor watches."""
    watched = watched_object(sensor)
    return watched is not None and is_animated(watched, PATH)


def check_watched(sensor: Sensor, depsgraph: Any) -> None:
    """Raise `NotPlaced` if Blender does not evaluate the use of the object that a sensor watches.

    Such an object is not in the view layer, or disabled in viewports, and its use can change.
    """
    watched = watched_object(sensor)
    if watched is not None and may_change(sensor) and not is_placed(watched, depsgraph):
        if watched not in depsgraph.view_layer.objects.values():
            raise NotPlaced(
                f"'{watched.name}' is in no collection of this view layer, so Blender plays no "
                "keys of its use",
                "tick its collection in the Outliner, or choose another object",
            )
        raise NotPlaced(
            f"'{watched.name}' is disabled in viewports, so Blender does not play the keys of its "
            "use",
            "enable it there (monitor icon)",
        )


def keyed_uses(sensor: Sensor, first: int, last: int) -> list[tuple[int, ObjectUse]]:
    """Return the use of what a sensor watches at `first`, and at the frames where it may change.

    These are whole frames from `first` to `last`, in order. The list is empty if anything but keys
    of an action sets the use, or if nothing does.
    """
    watched = watched_object(sensor)
    if watched is None or watched.animation_data is None:
        return []
    found = curves(watched, {PATH})
    strips = [strip for track in watched.animation_data.nla_tracks for strip in track.strips]
    if len(found) != 1 or found[0].mute or strips or len(watched.animation_data.drivers):
        return []
    stretch = time_stretch(bpy.context.scene)
    frames: Iterable[int] = range(first, last + 1)
    if not found[0].modifiers:
        # Between two keys, use changes only right after the first or at the second.
        keys = (point.co[0] / stretch for point in found[0].keyframe_points)
        near = {one for key in keys for one in (math.ceil(key), math.floor(key) + 1)}
        frames = sorted({first, *(frame for frame in near if first < frame <= last)})
    values = ((frame, found[0].evaluate(frame * stretch)) for frame in frames)
    # Blender takes values below 1 as off.
    return [(frame, ObjectUse(watched.name, value > 1.0 - 1e-6)) for frame, value in values]


def is_in_use(sensor: Sensor, depsgraph: Any) -> bool:
    """Return whether the object that a sensor watches is in use at the evaluated frame."""
    watched = watched_object(sensor)
    return watched is not None and bool(watched.evaluated_get(depsgraph).angen_use.in_use)
