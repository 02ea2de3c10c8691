# SPDX-License-Identifier: GPL-3.0-or-later
"""Voltage divider with a load resistor to ground, and the converter that reads it.

The sensing resistor is between the supply and the output, so the output rises as it conducts
better: V = Vcc·RM/(RM + R) (Interlink FSR Integration Guide, "Voltage Divider").
"""

from __future__ import annotations

import math


def voltage(supply: float, load_resistor: float, resistance: float) -> float:
    """Output in volts; `supply` in volts, the fixed and the sensing resistor in ohms (may be inf).

    The circuit that reads the output draws no current.
    """
    return supply * load_resistor / (load_resistor + resistance)


def adc(voltage: float, supply: float, bits: int) -> int:
    """Code of an ideal converter whose reference is the supply: floor(V/Vcc·(2^bits − 1)).

    Voltages beyond 0 … supply (both in volts) read the code at that end.
    """
    largest = (1 << bits) - 1
    return min(max(math.floor(voltage / supply * largest), 0), largest)
