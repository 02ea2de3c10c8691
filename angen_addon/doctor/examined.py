# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene that the checks examine, and the findings that they yield."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...sensor_logic.model import Array
from ..scene.home.evaluated_home import EvaluatedHome
from ..scene.rays.solids import SURFACE_TYPES
from ..scene.sensors import Sensor, all_sensors, is_evaluated, simulated, unit_scale
from .bare import Bare, bare_objects


class Finding(NamedTuple):
    """A mistake that a check found.

    Attributes
    ----------
    check
        The name of the check.
    text
        What is wrong.
    mend
        How to mend it.
    objects
        The names of the objects with the problem.
    """

    check: str
    text: str
    mend: str
    objects: tuple[str, ...] = ()


# Each function gets a scene and a view layer, and returns the objects that move without keyframes.
# Parts of the extension that move objects add their functions here.
MOVED_WITHOUT_KEYS: list[Callable[[Any, Any], list[Any]]] = []


@dataclass
class Examined:
    """The evaluated scene that the checks for mistakes examine."""

    scene: Any
    view_layer: Any
    depsgraph: Any

    @cached_property
    def sensors(self) -> list[Sensor]:
        """The sensors that are switched on and that Blender evaluates."""
        found = simulated(all_sensors(self.view_layer))
        return [sensor for sensor in found if is_evaluated(sensor, self.depsgraph)]

    @property
    def unplaced(self) -> list[Sensor]:
        """The sensors that are switched on but that Blender does not evaluate."""
        found = simulated(all_sensors(self.view_layer))
        return [sensor for sensor in found if sensor not in self.sensors]

    def requiring(self, *needs: str) -> list[Sensor]:
        """Return the sensors that read at least one of these quantities, such as `kind.RAYS`."""
        return [s for s in self.sensors if any(s.kind.requires(need) for need in needs)]

    @cached_property
    def home(self) -> EvaluatedHome:
        """The surfaces of the home, for casting rays."""
        return EvaluatedHome(self.depsgraph)

    @cached_property
    def moved_without_keys(self) -> list[Any]:
        """The objects that the extension moves without keyframes, such as residents."""
        return [obj for find in MOVED_WITHOUT_KEYS for obj in find(self.scene, self.view_layer)]

    @property
    def metres(self) -> float:
        """Metres in a Blender unit."""
        return unit_scale(self.scene)

    @cached_property
    def seen(self) -> list[tuple[Any, Array]]:
        """The visible objects that sensors do not ignore, each with its world matrix (4, 4).

        An instanced object has an entry for each instance.
        """
        found = []
        for instance in self.depsgraph.object_instances:
            original = instance.object.original
            owner = instance.parent.original if instance.is_instance else original
            ignored = original.angen_ignored or owner.angen_ignored
            if not ignored and owner.visible_get(view_layer=self.view_layer):
                found.append((original, np.array(instance.matrix_world, np.float64)))
        return found

    @cached_property
    def bare(self) -> list[Bare]:
        """The visible objects without faces, which sensors do not meet."""
        return list(bare_objects(self.depsgraph, self.view_layer, self.metres))

    def shown(self) -> list[Any]:
        """Return the visible objects that have a surface, without repetition."""
        return list(dict.fromkeys(obj for obj, _ in self.seen if obj.type in SURFACE_TYPES))


# What a check yields: the problem, the way to mend it, and the names of the objects with it.
Found = tuple[str, str] | tuple[str, str, tuple[str, ...]]
Check = Callable[[Examined], Iterable[Found]]
