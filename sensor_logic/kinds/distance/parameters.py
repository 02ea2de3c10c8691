# SPDX-License-Identifier: GPL-3.0-or-later
"""What is set on a distance sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...parameters import Choice, Parameters, parameter
from ...quantities import METRES, Lengths

# Reflectance of the white and the grey target in data sheets, each as measured at 940 nm.
WHITE, GREY = 0.88, 0.17
MOST_ZONES = 16
FIXED: dict[str, Any] = {"used_when": (("target", "FIXED"),)}
SEVERAL = "VL53L5CX data sheet DS13754: 8 × 8 zones"


@dataclass(frozen=True)
class DistanceParameters(Parameters):
    threshold: float = parameter(
        1.0, "Threshold", "Something is near that is nearer than this", unit="m"
    )
    hysteresis: float = parameter(
        0.0,
        "Hysteresis",
        "It is near until it is this much farther away than the threshold",
        unit="m",
    )
    report_step: float = parameter(
        0.05,
        "Report step",
        "The event log tells of the distance when it changed by this much",
        unit="m",
        short="Report by",
    )
    range_min: float = parameter(0.04, "Range min", "What is nearer reads this", unit="m")
    range_max: float = parameter(
        3.6,
        "Range max",
        "How far a white target is seen that fills a zone; reads this where there is none",
        unit="m",
        positive=True,
    )
    range_grey: float = parameter(
        1.7,
        "Range of grey",
        "How far a target is seen that reflects 17 %; ultrasound: as far as a white one",
        unit="m",
        positive=True,
        short="Of grey",
    )
    target: str = parameter(
        "MATERIAL",
        "Target",
        "How much of the light that it sends is thrown back",
        choices=(
            Choice("MATERIAL", "Materials", "As much as the colours of materials say", 0),
            Choice("FIXED", "Fixed", "The same of everything", 1),
        ),
    )
    reflectance: float = parameter(
        WHITE, "Reflectance", "What everything reflects, 0 to 1", minimum=0.01, maximum=1.0, **FIXED
    )
    horizontal_fov: float = parameter(
        math.radians(19.3),
        "Horizontal FOV",
        "Angle from side to side that all zones together take",
        unit="rad",
        maximum=math.radians(120),
        short="FOV Across",
    )
    vertical_fov: float = parameter(
        math.radians(19.3),
        "Vertical FOV",
        "Angle from top to bottom that all zones together take",
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
        "Rays from side to side, and from top to bottom, of each zone",
        minimum=1,
        maximum=32,
    )
    echo: str = parameter(
        "MEAN",
        "Echo",
        "What a zone reads where its rays meet several things",
        choices=(
            Choice("MEAN", "Mean", "The mean of all, by how much each throws back", 0),
            Choice("STRONGEST", "Strongest", "What throws back most, apart from the others", 1),
            Choice("FIRST", "First", "What is nearest of that which can be told", 2),
        ),
    )
    separation: float = parameter(
        0.6,
        "Separation",
        "Things nearer together than this are one echo",
        unit="m",
        used_when=(("echo", "STRONGEST"),),
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of a reading at no distance", unit="m"
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
