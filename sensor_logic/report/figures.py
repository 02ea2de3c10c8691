# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of each sensor: how often it spoke, how long it was active, its greatest value."""

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
    """`events`: changes of what it publishes, its first update apart, with the times (s) of the
    first and the last; `active`: the share (0..1) of its updates in which it was; `greatest` value
    among those that are valid, of the `field` that the sensor reports as a number; `invalid`:
    the share of updates that are not."""

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
        """As tables show it; empty where there is none."""
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
    """The field that a kind reports as a number, the first one that it measured, and its values;
    an empty name where there is none, as of a switch."""
    names = [field.name for field in track.kind.events if field.type is float]
    for name in names:
        values = np.array(track.columns[name], np.float64)
        if np.isfinite(values).any():
            return name, values
    return "", np.empty(0)


def invalid(track: Track) -> NDArray[np.bool_]:
    """Mask of the updates that say of themselves that they are not valid."""
    if "valid" not in track.columns:
        return np.zeros(len(track), bool)
    valid: NDArray[np.int8] = np.asarray(track.columns["valid"], dtype=np.int8)
    return np.asarray(valid == 0)
