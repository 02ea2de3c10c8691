# SPDX-License-Identifier: GPL-3.0-or-later
"""Explains why a door contact is open or closed: how far away its magnet is."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ....sensor_logic.quantities import Lengths, measured
from ....sensor_logic.wording import quoted
from ...explain.facts import Explanation, at_frame
from ...explain.replay import Replay
from .panel import NO_MAGNET


@dataclass(frozen=True)
class ContactCause:
    """The magnet's name, and in m its distance and those at which the contact closes and opens."""

    magnet: str
    distance: float
    closes: float
    opens: float

    @property
    def because(self) -> str:
        return self.magnet


def explain_contact(replay: Replay, index: int) -> Explanation:
    """Explains update `index` of a door contact. Raises AngenError."""
    pending = replay.take(index)
    if pending is None:
        return replay.off(index)
    parameters, track, lengths = pending.parameters, replay.track, replay.lengths
    distances = track.columns["distance_m"]
    if parameters.magnet is None or not math.isfinite(distances[index]):
        return replay.explanation(index, NO_MAGNET, ())
    closes, opens = parameters.close_distance, parameters.open_distance
    cause = ContactCause(parameters.magnet, float(distances[index]), closes, opens)
    facts = [
        ("Magnet", f"{quoted(cause.magnet)}, {_fine(cause.distance, lengths)} away"),
        ("Closes", f"nearer than {lengths.typed(closes)}"),
        ("Opens", f"farther than {lengths.typed(opens)}"),
    ]
    if index > 0:
        when = at_frame(track.frames[index - 1], track.times[index - 1])
        facts.append(("Before", f"{_fine(distances[index - 1], lengths)}, at {when}"))
    is_open = bool(track.active[index])
    if is_open:
        short = cause.distance - closes
        facts.insert(0, ("To close", f"it must come {_fine(short, lengths)} nearer"))
    return replay.explanation(index, _headline(cause, is_open, lengths), facts, "", cause)


def _headline(cause: ContactCause, is_open: bool, lengths: Lengths) -> str:
    state = "Open" if is_open else "Closed"
    between = cause.closes < cause.distance <= cause.opens
    still = " still" if between else ""
    return f"{state}{still}: {quoted(cause.magnet)} is {_fine(cause.distance, lengths)} away"


def _fine(length: float, lengths: Lengths) -> str:
    """A length to a tenth of a millimetre, since contacts switch within millimetres."""
    return measured(length, "m", 4, lengths)
