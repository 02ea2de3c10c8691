# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters of the distance sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...parameters import Choice, Parameters, parameter
from ...quantities import METRES, Lengths
from ...wording import Advice

# Reflectance of the white and the grey target in data sheets, each as measured at 940 nm.
WHITE, GREY = 0.88, 0.17
MOST_ZONES = 16
FIXED: dict[str, Any] = {"used_when": (("target", "FIXED"),)}
SEVERAL = "VL53L5CX data sheet DS13754: 8 × 8 zones"


@dataclass(frozen=True)
class DistanceParameters(Parameters):
    threshold: float = parameter(
        1.0, "Threshold", "Near is on where a target is closer than this", unit="m"
    )
    hysteresis: float = parameter(
        0.0,
        "Hysteresis",
        "Near goes off where the distance exceeds the threshold by this much",
        unit="m",
    )
    report_step: float = parameter(
        0.05,
        "Report step",
        "Least change of the distance that the event log records",
        unit="m",
        short="Report by",
    )
    range_min: float = parameter(0.04, "Range min", "Closer targets read this distance", unit="m")
    range_max: float = parameter(
        3.6,
        "Range max",
        "Greatest distance of a white target that fills a zone; the reading without a target",
        unit="m",
        positive=True,
    )
    range_grey: float = parameter(
        1.7,
        "Range of grey",
        "Greatest distance of a target that reflects 17 %; ultrasound: the same as of a white one",
        unit="m",
        positive=True,
        short="Of grey",
    )
    target: str = parameter(
        "MATERIAL",
        "Target",
        "Where the reflectance of targets comes from",
        choices=(
            Choice("MATERIAL", "Materials", "The colours of their materials", 0),
            Choice("FIXED", "Fixed", "One value for all targets", 1),
        ),
    )
    reflectance: float = parameter(
        WHITE, "Reflectance", "Share that targets reflect", minimum=0.01, maximum=1.0, **FIXED
    )
    horizontal_fov: float = parameter(
        math.radians(19.3),
        "Horizontal FOV",
        "Horizontal angle of all zones together",
        unit="rad",
        maximum=math.radians(120),
        short="FOV Across",
    )
    vertical_fov: float = parameter(
        math.radians(19.3),
        "Vertical FOV",
        "Vertical angle of all zones together",
        unit="rad",
        maximum=math.radians(120),
        short="FOV Up",
    )
    zones_across: int = parameter(
        1, "Zones across", "Zones in a row", minimum=1, maximum=MOST_ZONES, source=SEVERAL
    )
    zones_up: int = parameter(1, "Zones up", "Rows of zones", minimum=1, maximum=MOST_ZONES)
    rays: int = parameter(
        5,
        "Rays",
        "Rays of each zone horizontally, and as many vertically",
        minimum=1,
        maximum=32,
    )
    echo: str = parameter(
        "MEAN",
        "Echo",
        "Which distance a zone reads where its rays hit several targets",
        choices=(
            Choice("MEAN", "Mean", "The mean, weighted by the signal that each returns", 0),
            Choice("STRONGEST", "Strongest", "The target that returns the strongest signal", 1),
            Choice("FIRST", "First", "The nearest at which enough signal has returned", 2),
        ),
    )
    separation: float = parameter(
        0.6,
        "Separation",
        "Targets closer together than this give one echo",
        unit="m",
        used_when=(("echo", "STRONGEST"),),
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of a reading at distance 0", unit="m"
    )
    noise_growth: float = parameter(
        0.0, "Noise growth", "How much the standard deviation grows with each metre, in metres"
    )
    resolution: float = parameter(
        0.0, "Resolution", "Readings are multiples of this; 0: exact", unit="m"
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        problems = self.must_be_smaller("range_min", "range_max", lengths)
        if problems:
            return problems
        if self.range_grey > self.range_max:
            return [
                f"range_grey ({lengths.typed(self.range_grey)}) is beyond range_max "
                f"({lengths.typed(self.range_max)}): white is seen at least as far as grey"
            ]
        return []

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        threshold, most = lengths.typed(self.threshold), lengths.typed(self.range_max)
        if self.threshold <= self.range_min:
            return [
                Advice(
                    f"The threshold ({threshold}) is not above the range min "
                    f"({lengths.typed(self.range_min)}): near never goes on",
                    "Raise the threshold",
                )
            ]
        if self.threshold + self.hysteresis <= self.range_max:
            return []
        added = f" plus the hysteresis ({lengths.typed(self.hysteresis)})" * bool(self.hysteresis)
        return [
            Advice(
                f"The threshold ({threshold}){added} is beyond the range max ({most}): near goes "
                "off only where no zone detects anything",
                "Lower the threshold or the hysteresis",
            )
        ]
