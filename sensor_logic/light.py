# SPDX-License-Identifier: GPL-3.0-or-later
"""Light sensor: its parameters. Its physics is not simulated yet."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .parameters import Choice, Parameters, parameter

THESIS = "camera sensor of the thesis's Gazebo plugin"
GL5528 = "GL5528 data sheet"


@dataclass(frozen=True)
class LightParameters(Parameters):
    method: str = parameter(
        "FOUR_WALL",
        "Method",
        "What is measured",
        choices=(
            Choice("FOUR_WALL", "Four walls", "Luminance of four views, in percent", 0),
            Choice("ILLUMINANCE", "Illuminance", "Light on the sensor's face, in lux", 1),
        ),
    )
    engine: str = parameter(
        "CYCLES",
        "Engine",
        "What computes the light",
        choices=(
            Choice("CYCLES", "Cycles", "Path tracing", 0),
            Choice("EEVEE", "EEVEE", "Rasterising; needs a GPU", 1),
            Choice("DIRECT", "Direct", "Closed-form direct light, a fast preview", 2),
        ),
    )
    samples: int = parameter(1024, "Samples", "Light paths a reading", minimum=1, maximum=1_000_000)
    clip_start: float = parameter(
        0.5, "Clip start", "Nearer than this is not seen", unit="m", minimum=0.0, source=THESIS
    )
    clip_end: float = parameter(
        5.0,
        "Clip end",
        "How far the views see",
        unit="m",
        minimum=0.0,
        above_minimum=True,
        source=THESIS,
    )
    field_of_view: float = parameter(
        0.02,
        "Field of view",
        "Angle of each of the four views",
        unit="rad",
        minimum=0.0,
        above_minimum=True,
        maximum=math.pi,
        source=THESIS,
    )
    exposure: float = parameter(
        1.0, "Exposure", "Radiance that reads 100 % is one over this", minimum=0.0
    )
    threshold: float = parameter(
        50.0, "Threshold", "Lit above this reading, in the unit of the method", minimum=0.0
    )
    report_step: float = parameter(
        1.0,
        "Report step",
        "The event log tells of the reading when it changed by this much",
        minimum=0.0,
    )
    gamma: float = parameter(
        0.7, "Gamma", "Slope of the resistance over the light, both logarithmic", source=GL5528
    )
    resistance_10lux: float = parameter(
        14_000.0,
        "Resistance at 10 lux",
        "Resistance of the photoresistor at 10 lux",
        unit="Ω",
        minimum=0.0,
        above_minimum=True,
        source="8–20 kΩ, " + GL5528,
    )
    dark_resistance: float = parameter(
        1_000_000.0,
        "Dark resistance",
        "Resistance of the photoresistor in the dark",
        unit="Ω",
        minimum=0.0,
        above_minimum=True,
        source=GL5528,
    )
    load_resistor: float = parameter(
        10_000.0,
        "Load resistor",
        "Fixed resistor of the divider",
        unit="Ω",
        minimum=0.0,
        above_minimum=True,
    )
    supply_voltage: float = parameter(
        5.0, "Supply voltage", "Voltage of the divider", unit="V", minimum=0.0, above_minimum=True
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on the reading", minimum=0.0
    )

    def contradictions(self) -> list[str]:
        if self.clip_start >= self.clip_end:
            return [
                f"clip_start ({self.clip_start:.6g} m) must be smaller than "
                f"clip_end ({self.clip_end:.6g} m)"
            ]
        return []
