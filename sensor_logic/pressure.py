# SPDX-License-Identifier: GPL-3.0-or-later
"""Pressure sensor under furniture: its parameters. Its physics is not simulated yet."""

from __future__ import annotations

from dataclasses import dataclass

from .parameters import Parameters, parameter

FSR_402 = "Interlink FSR 402 data sheet, PDS-10004"


@dataclass(frozen=True)
class PressureParameters(Parameters):
    threshold: float = parameter(
        1.0, "Threshold", "Pressed above this force", unit="N", minimum=0.0
    )
    report_step: float = parameter(
        1.0,
        "Report step",
        "The event log tells of the force when it changed by this much",
        unit="N",
        minimum=0.0,
    )
    partner_object: str | None = parameter(
        None,
        "Partner object",
        "Measure this object alone; empty: everything",
        pointer="Object",
    )
    partner_collection: str | None = parameter(
        None,
        "Partner collection",
        "Measure the objects of this collection alone; empty: everything",
        pointer="Collection",
    )
    subtract_own_weight: bool = parameter(
        True, "Subtract own weight", "Leave the pad's own weight out of the reading"
    )
    area: float = parameter(
        1.267e-4,
        "Area",
        "Active area of the force-sensing resistor",
        unit="m²",
        minimum=0.0,
        above_minimum=True,
        source="12.7 mm diameter, " + FSR_402,
    )
    force_min: float = parameter(
        0.2,
        "Force min",
        "Least force that the resistor feels. Datasheets: actuation force",
        unit="N",
        minimum=0.0,
        source=FSR_402,
    )
    force_max: float = parameter(
        20.0,
        "Force max",
        "Force at which the resistor saturates. Datasheets: force sensitivity range",
        unit="N",
        minimum=0.0,
        above_minimum=True,
        source=FSR_402,
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
    adc_bits: int = parameter(
        10, "ADC bits", "Resolution of the converter behind it", minimum=1, maximum=32
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on the force", unit="N", minimum=0.0
    )

    def contradictions(self) -> list[str]:
        if self.force_min >= self.force_max:
            return [
                f"force_min ({self.force_min:.6g} N) must be smaller than "
                f"force_max ({self.force_max:.6g} N)"
            ]
        return []
