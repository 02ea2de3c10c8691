# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares the scene of a coverage map with the present scene, as for recordings."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from ...sensor_logic.coverage.detectors import DETECTOR
from ...sensor_logic.recording.tracks import Recording
from ..scene.changes import SCENE, SHOWN, Fingerprint, digest, key_of, what_is_shown
from ..scene.facts import FACTS_VERSION
from ..scene.marks import COVERAGE_MARK
from ..scene.sensors import Sensor, unit_scale
from .stored_recording import THIS_BLENDER, StoredRecording

# m: smaller sensors of other kinds do not hide the floor.
SMALL_M = 0.5
NONE_MEASURED = -1


class FollowedMap(StoredRecording):
    """The fingerprint of a coverage map's scene.

    It leaves out settings of the scene and sensors of other kinds, which the map does not depend
    on. The scene stores it as a text, so that undo and saving keep it.
    """

    KEY = f"{COVERAGE_MARK}_followed"

    @staticmethod
    def stored_text(scene: Any) -> str:
        """Return the text that the scene stores; empty without a map."""
        return str(scene.get(FollowedMap.KEY, ""))

    @classmethod
    def note(cls, scene: Any, depsgraph: Any) -> FollowedMap:
        """Store the present fingerprint in the scene as that of its map, and return it."""
        made = cls(Recording(), Fingerprint(depsgraph.view_layer.name, light=False))
        made.fingerprint = made._fingerprint_now(scene, depsgraph)
        header = [FACTS_VERSION, *THIS_BLENDER], depsgraph.view_layer.name
        made.stored = scene[cls.KEY] = json.dumps([*header, made.fingerprint.digests])
        return made

    @classmethod
    def read(cls, text: str) -> FollowedMap:
        """Return the fingerprint in a text from `note`.

        A map with a damaged text counts as made by an earlier version.
        """
        try:
            (facts, *blender), view_layer, digests = json.loads(text)
            known = {str(key): str(digest) for key, digest in digests.items()}
        except (ValueError, TypeError, AttributeError):
            (facts, *blender), view_layer, known = [NONE_MEASURED, *THIS_BLENDER], "", {}
        found = cls(Recording(), Fingerprint(view_layer, False, known), tuple(blender))
        found.facts, found.stored, found.unsure = facts, text, True
        return found

    def _fingerprint_now(self, scene: Any, depsgraph: Any) -> Fingerprint:
        made = super()._fingerprint_now(scene, depsgraph)
        layer = scene.view_layers[depsgraph.view_layer.name]
        for obj in _small_sensors(layer):
            made.digests.pop(key_of(obj, self._renamed), None)
            if obj.data is not None:
                made.digests.pop(key_of(obj.data), None)
        made.digests |= self._scene_digests(scene, layer, ())
        return made

    def _settings(self, scene: Any, sensors: Sequence[Sensor]) -> str:
        return digest(unit_scale(scene))

    def _scene_digests(self, scene: Any, layer: Any, sensors: Sequence[Sensor]) -> dict[str, str]:
        shown = what_is_shown(layer, self._renamed, _small_sensors(layer))
        return {SCENE: self._settings(scene, sensors), SHOWN: shown}


def _small_sensors(view_layer: Any) -> set[Any]:
    """Return small objects that are sensors of other kinds than the map's."""
    small = SMALL_M / unit_scale(view_layer.id_data)
    return {
        obj
        for obj in view_layer.objects
        if obj.angen_sensor.kind not in ("NONE", DETECTOR.identifier)
        and max(obj.dimensions) < small
    }
