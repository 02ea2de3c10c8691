# SPDX-License-Identifier: GPL-3.0-or-later
"""Slotted optical switch: a flag on the door breaks its beam, or not."""

from __future__ import annotations

from ...kind import CROSSINGS, RAYS, Field, Kind
from .model import OpticalSwitchParameters, SlottedSwitch
from .presets import PRESETS

KIND = Kind(
    "OPTICAL_SWITCH",
    2,
    "Optical switch",
    "Slotted optical switch, for doors and shutters",
    "SNAP_EDGE",
    "optical_switch",
    1.0,
    "Open",
    "Closed",
    OpticalSwitchParameters,
    events=(Field("open", bool, quantity="opening"),),
    samples=(Field("open", bool), Field("range_m", float, "m", 3)),
    model=SlottedSwitch,
    needs={RAYS: (), CROSSINGS: (("swept", True),)},
    presets=PRESETS,
)
