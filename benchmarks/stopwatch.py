# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the seconds that each part of a run takes, by wrapping the functions of the parts."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial, wraps
from inspect import isgeneratorfunction
from typing import Any

from angen_sensors.angen_addon.runtime import state
from angen_sensors.angen_addon.runtime.probes import Probes
from angen_sensors.angen_addon.runtime.sensor_runner import PendingUpdates, SensorRunner
from angen_sensors.angen_addon.scene.contact.tracker import ContactTracker
from angen_sensors.angen_addon.scene.rays.caster import RayCaster
from angen_sensors.angen_addon.scene.rays.reference import SceneRayCaster
from angen_sensors.sensor_logic.recording.tracks import Track

EVALUATION = "evaluation of the scene"
# The wrapped functions: owner, name, and the part to which their own time is added.
WRAPPED = (
    (type(state.CACHE), "note", "what moved"),
    (RayCaster, "update", "what moved"),
    (SceneRayCaster, "update", "what moved"),
    (RayCaster, "cast_at", "rays"),
    (SceneRayCaster, "cast_at", "rays"),
    (ContactTracker, "look", "contact forces"),
    (Probes, "forces", "contact forces"),
    (Probes, "measure", "light"),
    (SensorRunner, "read", "sensor models"),
    (PendingUpdates, "readings", "sensor models"),
    (Track, "extend", "recording"),
)
PARTS = (EVALUATION, *dict.fromkeys(part for *_, part in WRAPPED))


class Stopwatch:
    """Seconds by part, without those of nested parts. The remaining time is Blender's evaluation of
    the frames, and the loop itself."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self.calls: dict[str, list[float]] = defaultdict(list)
        self._inner: list[float] = []

    @contextmanager
    def running(self) -> Iterator[None]:
        before = [(owner, name, getattr(owner, name)) for owner, name, _ in WRAPPED]
        begin = time.perf_counter()
        for (owner, name, old), (*_, part) in zip(before, WRAPPED, strict=True):
            setattr(owner, name, self._wrapped(old, part))
        try:
            yield
        finally:
            for owner, name, old in before:
                setattr(owner, name, old)
        total = time.perf_counter() - begin
        self.seconds[EVALUATION] += total - sum(self.seconds.values())

    def _wrapped(self, work: Any, part: str) -> Any:
        @wraps(work)
        def measured(*arguments: Any, **named: Any) -> Any:
            result, seconds = self._timed(part, partial(work, *arguments, **named))
            self.calls[part].append(seconds)
            return result

        @wraps(work)
        def measured_steps(*arguments: Any, **named: Any) -> Iterator[Any]:
            steps, last, total = work(*arguments, **named), object(), 0.0
            while True:
                # What is done between its steps is not its own.
                step, seconds = self._timed(part, partial(next, steps, last))
                total += seconds
                if step is last:
                    self.calls[part].append(total)
                    return
                yield step

        return measured_steps if isgeneratorfunction(work) else measured

    def _timed(self, part: str, work: Callable[[], Any]) -> tuple[Any, float]:
        """What `work` returns, and the seconds that it took, with those of nested parts."""
        self._inner.append(0.0)
        start = time.perf_counter()
        try:
            result = work()
        finally:
            seconds = time.perf_counter() - start
            self.seconds[part] += seconds - self._inner.pop()
            if self._inner:
                self._inner[-1] += seconds
        return result, seconds
