# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial motion detectors, and of the thesis."""

from __future__ import annotations

import math

from ...kind import Preset
from .lenses import LENS_PRESETS, LENSES, PLATE, SHARP, pyroelectric_part


def _range_scan(
    part: str,
    label: str,
    source: str,
    *,
    range_max: float,
    horizontal: float,
    below: float | None = None,
    hold: float = 0.0,
    block: float = 0.0,
    warm_up: float = 0.0,
) -> Preset:
    """Return a preset of the range scan with the reach, angles and times of a pyroelectric part.

    Arguments are in metres, degrees and seconds. `horizontal` is the angle of the fans, and `below`
    is half of the vertical detection angle. Defaults stand for values that the source does not
    give; the note names them as assumed.
    """
    times = (("hold time", hold), ("block time", block), ("warm-up time", warm_up))
    assumed = [f"no {name}" for name, given in times if not given]
    if below is None:
        below = 90.0
        assumed.append("it looks straight down, too")
    source += f". Assumed: {', '.join([*assumed, 'any movement within these angles counts'])}"
    # All these presets set the same parameters, so that none keeps values of an earlier preset.
    values = {
        "model": "RANGE_SCAN",
        "horizontal_fov": math.radians(horizontal),
        "range_max": range_max,
        "vertical_fov": math.radians(below),
        "hold_time": hold,
        "blocking_time": block,
        "warm_up_time": warm_up,
        "retrigger": True,
    }
    if warm_up:
        source += (
            f". It reports nothing for the first {warm_up:g} s: set the warm-up time to 0 for "
            "one that was switched on long before"
        )
    return Preset(f"{part}_SCAN", f"{label}, range scan", values, source)


def _real_home(identifier: str, label: str, lens: str) -> Preset:
    """Return a preset of a wireless detector, fitted to recordings of a home (docs/pir.md)."""
    source = (
        "Measured in the CASAS home AL, 30 days: the hold is 6 ticks of 3/16 s, a detector ignores "
        "movement for 3 ticks after each message, and messages are delayed by 15 ms on average. "
        f"Assumed: the lens ({LENSES[lens].label}) and its distance, as none is known; {SHARP}; "
        f"{PLATE}"
    )
    return pyroelectric_part(
        identifier,
        f"Real home (CASAS), {label}",
        source,
        lens=lens,
        range_max=LENSES[lens].detection_distance,
        hold_time=1.125,
        blanking_time=0.5625,
        message_delay=0.015,
    )


PMOD_PIR = "30 s to stabilize as in Digilent's Pmod PIR reference manual for EKMC1601111"

PRESETS: tuple[Preset, ...] = (
    Preset(
        "THESIS",
        "Thesis (Gazebo range scan)",
        {
            "model": "RANGE_SCAN",
            "horizontal_fov": math.radians(120),
            "rays": 120,
            "range_min": 0.05,
            "range_max": 4.0,
            "vertical_fov": math.radians(90),
            "vertical_step": math.radians(10),
            "sweep": "SAWTOOTH",
            "threshold": 0.05,
            "noise_sigma": 0.0,
            "hold_time": 0.0,
            "blocking_time": 0.0,
            "warm_up_time": 0.0,
        },
        "range scan of the Gazebo plugin from the thesis behind this extension",
    ),
    *LENS_PRESETS,
    _range_scan(
        "HC_SR501",
        "HC-SR501",
        "HC-SR501 module data sheet: cone below 120°, block time 2.5 s; 1 minute of initialization "
        "as at escol.com.my. Measured: a person who crosses is seen at 5 m and not at 6 m with the "
        "trimmer in the middle; the shortest pulse",
        range_max=5.0,
        horizontal=120.0,
        below=60.0,
        hold=3.46,
        block=2.5,
        warm_up=60.0,
    ),
    _range_scan(
        "EKMC1601111",
        "Panasonic EKMC1601111 (5 m)",
        f"Panasonic: 5 m, 94° × 82°; {PMOD_PIR}",
        range_max=5.0,
        horizontal=94.0,
        below=41.0,
        warm_up=30.0,
    ),
    _range_scan(
        "EKMC1603111",
        "Panasonic EKMC1603111 (12 m)",
        f"Panasonic: 12 m, 102° × 92°; {PMOD_PIR}",
        range_max=12.0,
        horizontal=102.0,
        below=46.0,
        warm_up=30.0,
    ),
    _range_scan(
        "EKMC1604111",
        "Panasonic EKMC1604111 (wall, 12 m)",
        f"Panasonic: detects a first step at up to 12 m; 105° wide, down to 49° below; {PMOD_PIR}",
        range_max=12.0,
        horizontal=105.0,
        below=49.0,
        warm_up=30.0,
    ),
    _range_scan(
        "MI_NODE",
        "element14 MI:node PIR (7 m)",
        "element14 MI:node user manual V3.1, p. 23: 7 m, solid angle 110°, high for 2.5 s typical",
        range_max=7.0,
        horizontal=110.0,
        below=55.0,
        hold=2.5,
    ),
    _range_scan(
        "HAA53",
        "Velleman HAA53 (wall, 14 m)",
        "Velleman HAA53 manual, specifications, wide-angle lens: 14 m, 110° wide, at most 1 minute "
        "of warm-up, on a wall 1.8 to 2.5 m up; how far down it looks is not given",
        range_max=14.0,
        horizontal=110.0,
        warm_up=60.0,
    ),
    _real_home("CASAS_CEILING", "ceiling", "CEILING"),
    _real_home("CASAS_WALL", "wall", "THREE_TIERS"),
)
