# SPDX-License-Identifier: GPL-3.0-or-later
"""Acts out routines: what everybody does with body, doors, lamps and things, for one day."""

from .day import act, acting
from .ground import Ground

__all__ = ["Ground", "act", "acting"]
