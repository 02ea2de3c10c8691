# SPDX-License-Identifier: GPL-3.0-or-later
"""A ray caster that takes down which objects the sensor's own rays met."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....sensor_logic.model import Answers, Index
from ...scene.rays.caster import NOTHING, RayCaster
from ...scene.rays.reference import SceneRayCaster

Array = NDArray[np.float64]


class Seen(NamedTuple):
    """What a bundle of rays met: ranges (n,) in Blender units, and the name of the object that
    each met, empty where it met nothing."""

    ranges: Array
    names: list[str]


class Witness:
    """Stands in for `caster`: the same ranges, and `seen` of the last bundle that was cast."""

    def __init__(self, caster: RayCaster | SceneRayCaster) -> None:
        self._caster = caster
        # Blender's own ray cast tells nothing of instances: the exact layer names what is there.
        self._namer = caster if isinstance(caster, RayCaster) else RayCaster(caster.solids)
        self.seen = Seen(np.empty(0), [])

    @property
    def solids(self) -> Any:
        return self._caster.solids

    def update(self, depsgraph: Any) -> None:
        self._caster.update(depsgraph)
        if self._namer is not self._caster:
            self._namer.update(depsgraph)

    def cast_at(
        self,
        sensor: int,
        bundle: int,
        origins: Array,
        directions: Array,
        length: Array,
        frames: Index,
    ) -> Answers:
        rays = origins, directions, length
        ranges, met = self._namer.cast_met(sensor, bundle, *rays)
        if self._namer is not self._caster:
            ranges = self._caster.cast(sensor, bundle, *rays)
        names = {number: self.solids.name_of(number) for number in set(met.tolist())}
        names[NOTHING] = ""
        self.seen = Seen(ranges.copy(), [names[number] for number in met.tolist()])
        return Answers(ranges[None], np.zeros(len(frames), np.intp))
