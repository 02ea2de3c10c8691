# SPDX-License-Identifier: GPL-3.0-or-later
"""Light scenes that are kept from update to update of a run.

Handing a home over to Cycles takes longer than its light paths. A scene that is kept is handed over
once; afterwards Cycles takes over what changed. It gives the same bits as a new one.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from . import engine
from .frozen import Simulated
from .picture import Seen, Steps
from .reference import (
    Found,
    Lamps,
    Part,
    Reference,
    ReferenceScene,
    corrected,
    departs,
    looks_at_frame,
    states_of_lamps,
)
from .scene import LightScene, contents, quietly

Array = NDArray[np.float64]
FIRST_PICTURE, CLOSER_LOOK = "Cycles takes the scene in", "a closer look at the light"
# As many pictures of each sort are kept; each holds the scene in memory, as Cycles sees it.
AT_MOST = 4
# So many times the light paths are traced where a reference tells too little.
CLOSER = 16
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
        with quietly():
            return self._taken_in(light_scene, samples)

    def _taken_in(self, light_scene: LightScene, samples: int) -> Takes:
        light_scene.__enter__()
        try:
            engine.set_up(light_scene.scene, "CYCLES")
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

    def close(self) -> None:
        self.light_scene.close()


class _Pool:
    """Keeps AT_MOST things, by key; the one used longest ago is closed first.

    Not generic: what `typing` remembers of a generic class keeps the extension's modules alive
    until Blender's own end, at which the module of 4.5 then hangs.
    """

    def __init__(self) -> None:
        self._by_key: dict[Hashable, Any] = {}

    def get(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """The one kept, or a new one."""
        found = self._by_key.pop(key, None)
        if found is None:
            found = make()
        self._by_key[key] = found
        while len(self._by_key) > AT_MOST:
            self.drop(next(iter(self._by_key)))
        return found

    def peek(self, key: Hashable) -> Any:
        return self._by_key.get(key)

    def drop(self, key: Hashable) -> None:
        self._by_key.pop(key).close()

    def close(self) -> None:
        while self._by_key:
            self._by_key.popitem()[1].close()


class KeptScenes:
    """What `measure` may keep. To be closed before other code can change the scene.

    `reference`: light paths a reading that a reference traces, see `light_reference`; none where
    that is not more than the reading's own, and none for what is asked only once: of a sensor that
    is not `steady`.
    """

    def __init__(self, reference: int = 0) -> None:
        self.reference = reference
        self._scenes = _Pool()
        self._references = _Pool()
        # Of single requests that are looked at more closely.
        self._closer_scenes = _Pool()
        self._closer_references = _Pool()
        self._found: dict[Hashable, Found] = {}
        self._simulated = Simulated()

    def light(self, batch: Batch) -> Steps[tuple[list[Array], list[str]]]:
        """What each request of a batch finds; and notes."""
        self._simulated.look_again()
        now = contents(batch.scene, batch.view_layer, self._simulated)
        light, notes = yield from self._picture(batch, now, self._scenes)
        if batch.steady and self.refers(batch.samples) and not self._looks_at_frame:
            lamps = states_of_lamps(batch.view_layer, self._simulated)
            told = yield from self._referred(batch, now, lamps)
            referred = dict(zip(batch.together, told, strict=True))
            own = dict(zip(batch.together, light, strict=True))
            far = [pixel for pixel in own if departs(own[pixel], referred[pixel][0])]
            closer = (yield from self._closer(batch, far, now, lamps, referred)) if far else {}
            light = [
                closer[pixel] if pixel in closer else corrected(own[pixel], *referred[pixel])
                for pixel in own
            ]
        return light, notes

    def _closer(
        self,
        batch: Batch,
        far: list[int],
        now: Hashable,
        lamps: Lamps,
        referred: dict[int, tuple[Array, Array]],
    ) -> Steps[dict[int, Array]]:
        """The light of the requests at some pixels by several times the paths, corrected as it is
        by few."""
        paths = min(CLOSER * batch.samples, self.reference)
        # A picture each, as long as all of them can be kept: a new scene costs more than its paths.
        groups = [[pixel] for pixel in far] if len(far) <= AT_MOST else [list(batch.together)]
        found: dict[int, Array] = {}
        for pixels in groups:
            together = {pixel: batch.together[pixel] for pixel in pixels}
            near = replace(batch, together=together, samples=paths)
            light, _ = yield from self._picture(near, now, self._closer_scenes)
            if self.refers(paths):
                state = near.asked, now, lamps
                if state not in self._found:
                    make = partial(Reference, partial(_in_reference, near, self._simulated))
                    reference: Reference = self._closer_references.get((near.asked, now), make)
                    yield CLOSER_LOOK
                    many = [referred[pixel][1] for pixel in pixels]
                    self._remember(state, list(zip(reference.by_few(), many, strict=True)))
                pairs = zip(light, self._found[state], strict=True)
                light = [corrected(one, *pair) for one, pair in pairs]
            found.update(zip(pixels, light, strict=True))
        return {pixel: found[pixel] for pixel in far}

    def _picture(
        self, batch: Batch, now: Hashable, pool: _Pool
    ) -> Steps[tuple[list[Array], list[str]]]:
        """What the batch's own light paths find in the scene as it is; and notes."""

        def make() -> _Kept:
            light_scene = LightScene(batch.scene, batch.view_layer, self._simulated)
            return _Kept(now, light_scene, batch.taken_in(light_scene, batch.samples))

        key = batch.asked
        known: _Kept | None = pool.peek(key)
        if known is not None:
            if known.contents != now or known.light_scene.has_frozen or self._looks_at_frame:
                pool.drop(key)
            else:
                known.light_scene.follow()
        yield "" if pool.peek(key) is not None else FIRST_PICTURE
        kept: _Kept = pool.get(key, make)
        return kept.taken.light(), kept.light_scene.notes

    def _referred(self, batch: Batch, now: Hashable, lamps: Lamps) -> Steps[Found]:
        """What few and many paths find in the reference of a batch, in that state of the lamps."""
        state = batch.asked, now, lamps
        if state not in self._found:
            # Suns and other lamps each by themselves.
            apart = all(lamps)
            make = partial(
                Reference, partial(_in_reference, batch, self._simulated), self.reference, apart
            )
            reference: Reference = self._references.get((batch.asked, now, apart), make)
            self._remember(state, (yield from reference.light(lamps[0])))
        return self._found[state]

    def _remember(self, state: Hashable, found: Found) -> None:
        while len(self._found) >= STATES:
            self._found.pop(next(iter(self._found)))
        self._found[state] = found

    @cached_property
    def _looks_at_frame(self) -> bool:
        """Nothing but frames changes as long as scenes are kept."""
        return looks_at_frame()

    def refers(self, samples: int) -> bool:
        """Whether readings of so many light paths have a reference."""
        return self.reference > samples

    @property
    def states(self) -> int:
        """How many states of the lamps have a reference now, each picture by itself."""
        return len(self._found)

    def close(self) -> None:
        self._found.clear()
        self._simulated = Simulated()
        self._references.close()
        self._closer_references.close()
        self._scenes.close()
        self._closer_scenes.close()


def _in_reference(
    batch: Batch, simulated: Simulated, part: Part, paths: int | None = None
) -> tuple[ReferenceScene, Takes]:
    """A new reference scene and its picture, by the batch's own light paths or others."""
    light_scene = ReferenceScene(batch.scene, batch.view_layer, part, simulated)
    return light_scene, batch.taken_in(light_scene, paths or batch.samples)


def _bits(seen: Seen) -> tuple[Hashable, ...]:
    request = seen.request
    return seen.lids, repr(replace(request, matrix=NOWHERE)), request.matrix.tobytes()
