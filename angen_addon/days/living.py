# SPDX-License-Identifier: GPL-3.0-or-later
"""One day in the open home: the keys of its stretches come and go, the sensors read on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from typing import Any, Protocol

from ...sensor_logic.clock import exact
from ...sensor_logic.days.cuts import stretches
from ...sensor_logic.days.rows import Happening, attributed
from ...sensor_logic.days.times import FPS, LEAD_S, clock_of_day, frame_at
from ...sensor_logic.days.truth import DAY_S, US
from ...sensor_logic.log.event_log import Event
from ...sensor_logic.recording.tracks import Recording
from ...sensor_logic.residents.acted import Acted
from ..process.memory import give_back
from ..runtime.sensor_runner import SensorRunner
from ..runtime.simulation import Exchange, Progress, simulate
from ..scene.sensors import Sensor, decimal
from .causes import Causes
from .stretch import DayStretch, state_of

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
    """Day `number` (from 0) of a run, with what was `acted` on it, or the s `between` of it, or a
    `stretch`. `residents`: the object of each person; `causes`: whether events are to be told with
    who and what made them. After `progress` was gone through, `events` are those of the day, those
    of a stretch not `attributed` yet, and `recording` is what was read, in the frames of the
    day."""

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
        stretch: DayStretch | None = None,
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
        self._stretch, own = stretch, 0
        if stretch is not None and stretch.number:
            own = stretch.number - 1
            first = max(first, stretch.cuts[own] - max(LEAD_S, self._before))
        self._cuts = stretch.cuts[own:] if stretch is not None else ()
        cuts = stretches(acted.spans(first, last), first, last, MOST_MOVEMENT)
        self._bounds = [first, *sorted({*cuts, *self._cuts}), last]
        self.events: tuple[Happening, ...] = ()

    def progress(self) -> Iterator[Progress]:
        """Does it. Raises SensorError."""
        first, *others = pairwise(self._bounds)
        begin, end = frame_at(self._bounds[0]), frame_at(self._bounds[-1]) - 1
        exchanges = [
            Exchange(frame_at(start), self._shown(start, end), self._ends(start))
            for start, end in others
        ]
        with at_ten_frames(self._scene):
            self._show(*first)
            run = simulate(
                self._scene,
                self._sensors,
                begin,
                end,
                self.recording,
                exchanges,
                self._clock,
                self._causes.notes,
            )
            for step in run:
                yield step if self._stretch is None else self._of_stretch(step)
            self._causes.take_left()
            if self._stretch is not None:
                self._hand_on(self._stretch)
        told = _events(self._causes.told, self._midnight)
        self.events = tuple(told) if self._stretch is not None else attributed(told)

    def _of_stretch(self, step: Progress) -> Progress:
        """How far a stretch is, which is over at the next cut as far as is known."""
        here = self._bounds[0] + step.seconds_done
        own = self._stretch is not None and self._stretch.number > 0
        later = (cut for cut in self._cuts[own:] if cut > here)
        return replace(step, seconds_total=next(later, self._bounds[-1]) - self._bounds[0])

    def _shown(self, start: float, end: float) -> Callable[[], None]:
        def exchange() -> None:
            self._causes.take_left()
            self._show(start, end)
            give_back()

        return exchange

    def _show(self, start: float, end: float) -> None:
        self._keys.show(self._acted, start - self._before, end + AFTER_S)

    def _ends(self, start: float) -> Callable[[Sequence[SensorRunner]], bool]:
        """Whether the run is over at a bound: another process goes on from a cut if its sensors
        are in the same state there."""

        def ends(runners: Sequence[SensorRunner]) -> bool:
            stretch = self._stretch
            if stretch is None or start not in self._cuts:
                return False
            self._causes.take_left()
            number, state = stretch.cuts.index(start) + 1, state_of(runners, self._causes.new)
            if number == stretch.number:
                # What was before is another's.
                self._causes.begin_here()
                stretch.tell(state)
                return False
            if stretch.meets(number, state):
                stretch.until = number
            return stretch.until == number

        return ends

    def _hand_on(self, stretch: DayStretch) -> None:
        """Tells what was held until the last events before the stretch are known."""
        if stretch.number and self._causes.holds:
            events = self._causes.held_events(stretch.last_before())
            for start, end in pairwise(self._bounds):
                frames = frame_at(start), frame_at(end)
                mine = [event for event in events if frames[0] <= event.frame < frames[1]]
                if mine:
                    self._show(start, end)
                    self._causes.tell_held(mine)
        last = self._causes.last
        if stretch.until and last:
            stretch.hand_on(stretch.until, last)


def _events(told: list[tuple[Event, str, str]], midnight: float) -> list[Happening]:
    """How everything is at midnight, and what happens then."""
    told.sort(key=lambda one: one[0])
    begins: dict[tuple[str, str], Happening] = {}
    found = []
    for event, person, because in told:
        time = round((event.time - midnight) * US)
        what = event.sensor, event.kind, event.field, event.value
        if time <= 0:
            begins[event.sensor, event.field] = Happening(0, *what)
        else:
            found.append(Happening(time, *what, person, because))
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
