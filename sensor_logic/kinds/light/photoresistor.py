# SPDX-License-Identifier: GPL-3.0-or-later
"""Photoresistor (LDR): its resistance over light, and how it follows changes."""

from __future__ import annotations

import math

REFERENCE_LUX = 10.0


def conductance(lux: float, resistance_10lux: float, gamma: float, dark_resistance: float) -> float:
    """Conductance in S in a constant illuminance E: 1/R_dark + (E / 10 lx)^γ / R10.

    γ = log10(R at 10 lx / R at 100 lx) as in data sheets, away from the dark.
    """
    return 1.0 / dark_resistance + math.pow(max(lux, 0.0) / REFERENCE_LUX, gamma) / resistance_10lux


def equivalent_lux(
    siemens: float, resistance_10lux: float, gamma: float, dark_resistance: float
) -> float:
    """The constant illuminance in lux that gives this conductance: the inverse of `conductance`."""
    of_light = (siemens - 1.0 / dark_resistance) * resistance_10lux
    return REFERENCE_LUX * math.pow(max(of_light, 0.0), 1.0 / gamma)


def follow(before: float, target: float, dt: float, rise: float, fall: float) -> float:
    """The conductance `dt` seconds later: exponential, with a time constant for rising and one for
    falling (s). Exact for constant light during `dt`, so steps of any length agree."""
    constant = rise if target > before else fall
    return target + (before - target) * math.exp(-dt / constant) if constant > 0.0 else target
