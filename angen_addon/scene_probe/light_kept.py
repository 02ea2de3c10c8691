# SPDX-License-Identifier: GPL-3.0-or-later
"""Light scenes that are kept from update to update of a run.

Handing a home over to Cycles takes longer than its light paths. A scene that is kept is handed over
once; afterwards Cycles takes over what changed. It gives the same bits as a new one.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from . import light_engine
from .light_picture import Seen
from .light_reference import (
    Found,
    Part,
    Reference,
    ReferenceScene,
    corrected,
    looks_at_frame,
    states_of_lamps,
)
from .light_scene import LightScene, contents

Array = NDArray[np.float64]
# As many pictures are kept; each holds the scene in memory, as Cycles sees it.
AT_MOST = 4
# Of so many states of the lamps, each picture by itself, it is remembered what a reference found.
STATES = 4096
NOWHERE = np.zeros(0)


class Takes(Protocol):
    """What takes a picture of a batch of requests, `Views` or `Faces`."""

    def __init__(self, light_scene: Any, together: dict[int, Seen], samples: int) -> None: ...
    def light(self) -> list[Array]: ...


@dataclass(frozen=True)
class Batch:
    """Requests that one picture answers, at the present frame of the user's scene."""

    scene: Any
    view_layer: Any
    takes: type[Takes]
    together: dict[int, Seen]
    samples: int

    @property
    def asked(self) -> Hashable:
        """All that is asked, to be compared."""
        pixels = tuple((pixel, *_bits(seen)) for pixel, seen in self.together.items())
        metres = self.scene.unit_settings.scale_length
        return self.takes.__name__, self.samples, metres, pixels

    @property
    def steady(self) -> bool:
        return all(seen.request.steady for seen in self.together.values())

    def taken_in(self, light_scene: LightScene, samples: int) -> Takes:
        """Enters a light scene and sets up the picture in it."""
        light_scene.__enter__()
        try:
            light_engine.set_up(light_scene.scene, "CYCLES")
            light_scene.scene.render.use_persistent_data = True
            return self.takes(light_scene, self.together, samples)
        except BaseException:
            light_scene.close()
            raise


@dataclass(frozen=True)
class _Kept:
    contents: Hashable
    light_scene: LightScene
    taken: Takes


class KeptScenes:
    """What `measure` may keep. To be closed before other code can change the scene.

    `reference`: light paths a reading that a reference traces, see `light_reference`; none where
    that is not more than the reading's own, and none for what is asked only once: of a sensor that
    is not `steady`.
    """

    def __init__(self, reference: int = 0) -> None:
        self.reference = reference
        self._kept: dict[Hashable, _Kept] = {}
        self._references: dict[Hashable, Reference] = {}
        self._found: dict[Hashable, Found] = {}

    def light(self, batch: Batch) -> tuple[list[Array], list[str]]:
        """What each request of a batch finds; and notes."""
        key = batch.asked
        now = contents(batch.scene, batch.view_layer)
        found = self._kept.pop(key, None)
        if found is not None and (
            found.contents != now or found.light_scene.has_frozen or self._looks_at_frame
        ):
            found.light_scene.close()
            found = None
        if found is None:
            light_scene = LightScene(batch.scene, batch.view_layer)
            found = _Kept(now, light_scene, batch.taken_in(light_scene, batch.samples))
        else:
            found.light_scene.follow()
        # The last one used comes last.
        self._kept[key] = found
        while len(self._kept) > AT_MOST:
            self._kept.pop(next(iter(self._kept))).light_scene.close()
        light = found.taken.light()
        if batch.steady and self.refers(batch.samples) and not self._looks_at_frame:
            lamps = states_of_lamps(batch.view_layer)
            state = key, now, lamps
            if state not in self._found:
                while len(self._found) >= STATES:
                    self._found.pop(next(iter(self._found)))
                apart = all(lamps)
                reference = self._reference(batch, apart, (key, now, apart))
                self._found[state] = reference.light(lamps[0])
            pairs = zip(light, self._found[state], strict=True)
            light = [corrected(own, few, many) for own, (few, many) in pairs]
        return light, found.light_scene.notes

    @cached_property
    def _looks_at_frame(self) -> bool:
        """Nothing but frames changes as long as scenes are kept."""
        return looks_at_frame()

    def refers(self, samples: int) -> bool:
        """Whether readings of so many light paths have a reference."""
        return self.reference > samples

    def _reference(self, batch: Batch, apart: bool, picture: Hashable) -> Reference:
        """`apart`: suns and other lamps each by themselves."""

        def taken(count: int, part: Part) -> tuple[ReferenceScene, Takes]:
            light_scene = ReferenceScene(batch.scene, batch.view_layer, part)
            return light_scene, batch.taken_in(light_scene, count)

        kept = self._references
        # The last one used comes last.
        known = kept.pop(picture, None)
        if known is None:
            many = partial(taken, self.reference)
            few = taken(batch.samples, Part.ALL)
            known = (
                Reference(few, many(Part.ROOM), many) if apart else Reference(few, many(Part.ALL))
            )
        kept[picture] = known
        while len(kept) > AT_MOST:
            kept.pop(next(iter(kept))).close()
        return kept[picture]

    @property
    def states(self) -> int:
        """How many states of the lamps have a reference now, each picture by itself."""
        return len(self._found)

    def close(self) -> None:
        self._found.clear()
        while self._references:
            self._references.popitem()[1].close()
        while self._kept:
            self._kept.popitem()[1].light_scene.close()


def _bits(seen: Seen) -> tuple[Hashable, ...]:
    request = seen.request
    return seen.lids, repr(replace(request, matrix=NOWHERE)), request.matrix.tobytes()
