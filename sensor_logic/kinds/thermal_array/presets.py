# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of commercial infrared arrays.

Each note says which figures are *measured* (by us, in the raw files of public recordings:
docs/measured.md), which are from a data sheet, and which are *assumed*. Data sheets give bounds of
the error of a temperature: a third of the bound is used as the standard deviation among devices.
The noise of a frame grows with the root of the frame rate.
"""

from __future__ import annotations

import math
from typing import Any

from ...kind import Preset, parts_with

ALL = "fixed pattern of 0.2 K"
DRIFT = "a draw of the drift each 5 s"
# The rise of the noise towards the corners of lenses of 75° to 110°. Measured on an MLX90640: its
# median pixel has 1.29 and its edge pixels 1.68 times the noise of the middle.
WIDE_RISE, WIDE_CORNER = 0.82, 0.45

_part = parts_with(
    resolution=0.0,
    settling_time=0.0,
    coldest=-40.0,
    hottest=300.0,
    blur=0.5,
    noise_rise=WIDE_RISE,
    noise_corner=WIDE_CORNER,
    frame_noise=0.0,
    frame_drift=0.0,
    pixel_drift=0.0,
    drift_time=5.0,
    fixed_pattern=0.2,
    mean_of=1,
)


def _grid_eye(identifier: str, label: str, rate: float, noise: str) -> Preset:
    return _part(
        identifier,
        label,
        "Panasonic, Grid-EYE AMG88 catalogue: 60° × 60°, steps of 0.25 K, 0 to 80 °C, ±2.5 K, of "
        f"which a third is taken as the standard deviation. {noise}, its rise to the corners and "
        "both drifts measured on one part. Assumed: blur (0.5 pixels) as measured on an MLX90640 "
        f"and a D6T; {DRIFT}; {ALL}",
        rate=rate,
        columns=8,
        rows=8,
        horizontal_fov=math.radians(60.0),
        vertical_fov=math.radians(60.0),
        netd=round(0.187 * math.sqrt(rate / 10.0), 4),
        noise_rise=0.5,
        noise_corner=0.0,
        frame_drift=0.095,
        pixel_drift=0.033,
        offset_sigma=2.5 / 3,
        resolution=0.25,
        coldest=0.0,
        hottest=80.0,
    )


def _melexis(
    identifier: str, label: str, across: float, up: float, noise: str, **values: Any
) -> Preset:
    return _part(
        identifier,
        label,
        f"Melexis data sheet: {across:g}° × {up:g}°, −40 to 300 °C. {noise}; {DRIFT}; {ALL}",
        rate=4.0,
        horizontal_fov=math.radians(across),
        vertical_fov=math.radians(up),
        pixel_drift=0.065,
        **values,
    )


def _mlx90640(identifier: str, label: str, across: float, up: float, place: str) -> Preset:
    return _melexis(
        identifier,
        label,
        across,
        up,
        "Noise measured at 8 Hz (0.277 K in the middle), here for 4 Hz: the data sheet's 0.1 K at "
        f"1 Hz. Drift of pixels measured. {place}the ±1 K of its inner pixels are three standard "
        "deviations",
        columns=32,
        rows=24,
        netd=0.196,
        offset_sigma=1.0 / 3,
    )


def _omron(identifier: str, label: str, view: str, noise: str, **values: Any) -> Preset:
    return _part(
        identifier,
        label,
        f"Omron D6T. {view}. Running mean of 1.4 s and blur (0.5 pixels) measured on a D6T-1616L. "
        f"{noise}. Their steps of 0.1 K vanish in the mean. Assumed: the ±1.5 K of the data sheet "
        f"of the D6T-44L are three standard deviations; {ALL}",
        rate=10.0,
        mean_of=14,
        offset_sigma=0.5,
        coldest=5.0,
        hottest=50.0,
        **values,
    )


PRESETS: tuple[Preset, ...] = (
    _grid_eye(
        "AMG8833",
        "Panasonic Grid-EYE AMG8833 (8 × 8, 10 Hz)",
        10.0,
        "Noise (0.187 K at 10 Hz)",
    ),
    _grid_eye(
        "AMG8833_1HZ",
        "Panasonic Grid-EYE AMG8833 (8 × 8, 1 Hz)",
        1.0,
        "Noise (that at 10 Hz, by the root of the rate: 0.059 K)",
    ),
    _mlx90640(
        "MLX90640_BAA",
        "Melexis MLX90640 BAA (32 × 24, 110°)",
        110.0,
        75.0,
        "Noise by place and blur (0.5 pixels) measured. Assumed: ",
    ),
    _mlx90640(
        "MLX90640_BAB",
        "Melexis MLX90640 BAB (32 × 24, 55°)",
        55.0,
        35.0,
        "Assumed: noise by place and blur (0.5 pixels) as of the lens of 110°; ",
    ),
    _melexis(
        "MLX90641_BCA",
        "Melexis MLX90641 BCA (16 × 12, 110°)",
        110.0,
        75.0,
        "Noise 0.1 K at 4 Hz, of devices ±2 K, of which a third is taken as the standard "
        "deviation. Assumed: noise by place, drift of pixels and blur (0.5 pixels) as of the "
        "MLX90640",
        columns=16,
        rows=12,
        netd=0.1,
        offset_sigma=2.0 / 3,
    ),
    _omron(
        "D6T_44L",
        "Omron D6T-44L-06 (4 × 4, 44°)",
        "Data sheet: 44.2° × 45.7°, 5 to 50 °C",
        "Assumed: the mean and the blur are this part's too; noise 0.06 K, 10 readings a second, "
        "and the rise of the noise as of the D6T-1616L",
        columns=4,
        rows=4,
        horizontal_fov=math.radians(44.2),
        vertical_fov=math.radians(45.7),
        netd=0.06,
    ),
    _omron(
        "D6T_1616L",
        "Omron D6T-1616L (16 × 16, 90°)",
        "Assumed, no data sheet was found: 90° × 90°, 5 to 50 °C",
        "Noise of corner pixels 2.33 times that of middle ones measured; between them as of the "
        "MLX90640, and 0.06 K in the middle, assumed",
        columns=16,
        rows=16,
        horizontal_fov=math.radians(90.0),
        vertical_fov=math.radians(90.0),
        netd=0.06,
    ),
    _part(
        "HTPA32",
        "Heimann HTPA 32 × 32 L2.1 (90°)",
        "Heimann, HTPA32x32d as sold by Sipeed: 90° × 90°, noise 0.14 K at 1 Hz, here for 5 Hz, "
        "the measured rate. Noise of corner pixels twice that of middle ones, and steps of 0.1 K, "
        "measured on two parts. Assumed: the noise between, blur (0.5 pixels), −20 to 300 °C, ±3 K "
        f"of devices as three standard deviations; {ALL}",
        rate=5.0,
        columns=32,
        rows=32,
        horizontal_fov=math.radians(90.0),
        vertical_fov=math.radians(90.0),
        netd=0.31,
        noise_rise=0.65,
        noise_corner=0.35,
        offset_sigma=1.0,
        resolution=0.1,
        coldest=-20.0,
        hottest=300.0,
    ),
)
