# SPDX-License-Identifier: GPL-3.0-or-later
"""Read whether the objects that sensors watch are in use."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import bpy
import numpy as np

from ...sensor_logic.kind import USES
from ...sensor_logic.logs.error import AngenError, explained
from ...sensor_logic.model import Answers, Index, ObjectUse
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
        raise NotPlaced(
            f"'{watched.name}' is disabled in viewports, so Blender does not play the keys of its "
            "use",
            "enable it there (monitor icon), or tick its collection",
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
    keys = (math.ceil(point.co[0] / stretch) for point in found[0].keyframe_points)
    frames = sorted({first, *(frame for frame in keys if first < frame <= last)})
    values = ((frame, found[0].evaluate(frame * stretch)) for frame in frames)
    return [(frame, ObjectUse(watched.name, value >= 0.5)) for frame, value in values]


class UseReader:
    """Reads at each frame whether the watched objects are in use.

    What no keyframe or driver changes is only read when a sensor asks for it.
    """

    def __init__(self) -> None:
        self._sensors: list[Sensor] = []
        self._column: dict[str, int] = {}
        # Of each frame, whether the objects of the sensors are in use.
        self._noted: list[list[bool]] = []
        self._shown = np.zeros((1, 0), np.intp)

    def watch(self, sensors: Iterable[Sensor]) -> None:
        """Read the use of what these sensors watch from now on; the others watch nothing."""
        self._sensors = [s for s in sensors if s.kind.requires(USES) and may_change(s)]
        self._column = {sensor.name: column for column, sensor in enumerate(self._sensors)}

    def look(self, depsgraph: Any) -> None:
        """Read the present frame, and answer queries about this frame alone."""
        self.add(depsgraph)
        self.finish()

    def add(self, depsgraph: Any) -> None:
        """Read the present frame of an evaluated scene."""
        self._noted.append([_is_in_use(sensor, depsgraph) for sensor in self._sensors])

    def finish(self) -> None:
        """Answer queries about the frames that were read since the last call."""
        shape = len(self._noted), len(self._sensors)
        self._shown = np.array(self._noted, np.intp).reshape(shape)
        self._noted = []

    def at(self, sensor: Sensor, frames: Index, depsgraph: Any) -> Answers:
        """Return the `ObjectUse` of what a sensor watches at frames (n,), given by index.

        Raise `AngenError` if it cannot be read in the evaluated `depsgraph`.
        """
        watched = watched_object(sensor)
        with explained(f"'{sensor.name}'", NotPlaced, raised=AngenError):
            check_watched(sensor, depsgraph)
        if watched is None:
            return Answers([None], np.zeros(len(frames), np.intp))
        table = [ObjectUse(watched.name, False), ObjectUse(watched.name, True)]
        column = self._column.get(sensor.name)
        if column is None:
            return Answers(table, np.full(len(frames), int(watched.angen_use.in_use)))
        return Answers(table, self._shown[frames, column])


def _is_in_use(sensor: Sensor, depsgraph: Any) -> bool:
    watched = watched_object(sensor)
    return watched is not None and bool(watched.evaluated_get(depsgraph).angen_use.in_use)
