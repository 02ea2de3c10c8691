# SPDX-License-Identifier: GPL-3.0-or-later
"""From radiometric quantities to photometric ones: luminance, illuminance, 8-bit counts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..model import Array

# Luminance of linear RGB with the primaries of Rec. 709 (ITU-R BT.709-6, table 1).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# lm/W: Blender's glTF exporter converts lamps as if all light had 555 nm.
EFFICACY = 683.0
COUNTS = 255


def luminance(rgb: ArrayLike) -> Array:
    """Luminance Y (…) of linear Rec. 709 colours (…, 3), in their unit; negative for a lamp of
    negative power."""
    weighted: Array = np.asarray(rgb, dtype=np.float64) @ LUMINANCE
    return weighted


def illuminance(rgb: ArrayLike, efficacy: float = EFFICACY) -> float:
    """Illuminance in lux of an irradiance (3,) in W/m², at least 0. `efficacy` in lm/W."""
    return max(0.0, efficacy * float(luminance(rgb)))


def counts(rgb: ArrayLike, exposure: float) -> Array:
    """8-bit values (…) of linear radiances: round(255 · clamp(exposure · L, 0, 1)).

    Halves are rounded up, as in a converter; NaN gives 0.
    """
    light = np.nan_to_num(np.asarray(rgb, dtype=np.float64) * exposure, nan=0.0)
    return np.floor(COUNTS * np.clip(light, 0.0, 1.0) + 0.5)


def luminance_percent(views: ArrayLike, exposure: float) -> float:
    """Mean luminance in percent of views (n, 3), each one pixel of linear radiance.

    White views give 100 %; one 8-bit count in all channels 0.39 %.
    """
    return float(luminance(counts(views, exposure)).mean() / COUNTS * 100.0)
