# SPDX-License-Identifier: GPL-3.0-or-later
"""Photoresistor (LDR): resistance over light, its rise and fall, and the divider behind it."""

from __future__ import annotations

import math

REFERENCE_LUX = 10.0


def conductance(lux: float, resistance_10lux: float, gamma: float, dark_resistance: float) -> float:
    """Siemens at rest in a light: 1/R_dark + (E / 10 lx)^γ / R10.

    γ = log10(R at 10 lx / R at 100 lx) as in data sheets, away from the dark.
    """
    return 1.0 / dark_resistance + math.pow(max(lux, 0.0) / REFERENCE_LUX, gamma) / resistance_10lux


def equivalent_lux(
    siemens: float, resistance_10lux: float, gamma: float, dark_resistance: float
) -> float:
    """The light in which a resistor at rest has this conductance: inverse of `conductance`."""
    of_light = (siemens - 1.0 / dark_resistance) * resistance_10lux
    return REFERENCE_LUX * math.pow(max(of_light, 0.0), 1.0 / gamma)


def follow(before: float, target: float, dt: float, rise: float, fall: float) -> float:
    """The conductance `dt` seconds later: exponential, with its own time constant each way.

    Exact for a light that holds for all of `dt`, so steps of any length agree.
    """
    constant = rise if target > before else fall
    return target + (before - target) * math.exp(-dt / constant) if constant > 0.0 else target


def divided(supply: float, load_resistor: float, resistance: float) -> float:
    """Volts over the load resistor, the resistor of the sensor being on the supply's side."""
    return supply * load_resistor / (load_resistor + resistance)
