# SPDX-License-Identifier: GPL-3.0-or-later
"""Appearance of door contacts: a flat body, with rings where its magnet closes and opens it; their
panel rows and explanations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from bpy.types import Context

from ...panels.lines import draw_lines
from ...panels.readings import ReadingText
from ...sensor_logic.wording import Lengths, measured, quoted
from ..authoring.housing import Housing
from ..explain.facts import Explanation, at_frame
from ..explain.replay import Replay
from ..scene.sensors import Sensor
from ..view.appearance import Appearance
from ..view.overlay.figures import Figure, circle, pairs

# Draws the distances of a door contact's magnet, as rings about it in two planes.


def figure(seen: Any, metres: float) -> Figure:
    """Whole rings where the magnet closes the contact, dashed ones where it opens it."""
    drawn = Figure()
    x, y, z = seen.pose.axes.T
    for radius, meaning in (
        (seen.parameters.close_distance, "gate"),
        (seen.parameters.open_distance, "limit"),
    ):
        for side in (y, z):
            ring = circle(seen.pose.origin / metres, x, side, radius / metres)
            lines = pairs(ring, np.roll(ring, -1, axis=0))
            drawn.add(meaning, lines if meaning == "gate" else lines[::2])
    return drawn


# The housing of a door contact; its magnet is another object.


def _contact() -> Housing:
    """27.5 × 13.6 × 9 mm, as sold with adhesive backs (midlandelectronics.com)."""
    return Housing().box((-0.01375, -0.0068, 0.0), (0.01375, 0.0068, 0.009))


HOUSINGS = {"": _contact}


# Rows in the panel of a door contact below its parameters.

NO_MAGNET = "It has no magnet, so it is always open. Choose the object that is its magnet"


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Warns of a missing magnet."""
    if sensor.parameters.magnet is None:
        draw_lines(layout, NO_MAGNET, "ERROR")


# Explains why a door contact is open or closed: how far away its magnet is.


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


APPEARANCE = Appearance(HOUSINGS, figure=figure, explain=explain_contact, details=draw)
