# SPDX-License-Identifier: GPL-3.0-or-later
"""Presence radar: a millimetre-wave FMCW radar that detects people who move or only breathe.

- Model: radar.py, with parameters.py and presets.py. Materials and breathing: sensor_logic/radio/.
- Scene: `EchoProbe` in angen_addon/scene/surfaces/echoes.py.
- Window: angen_addon/kinds/presence_radar/; coverage maps: coverage.py.
- Physics: docs/presence_radar.md.
- Tests: tests/pure/test_presence_radar*.py, tests/blender/test_presence_radar.py.
"""

from __future__ import annotations

from ...kind import Field, Kind
from ...radio.echoes import ECHOES
from ...radio.properties import OWNER_PROPERTIES
from .coverage import view
from .parameters import RadarParameters
from .presets import PRESETS
from .radar import PresenceRadar

PRESENCE = Field("presence", bool, quantity="occupancy")
MOVING = Field("moving", bool, quantity="motion")
DISTANCE = Field("distance_m", float, "m", 2, step="report_step", quantity="distance")
KIND = Kind(
    "PRESENCE_RADAR",
    8,
    "Presence radar",
    "Presence radar: millimetre waves detect people who move or only breathe",
    "FORCE_HARMONIC",
    "presence_radar",
    10.0,
    "Present",
    "Absent",
    RadarParameters,
    events=(PRESENCE, MOVING, DISTANCE),
    samples=(
        PRESENCE,
        MOVING,
        DISTANCE,
        Field("targets", int),
        Field("x_m", str, optional=True),
        Field("y_m", str, optional=True),
        Field("speed_mps", str, optional=True),
        Field("gates", str, quantity="energies"),
    ),
    model=PresenceRadar,
    needs={ECHOES: ()},
    in_room=True,
    presets=PRESETS,
    part="LD2410",
    view=view,
    owner_properties=OWNER_PROPERTIES,
    value_when_idle=False,
)
