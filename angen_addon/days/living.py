# SPDX-License-Identifier: GPL-3.0-or-later
"""One day in the open home: the keys of its stretches come and go, the sensors read on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from typing import Any, Protocol

from ...sensor_logic.clock import exact
from ...sensor_logic.days.rows import attributed
from ...sensor_logic.days.times import FPS, LEAD_S, clock_of_day, frame_at, stretches
from ...sensor_logic.days.truth import DAY_S, US
from ...sensor_logic.log.event_log import Event
from ...sensor_logic.recording.tracks import Recording
from ...sensor_logic.residents.acted import Acted
from ..process.memory import give_back
from ..runtime.simulation import Exchange, Progress, simulate
from ..scene.sensors import Sensor, decimal
from .causes import Causes

# s: with more movement than this between two exchanges keys take much memory.
MOST_MOVEMENT = 200.0
# s: keys go on for so long after a stretch, for what needs the frames after its own.
AFTER_S = 1.0
# Updates that *Explain* goes back to: of the same tilt, and the one before that.
TILTS_BACK = 24


class Keys(Protocol):
    """What puts the keys of a stretch of a day into the home."""

    def show(self, acted: Acted, first: float, last: float) -> None: ...


class DayRun:
    """Day `number` (from 0) of a run, with what was `acted` on it, or the s `between` of it.
    `residents`: the object of each person; `causes`: whether events are to be told with who and
    what made them. After `progress` was gone through, `events` are those of the day, and
    `recording` is what was read, in the frames of the day."""

    def __init__(
        self,
        scene: Any,
        sensors: Sequence[Sensor],
        acted: Acted,
        residents: Mapping[str, Any],
        keys: Keys,
        number: int,
        between: tuple[float, float] | None = None,
        causes: bool = True,
    ) -> None:
        self._scene, self._sensors, self._keys, self._acted = scene, sensors, keys, acted
        self._clock = clock_of_day(number)
        self._midnight = LEAD_S + number * DAY_S
        self.recording = Recording()
        what = self.recording, acted, residents, self._midnight
        self._causes = Causes(scene, sensors, *what, causes)
        rates = [decimal(sensor.settings.update_rate) for sensor in sensors]
        self._before = max([TILTS_BACK / float(exact(rate)) for rate in rates] + [AFTER_S])
        begin, last = between or (0.0, DAY_S)
        first = begin - LEAD_S
        cuts = stretches(acted.spans(first, last), first, last, MOST_MOVEMENT)
        self._bounds = [first, *cuts, last]
        self.events: tuple[Event[int], ...] = ()

    def progress(self) -> Iterator[Progress]:
        """Does it. Raises AngenError."""
        first, *others = pairwise(self._bounds)
        begin, end = frame_at(self._bounds[0]), frame_at(self._bounds[-1]) - 1
        exchanges = [Exchange(frame_at(start), self._shown(start, end)) for start, end in others]
        with at_ten_frames(self._scene):
            self._show(*first)
            yield from simulate(
                self._scene,
                self._sensors,
                begin,
                end,
                self.recording,
                exchanges,
                self._clock,
                self._causes.note if self._causes.wanted else None,
            )
            self._causes.take_left()
        self.events = attributed(_events(self._causes.told, self._midnight))

    def _shown(self, start: float, end: float) -> Callable[[], None]:
        def exchange() -> None:
            self._causes.take_left()
            self._show(start, end)
            give_back()

        return exchange

    def _show(self, start: float, end: float) -> None:
        self._keys.show(self._acted, start - self._before, end + AFTER_S)


def _events(told: Iterable[Event[float]], midnight: float) -> list[Event[int]]:
    """How everything is at midnight, and what happens then; without frames, which a day has not."""
    begins: dict[tuple[str, str], Event[int]] = {}
    found = []
    for event in sorted(told):
        time = round((event.time - midnight) * US)
        if time <= 0:
            at_midnight = replace(event.at(0), frame=0.0, person="", because="")
            begins[event.sensor, event.field] = at_midnight
        else:
            found.append(replace(event.at(time), frame=0.0))
    return [*begins.values(), *found]


@contextmanager
def at_ten_frames(scene: Any) -> Iterator[None]:
    """The scene in the time of a day: 10 frames a second, each of them whole."""
    render = scene.render
    names = ("fps", "fps_base", "frame_map_old", "frame_map_new")
    before = [getattr(render, name) for name in names]
    substeps, frame, subframe = scene.angen_substeps, scene.frame_current, scene.frame_subframe
    render.fps, render.fps_base, render.frame_map_old, render.frame_map_new = FPS, 1.0, 100, 100
    scene.angen_substeps = 1
    try:
        yield
    finally:
        for name, value in zip(names, before, strict=True):
            setattr(render, name, value)
        scene.angen_substeps = substeps
        scene.frame_set(frame, subframe=subframe)
