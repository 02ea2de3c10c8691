# SPDX-License-Identifier: GPL-3.0-or-later
"""Force-sensing resistor: from a force on it to its resistance, voltage and converter code.

The curve R(F) of a typical part, and optionally the deviations of a single part from it:
hysteresis, drift under load, spread from part to part and from press to press.
docs/force_resistor.md has the equations with their sources.
"""

from __future__ import annotations

import math
from bisect import bisect
from dataclasses import dataclass

from ...physics import divider
from .parameters import PressureParameters

GRAM_FORCE = 9.80665e-3
# Grams-force and ohms, read off the typical curve in Interlink's FSR Integration Guide and data
# sheet PDS-10004, which mark those from 1000 g on as interpolated.
FSR_402_POINTS = (
    (20.0, 30_000.0),
    (50.0, 10_000.0),
    (100.0, 6_000.0),
    (1_000.0, 1_250.0),
    (2_000.0, 750.0),
    (4_000.0, 450.0),
    (7_000.0, 300.0),
    (10_000.0, 250.0),
)
LOG_FORCES = tuple(math.log(grams * GRAM_FORCE) for grams, _ in FSR_402_POINTS)
LOG_RESISTANCES = tuple(math.log(ohms) for _, ohms in FSR_402_POINTS)

# Interlink's guide has the contact settle in "the order of seconds"; drift counts from there.
DRIFT_START = 1.0
# A load that changes by less than this share counts as constant, and the drift goes on.
SAME_LOAD = 0.1


@dataclass(frozen=True)
class FsrReading:
    """Resistance in ohms, output voltage of the divider in volts, code of the converter."""

    resistance_ohm: float
    voltage_v: float
    adc: int


def _log_fsr_402(log_force: float) -> float:
    """ln of a typical FSR 402's resistance in ohms over ln of the force in newtons.

    Straight lines between the points of the data sheet; the first and the last line are extended.
    """
    i = min(max(bisect(LOG_FORCES, log_force), 1), len(LOG_FORCES) - 1)
    slope = (LOG_RESISTANCES[i] - LOG_RESISTANCES[i - 1]) / (LOG_FORCES[i] - LOG_FORCES[i - 1])
    return LOG_RESISTANCES[i] + slope * (log_force - LOG_FORCES[i])


def contact(parameters: PressureParameters, force: float) -> float:
    """How much of the film is in contact at `force` newtons: 0 without force, 1 from force_min."""
    if force <= 0.0:
        return 0.0
    return min(force / parameters.force_min, 1.0) if parameters.force_min > 0.0 else 1.0


def typical_resistance(parameters: PressureParameters, force: float) -> float:
    """Resistance in ohms of an ideal part at `force` newtons, for a growing load.

    At force_max and above the film is saturated. Below force_min the logarithm of the resistance
    rises in proportion to the force that is missing, up to that of the unloaded part: steep as
    the break of a real part (0.16 N gives 0.1 MΩ, below which the guide has the break), without
    a step.
    """
    touching = contact(parameters, force)
    if touching == 0.0:
        return parameters.unloaded_resistance
    log_force = math.log(min(max(force, parameters.force_min), parameters.force_max))
    if parameters.resistor == "POWER_LAW":
        log_film = math.log(parameters.resistance_at_1n) - parameters.exponent * log_force
    else:
        log_film = _log_fsr_402(log_force)
    log_open = math.log(parameters.unloaded_resistance)
    return math.exp(log_open + touching * min(log_film - log_open, 0.0))


def spread_factor(spread: float, unit_noise: float) -> float:
    """A factor of mean 1 and standard deviation `spread`, from a standard normal number.

    Log-normal, so that no draw makes a resistance negative. The data sheets give their ± as one
    standard deviation over the mean.
    """
    variance = math.log1p(spread * spread)
    return math.exp(math.sqrt(variance) * unit_noise - variance / 2.0)


class ForceResistor:
    """One part with its state. `part_noise`, a standard normal number, is its deviation from the
    typical part; `touched`: whether it is being pressed."""

    def __init__(self, part_noise: float = 0.0) -> None:
        self._part_noise = part_noise
        self._press_noise = 0.0
        self._log_conductance: float | None = None
        self.touched = False
        self._load = 0.0
        self._load_time = 0.0
        self._decades = 0.0

    def update(
        self, parameters: PressureParameters, force_n: float, time_s: float, unit_noise: float
    ) -> FsrReading:
        """The reading at `force_n` newtons and `time_s` seconds, which must not decrease.

        `unit_noise` is a standard normal number of this update; it matters only at an update at
        which a press begins, because repeatability is the spread from press to press.
        """
        touching = contact(parameters, force_n)
        load = min(force_n, parameters.force_max)
        if touching == 1.0 and not self.touched:
            self._press_noise = unit_noise
        decades = self._drift_decades(touching == 1.0, load, time_s)
        self.touched = touching == 1.0
        factor = (
            spread_factor(parameters.part_spread, self._part_noise)
            * spread_factor(parameters.repeatability, self._press_noise)
            * (1.0 - parameters.drift * decades)
        )
        resistance = self._with_hysteresis(parameters, force_n, touching) * factor**touching
        voltage = divider.voltage(parameters.supply_voltage, parameters.load_resistor, resistance)
        code = divider.adc(voltage, parameters.supply_voltage, parameters.adc_bits)
        return FsrReading(resistance, voltage, code)

    def _with_hysteresis(
        self, parameters: PressureParameters, force: float, touching: float
    ) -> float:
        """Resistance in ohms: a play operator on the logarithm of the conductance.

        The conductance follows the typical curve for a growing load, stays constant as the load
        begins to fall, and then keeps 1/(1 − hysteresis) above that curve. It does not depend on
        the rate; a small change of the load inside the play changes nothing.
        """
        typical = typical_resistance(parameters, force)
        if parameters.hysteresis == 0.0:
            self._log_conductance = None
            return typical
        low = -math.log(typical)
        high = low - touching * math.log1p(-parameters.hysteresis)
        before = low if self._log_conductance is None else self._log_conductance
        self._log_conductance = min(max(before, low), high)
        return math.exp(-self._log_conductance)

    def _drift_decades(self, touched: bool, load: float, time: float) -> float:
        """Decades of time, log10(1 + t/DRIFT_START), for which the load has been constant.

        When a load grows, the drift of the old load stays and that of the added load starts at 0;
        conductance is about proportional to force, so the decades shrink by the ratio of loads.
        """
        if not touched:
            return 0.0
        if not self.touched:
            self._load, self._load_time, self._decades = load, time, 0.0
        elapsed = (time - self._load_time) / DRIFT_START
        decades = math.log10(10.0**self._decades + elapsed) * min(self._load / load, 1.0)
        if abs(load - self._load) > SAME_LOAD * self._load:
            self._load, self._load_time, self._decades = load, time, decades
        return decades
