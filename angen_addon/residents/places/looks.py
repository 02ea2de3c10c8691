# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a marked object looks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ....sensor_logic.model import Array
from ....sensor_logic.residents import places as known

# What looks somewhere.
FACING = (known.STAND, known.SIT, known.LIE, known.USE, known.TAP, known.APPLIANCE, known.DRAWER)


def look_of(obj: Any, matrix: Any) -> Array:
    """(2,): where the mark of an object looks, as a unit vector on the floor."""
    angle = obj.angen_place.facing
    local = np.array([math.sin(angle), -math.cos(angle), 0.0])
    found: Array = (np.array(matrix)[:3, :3] @ local)[:2]
    size = float(np.linalg.norm(found))
    # Of what lies on its back the front looks up or down.
    return found / size if size > 1e-9 else local[:2]


def set_look(obj: Any, matrix: Any, look: Array) -> None:
    """Turns the mark so that it looks along (2,) in the world."""
    axes = np.array(matrix)[:2, :2]
    if abs(np.linalg.det(axes)) < 1e-12:
        return
    local = np.linalg.solve(axes, look)
    obj.angen_place.facing = math.atan2(local[0], -local[1])
