# SPDX-License-Identifier: GPL-3.0-or-later
"""The edits of the scene, and what is looked up anew only after an edit, such as its sensors."""

from __future__ import annotations

import weakref
from typing import Any, Protocol

from ..scene import memory
from ..scene.outputs import are_driven
from ..scene.sensors import Sensor, all_sensors


class Listener(Protocol):
    """An object whose method `note` is called at each evaluation of the scene.

    `edited` is false if only the frame has changed. `by_frame` says whether a change of frame
    caused the evaluation.
    """

    def note(self, depsgraph: Any, edited: bool, by_frame: bool) -> None: ...


class Edits:
    """The edits of the scene: who is notified of them, and what is looked up anew after them."""

    def __init__(self) -> None:
        # See `revision`.
        self._revision = 0
        # The listed sensors, with the view layer and the revision of the list.
        self._sensors: tuple[Any, list[Sensor]] = (None, [])
        # The revision of the look-up, and whether drivers read outputs.
        self._driven = -1, False
        self._listeners: weakref.WeakSet[Listener] = weakref.WeakSet()

    @property
    def revision(self) -> int:
        """A number that grows with each edit of the scene; a change of frame is no edit."""
        return self._revision

    def count(self) -> None:
        """Count an edit that Blender does not report."""
        self._revision += 1

    def watch(self, probe: Listener) -> None:
        """Call `probe.note` at each evaluation from now on, until `probe` is garbage-collected."""
        self._listeners.add(probe)

    def note(self, depsgraph: Any, edited: bool, by_frame: bool = False) -> None:
        """Notify all listeners; call this method at each evaluation.

        `edited` is false if only the frame has changed. `by_frame` says whether a change of frame
        caused the evaluation. A script may change the scene just before it moves the playhead:
        Blender reports this edit with the change of frame, and it counts as an edit.
        """
        if edited or depsgraph.id_type_updated("SCENE") or depsgraph.id_type_updated("COLLECTION"):
            self._revision += 1
        for probe in self._listeners:
            probe.note(depsgraph, edited, by_frame)

    def sensors(self, view_layer: Any) -> list[Sensor]:
        """Return all sensors of a view layer; list them anew only after an edit of the scene.

        Call this method only in handlers and while drawing, when Blender has reported all edits.
        Elsewhere call `all_sensors`.
        """
        return self.sensors_and_revision(view_layer)[0]

    def sensors_and_revision(self, view_layer: Any) -> tuple[list[Sensor], int]:
        """Return all sensors of a view layer as `sensors` does, and the revision of the scene."""
        layer = view_layer.id_data.session_uid, view_layer.name
        known, sensors = self._sensors
        if known == (self._revision, *layer) and not _have_their_names(sensors):
            # Blender does not report new names.
            self._revision += 1
        if known != (self._revision, *layer):
            sensors = all_sensors(view_layer)
            self._sensors = (self._revision, *layer), sensors
        return sensors, self._revision

    def outputs_are_driven(self) -> bool:
        """Return whether any driver reads an output; look anew only after an edit of the scene."""
        if self._driven[0] != self._revision:
            self._driven = self._revision, are_driven()
        return self._driven[1]

    def forget(self) -> None:
        """Forget the sensors and all listeners, because Blender will replace its data."""
        self.count()
        self._sensors = None, []
        self._listeners = weakref.WeakSet()


def _have_their_names(sensors: list[Sensor]) -> bool:
    """Return whether all sensors still exist and have the names under which they were listed."""
    try:
        return all(sensor.name_now == sensor.name for sensor in sensors)
    except ReferenceError:
        return False


EDITS = Edits()
memory.forgets_at_undo(EDITS.forget)
