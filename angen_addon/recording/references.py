# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep the light references of the last run (scene/light/cycles.py) for the next run.

A light reference is a picture with many light paths, by which noisy readings are corrected.
"""

from __future__ import annotations

from typing import Any

from ...sensor_logic.kind import LIGHT
from ..scene import memory
from ..scene.facts import facts_without
from ..scene.sensors import all_sensors
from .fingerprint import Fingerprint, digest, fingerprint_of, key_of

# Entries of a fingerprint whose keys start so are on warmth, on which light does not depend.
WARMTH = "Warmth "


class LightReferences:
    """The light references of the last run: pictures by which noisy readings are corrected.

    They are valid until data changes on which light depends. Changes of sensors that measure no
    light do not matter. Computing references anew takes as long as simulating about 50 s of the
    sample home.
    """

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget the references of the last run."""
        self._digest = ""
        self._found: dict[Any, Any] = {}

    def of(self, scene: Any, depsgraph: Any) -> dict[Any, Any]:
        """Return the references for a run of the present scene, to which the run adds its own.

        The dictionary is empty if the last run was of another scene, or if its light has changed
        since.
        """
        if not self._found:
            return {}
        now = _digest_for_light(scene, depsgraph, fingerprint_of(scene, depsgraph, light=True))
        return dict(self._found) if now == self._digest else {}

    def keep(
        self, scene: Any, depsgraph: Any, fingerprint: Fingerprint, found: dict[Any, Any]
    ) -> None:
        """Store the references `found` that a run computed for a scene with this fingerprint."""
        if found and fingerprint.light:
            self._digest = _digest_for_light(scene, depsgraph, fingerprint)
            self._found = found


REFERENCES = LightReferences()
memory.forgets_at_load(REFERENCES.clear)


def _digest_for_light(scene: Any, depsgraph: Any, fingerprint: Fingerprint) -> str:
    """Return a digest of all data on which light depends."""
    digests = {k: d for k, d in fingerprint.digests.items() if not k.startswith(WARMTH)}
    for sensor in all_sensors(scene.view_layers[depsgraph.view_layer.name]):
        if not sensor.kind.requires(LIGHT):
            digests[key_of(sensor.object)] = digest(facts_without(sensor.object, "angen_sensor"))
    return digest(sorted(digests.items()))
