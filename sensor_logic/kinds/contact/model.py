# SPDX-License-Identifier: GPL-3.0-or-later
"""Door contact: a reed switch that closes where its magnet comes near.

The blades of a reed close at more ampere turns than they open at. So the distance at which it opens
is the larger one; between the two distances it keeps its state.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...kind import POSES
from ...model import Model, Reading, Update
from ...parameters import Parameters, parameter
from ...quantities import METRES, Lengths


@dataclass(frozen=True)
class ContactParameters(Parameters):
    magnet: str | None = parameter(
        None,
        "Magnet",
        "The object whose origin is the magnet; without one the contact is always open",
        pointer="Object",
    )
    close_distance: float = parameter(
        0.015,
        "Close distance",
        "The contact closes where the magnet is nearer. Data sheets: operate, make or pull-in",
        unit="m",
        positive=True,
        short="Closes At",
    )
    open_distance: float = parameter(
        0.02,
        "Open distance",
        "The contact opens where the magnet is farther. Data sheets: release, break or drop-out",
        unit="m",
        positive=True,
        short="Opens At",
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        if self.open_distance < self.close_distance:
            return [
                f"open_distance ({lengths.typed(self.open_distance)}) must be at least "
                f"close_distance ({lengths.typed(self.close_distance)})"
            ]
        return []


class DoorContact(Model):
    """One contact. It is open at first, unless its magnet is near."""

    def __init__(self) -> None:
        self._closed = False

    def update(self, parameters: ContactParameters, update: Update) -> Reading:
        magnet = update.ask(POSES, "magnet")
        if magnet is None:
            self._closed, distance = False, math.inf
        else:
            distance = float(np.linalg.norm(magnet.origin - update.pose.origin))
            limit = parameters.open_distance if self._closed else parameters.close_distance
            self._closed = distance <= limit
        is_open = not self._closed
        return Reading(is_open, distance, {"open": is_open, "distance_m": distance})
