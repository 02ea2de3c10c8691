# SPDX-License-Identifier: GPL-3.0-or-later
"""What a report tells, as numbers: the run, its sensors, and the plan of the home, in metres."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ..model import Array
from ..recording.tracks import Recording
from .sections import Line


@dataclass(frozen=True)
class SensorFacts:
    """A sensor of the run: `period` (s) between its updates; `settings` are those that differ from
    the defaults, as (name, value with unit)."""

    name: str
    kind_name: str
    room: str
    period: float
    settings: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Shape:
    """What a solid shows in the plan, `top` (m) its highest point below the cut or at it.

    `role`: "wall" is cut and thin, "solid" is cut, "low" is seen from above, "floor" is at most a
    rug high, "moving" is cut and does not stand still.
    """

    role: str
    lines: tuple[Line, ...]
    top: float


@dataclass(frozen=True)
class Placed:
    """A sensor in the plan: where it stands, and `looks`, its viewing direction seen from above
    (shorter than 1 where it looks down or up), both (2,); `height` (m) above the floor.

    `fans` are the ends (n, 2) of rays that go out from it in one fan each, `beams` (2, 2) single
    rays from start to end, `pad` (n, 2) the outline of a face that feels.
    """

    name: str
    at: Array
    looks: Array
    height: float
    fans: tuple[Array, ...] = ()
    beams: tuple[Array, ...] = ()
    pad: Array | None = None


@dataclass(frozen=True)
class Storey:
    """A floor of the home: heights in m of the floor itself and of the cut; the part of the world
    that is shown as (x, y) of two corners (2, 2)."""

    floor: float
    cut: float
    view: Array
    shapes: tuple[Shape, ...]
    sensors: tuple[Placed, ...]


@dataclass(frozen=True)
class Report:
    """A run to report: `facts` are (name, value) of the scene, `plan_frame` that of the plan."""

    title: str
    facts: tuple[tuple[str, str], ...]
    sensors: tuple[SensorFacts, ...]
    recording: Recording
    storeys: tuple[Storey, ...] = ()
    plan_frame: int = 0
    made_by: str = ""

    @property
    def span(self) -> tuple[float, float]:
        """First and last moment (s) of the run."""
        clock = self.recording.clock
        assert clock is not None
        first = clock.first_step(self.recording.frame_start)
        last = clock.first_step(max(self.recording.frame_end, self.recording.frame_start) + 1)
        return clock.step_time(first), clock.step_time(last)

    def ordered(self) -> tuple[SensorFacts, ...]:
        """The sensors as they are numbered, from 1: by room, those without one last."""
        return tuple(
            sorted(self.sensors, key=lambda s: (s.room == "", _natural(s.room), _natural(s.name)))
        )


def _natural(text: str) -> tuple[tuple[str, int, str], ...]:
    """To sort by: numbers in names by their value, "PIR 9" before "PIR 10"."""
    parts = re.findall(r"(\D*)(\d*)", text)
    return tuple((word, int(digits or 0), digits) for word, digits in parts)
