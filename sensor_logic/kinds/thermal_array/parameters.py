# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters of an infrared array."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...logs.wording import METRES, Advice, Lengths
from ...parameters import Choice, Parameters, parameter

MOST_PIXELS = 160
# Many more rays than this fill the memory.
MAX_RAYS = 200_000
GRID_EYE = "Panasonic Grid-EYE AMG8833: 8 × 8 pixels, 60° × 60°"
LEARNT: dict[str, Any] = {"used_when": (("background", "LEARNT"),)}


@dataclass(frozen=True)
class ThermalArrayParameters(Parameters):
    """The parameters of an infrared array."""

    columns: int = parameter(
        8, "Columns", "Pixels in a row", minimum=1, maximum=MOST_PIXELS, source=GRID_EYE
    )
    rows: int = parameter(8, "Rows", "Rows of pixels", minimum=1, maximum=MOST_PIXELS)
    horizontal_fov: float = parameter(
        math.radians(60.0),
        "Horizontal FOV",
        "Horizontal angle of all pixels together",
        unit="rad",
        positive=True,
        maximum=math.radians(150),
        short="FOV Across",
        source=GRID_EYE,
    )
    vertical_fov: float = parameter(
        math.radians(60.0),
        "Vertical FOV",
        "Vertical angle of all pixels together",
        unit="rad",
        positive=True,
        maximum=math.radians(150),
        short="FOV Up",
    )
    rays: int = parameter(
        34,
        "Rays a pixel",
        "Rays of each pixel. More rays measure edges more exactly and take more time",
        minimum=1,
        maximum=1024,
    )
    blur: float = parameter(
        0.0,
        "Blur",
        "Standard deviation of the Gaussian with which the lens blurs the picture, in pixels",
        maximum=4.0,
        source="Measured on two parts: 0.5",
    )
    threshold: float = parameter(
        2.0,
        "Threshold",
        "A pixel is warm if it exceeds the background by more than this",
        unit="K",
        positive=True,
    )
    min_pixels: int = parameter(
        2, "Warm pixels", "Occupied is on if at least as many pixels are warm", minimum=1
    )
    hold_time: float = parameter(
        5.0, "Hold time", "Occupied stays on for this long after the last warm frame", unit="s"
    )
    background: str = parameter(
        "MEDIAN",
        "Background",
        "With what pixels are compared",
        choices=(
            Choice("MEDIAN", "Median", "The median of all pixels of the frame", 0),
            Choice("LEARNT", "Learnt", "The mean of each pixel while it was not warm", 1),
        ),
    )
    background_time: float = parameter(
        60.0,
        "Learning time",
        "Time constant of the mean of each pixel",
        unit="s",
        positive=True,
        **LEARNT,
    )
    report_step: float = parameter(
        0.5,
        "Report step",
        "Least change of the highest temperature that the event log records",
        unit="K",
        short="Report by",
    )
    netd: float = parameter(
        0.0,
        "Noise",
        "Standard deviation of a pixel in the middle from frame to frame. Data sheets: NETD, at "
        "the frame rate",
        unit="K",
    )
    noise_rise: float = parameter(
        0.0,
        "Noise rise",
        "By how much the noise grows with the square of the distance from the middle: its share "
        "of Noise at a corner pixel",
    )
    noise_corner: float = parameter(
        0.0,
        "Noise in corners",
        "By how much the noise grows with the sixth power of the distance from the middle: its "
        "share of Noise at a corner pixel",
        short="In Corners",
    )
    frame_noise: float = parameter(
        0.0,
        "Noise of frames",
        "Standard deviation of an error that all pixels of a frame have in common, from frame to "
        "frame",
        unit="K",
        short="Of Frames",
    )
    frame_drift: float = parameter(
        0.0,
        "Drift of frames",
        "Standard deviation of a slow error that all pixels have in common",
        unit="K",
        short="Drift",
    )
    pixel_drift: float = parameter(
        0.0,
        "Drift of pixels",
        "Standard deviation of a slow error of each pixel",
        unit="K",
        short="Pixel Drift",
    )
    drift_time: float = parameter(
        5.0,
        "Drift time",
        "Time in which a slow error takes another value",
        unit="s",
        positive=True,
    )
    fixed_pattern: float = parameter(
        0.0,
        "Fixed pattern",
        "Standard deviation among the pixels of an error that never changes",
        unit="K",
        short="Pattern",
    )
    offset_sigma: float = parameter(
        0.0,
        "Spread of devices",
        "Standard deviation of the error that all pixels of a device have in common",
        unit="K",
        short="Spread",
    )
    resolution: float = parameter(
        0.0, "Resolution", "Temperatures are multiples of this; 0: exact", unit="K"
    )
    coldest: float = parameter(
        -40.0, "Coldest", "The lowest temperature that a pixel reads", unit="°C", minimum=-273.15
    )
    hottest: float = parameter(
        300.0, "Hottest", "The highest temperature that a pixel reads", unit="°C", minimum=-273.15
    )
    settling_time: float = parameter(
        0.0,
        "Settling time",
        "Time constant with which the pixels follow the radiation; 0: at once",
        unit="s",
    )
    mean_of: int = parameter(
        1,
        "Mean of readings",
        "Each frame is the mean of the present and of earlier readings, so many together. Noise "
        "is that of this mean",
        minimum=1,
        maximum=100,
        short="Mean of",
    )
    keep_frames: bool = parameter(
        True,
        "Keep frames",
        "Samples have the temperatures of all pixels. A large array with noise fills 5 kB a frame",
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return sentences about limits that contradict each other, and about too many rays."""
        problems = self.must_be_smaller("coldest", "hottest", lengths)
        pixels = self.columns * self.rows
        if pixels * self.rays > MAX_RAYS:
            problems.append(
                f"{self.columns} × {self.rows} pixels with {self.rays} rays each are more than "
                f"{MAX_RAYS} rays: take at most {MAX_RAYS // pixels} rays a pixel, or fewer pixels"
            )
        if self.min_pixels > pixels:
            problems.append(
                f"min_pixels ({self.min_pixels}) is more than the array has: "
                f"{self.columns} × {self.rows}"
            )
        return problems

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if half of the pixels or more would have to be warmer than the median."""
        most = (self.columns * self.rows) // 2
        if self.background != "MEDIAN" or self.min_pixels <= most:
            return []
        return [
            Advice(
                f"Only {most} of {self.columns} × {self.rows} pixels can be warmer than their "
                f"median, and occupied needs {self.min_pixels}: it never goes on",
                "Need fewer warm pixels, or let the sensor learn its background",
            )
        ]

    @property
    def drifts(self) -> bool:
        """Whether a slow error is added to the frames."""
        return self.frame_drift > 0.0 or self.pixel_drift > 0.0

    @property
    def field_of_view(self) -> tuple[float, float]:
        """The horizontal and the vertical angle of all pixels together, in radians."""
        return self.horizontal_fov, self.vertical_fov

    @property
    def pixels(self) -> tuple[int, int]:
        """The numbers of columns and of rows."""
        return self.columns, self.rows
