# SPDX-License-Identifier: GPL-3.0-or-later
"""What caused the readings in a recording, by the evidence that it holds."""

from __future__ import annotations

from ..evidence import Cause, measured_cause
from ..logs.error import AngenError
from .tracks import Track


def check_evidence(track: Track) -> None:
    """Raise `AngenError` if a recording does not tell why the sensor read what it did."""
    if not track.has_evidence:
        raise AngenError(
            f"The recording does not tell why '{track.sensor}' read this: simulate again"
        )


def cause_of(track: Track, index: int) -> Cause:
    """Return what caused the reading at update `index`; the end of a motion has no object.

    Raise `AngenError` if the recording does not tell.
    """
    check_evidence(track)
    kind = track.kind
    if kind.cause is not None:
        found = kind.cause(track, index)
    else:
        known = [f.name for f in kind.evidence if f.name == "object"]
        names = (track.evidence.value(name, index) for name in known)
        found = measured_cause(track, index, filter(None, names))
    has_ended = kind.publishes("motion") and not track.active[index]
    return found._replace(objects=()) if has_ended else found
