# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that the doctor's checks examine, and their findings."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...sensor_logic.model import Array
from ..scene.home import Home
from ..scene.rays.solids import SURFACE_TYPES
from ..scene.sensors import Sensor, all_sensors, simulated, unit_scale


class Finding(NamedTuple):
    """A problem: the `check` that found it, a sentence about it, and how to `mend` it."""

    check: str
    text: str
    mend: str


@dataclass
class Examined:
    """A scene as it is evaluated, with the sensors that are switched on."""

    scene: Any
    view_layer: Any
    depsgraph: Any

    @cached_property
    def sensors(self) -> list[Sensor]:
        return simulated(all_sensors(self.view_layer))

    def requiring(self, *needs: str) -> list[Sensor]:
        """The sensors whose models require one of these quantities (kind.RAYS …)."""
        return [s for s in self.sensors if any(s.kind.requires(need) for need in needs)]

    @cached_property
    def home(self) -> Home:
        """What rays meet."""
        return Home(self.depsgraph)

    @property
    def metres(self) -> float:
        return unit_scale(self.scene)

    @cached_property
    def seen(self) -> list[tuple[Any, Array]]:
        """The originals of all that is shown and not ignored by sensors, those in instances at
        each of their places, with their matrices (4, 4) in the world."""
        found = []
        for instance in self.depsgraph.object_instances:
            original = instance.object.original
            owner = instance.parent.original if instance.is_instance else original
            ignored = original.angen_ignored or owner.angen_ignored
            if not ignored and owner.visible_get(view_layer=self.view_layer):
                found.append((original, np.array(instance.matrix_world, np.float64)))
        return found

    def shown(self) -> list[Any]:
        """Objects with a surface that sensors see, those in instances once."""
        return list(dict.fromkeys(obj for obj, _ in self.seen if obj.type in SURFACE_TYPES))


# What a check yields: what is wrong, and the way to mend it.
Found = tuple[str, str]
Check = Callable[[Examined], Iterable[Found]]
