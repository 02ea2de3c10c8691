# SPDX-License-Identifier: GPL-3.0-or-later
"""The parameters of a pressure sensor."""

from __future__ import annotations

from dataclasses import dataclass

from ...parameters import Choice, Parameters, parameter
from ...quantities import METRES, Lengths

FSR_402 = "Interlink FSR 402 data sheet, PDS-10004"


@dataclass(frozen=True)
class PressureParameters(Parameters):
    threshold: float = parameter(1.0, "Threshold", "Pressed is on above this force", unit="N")
    report_step: float = parameter(
        1.0,
        "Report step",
        "Least change of the force that the event log records",
        unit="N",
        short="Report by",
    )
    partner_object: str | None = parameter(
        None,
        "Partner object",
        "Measure only this object; empty: measure everything",
        pointer="Object",
        short="Object",
    )
    partner_collection: str | None = parameter(
        None,
        "Partner collection",
        "Measure only the objects of this collection; empty: measure everything",
        pointer="Collection",
        short="Collection",
    )
    subtract_own_weight: bool = parameter(
        True,
        "Subtract own weight",
        "Leave the pad's own weight out of the reading",
        short="Less own weight",
    )
    area: float = parameter(
        1.267e-4,
        "Area",
        "Active area of the force-sensing resistor",
        unit="m²",
        positive=True,
        source="12.7 mm diameter, " + FSR_402,
    )
    force_min: float = parameter(
        0.2,
        "Force min",
        "Least force that the resistor measures. Datasheets: actuation force",
        unit="N",
        source=FSR_402,
    )
    force_max: float = parameter(
        20.0,
        "Force max",
        "Force at which the resistor saturates. Datasheets: force sensitivity range",
        unit="N",
        positive=True,
        source=FSR_402,
    )
    resistor: str = parameter(
        "FSR_402",
        "Resistor",
        "How the resistance follows the force",
        choices=(
            Choice("FSR_402", "FSR 402", "The typical curve of the Interlink FSR 402", 0),
            Choice("POWER_LAW", "Power law", "Resistance at 1 N and exponent, for other parts", 1),
        ),
        source=FSR_402,
    )
    resistance_at_1n: float = parameter(
        6880.0,
        "Resistance at 1 N",
        "Resistance under a force of 1 N. Datasheets: from the curve of resistance over force",
        unit="Ω",
        positive=True,
        source="power law through the curve of the FSR 402 from 0.2 to 20 N, up to 20 % off",
        used_when=(("resistor", "POWER_LAW"),),
        short="At 1 N",
    )
    exponent: float = parameter(
        0.763,
        "Exponent",
        "The resistance falls with the force to this power. "
        "Datasheets: slope of the curve, both axes logarithmic",
        positive=True,
        maximum=5.0,
        source="power law through the curve of the FSR 402 from 0.2 to 20 N, up to 20 % off",
        used_when=(("resistor", "POWER_LAW"),),
    )
    unloaded_resistance: float = parameter(
        10_000_000.0,
        "Unloaded resistance",
        "Resistance without force. Datasheets: non-actuated or stand-off resistance",
        unit="Ω",
        positive=True,
        source="> 10 MΩ, " + FSR_402,
        short="Unloaded",
    )
    hysteresis: float = parameter(
        0.0,
        "Hysteresis",
        "Share by which the resistance is lower for a falling load than for a growing one. "
        "Datasheets: hysteresis, (RF+ − RF−)/RF+",
        maximum=0.9,
        source="0.10 on average, " + FSR_402,
    )
    drift: float = parameter(
        0.0,
        "Drift",
        "Share of the resistance lost with each tenfold time under a constant load. "
        "Datasheets: long-term drift, per log10(time)",
        maximum=0.1,
        source="< 0.05 (1 kg, 35 days), " + FSR_402,
    )
    part_spread: float = parameter(
        0.0,
        "Part spread",
        "Standard deviation of the resistance from sensor to sensor, as a share of it. "
        "Datasheets: part-to-part repeatability, one standard deviation / mean",
        maximum=0.5,
        source="± 0.06 in one batch, " + FSR_402,
    )
    repeatability: float = parameter(
        0.0,
        "Repeatability",
        "Standard deviation of the resistance from press to press, as a share of it. "
        "Datasheets: single-part repeatability, one standard deviation / mean",
        maximum=0.5,
        source="± 0.02, " + FSR_402,
    )
    load_resistor: float = parameter(
        10_000.0,
        "Load resistor",
        "Fixed resistor of the divider, from its output to ground. Datasheets: measuring resistor",
        unit="Ω",
        positive=True,
        short="Load",
    )
    supply_voltage: float = parameter(
        5.0, "Supply voltage", "Voltage of the divider", unit="V", positive=True, short="Supply"
    )
    adc_bits: int = parameter(
        10, "ADC bits", "Resolution of the converter behind it", minimum=1, maximum=32
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on the force", unit="N"
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        return self.must_be_smaller("force_min", "force_max", lengths)
