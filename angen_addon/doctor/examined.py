# SPDX-License-Identifier: GPL-3.0-or-later
"""What checks are given, and what they find."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from ..plan.home import Home
from ..scene_probe.solids import SURFACE_TYPES
from ..sensors import Sensor, all_sensors, simulated, unit_scale

NAMED = 4


class Finding(NamedTuple):
    """`check` names the check that found it; `text` what is wrong, in a sentence; `mend` the way
    to mend it."""

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

    def of_kind(self, *kinds: str) -> list[Sensor]:
        return [s for s in self.sensors if s.kind.identifier in kinds]

    @cached_property
    def home(self) -> Home:
        """What rays meet."""
        return Home(self.depsgraph)

    @property
    def metres(self) -> float:
        return unit_scale(self.scene)

    def shown(self) -> Iterator[Any]:
        """Objects with a surface that sensors see."""
        for obj in self.view_layer.objects:
            if (
                obj is not None
                and obj.type in SURFACE_TYPES
                and not obj.angen_ignored
                and obj.visible_get(view_layer=self.view_layer)
            ):
                yield obj


# What a check yields: what is wrong, and the way to mend it.
Found = tuple[str, str]
Check = Callable[[Examined], Iterable[Found]]


def named(things: Iterable[str]) -> str:
    """Names in quotes, the first few of many."""
    names = sorted(dict.fromkeys(things))
    more = len(names) - NAMED
    told = ", ".join(f"'{name}'" for name in names[:NAMED])
    return f"{told} and {more} more" if more > 0 else told
