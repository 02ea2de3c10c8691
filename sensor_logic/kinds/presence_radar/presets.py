# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial presence radars."""

from __future__ import annotations

import math

from ...kind import Preset, parts_with

_part = parts_with(
    range_min=0.0,
    integration_time=0.1,
    max_targets=0,
    angle_resolution=math.radians(20.0),
    hold_time=5.0,
    energy_noise=0.0,
    range_noise=0.0,
    angle_noise=0.0,
)
PRESETS: tuple[Preset, ...] = (
    _part(
        "LD2410",
        "Hi-Link LD2410 (24 GHz)",
        "Hi-Link, HLK-LD2410 user manual V1.02, table 2: 24 to 24.25 GHz, ±60°, gates of 0.75 m, "
        "0.75 to 6 m; presence up to 5 m, taken as the range of people who only breathe. "
        "Thresholds and 5 s: factory settings in its serial protocol",
        frequency=24.125,
        horizontal_fov=math.radians(120.0),
        vertical_fov=math.radians(120.0),
        range_max=6.0,
        gate_length=0.75,
        moving_range=6.0,
        still_range=5.0,
        moving_thresholds="50 40 30 20 15 15 15 15",
        still_thresholds="0 40 40 30 30 20 20 20",
    ),
    _part(
        "LD2410C_FINE",
        "Hi-Link LD2410C (24 GHz, gates of 0.2 m)",
        "As the LD2410, with the distance resolution of 0.2 m of firmware 2.04 and later: 8 gates "
        "up to 1.6 m (documentation of aio-ld2410)",
        frequency=24.125,
        horizontal_fov=math.radians(120.0),
        vertical_fov=math.radians(120.0),
        range_max=1.6,
        gate_length=0.2,
        moving_range=6.0,
        still_range=5.0,
        moving_thresholds="50 40 30 20 15 15 15 15",
        still_thresholds="0 40 40 30 30 20 20 20",
    ),
    _part(
        "LD2450",
        "Hi-Link LD2450 (24 GHz, three targets)",
        "Hi-Link, HLK-LD2450 manual V1.00: 24 GHz, ±60° by ±35°, 6 m, up to three targets with x, "
        "y and speed at 10 Hz; gates of 0.32 m in the example of its table 3. Assumed: one "
        "transmitter and two receivers separate 30°, people who only breathe are tracked up to 3 "
        "m, and thresholds of 15 and 20",
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
        angle_resolution=math.radians(30.0),
        hold_time=0.0,
    ),
    _part(
        "MR60BHA1",
        "Seeed MR60BHA1 (60 GHz, breathing)",
        "Seeed Studio, MR60BHA1 data sheet: 58 to 63.5 GHz, beams of ±40° (−3 dB), presence up to "
        "3 m, breathing from 0.4 to 2 m. Assumed: gates of 0.5 m, thresholds of 15 and 20",
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
