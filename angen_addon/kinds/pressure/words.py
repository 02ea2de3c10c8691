# SPDX-License-Identifier: GPL-3.0-or-later
"""A centre of pressure in words."""

from __future__ import annotations

import math

from ....sensor_logic.kinds.pressure import KIND
from ....sensor_logic.quantities import METRES, NOTHING, Lengths
from ...scene.units import UNITS


def centre_text(x: float, y: float, lengths: Lengths) -> str:
    """A centre of pressure, from the pad's origin along its axes (m); in centimetres where the
    scene has metres, as pads are small."""
    if math.isnan(x) or math.isnan(y):
        return NOTHING
    fine = UNITS["CENTIMETERS"] if lengths == METRES else lengths
    along = KIND.fields["cop_x_m"]
    return f"X {along.text(x, fine)}, Y {along.text(y, fine)}"
