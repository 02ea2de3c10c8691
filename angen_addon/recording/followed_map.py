# SPDX-License-Identifier: GPL-3.0-or-later
"""The check whether a coverage map or the like is stale, which works as for a recording."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from ...sensor_logic.kinds import KINDS
from ..scene.facts import FACTS_VERSION
from ..scene.marks import COVERAGE_MARK
from ..scene.sensors import Sensor, unit_scale
from .fingerprint import SCENE, SHOWN, Fingerprint, digest, key_of, what_is_shown
from .followed_scene import THIS_BLENDER, FollowedScene

# m: sensors that are smaller than this hide no floor and bar no way.
SMALL_M = 0.5
# Stands for the FACTS_VERSION of a text that cannot be read.
NONE_MEASURED = -1


class FollowedResult(FollowedScene):
    """The fingerprint of the scene for which a result, such as a coverage map, was computed.

    It leaves out data on which the result does not depend: most settings of the scene, and small
    sensors. The scene stores the fingerprint as a text, so that undo and saving keep it.
    """

    @staticmethod
    def stored_text(scene: Any) -> str:
        """Return the fingerprint that the scene stores, as a text; empty without a result."""
        raise NotImplementedError

    @staticmethod
    def store_text(scene: Any, text: str) -> None:
        """Store a fingerprint as a text in the scene."""
        raise NotImplementedError

    @staticmethod
    def depends_on(sensor: Any) -> bool:
        """Return whether the result depends on a small sensor, given as an object."""
        raise NotImplementedError

    @classmethod
    def note(cls, scene: Any, depsgraph: Any) -> FollowedResult:
        """Compute the fingerprint of the present scene, store it in the scene, and return it.

        Call this method when a result was made.
        """
        made = cls(Fingerprint(depsgraph.view_layer.name, light=False))
        made.fingerprint = made._fingerprint_now(scene, depsgraph)
        header = [FACTS_VERSION, *THIS_BLENDER], depsgraph.view_layer.name
        made.stored = json.dumps([*header, made.fingerprint.digests])
        cls.store_text(scene, made.stored)
        return made

    @classmethod
    def read(cls, text: str) -> FollowedResult:
        """Return the fingerprint in a text that `note` has stored.

        If the text is damaged, return a fingerprint that counts as stale.
        """
        try:
            (facts, *blender), view_layer, digests = json.loads(text)
            known = {str(key): str(digest) for key, digest in digests.items()}
        except (ValueError, TypeError, AttributeError):
            (facts, *blender), view_layer, known = [NONE_MEASURED, *THIS_BLENDER], "", {}
        found = cls(Fingerprint(view_layer, False, known), tuple(blender))
        found.facts, found.stored, found.unsure = facts, text, True
        return found

    def _fingerprint_now(self, scene: Any, depsgraph: Any) -> Fingerprint:
        made = super()._fingerprint_now(scene, depsgraph)
        layer = scene.view_layers[depsgraph.view_layer.name]
        for obj in self._left_out(layer):
            made.digests.pop(key_of(obj, self._renamed), None)
            if obj.data is not None:
                made.digests.pop(key_of(obj.data), None)
        made.digests |= self._scene_digests(scene, layer, ())
        return made

    def _settings(self, scene: Any, sensors: Sequence[Sensor]) -> str:
        return digest(unit_scale(scene))

    def _scene_digests(self, scene: Any, layer: Any, sensors: Sequence[Sensor]) -> dict[str, str]:
        shown = what_is_shown(layer, self._renamed, self._left_out(layer))
        return {SCENE: self._settings(scene, sensors), SHOWN: shown}

    def _left_out(self, view_layer: Any) -> set[Any]:
        """Return the objects that are small sensors on which the result does not depend."""
        small = SMALL_M / unit_scale(view_layer.id_data)
        return {
            obj
            for obj in view_layer.objects
            if obj.angen_sensor.kind in KINDS
            and not self.depends_on(obj)
            and max(obj.dimensions) < small
        }


class FollowedMap(FollowedResult):
    """The fingerprint of the scene for which a coverage map was computed.

    Small sensors are left out if they are of kinds that have no coverage maps.
    """

    KEY = f"{COVERAGE_MARK}_followed"

    @staticmethod
    def stored_text(scene: Any) -> str:
        return str(scene.get(FollowedMap.KEY, ""))

    @staticmethod
    def store_text(scene: Any, text: str) -> None:
        scene[FollowedMap.KEY] = text

    @staticmethod
    def depends_on(sensor: Any) -> bool:
        return KINDS[sensor.angen_sensor.kind].view is not None
