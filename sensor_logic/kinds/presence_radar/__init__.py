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
from .gate_evidence import FIELDS as EVIDENCE
from .gate_evidence import cause
from .parameters import RadarParameters
from .presets import PRESETS
from .radar import PresenceRadar

PRESENCE = Field(
    "presence",
    bool,
    quantity="occupancy",
    tip="Whether any gate detects movement or breathing, or did within the hold time",
)
MOVING = Field("moving", bool, quantity="motion", tip="Whether any gate detects movement")
DISTANCE = Field(
    "distance_m",
    float,
    "m",
    2,
    step="report_step",
    quantity="distance",
    tip="Distance of what the nearest gate detects; without presence the range max",
)
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
        Field("targets", int, tip="Number of targets"),
        Field("x_m", str, optional=True, tip="Where each target is in m, to the right"),
        Field("y_m", str, optional=True, tip="Where each target is in m, ahead"),
        Field("speed_mps", str, optional=True, tip="Radial speed of each target, away positive"),
        Field("gates", str, quantity="energies", tip="Energies of each gate: moving/still"),
    ),
    evidence=EVIDENCE,
    cause=cause,
    model=PresenceRadar,
    needs={ECHOES: ()},
    integrates="integration_time",
    in_room=True,
    presets=PRESETS,
    part="LD2410",
    view=view,
    owner_properties=OWNER_PROPERTIES,
    value_when_idle=False,
)
