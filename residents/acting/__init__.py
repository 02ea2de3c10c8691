# SPDX-License-Identifier: GPL-3.0-or-later
"""Act out a day of a routine: the motion of bodies, doors, lamps and things."""

from .day import act, acting
from .floor_map import FloorMap

__all__ = ["FloorMap", "act", "acting"]
