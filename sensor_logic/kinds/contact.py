# SPDX-License-Identifier: GPL-3.0-or-later
"""Door contact: a reed switch on the frame that a magnet on the leaf holds closed.

- Model: `DoorContact`, with its parameters and presets in this file.
- Scene: the magnet's pose, by `_named_poses` in angen_addon/runtime/sensor_runner.py.
- Interface: angen_addon/kinds/contact.py.
- Physics: docs/contact.md.
- Tests: tests/pure/test_distance_and_contact.py, tests/blender/test_distance_contact.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..evidence import Cause, measured_cause
from ..kind import POSES, Field, Kind, Preset
from ..logs.wording import METRES, Lengths
from ..model import Model, Reading, Update
from ..parameters import Parameters, parameter

# The blades of a reed close at more ampere turns than they open at. So a reed opens at a larger
# distance than it closes. Between the two distances it keeps its state.


@dataclass(frozen=True)
class ContactParameters(Parameters):
    """The parameters of a door contact."""

    magnet: str | None = parameter(
        None,
        "Magnet",
        "The object whose origin is the magnet; without one the contact is always open",
        pointer="Object",
    )
    close_distance: float = parameter(
        0.015,
        "Close distance",
        "The contact closes when the magnet is nearer than this. Data sheets: operate, make or "
        "pull-in",
        unit="m",
        positive=True,
        short="Closes At",
    )
    # The hysteresis of the contact: it opens farther away than it closes.
    open_distance: float = parameter(
        0.02,
        "Open distance",
        "The contact opens when the magnet is farther than this. Data sheets: release, break or "
        "drop-out",
        unit="m",
        positive=True,
        short="Opens At",
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return a sentence if the contact would open at a smaller distance than it closes."""
        if self.open_distance < self.close_distance:
            return [
                f"open_distance ({lengths.typed(self.open_distance)}) must be at least "
                f"close_distance ({lengths.typed(self.close_distance)})"
            ]
        return []


class DoorContact(Model):
    """Model of one door contact. Its state is whether the contact is closed; it starts open."""

    def __init__(self) -> None:
        self._closed = False

    def update(self, parameters: ContactParameters, update: Update) -> Reading:
        """Return whether the contact is open, and the magnet's distance in m (inf if unset)."""
        magnet = update.ask(POSES, "magnet")
        if magnet is None:
            self._closed, distance = False, math.inf
        else:
            distance = float(np.linalg.norm(magnet.origin - update.pose.origin))
            limit = parameters.open_distance if self._closed else parameters.close_distance
            self._closed = distance <= limit
        is_open = not self._closed
        return Reading(is_open, distance, {"open": is_open, "distance_m": distance})


# Presets of commercial door contacts, each with the magnet that its maker specifies.

REED_RELAYS = (
    "Reed Relays and Electronics India, actuation distances of the {} sensor, {} AT, tip to tip, "
    "magnet {}: operates at {} to {} mm, releases at {} to {} mm. Assumed: the means of these"
)


def _reed(
    part: str, turns: str, magnet: str, operate: tuple[float, float], release: tuple[float, float]
) -> Preset:
    """Return a preset of a reed sensor with a neodymium magnet.

    `turns` is the sensitivity in ampere-turns. `operate` and `release` are the least and the
    greatest distance in mm at which the contact closes and opens.
    """
    return Preset(
        f"{part}_{magnet}".replace("-", "_"),
        f"{part} with magnet {magnet}",
        {"close_distance": sum(operate) / 2000.0, "open_distance": sum(release) / 2000.0},
        REED_RELAYS.format(part, turns, magnet, *operate, *release),
    )


PRESETS: tuple[Preset, ...] = (
    _reed("MS-214-1", "10-15", "NDR-L", (15.5, 20.0), (18.5, 22.0)),
    _reed("MS-214-1", "10-15", "NDC-M", (10.5, 14.0), (13.0, 15.5)),
    _reed("MS-214-1", "10-15", "NDC-L", (29.0, 35.5), (33.0, 38.0)),
    _reed("MS-225", "10-15", "NDC-M", (8.0, 11.0), (10.0, 12.0)),
    _reed("MS-228", "20-25", "NDC-L", (21.0, 24.0), (29.0, 30.0)),
)


def cause(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: the magnet and its distance."""
    magnet = track.parameters_at(index).magnet
    return measured_cause(track, index, [magnet] if magnet else [])


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
    events=(Field("open", bool, quantity="opening", tip="Whether the magnet is too far away"),),
    samples=(
        Field("open", bool),
        Field(
            "distance_m",
            float,
            "m",
            4,
            tip="Distance from the contact to the magnet; infinite without a magnet",
        ),
    ),
    cause=cause,
    model=DoorContact,
    needs={POSES: ()},
    presets=PRESETS,
    part="MS_214_1_NDC_L",
)
