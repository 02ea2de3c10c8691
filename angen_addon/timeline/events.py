# SPDX-License-Identifier: GPL-3.0-or-later
"""At which updates of a track something happened: the rows of the event log, found fast."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...sensor_logic.event_log import format_value
from ...sensor_logic.kind import Field
from ...sensor_logic.recording import Track

Indices = NDArray[np.intp]


def log_indices(track: Track) -> Indices:
    """The updates that the event log tells of, in order; the first update is one of them."""
    found = [_news(track, published) for published in track.kind.events]
    return np.unique(np.concatenate([np.empty(0, np.intp), *found])).astype(np.intp)


def switch_indices(track: Track) -> Indices:
    """The updates at which a published state changed: not the first one, no measured values."""
    found = [_changes(track.columns[f.name]) for f in track.kind.events if f.type is not float]
    return np.unique(np.concatenate([np.empty(0, np.intp), *found])).astype(np.intp)


def event_indices(track: Track) -> Indices:
    """The updates to jump to: where a state changed; of a track whose states never did, where a
    measured value did by its step."""
    found = switch_indices(track)
    if len(found):
        return found
    told = log_indices(track)
    return told[told > 0]


def _news(track: Track, published: Field) -> Indices:
    column = track.columns[published.name]
    if published.type is float:
        return _steps(column, track.steps.get(published.name, 0.0))
    first = np.zeros(min(len(column), 1), np.intp)
    return np.concatenate([first, _changes(column)])


def _changes(column: Any) -> Indices:
    """Where a column of states or texts differs from the update before."""
    if isinstance(column, list):
        found = [i for i in range(1, len(column)) if column[i] != column[i - 1]]
        return np.array(found, np.intp)
    values = np.frombuffer(column, np.int8 if column.typecode == "b" else np.int64)
    return np.flatnonzero(values[1:] != values[:-1]) + 1


def _steps(column: Any, step: float) -> Indices:
    """Where a measured value has moved by a step since it was told last."""
    found: list[int] = []
    last = math.nan
    for index, value in enumerate(column):
        if math.isnan(value):
            continue
        told = (
            abs(value - last) >= step if step > 0.0 else format_value(value) != format_value(last)
        )
        if not found or told:
            found.append(index)
            last = value
    return np.array(found, np.intp)
