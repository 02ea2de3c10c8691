# SPDX-License-Identifier: GPL-3.0-or-later
"""Light sensors that can be bought, and the thesis's."""

from __future__ import annotations

from ...kind import Preset
from .parts import PARTS

PRESETS: tuple[Preset, ...] = (
    Preset(
        "THESIS",
        "Thesis (Gazebo cameras, four walls)",
        {
            "method": "FOUR_WALL",
            "clip_start": 0.5,
            "clip_end": 5.0,
            "field_of_view": 0.02,
            "noise_sigma": 0.0,
        },
        "camera sensor of the thesis's Gazebo plugin",
    ),
    *(
        Preset(part.name.upper().replace("-", "_"), part.name, part.values, part.source)
        for part in PARTS
    ),
)
