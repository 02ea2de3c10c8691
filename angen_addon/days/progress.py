# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a run of days is, on standard error."""

from __future__ import annotations

import time
from typing import Protocol, TextIO

import numpy as np

from ...sensor_logic.days.truth import DAY_S
from ...sensor_logic.residents.acted import Acted
from ..commands.console import tell
from ..runtime.simulation import Progress

TERMINAL_S, LOG_S = 0.3, 30.0


class FinishedDays(Protocol):
    def has(self, number: int) -> bool: ...


class DayLine:
    """One line that renews itself on a terminal, else one now and then. Of several processes it
    sees the whole days."""

    def __init__(self, stream: TextIO, quiet: bool, days: int, kept: FinishedDays) -> None:
        self._stream, self._quiet, self._days, self._kept = stream, quiet, days, kept
        self._begin = time.perf_counter()
        self._shown = self._begin
        self._terminal = stream is not None and stream.isatty()
        self._had = self._whole()

    def _whole(self) -> int:
        return sum(self._kept.has(number) for number in range(self._days))

    def show(self, step: Progress | None = None, acted: Acted | None = None) -> None:
        """`step` of the day that was `acted`; without them, of several processes."""
        now = time.perf_counter()
        if self._quiet or now - self._shown < (TERMINAL_S if self._terminal else LOG_S):
            return
        self._shown = now
        whole = self._whole()
        part = step.seconds_done / max(step.seconds_total, 1e-9) if step is not None else 0.0
        moved = _moved(acted, part) if acted is not None else part
        made = whole - self._had + moved
        text = f"day {min(whole + 1, self._days)} of {self._days}"
        text += f", {part:.0%} of it" if step is not None else ""
        if made > 0.02:
            each = (now - self._begin) / made
            left = each * (self._days - whole - moved)
            text += f", {60 / each:.2g} days a minute, about {_rounded(left)} left"
        if step is not None and step.doing:
            text += f", {step.doing}"
        tell(f"\r{text:<70}" if self._terminal else f"{text}\n", self._stream)

    def clear(self) -> None:
        if self._terminal and not self._quiet:
            tell("\r" + " " * 70 + "\r", self._stream)

    def summary(self) -> str:
        """What was made, and how fast."""
        made, took = self._whole() - self._had, time.perf_counter() - self._begin
        return f"; {made} made in {_rounded(took)}" if made else ""


def _moved(acted: Acted, part: float) -> float:
    """How much of a day's movement is in the first part of its time: while all rest, a run takes
    no time."""
    spans = acted.spans(0.0, DAY_S)
    moving = float(np.diff(spans).sum())
    before = float(np.diff(np.minimum(spans, part * DAY_S)).sum())
    return before / moving if moving else part


def _rounded(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
