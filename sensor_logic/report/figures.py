# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of each sensor: the number of its events, its active time, its greatest value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kind import Field
from ..log.event_log import track_events
from ..model import Array
from ..recording.tracks import Track


@dataclass(frozen=True)
class Figures:
    """`events`: the number of events after the first update, with the times (s) of the first and
    the last one; `active`: the share (0..1) of updates at which the sensor was active; `greatest`:
    the greatest valid value of its main numeric `field`; `invalid`: the share of invalid
    updates."""

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
        return self.field.unit if self.field else ""

    @property
    def greatest_text(self) -> str:
        """The greatest value with its unit; "" without one."""
        if self.field is None or self.greatest is None:
            return ""
        return self.field.short(self.greatest)


def figures(track: Track) -> Figures:
    """The figures of a sensor's track."""
    start = track.times[0] if len(track) else 0.0
    changes = sorted(e.time for e in track_events(track) if e.time > start)
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
    """The first numeric event field that was measured, and its values (n,); "" and no values where
    there is none, as of a switch."""
    names = [field.name for field in track.kind.events if field.type is float]
    for name in names:
        values = np.array(track.columns[name], np.float64)
        if np.isfinite(values).any():
            return name, values
    return "", np.empty(0)


def invalid(track: Track) -> NDArray[np.bool_]:
    """Mask (n,) of the updates whose field `valid` is false."""
    if "valid" not in track.columns:
        return np.zeros(len(track), bool)
    valid: NDArray[np.int8] = np.asarray(track.columns["valid"], dtype=np.int8)
    return np.asarray(valid == 0)
