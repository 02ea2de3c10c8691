# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the light references (scene/light/cycles.py) from one run to the next."""

from __future__ import annotations

from typing import Any

from ...sensor_logic.kind import LIGHT
from ..scene.changes import Fingerprint, digest, fingerprint_of, key_of
from ..scene.facts import facts_without
from ..scene.sensors import all_sensors

# Entries of a fingerprint whose keys start so are on warmth, on which light does not depend.
WARMTH = "Warmth "


class LightReferences:
    """The light references of the last run.

    They are valid until something changes on which light depends. Parameters of sensors that
    measure no light can change meanwhile. Computing references anew takes as long as simulating
    about 50 s of the sample home.
    """

    def __init__(self) -> None:
        self._digest = ""
        self._found: dict[Any, Any] = {}

    def of(self, scene: Any, depsgraph: Any) -> dict[Any, Any]:
        """Return the references for a run of the present scene, to which the run adds its own.

        They are empty if the last run was of another scene, or if its light has changed since.
        """
        if not self._found:
            return {}
        now = _digest_for_light(scene, depsgraph, fingerprint_of(scene, depsgraph, light=True))
        return dict(self._found) if now == self._digest else {}

    def keep(
        self, scene: Any, depsgraph: Any, fingerprint: Fingerprint, found: dict[Any, Any]
    ) -> None:
        """Keep the references `found` in a run, whose scene has this fingerprint."""
        if found and fingerprint.light:
            self._digest = _digest_for_light(scene, depsgraph, fingerprint)
            self._found = found


def _digest_for_light(scene: Any, depsgraph: Any, fingerprint: Fingerprint) -> str:
    """Return a digest of all that light depends on.

    `fingerprint` is that of the present scene.
    """
    digests = {k: d for k, d in fingerprint.digests.items() if not k.startswith(WARMTH)}
    for sensor in all_sensors(scene.view_layers[depsgraph.view_layer.name]):
        if not sensor.kind.requires(LIGHT):
            digests[key_of(sensor.object)] = digest(facts_without(sensor.object, "angen_sensor"))
    return digest(sorted(digests.items()))
