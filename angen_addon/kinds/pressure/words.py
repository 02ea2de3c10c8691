# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a centre of pressure as text."""

from __future__ import annotations

import math

from ....sensor_logic.kinds.pressure import KIND
from ....sensor_logic.quantities import METRES, NOTHING, Lengths
from ...scene.units import UNITS


def centre_text(x: float, y: float, lengths: Lengths) -> str:
    """The text for a centre of pressure (m, from the pad's origin along its axes); in centimetres
    where the scene's unit is metres, since pads are small."""
    if math.isnan(x) or math.isnan(y):
        return NOTHING
    fine = UNITS["CENTIMETERS"] if lengths == METRES else lengths
    along = KIND.fields["cop_x_m"]
    return f"X {along.text(x, fine)}, Y {along.text(y, fine)}"
