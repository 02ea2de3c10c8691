# SPDX-License-Identifier: GPL-3.0-or-later
"""The content of a report as numbers: the run, its sensors, and the plan of the home, in metres."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kind import Field
from ..log import event_rows
from ..model import Array
from ..recording.tracks import Recording, Track
from .sections import Line


@dataclass(frozen=True)
class ReportedSensor:
    """A sensor of the run.

    `period` (s) is the time between updates. `settings` are the settings that differ from the
    defaults, as (name, value with unit).
    """

    name: str
    kind_name: str
    room: str
    period: float
    settings: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class PlanShape:
    """The lines of a solid in the plan; `top` (m) is its highest point at or below the cut.

    The `role` is one of these:

    - "wall": cut and thin
    - "solid": cut
    - "low": below the cut, drawn from above
    - "floor": at most as high as a rug
    - "moving": cut, and it moves during the run
    """

    role: str
    lines: tuple[Line, ...]
    top: float


@dataclass(frozen=True)
class SensorInPlan:
    """A sensor in the plan.

    Attributes
    ----------
    at
        The position (2,) in m.
    looks
        The viewing direction (2,) seen from above, shorter than 1 if it points up or down.
    height
        The height in m above the floor.
    fans
        The ends (n, 2) of the rays of each fan from the sensor.
    beams
        Single rays, start and end (2, 2).
    pad
        The outline (n, 2) of a pressure-sensitive face.
    """

    name: str
    at: Array
    looks: Array
    height: float
    fans: tuple[Array, ...] = ()
    beams: tuple[Array, ...] = ()
    pad: Array | None = None


@dataclass(frozen=True)
class PlanStorey:
    """A storey of the home.

    `floor` and `cut` are heights in m. `view` (2, 2) has two corners of the area that the plan
    shows.
    """

    floor: float
    cut: float
    view: Array
    shapes: tuple[PlanShape, ...]
    sensors: tuple[SensorInPlan, ...]


@dataclass(frozen=True)
class Report:
    """The content of a report.

    `facts` are pairs (name, value) about the scene; `plan_frame` is the frame shown in the plan.
    """

    title: str
    facts: tuple[tuple[str, str], ...]
    sensors: tuple[ReportedSensor, ...]
    recording: Recording
    storeys: tuple[PlanStorey, ...] = ()
    plan_frame: int = 0
    made_by: str = ""

    @property
    def span(self) -> tuple[float, float]:
        """The begin and the end of the run (s)."""
        clock = self.recording.clock
        assert clock is not None
        first = clock.first_step(self.recording.frame_start)
        last = clock.first_step(max(self.recording.frame_end, self.recording.frame_start) + 1)
        return clock.step_time(first), clock.step_time(last)

    def ordered(self) -> tuple[ReportedSensor, ...]:
        """Return the sensors in the order of their numbers: by room, then by name.

        Sensors without a room come last.
        """
        return tuple(
            sorted(self.sensors, key=lambda s: (s.room == "", _natural(s.room), _natural(s.name)))
        )


def _natural(text: str) -> tuple[tuple[str, int, str], ...]:
    """Return a sorting key that puts "PIR 9" before "PIR 10"."""
    parts = re.findall(r"(\D*)(\d*)", text)
    return tuple((word, int(digits or 0), digits) for word, digits in parts)


# The figures of each sensor: the number of events, the active time, the greatest value.


@dataclass(frozen=True)
class Figures:
    """The figures of a sensor.

    Attributes
    ----------
    events
        The number of events after the first update.
    first, last
        The times (s) of the first and the last event.
    active
        The share (0 to 1) of updates at which the sensor was active.
    greatest
        The greatest valid value of `field`.
    field
        The main numeric field.
    invalid
        The share of invalid updates.
    """

    updates: int
    events: int
    first: float | None
    last: float | None
    active: float
    greatest: float | None
    field: Field | None
    invalid: float

    @property
    def unit(self) -> str:
        """The unit of the main field."""
        return self.field.unit if self.field else ""

    @property
    def greatest_text(self) -> str:
        """The greatest value with its unit; "" without a value."""
        if self.field is None or self.greatest is None:
            return ""
        return self.field.short(self.greatest)


def figures(track: Track) -> Figures:
    """Return the figures of a sensor's track."""
    changes = [track.times[index] for index in event_rows(track).tolist()]
    name, values = quantity(track)
    valid = ~invalid(track)
    known = values[valid & np.isfinite(values)] if name else np.empty(0)
    return Figures(
        len(track),
        len(changes),
        changes[0] if changes else None,
        changes[-1] if changes else None,
        float(np.mean(track.active)) if len(track) else 0.0,
        float(known.max()) if len(known) else None,
        track.kind.fields.get(name),
        float(1.0 - valid.mean()) if len(track) else 0.0,
    )


def quantity(track: Track) -> tuple[str, Array]:
    """Return the first numeric event field that was measured, and its values (n,).

    Return "" and no values if there is no such field, as for a switch.
    """
    names = [field.name for field in track.kind.events if field.type is float]
    for name in names:
        values = np.array(track.columns[name], np.float64)
        if np.isfinite(values).any():
            return name, values
    return "", np.empty(0)


def invalid(track: Track) -> NDArray[np.bool_]:
    """Return the mask (n,) of the updates whose field `valid` is false."""
    if "valid" not in track.columns:
        return np.zeros(len(track), bool)
    valid: NDArray[np.int8] = np.asarray(track.columns["valid"], dtype=np.int8)
    return np.asarray(valid == 0)
