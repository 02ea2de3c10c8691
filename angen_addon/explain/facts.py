# SPDX-License-Identifier: GPL-3.0-or-later
"""Why a sensor reads what it reads, in words: what panels and the command line show."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from ...sensor_logic.log import format_frame
from ...sensor_logic.wording import percent, typed

# Names and values.
Facts = list[tuple[str, str]]


@dataclass(frozen=True)
class Explanation:
    """`index`: the update in the sensor's track; `headline`: a sentence; `facts`: names and
    values; `doubt`: why this may not be what happened, empty where it is sure; `cause`: the same
    as numbers, of the kind's own type, which also tells `because` of which object it is."""

    sensor: str
    index: int
    frame: float
    time: float
    headline: str
    facts: tuple[tuple[str, str], ...]
    doubt: str = ""
    cause: Any = None

    @property
    def because(self) -> str:
        """The object that made the reading what it is; empty where none did, or it is not known,
        as for a motion that is over."""
        return self.cause.because if self.cause is not None else ""

    def after(self, facts: Iterable[tuple[str, str]]) -> Explanation:
        """The same with these facts before its own."""
        return replace(self, facts=(*facts, *self.facts))

    def as_text(self) -> str:
        """Lines for a terminal."""
        lines = [f"{self.sensor}, frame {format_frame(self.frame)} ({self.time:.3f} s)"]
        lines.append(self.headline)
        width = max((len(name) for name, _ in self.facts), default=0)
        lines += [f"  {name:<{width}}  {text}" for name, text in self.facts]
        if self.doubt:
            lines.append(f"Doubtful: {self.doubt}")
        return "\n".join(lines) + "\n"


def at_frame(frame: float, time: float) -> str:
    return f"frame {format_frame(frame)} ({time:.3f} s)"


def more_needed(threshold: float, value: float, unit: str) -> str:
    """How far a value is from the threshold that it must exceed."""
    share = f"{percent(value / threshold)} of that" if threshold else "nothing"
    return f"more than {typed(threshold, unit)} is needed: it is {share}"
