# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial presence radars."""

from __future__ import annotations

import math

from ...kind import Preset, parts_with
from .parameters import AMPLITUDE

_part = parts_with(
    range_min=0.0,
    range_scale=1.0,
    moving_energy=15.0,
    still_energy=20.0,
    scale=AMPLITUDE,
    moving_floors="0",
    still_floors="0",
    movement_starts=False,
    integration_time=0.1,
    still_time=2.0,
    tail_share=0.02,
    tail_length=1.5,
    max_targets=0,
    angle_resolution=math.radians(20.0),
    hold_time=5.0,
    energy_noise=0.0,
    floor_noise=0.2,
    fading=True,
    range_noise=0.0,
    angle_noise=0.0,
)
# What was measured with an LD2410B.
_LD2410 = {
    "frequency": 24.125,
    "horizontal_fov": math.radians(120.0),
    "vertical_fov": math.radians(120.0),
    "range_scale": 1.05,
    "moving_range": 6.0,
    "moving_energy": 17.4,
    "still_range": 13.0,
    "moving_thresholds": "50 50 40 30 20 15 15 15 15",
    "still_thresholds": "0 0 40 40 30 30 20 20 20",
    "moving_floors": "17.6 13.2 4.35 2.88 5.29 3.06 3.87 3.33 4.41",
    "still_floors": "5 5 5 5 5 5 5 5 2.6",
    "movement_starts": True,
    "integration_time": 0.25,
}
PRESETS: tuple[Preset, ...] = (
    _part(
        "LD2410",
        "Hi-Link LD2410 (24 GHz)",
        "Hi-Link, HLK-LD2410 user manual V1.02, table 2: 24 to 24.25 GHz, ±60°, gates of 0.75 m, "
        "moving 6 m. Thresholds and 5 s: factory settings, serial protocol of the LD2410C V1.09. "
        "Measured with an LD2410B (docs/presence_radar.md): amplitudes, gates from 0, floors, "
        "floor noise, still time, still energies 8 times those of movement (a range of 13 m), "
        "movement starts presence; each from one figure: integration time, distance scale, tail "
        "share. Measured with five LD2410C: tail length. Assumed: still floors of gates 0 to 7; "
        "no noise but floors and fading",
        range_max=6.0,
        gate_length=0.75,
        **_LD2410,
    ),
    _part(
        "LD2410C_FINE",
        "Hi-Link LD2410C (24 GHz, gates of 0.2 m)",
        "As the LD2410, with the distance resolution of 0.2 m of firmware 2.04 and later: gates 0 "
        "to 8, up to 1.6 m (documentation of aio-ld2410). Assumed: all else as with gates of 0.75 "
        "m, also the energies and floors",
        range_max=1.6,
        gate_length=0.2,
        **_LD2410,
    ),
    _part(
        "LD2450",
        "Hi-Link LD2450 (24 GHz, three targets)",
        "Hi-Link, HLK-LD2450 manual V1.00: 24 GHz, ±60° by ±35°, 6 m, up to three targets with x, "
        "y and speed at 10 Hz; gates of 0.32 m in the example of its table 3. Assumed: one "
        "transmitter and two receivers separate 30°, people who only breathe are tracked up to 3 "
        "m, thresholds of 15 and 20, no floors, no hold time, and no fading, because it tracks its "
        "targets; integration time of 0.1 s; still time and tail as the LD2410",
        frequency=24.125,
        horizontal_fov=math.radians(120.0),
        vertical_fov=math.radians(70.0),
        range_max=6.0,
        gate_length=0.32,
        moving_range=6.0,
        still_range=3.0,
        moving_thresholds="15",
        still_thresholds="20",
        max_targets=3,
        fading=False,
        angle_resolution=math.radians(30.0),
        hold_time=0.0,
    ),
    _part(
        "MR60BHA1",
        "Seeed MR60BHA1 (60 GHz, breathing)",
        "Seeed Studio, MR60BHA1 data sheet: 58 to 63.5 GHz, beams of ±40° (−3 dB), presence up to "
        "3 m, breathing from 0.4 to 2 m. Assumed: gates of 0.5 m, thresholds of 15 and 20, no "
        "floors, integration time of 0.1 s; hold time, still time and tail as the LD2410",
        frequency=60.75,
        horizontal_fov=math.radians(80.0),
        vertical_fov=math.radians(80.0),
        range_min=0.4,
        range_max=3.0,
        gate_length=0.5,
        moving_range=3.0,
        still_range=2.0,
        moving_thresholds="15",
        still_thresholds="20",
        hold_time=5.0,
    ),
)
