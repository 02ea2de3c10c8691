# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps the light references (scene/light/cycles.py) from one run to the next."""

from __future__ import annotations

from typing import Any

from ...sensor_logic.kind import LIGHT
from ..scene.changes import Fingerprint, digest, fingerprint_of, key_of
from ..scene.facts import facts_without
from ..scene.sensors import all_sensors

# Start of the fingerprint's keys that light does not depend on.
WARMTH = "Warmth "


class LightReferences:
    """The light references of the last run, valid while all that light depends on is the same.

    Parameters of sensors that measure no light may change. To trace the references anew takes as
    long as about 50 s of the sample home.
    """

    def __init__(self) -> None:
        self._digest = ""
        self._found: dict[Any, Any] = {}

    def of(self, scene: Any, depsgraph: Any) -> dict[Any, Any]:
        """Return the references for a run of the present scene; the run adds to them."""
        if not self._found:
            return {}
        now = _digest_for_light(scene, depsgraph, fingerprint_of(scene, depsgraph, light=True))
        return dict(self._found) if now == self._digest else {}

    def keep(
        self, scene: Any, depsgraph: Any, fingerprint: Fingerprint, found: dict[Any, Any]
    ) -> None:
        """Keep the references of a run in a scene with this fingerprint."""
        if found and fingerprint.light:
            self._digest = _digest_for_light(scene, depsgraph, fingerprint)
            self._found = found


def _digest_for_light(scene: Any, depsgraph: Any, fingerprint: Fingerprint) -> str:
    """Return a digest of what light depends on, from the fingerprint of the present scene."""
    digests = {k: d for k, d in fingerprint.digests.items() if not k.startswith(WARMTH)}
    for sensor in all_sensors(scene.view_layers[depsgraph.view_layer.name]):
        if not sensor.kind.requires(LIGHT):
            digests[key_of(sensor.object)] = digest(facts_without(sensor.object, "angen_sensor"))
    return digest(sorted(digests.items()))
