# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the updates of a track at which something happened: the rows of the event log."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from ..recording.tracks import Track
from .event_log import event_updates

Indices = NDArray[np.intp]


def log_indices(track: Track) -> Indices:
    """The updates that have rows in the event log, in order; the first update is one of them."""
    return _together(event_updates(track, published) for published in track.kind.events)


def switch_indices(track: Track) -> Indices:
    """The updates at which a published state changed: not the first one, no measured values."""
    return _together(event_updates(track, f)[1:] for f in track.kind.events if f.type is not float)


def _together(found: Iterable[list[int]]) -> Indices:
    return np.array(sorted(set().union(*found)), np.intp)


def event_indices(track: Track) -> Indices:
    """The updates to jump to: where a state changed; of a track whose states never did, where a
    measured value did by its step."""
    found = switch_indices(track)
    if len(found):
        return found
    told = log_indices(track)
    return told[told > 0]
