# SPDX-License-Identifier: GPL-3.0-or-later
"""The content of a report as plain data: the run, its sensors, and the plan of the home.

Lengths are in metres.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..logs.fields import Field
from ..model import Array
from ..recording.events import event_rows
from ..recording.tracks import Recording, Track
from .sections import Line


@dataclass(frozen=True)
class ReportedSensor:
    """A sensor in a report.

    `period` is the time between updates in s. `settings` has the parameters that differ from their
    defaults, as pairs of a name and a value with its unit. `shapes` has the numbers of columns and
    of rows of each field that holds a picture.
    """

    name: str
    kind_name: str
    room: str
    period: float
    settings: tuple[tuple[str, str], ...] = ()
    shapes: tuple[tuple[str, tuple[int, int]], ...] = ()


@dataclass(frozen=True)
class PlanShape:
    """The lines that show a solid in the floor plan, which is a horizontal cut through a storey.

    `top` (m) is the solid's highest point below the cut. The `role` decides how it is drawn:

    - "wall": it is cut, and thin
    - "solid": it is cut
    - "low": it is below the cut, and drawn as seen from above
    - "floor": it is at most as high as a rug
    - "moving": it is cut, and moves during the run
    """

    role: str
    lines: tuple[Line, ...]
    top: float


@dataclass(frozen=True)
class SensorInPlan:
    """A sensor in the floor plan.

    Attributes
    ----------
    at
        The position (2,) in m.
    looks
        The x and y components (2,) of its unit viewing direction: short if it looks up or down.
    height
        The height in m above the floor.
    fans
        The outlines of fans of rays: the ends (n, 2) of the rays of each fan.
    beams
        Single rays: the start and the end (2, 2) of each.
    pad
        The outline (n, 2) of the surface of a pressure sensor, or None.
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
    """A storey of the home in the plan.

    `floor` is the height of the floor in m. `cut` is the height in m of the plane that cuts the
    walls. `view` (2, 2) has the lower left and the upper right corner of the area that the plan
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

    Attributes
    ----------
    facts
        Pairs of a name and a value, which describe the scene and the run.
    plan_frame
        The frame that the plans show.
    made_by
        The last line of the report: the program that wrote it.
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
        """The first and the last time of the run (s)."""
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
    """Return a sorting key of a text, by which "PIR 9" comes before "PIR 10"."""
    parts = re.findall(r"(\D*)(\d*)", text)
    return tuple((word, int(digits or 0), digits) for word, digits in parts)


# The figures of each sensor: the number of events, the active time, the greatest value.


@dataclass(frozen=True)
class Figures:
    """Statistics of a sensor over a run, for the report's table.

    Attributes
    ----------
    updates
        The number of updates.
    events
        The number of events after the first update.
    first, last
        The times (s) of the first and the last of these events.
    active
        The fraction (0 to 1) of valid updates at which the sensor was active; None without any.
    greatest
        The greatest valid value of `field`.
    field
        The first field with a number that was measured, if any.
    invalid
        The fraction of updates whose reading is not valid.
    """

    updates: int
    events: int
    first: float | None
    last: float | None
    active: float | None
    greatest: float | None
    field: Field | None
    invalid: float

    @property
    def unit(self) -> str:
        """The unit of `field`."""
        return self.field.unit if self.field else ""

    @property
    def greatest_text(self) -> str:
        """The greatest value of `field` with its unit; "" if there is none."""
        if self.field is None or self.greatest is None:
            return ""
        return self.field.short(self.greatest)


def figures(track: Track) -> Figures:
    """Return the statistics of a sensor's track, for the report's table."""
    changes = [track.times[index] for index in event_rows(track).tolist()]
    name, values = quantity(track)
    valid = ~track.invalid()
    known = values[valid & np.isfinite(values)] if name else np.empty(0)
    return Figures(
        len(track),
        len(changes),
        changes[0] if changes else None,
        changes[-1] if changes else None,
        float(np.mean(np.asarray(track.active)[valid])) if valid.any() else None,
        float(known.max()) if len(known) else None,
        track.kind.fields.get(name),
        float(1.0 - valid.mean()) if len(track) else 0.0,
    )


def quantity(track: Track) -> tuple[str, Array]:
    """Return the name and the values (n,) of the first numeric field that was ever measured.

    Only fields whose changes are events are considered. If none was measured, as for a switch,
    return "" and an empty array.
    """
    names = [field.name for field in track.kind.events if field.type is float]
    for name in names:
        values = np.array(track.columns[name], np.float64)
        if np.isfinite(values).any():
            return name, values
    return "", np.empty(0)
