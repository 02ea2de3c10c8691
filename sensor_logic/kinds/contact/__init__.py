# SPDX-License-Identifier: GPL-3.0-or-later
"""Door contact: a reed switch on the frame that a magnet on the leaf holds closed."""

from __future__ import annotations

from ...kind import POSES, Field, Kind
from .model import ContactParameters, DoorContact
from .presets import PRESETS

KIND = Kind(
    "CONTACT",
    6,
    "Door contact",
    "Door contact: a reed switch and its magnet",
    "LINKED",
    "contact",
    10.0,
    "Open",
    "Closed",
    ContactParameters,
    events=(Field("open", bool, quantity="opening"),),
    samples=(Field("open", bool), Field("distance_m", float, "m", 4)),
    model=DoorContact,
    needs={POSES: ()},
    presets=PRESETS,
)
