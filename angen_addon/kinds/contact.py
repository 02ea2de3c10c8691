# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of door contacts: housing, rings in the viewport, panel rows and explanations.

One ring shows the distance at which an approaching magnet closes the contact. The other shows the
distance at which a departing magnet opens it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from bpy.types import Context

from ...sensor_logic.logs.wording import Lengths, measured, quoted
from ..appearance.appearance import Appearance
from ..appearance.facts import Explanation
from ..appearance.figures import Figure, circle, pairs
from ..appearance.housing import Housing
from ..appearance.panel_parts import draw_lines
from ..appearance.reading_text import ReadingText
from ..appearance.recorded import RecordedSensor
from ..scene.sensors import Sensor


def figure(seen: Any, metres: float) -> Figure:
    """Draw the closing distance as a solid ring, and the opening distance as a dashed one.

    At these distances, the magnet closes and opens the contact. Each ring is drawn twice, in planes
    at right angles. `seen` is the `DrawnSensor`, and `metres` the length of a Blender unit in m.
    """
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


def _contact() -> Housing:
    """Return a housing of 27.5 × 13.6 × 9 mm, as sold with adhesive backs.

    The size is from midlandelectronics.com. The magnet is a separate object.
    """
    return Housing().box((-0.01375, -0.0068, 0.0), (0.01375, 0.0068, 0.009))


HOUSINGS = {"": _contact}


NO_MAGNET = "It has no magnet, so it is always open. Choose the object that is its magnet"


def draw(layout: Any, context: Context, sensor: Sensor, seen: ReadingText) -> None:
    """Draw a warning below the parameters in the panel if the contact has no magnet.

    `seen` has the texts of the sensor's reading.
    """
    if sensor.parameters.magnet is None:
        draw_lines(layout, NO_MAGNET, "ERROR")


@dataclass(frozen=True)
class ContactCause:
    """The magnet of a door contact, its distance and the switching distances. Lengths are in m.

    Attributes
    ----------
    magnet
        The name of the magnet object.
    distance
        The distance from the contact to the magnet.
    closes
        The contact closes once the magnet is nearer than this.
    opens
        The contact opens once the magnet is farther away than this.
    """

    magnet: str
    distance: float
    closes: float
    opens: float


def explain_contact(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a door contact by the distance of its magnet."""
    parameters, lengths = recorded.parameters_at(index), recorded.lengths
    distances = recorded.track.columns["distance_m"]
    if parameters.magnet is None or not math.isfinite(distances[index]):
        return recorded.explanation(index, NO_MAGNET, ())
    closes, opens = parameters.close_distance, parameters.open_distance
    cause = ContactCause(parameters.magnet, float(distances[index]), closes, opens)
    facts = [
        ("Magnet", f"{quoted(cause.magnet)}, {_fine(cause.distance, lengths)} away"),
        ("Closes", f"nearer than {lengths.typed(closes)}"),
        ("Opens", f"farther than {lengths.typed(opens)}"),
    ]
    if index > 0:
        before = _fine(distances[index - 1], lengths)
        facts.append(("Before", f"{before}, at {recorded.when(index - 1)}"))
    is_open = bool(recorded.track.active[index])
    if is_open:
        short = cause.distance - closes
        text = f"the magnet must come {_fine(short, lengths)} nearer"
        facts.insert(0, ("To close", text))
    return recorded.explanation(index, _headline(cause, is_open, lengths), facts, "", cause)


def _headline(cause: ContactCause, is_open: bool, lengths: Lengths) -> str:
    state = "open" if is_open else "closed"
    between = cause.closes < cause.distance <= cause.opens
    state = f"Still {state}" if between else state.capitalize()
    return f"{state}: {quoted(cause.magnet)} is {_fine(cause.distance, lengths)} away"


def _fine(length: float, lengths: Lengths) -> str:
    """Return a length as a text, rounded to a tenth of a millimetre."""
    return measured(length, "m", 4, lengths)


APPEARANCE = Appearance(HOUSINGS, figure=figure, explain=explain_contact, details=draw)
