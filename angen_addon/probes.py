# SPDX-License-Identifier: GPL-3.0-or-later
"""What reads the scene for the sensors: one of each probe, and only those that they need."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from ..sensor_logic.contact.island import PadForces
from . import state
from .scene_probe.bodies import Bodies
from .scene_probe.rays import RayCaster
from .scene_probe.reference_rays import SceneRayCaster
from .sensors import Sensor, unit_scale


def make_caster(scene: Any) -> RayCaster | SceneRayCaster:
    """The ray caster that the scene chose, told of every change from now on."""
    caster = SceneRayCaster(scene) if scene.angen_ray_caster == "SCENE" else RayCaster()
    state.CACHE.watch(caster.solids)
    return caster


class Probes:
    """The probes for the sensors of a scene."""

    def __init__(self, scene: Any) -> None:
        self.caster = make_caster(scene)
        self._bodies = Bodies(self.caster.solids)
        self._pads: list[Any] = []

    def serve(self, sensors: Iterable[Sensor]) -> None:
        """From now on the probes look at what these sensors need."""
        self._pads = [sensor.object for sensor in sensors if sensor.kind.motion]

    def look(self, depsgraph: Any, frame: int | None, due: Sequence[Any] = ()) -> None:
        """Brings the probes to the scene as it is now evaluated.

        `frame`: the whole frame that this is, or None where its motion is not needed; `due`: pads
        whose forces at this frame will be asked for.
        """
        self.caster.update(depsgraph)
        if self._pads and frame is not None:
            metres = unit_scale(depsgraph.scene)
            self._bodies.look(depsgraph, frame, metres, self._pads, due)

    def forces(self, pad: Any, frame: int) -> PadForces:
        """The contact forces on a pad at a whole frame, after the next one was looked at."""
        return self._bodies.forces(pad, frame)
