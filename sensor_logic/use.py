# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object is in use: a property that residents write in days, and anybody can key."""

from __future__ import annotations

from dataclasses import dataclass

from .kind import OwnerProperties
from .parameters import Parameters, parameter


@dataclass(frozen=True)
class Use(Parameters):
    """Whether somebody uses an object."""

    in_use: bool = parameter(
        False,
        "In Use",
        "Somebody uses this object now: sits on it, works at it, or has switched it on. Residents "
        "set it in days; otherwise key it",
    )


IN_USE = OwnerProperties(
    "angen_use",
    ("Object",),
    "Use",
    "Whether this object is in use, which decides what it does: draw power, let water flow",
    Use,
)
