# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial infrared arrays.

Data sheets give bounds of the error of a temperature. A third of the bound is used as the standard
deviation among devices. The noise of a frame grows with the root of the frame rate.
"""

from __future__ import annotations

import math

from ...kind import Preset, parts_with

MELEXIS = (
    "Its noise is 0.1 K at 1 Hz, and grows with the root of the rate: here for 4 Hz. The ±1 K of "
    "its inner pixels are taken as three standard deviations"
)


_part = parts_with(resolution=0.0, settling_time=0.0, coldest=-40.0, hottest=300.0)


def _grid_eye(identifier: str, label: str, netd: float, rate: str) -> Preset:
    return _part(
        identifier,
        label,
        "Panasonic, Grid-EYE AMG88 catalogue: 60° × 60°, steps of 0.25 K, 0 to 80 °C, ±2.5 K, of "
        f"which a third is taken as the standard deviation; noise (NETD) {netd:g} K at {rate}",
        columns=8,
        rows=8,
        horizontal_fov=math.radians(60.0),
        vertical_fov=math.radians(60.0),
        netd=netd,
        offset_sigma=2.5 / 3,
        resolution=0.25,
        coldest=0.0,
        hottest=80.0,
    )


def _melexis(identifier: str, label: str, source: str, across: float, up: float) -> Preset:
    return _part(
        identifier,
        label,
        f"{source}. {MELEXIS}",
        columns=32,
        rows=24,
        horizontal_fov=math.radians(across),
        vertical_fov=math.radians(up),
        netd=0.2,
        offset_sigma=1.0 / 3,
    )


MLX90640 = "Melexis, MLX90640 data sheet, revision 11"
PRESETS: tuple[Preset, ...] = (
    _grid_eye("AMG8833", "Panasonic Grid-EYE AMG8833 (8 × 8, 10 Hz)", 0.16, "10 Hz"),
    _grid_eye(
        "AMG8833_1HZ",
        "Panasonic Grid-EYE AMG8833 (8 × 8, 1 Hz)",
        0.05,
        "1 Hz: set the update rate to 1 Hz",
    ),
    _melexis(
        "MLX90640_BAA",
        "Melexis MLX90640 BAA (32 × 24, 110°)",
        f"{MLX90640}: 110° × 75°",
        110.0,
        75.0,
    ),
    _melexis(
        "MLX90640_BAB",
        "Melexis MLX90640 BAB (32 × 24, 55°)",
        f"{MLX90640}: 55° × 35°",
        55.0,
        35.0,
    ),
    _part(
        "MLX90641_BCA",
        "Melexis MLX90641 BCA (16 × 12, 110°)",
        "Melexis, MLX90641 data sheet: 110° × 75°, noise 0.1 K at 4 Hz, of devices ±2 K, of which "
        "a third is taken as the standard deviation",
        columns=16,
        rows=12,
        horizontal_fov=math.radians(110.0),
        vertical_fov=math.radians(75.0),
        netd=0.1,
        offset_sigma=2.0 / 3,
    ),
)
