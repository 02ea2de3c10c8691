# SPDX-License-Identifier: GPL-3.0-or-later
"""Read whether the objects that sensors watch are in use."""

from __future__ import annotations

from typing import Any

from ...sensor_logic.parameters import specs
from .animation import is_animated
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
        raise NotPlaced(
            f"'{watched.name}' is disabled in viewports, so Blender does not play the keys of its "
            "use",
            "enable it there (monitor icon), or tick its collection",
        )


def is_in_use(sensor: Sensor, depsgraph: Any) -> bool:
    """Return whether the object that a sensor watches is in use at the evaluated frame."""
    watched = watched_object(sensor)
    return watched is not None and bool(watched.evaluated_get(depsgraph).angen_use.in_use)
