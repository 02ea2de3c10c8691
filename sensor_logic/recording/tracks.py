# SPDX-License-Identifier: GPL-3.0-or-later
"""The readings of a run in memory, for playback, logs and reports."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from copy import copy
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..clock import Clock
from ..kind import Kind
from ..kinds import KINDS
from ..logs.fields import Field
from ..model import Reading
from ..physics import TIME_TOLERANCE_S
from .columns import Column, EvenSpacing
from .rows import Rows

# The column of evidence with the index of an update's parameters.
PARAMETERS = "parameters"


@dataclass(eq=False)
class Track:
    """One sensor's readings in time order, as columns.

    Frames and times (s) are floats.

    Attributes
    ----------
    uid
        Identifies the sensor in this session, even if it is renamed. It is the session uid of its
        object, or the path of a sensor in a collection instance.
    steps
        For some fields, the least change that is an event, by name.
    clock
        The time base of frames and times, if known.
    warm_up
        The time (s) before which the sensor warms up, so that its readings are not valid.
    columns
        The values of each field by name; NaN for values that were not measured.
    evidence
        For each update, the values of the kind's `evidence` fields by name. The column PARAMETERS
        has the index of the update's parameters in `parameters`. Empty if the recording was made by
        a version that stored no evidence.
    parameters
        The different parameters that the sensor has had, each with its index.
    """

    sensor: str
    kind_name: str
    uid: int | tuple[int, ...] = 0
    steps: dict[str, float] = field(default_factory=dict)
    clock: Clock | None = None
    warm_up: float = 0.0

    def __post_init__(self) -> None:
        frames = times = None
        if self.clock is not None:
            frames = EvenSpacing(self.clock.frame_start, Fraction(1, self.clock.substeps))
            times = EvenSpacing(0, 1 / self.clock.steps_per_second)
        self.frames, self.times = Column(float, grid=frames), Column(float, grid=times)
        self.active, self.value = Column(bool), Column(float)
        self.columns = {f.name: Column(f.type) for f in self.kind.samples}
        types = {f.name: f.type for f in self.kind.evidence}
        self.evidence = Rows({**types, PARAMETERS: int})
        self.parameters: dict[Any, int] = {}

    @property
    def kind(self) -> Kind:
        """The kind of the sensor."""
        return KINDS[self.kind_name]

    @property
    def has_evidence(self) -> bool:
        """Whether the recording tells why the sensor read what it did."""
        return self.evidence.updates == len(self)

    def parameters_at(self, index: int) -> Any:
        """Return the parameters that the sensor had at an update."""
        return list(self.parameters)[self.evidence.value(PARAMETERS, index)]

    def append(self, frame: float, time: float, reading: Reading) -> None:
        """Append one reading, without its evidence."""
        self.frames.append(frame)
        self.times.append(time)
        self.active.append(reading.active)
        self.value.append(reading.value)
        for name, column in self.columns.items():
            column.extend_numbers(column.as_numbers([reading.fields[name]], 1))

    def extend(
        self,
        frames: Iterable[float],
        times: Iterable[float],
        readings: Any,
        parameters: Any = None,
    ) -> None:
        """Append n readings, and their evidence unless `parameters` is None.

        `readings` has `active` (n,), `value` (n,), `fields` and `evidence`. The latter two have a
        list or array (n,) for each field, or None for a field that no reading measured.
        `parameters` are those with which the readings were made.
        """
        self.frames.extend(frames)
        self.times.extend(times)
        self.active.extend(readings.active)
        self.value.extend(readings.value)
        count = len(readings.active)
        for name, column in self.columns.items():
            column.extend_numbers(column.as_numbers(readings.fields[name], count))
        if parameters is not None:
            number = self.parameters.setdefault(parameters, len(self.parameters))
            which = {PARAMETERS: np.full(count, number)}
            self.evidence.extend({**readings.evidence, **which}, count)

    def invalid(self) -> NDArray[np.bool_]:
        """Return the mask (n,) of the updates whose reading is not valid."""
        times = np.asarray(self.times, np.float64)
        found: NDArray[np.bool_] = times < self.warm_up - TIME_TOLERANCE_S
        if "valid" in self.columns:
            found |= np.asarray(self.columns["valid"], np.int8) == 0
        return found

    def renamed(self, sensor: str) -> Track:
        """Return a track with the same readings, of a sensor that is called `sensor` now."""
        track = copy(self)
        track.sensor = sensor
        return track

    def __len__(self) -> int:
        return len(self.frames)

    @property
    def nbytes(self) -> int:
        """The memory of the readings in bytes."""
        columns = [self.frames, self.times, self.active, self.value, *self.columns.values()]
        columns += self.evidence.all_columns()
        return sum(column.nbytes for column in columns)

    def __eq__(self, other: object) -> bool:
        """Return whether all readings and their evidence are equal to the bit, NaN included."""
        return isinstance(other, Track) and self._content() == other._content()

    def _content(self) -> list[Any]:
        columns = [self.frames, self.times, self.active, self.value, *self.columns.values()]
        names, why = list(self.columns), [self.evidence, list(self.parameters)]
        return [self.sensor, self.kind_name, self.uid, self.steps, names, *columns, *why]

    def reading_at(self, index: int) -> Field:
        """Return the main field at an update: the first numeric field that was measured.

        `index` is the index of the update. The field depends on how the sensor measured at this
        update.
        """
        numbers = [f for f in self.kind.samples if f.type is float]
        measured = (f for f in numbers if not math.isnan(self.columns[f.name][index]))
        return next(measured, numbers[0])

    def at(self, frame: float) -> int | None:
        """Return the index of the last update at or before `frame`; None if there is none."""
        index = self.frames.until(frame) - 1
        return index if index >= 0 else None


@dataclass
class Recording:
    """The readings of a run: a track for each sensor, by the sensor's name.

    `clock` is the time base, if known. `frame_start` and `frame_end` are the run's first and last
    frame.
    """

    tracks: dict[str, Track] = field(default_factory=dict)
    clock: Clock | None = None
    frame_start: int = 0
    frame_end: int = 0

    def track_of(self, uid: int | tuple[int, ...]) -> Track | None:
        """Return the track of the sensor with this `uid`, or None if there is none."""
        return next((track for track in self.tracks.values() if track.uid == uid), None)

    def only(self, names: Collection[str]) -> Recording:
        """Return the recording with only the sensors that have these names."""
        return replace(self, tracks={n: t for n, t in self.tracks.items() if n in names})

    def covers(self, frame: float) -> bool:
        """Return whether the run included this frame."""
        return self.frame_start <= frame < self.frame_end + 1
