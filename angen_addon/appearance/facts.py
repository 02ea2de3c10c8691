# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of an explanation, as panels and the command line show it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from ...sensor_logic.logs.log import format_frame
from ...sensor_logic.logs.wording import percent, typed

# Pairs of a name and a value.
Facts = list[tuple[str, str]]


@dataclass(frozen=True)
class Explanation:
    """Why a sensor had its reading at one update.

    Attributes
    ----------
    sensor
        The name of the sensor.
    index
        The index of the update in the sensor's track.
    frame, time
        The frame and the time (s) of the update.
    headline
        The explanation in a sentence.
    facts
        Details, as pairs of a name and a text.
    doubt
        Why the explanation may be wrong; empty if it is certain.
    cause
        The details as numbers, in a class of the sensor's kind such as `PadCause`.
    cause_name
        The name of the object that caused the reading. It is empty if no object did, or if the
        object is unknown, as for a movement that has ended.
    """

    sensor: str
    index: int
    frame: float
    time: float
    headline: str
    facts: tuple[tuple[str, str], ...]
    doubt: str = ""
    cause: Any = None
    cause_name: str = ""

    def after(self, facts: Iterable[tuple[str, str]]) -> Explanation:
        """Return a copy of the explanation with `facts` inserted before its own facts."""
        return replace(self, facts=(*facts, *self.facts))

    def as_text(self, remark: str = "") -> str:
        """Return the explanation as lines for a terminal, with a remark after the first line."""
        lines = [f"{self.sensor}, frame {format_frame(self.frame)} ({self.time:.3f} s)"]
        lines += [remark, self.headline] if remark else [self.headline]
        width = max((len(name) for name, _ in self.facts), default=0)
        lines += [f"  {name:<{width}}  {text}" for name, text in self.facts]
        if self.doubt:
            lines.append(f"Doubtful: {self.doubt}")
        return "\n".join(lines) + "\n"


def at_frame(frame: float, time: float) -> str:
    """Return a text such as "frame 12 (0.500 s)"."""
    return f"frame {format_frame(frame)} ({time:.3f} s)"


def more_needed(threshold: float, value: float, unit: str) -> str:
    """Return a text that compares a value with the threshold that it does not reach."""
    share = f"{percent(value / threshold)} of that" if threshold else "not above it"
    return f"more than {typed(threshold, unit)} is needed, the reading is {share}"
