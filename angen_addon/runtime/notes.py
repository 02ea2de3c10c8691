# SPDX-License-Identifier: GPL-3.0-or-later
"""What sensors asked of the scene at their last updates, what they were answered, and what their
rays met: so that it can be told what made a reading without going back to its frame."""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...sensor_logic.kind import RAYS, REFLECTANCE, WARMTH
from ...sensor_logic.model import FIRST, Answers, Array, Ask, Index, Updates
from ..scene.rays.caster import NOTHING, RayCaster

if TYPE_CHECKING:
    from .answers import Question
    from .sensor_runner import SensorRunner

# What is asked of rays, which meet something.
CAST = {RAYS, WARMTH, REFLECTANCE}
# So many updates of a sensor are kept: those of each tilt that a motion detector goes through.
KEPT = 256


class NotNoted(LookupError):
    """It was not asked in the run: only the scene itself can tell."""


class Met(NamedTuple):
    """What a bundle of rays met: ranges (n,) in Blender units, and the name of the object that
    each met, empty where it met nothing."""

    ranges: Array
    names: list[str]


@dataclass(frozen=True)
class _Asked:
    """A question about those of the updates that `which` (k,) lists, all where it is None; rays by
    their bundle. The answers, and what rays `met`."""

    need: str
    bundle: Any
    which: Index | None
    answers: Answers
    met: Answers | None

    def place(self, update: int) -> int | None:
        """Where among the answers that of an update is."""
        if self.which is None:
            return update
        at = int(np.searchsorted(self.which, update))
        return at if at < len(self.which) and self.which[at] == update else None


@dataclass(frozen=True)
class _Sensed:
    """Updates at `steps` (n,) in order, with what was asked."""

    steps: list[int]
    parameters: Any
    updates: Updates
    asked: list[_Asked] = field(default_factory=list)


class _Last:
    """The last `updates` of a sensor: at least KEPT, if there were so many."""

    def __init__(self) -> None:
        self.updates: deque[_Sensed] = deque()
        self._count = 0

    def append(self, sensed: _Sensed) -> None:
        self.updates.append(sensed)
        self._count += len(sensed.steps)
        while self._count - len(self.updates[0].steps) >= KEPT:
            self._count -= len(self.updates.popleft().steps)


class Notes:
    """Of all sensors whose probes have them. `read` is called with a sensor's name after its
    readings were recorded."""

    def __init__(self, read: Callable[[str], object] = lambda name: None) -> None:
        self.read = read
        self._sensed: dict[str, _Last] = {}
        self._met: Any = None
        # By number; those that are gone too.
        self._names: dict[int, str] = {}
        self._listing = -1
        # Blender's own ray cast tells nothing of instances: the exact layer names what is there.
        self._namer: RayCaster | None = None

    @property
    def met(self) -> Met:
        """What the rays met that were asked of last."""
        if self._met is None:
            return Met(np.empty(0), [])
        names = [self.name_of(number) for number in self._met.met.tolist()]
        return Met(self._met.ranges.copy(), names)

    def name_of(self, number: int) -> str:
        """What people know a solid by that was met."""
        return "" if number == NOTHING else self._names.get(number, "")

    def listen(self, question: Question, updates: Updates) -> Updates:
        """The same updates, of which all that is asked is taken down."""
        sensed = _Sensed(question.steps, question.read.parameters, updates)
        self._sensed.setdefault(question.runner.sensor.name, _Last()).append(sensed)
        asks = updates.scene.items()
        told = {need: partial(self._ask, question, sensed, need, ask) for need, ask in asks}
        return replace(updates, scene=told)

    def _ask(
        self,
        question: Question,
        sensed: _Sensed,
        need: str,
        ask: Ask,
        *asked: Any,
        which: Index | None = None,
    ) -> Answers:
        answers: Answers = ask(*asked, which=which)
        met = None
        if need in CAST:
            met = self._seen(question, asked)
            self._met = met[-1]
            self._note_names(question.probes.caster.solids)
        sensed.asked.append(_Asked(need, _bundle(asked), which, answers, met))
        return answers

    def _seen(self, question: Question, asked: tuple[Any, ...]) -> Answers:
        """What the rays met that were cast just now."""
        caster = question.probes.caster
        if isinstance(caster, RayCaster):
            return caster.seen
        if self._namer is None:
            self._namer = RayCaster(caster.solids)
        self._namer.update(question.depsgraph)
        bundle, origins, directions, length = asked
        metres, last = question.read.metres, np.array([len(self._namer.frames) - 1])
        rays = origins / metres, directions, length / metres
        return self._namer.see_at(question.runner.uid, bundle, *rays, last)

    def _note_names(self, solids: Any) -> None:
        if self._listing != solids.listing:
            self._listing = solids.listing
            self._names |= {solid.number: solid.name for solid in solids.solids}

    def recall(self, runner: SensorRunner, step: int) -> tuple[Any, Updates]:
        """Parameters and the update at a step, of the sensor of a runner: its questions are
        answered as they were. Raises NotNoted."""
        last = self._sensed.get(runner.sensor.name)
        for sensed in reversed(last.updates if last is not None else ()):
            if sensed.steps[0] <= step <= sensed.steps[-1]:
                i = bisect_left(sensed.steps, step)
                own, one = sensed.updates, slice(i, i + 1)
                scene = {need: partial(self._answer, sensed, i, need) for need in own.scene}
                found = own.numbers[one], own.times[one], own.due[one], own.pose, scene
                return sensed.parameters, Updates(*found, own.noise, own.device_noise)
        raise NotNoted

    def _answer(
        self, sensed: _Sensed, update: int, need: str, *asked: Any, which: Index | None = None
    ) -> Answers:
        bundle = _bundle(asked)
        for known in sensed.asked:
            if (known.need, known.bundle) == (need, bundle):
                place = known.place(update)
                if place is not None:
                    if known.met is not None:
                        self._met = known.met[place]
                    return Answers([known.answers[place]], FIRST)
        raise NotNoted


def _bundle(asked: tuple[Any, ...]) -> Any:
    """What tells questions of one need apart: the bundle's number, or whose pose it is."""
    return asked[0] if asked and isinstance(asked[0], (int, str)) else None
