# SPDX-License-Identifier: GPL-3.0-or-later
"""From the colours a file works in to linear Rec. 709; before Blender 5.0 they are the same."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# From the primaries' chromaticities (ITU-R BT.709, BT.2020; AMPAS S-2014-004, adapted to D65).
TO_REC709: dict[str, Any] = {
    "Linear Rec.2020": [
        [1.660491, -0.587641, -0.072850],
        [-0.124550, 1.132900, -0.008349],
        [-0.018151, -0.100579, 1.118730],
    ],
    "ACEScg": [
        [1.705052, -0.621792, -0.083258],
        [-0.130257, 1.140802, -0.010548],
        [-0.024003, -0.128969, 1.152972],
    ],
}


def to_rec709(rgb: Array) -> Array:
    """Colours (…, 3) of a render of the present file."""
    space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "")
    matrix = TO_REC709.get(space)
    return rgb if matrix is None else rgb @ np.array(matrix).T
