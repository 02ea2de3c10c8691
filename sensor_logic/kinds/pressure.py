# SPDX-License-Identifier: GPL-3.0-or-later
"""Pressure sensor: a pad that measures the forces on it, and its force-sensing resistor.

- Model: `PressurePad`, with its resistor, parameters and presets in this file.
- Scene: bodies and their motion by angen_addon/scene/forces/, beginning with tracker.py; the
  forces between them by sensor_logic/forces/, beginning with pad_forces.py.
- Interface: angen_addon/kinds/pressure.py; the weight of things: panels/load.py.
- Physics: docs/pressure.md; the resistor: docs/force_resistor.md.
- Tests: tests/pure/test_pressure.py, test_forces*.py and test_balance.py,
  tests/blender/test_pressure_*.py.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import physics
from ..evidence import Cause, measured_cause, rows_of, rows_text
from ..kind import FORCES, Field, Kind, Preset
from ..logs.wording import METRES, Lengths, joined, split, typed
from ..model import Model, PadContact, Pose, Reading, Update
from ..parameters import Choice, Parameters, parameter

# The parameters of a pressure sensor.

FSR_402_SHEET = "Interlink FSR 402 data sheet, PDS-10004"


@dataclass(frozen=True)
class PressureParameters(Parameters):
    """The parameters of a pressure sensor."""

    threshold: float = parameter(
        1.0, "Threshold", "The output pressed is on above this force", unit="N"
    )
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
        "Measure only this object. Empty: measure everything",
        pointer="Object",
        short="Object",
    )
    partner_collection: str | None = parameter(
        None,
        "Partner collection",
        "Measure only the objects of this collection. Empty: measure everything",
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
        source="12.7 mm diameter, " + FSR_402_SHEET,
    )
    overall_area: float = parameter(
        0.0,
        "Overall area",
        "Area of the force-sensing resistor with its rim, which carries a share of what is larger "
        "than the active area. 0: the whole force reaches the active area, as through a disk",
        unit="m²",
        source="18.28 mm diameter, Interlink FSR 402 data sheet of 2010",
        short="Overall",
    )
    rim_force: float = parameter(
        1.75,
        "Rim force",
        "Force up to which the active area carries everything. Of the force above it, the rim "
        "carries a share in proportion to its area",
        unit="N",
        source="measured: a flat weight of 250, 500, 750 g gives 12, 20, 31 % less conductance "
        "than a finger, ekaeoq/uartfsr",
    )
    force_min: float = parameter(
        0.2,
        "Force min",
        "Least force that the resistor measures. Datasheets: actuation force",
        unit="N",
        source=FSR_402_SHEET,
    )
    force_max: float = parameter(
        20.0,
        "Force max",
        "Force at which the resistor saturates. Datasheets: force sensitivity range",
        unit="N",
        positive=True,
        source=FSR_402_SHEET,
    )
    resistor: str = parameter(
        "FSR_402",
        "Resistor",
        "How the resistance follows the force",
        choices=(
            Choice("FSR_402", "FSR 402", "The typical curve of the Interlink FSR 402", 0),
            Choice("POWER_LAW", "Power law", "Resistance at 1 N and exponent, for other parts", 1),
        ),
        source=FSR_402_SHEET,
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
        source="> 10 MΩ, " + FSR_402_SHEET,
        short="Unloaded",
    )
    hysteresis: float = parameter(
        0.0,
        "Hysteresis",
        "Share by which the resistance is lower for a falling load than for a growing one. "
        "Datasheets: hysteresis, (RF+ − RF−)/RF+",
        maximum=0.9,
        source="0.10 on average, " + FSR_402_SHEET,
    )
    drift: float = parameter(
        0.0,
        "Drift",
        "Share of the resistance lost with each tenfold time under a constant load. "
        "Datasheets: long-term drift, per log10(time)",
        maximum=0.1,
        source="< 0.05 (1 kg, 35 days), " + FSR_402_SHEET,
    )
    part_spread: float = parameter(
        0.0,
        "Part spread",
        "Standard deviation of the resistance from sensor to sensor, as a share of it. "
        "Datasheets: part-to-part repeatability, one standard deviation / mean",
        maximum=0.5,
        source="± 0.06 in one batch, " + FSR_402_SHEET,
    )
    repeatability: float = parameter(
        0.0,
        "Repeatability",
        "Standard deviation of the resistance from press to press, as a share of it. "
        "Datasheets: single-part repeatability, one standard deviation / mean",
        maximum=0.5,
        source="± 0.02, " + FSR_402_SHEET,
    )
    load_resistor: float = parameter(
        10_000.0,
        "Load resistor",
        "Fixed resistor of the voltage divider, from its output to ground. Datasheets: measuring "
        "resistor",
        unit="Ω",
        positive=True,
        short="Load",
    )
    supply_voltage: float = parameter(
        5.0, "Supply voltage", "Voltage of the divider", unit="V", positive=True, short="Supply"
    )
    adc_bits: int = parameter(
        10,
        "ADC bits",
        "Resolution of the analogue-to-digital converter that reads the voltage",
        minimum=1,
        maximum=32,
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on the force", unit="N"
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return sentences about a force range or areas that contradict each other."""
        problems = self.must_be_smaller("force_min", "force_max", lengths)
        if 0.0 < self.overall_area < self.area:
            problems.append(
                f"overall_area ({typed(self.overall_area, 'm²')}) is smaller than the active area "
                f"({typed(self.area, 'm²')}) within it: enlarge it, or set it to 0"
            )
        return problems


# Force-sensing resistor: resistance, voltage and converter code as functions of the force.
#
# The curve R(F) of a typical part, and optionally the deviations of a single part from it:
# hysteresis, drift under load, spread from part to part and from press to press.
# docs/force_resistor.md has the equations with their sources.

GRAM_FORCE = 9.80665e-3
# Grams-force and ohms, read off the typical curve in Interlink's FSR Integration Guide and data
# sheet PDS-10004, which mark the points from 1000 g on as interpolated.
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

# In s. By Interlink's guide the contact settles in "the order of seconds"; drift starts after that.
DRIFT_START = 1.0
# A load that changes by less than this share counts as constant, and the drift continues.
SAME_LOAD = 0.1


@dataclass(frozen=True)
class FsrReading:
    """The outputs of a resistor's circuit: resistance in ohms, voltage in volts, and ADC code."""

    resistance_ohm: float
    voltage_v: float
    adc: int


def _log_fsr_402(log_force: float) -> float:
    """Return ln(resistance / Ω) of a typical FSR 402 at ln(force / N), interpolated linearly."""
    i = min(max(bisect(LOG_FORCES, log_force), 1), len(LOG_FORCES) - 1)
    slope = (LOG_RESISTANCES[i] - LOG_RESISTANCES[i - 1]) / (LOG_FORCES[i] - LOG_FORCES[i - 1])
    return LOG_RESISTANCES[i] + slope * (log_force - LOG_FORCES[i])


def contact(parameters: PressureParameters, force: float) -> float:
    """Return the fraction of the resistor's conductive film that is in contact at `force` (N).

    The fraction grows in proportion to the force, from 0 without force to 1 at force_min.
    """
    if force <= 0.0:
        return 0.0
    return min(force / parameters.force_min, 1.0) if parameters.force_min > 0.0 else 1.0


def typical_resistance(parameters: PressureParameters, force: float) -> float:
    """Return the resistance in ohms of a typical part at a growing load of `force` (N).

    Above force_max the resistance stays constant. Below force_min its logarithm rises linearly to
    the unloaded resistance. In a real part it jumps instead: by Interlink's guide, contact breaks
    below 0.16 N, at 0.1 MΩ.
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


def active_force(parameters: PressureParameters, force: float, contact_area: float) -> float:
    """Return the part in N of `force` that presses on the active area of the resistor.

    The rest presses on the rim. It is 0 up to `rim_force`, and for contacts that are not larger
    than the active area. Above `rim_force`, the force is distributed evenly over the contact.

    Parameters
    ----------
    force
        The force on the pad in N.
    contact_area
        The area in m² of what presses; 0 if it is unknown. What is larger than the part covers it.
    """
    covered = min(contact_area, parameters.overall_area)
    if covered <= parameters.area or force <= parameters.rim_force:
        return force
    return parameters.rim_force + (force - parameters.rim_force) * parameters.area / covered


def spread_factor(spread: float, unit_noise: float) -> float:
    """Return a log-normal factor of mean 1 and standard deviation `spread`, from a normal number.

    `unit_noise` is that standard normal number. Log-normal factors are positive, and so are the
    resistances that they multiply.
    """
    variance = math.log1p(spread * spread)
    return math.exp(math.sqrt(variance) * unit_noise - variance / 2.0)


class ForceResistor:
    """One force-sensing resistor with its state.

    Attributes
    ----------
    touched
        Whether the resistor was pressed at the last update.
    """

    def __init__(self, part_noise: float = 0.0) -> None:
        """Make an unloaded resistor.

        `part_noise` is a standard normal number. It determines by how much this part differs from a
        typical part.
        """
        self._part_noise = part_noise
        self._press_noise = 0.0
        self._log_conductance: float | None = None
        self.touched = False
        self._load = 0.0
        self._load_time = 0.0
        self._decades = 0.0

    def update(
        self,
        parameters: PressureParameters,
        force_n: float,
        time_s: float,
        unit_noise: float,
        contact_area: float = 0.0,
    ) -> FsrReading:
        """Return the reading at a force of `force_n` newtons.

        Parameters
        ----------
        time_s
            The time in s, not before the time of the previous call.
        unit_noise
            A standard normal number, used for the repeatability if a press begins at this update.
        contact_area
            The area in m² of what presses, as in `active_force`.
        """
        force_n = active_force(parameters, force_n, contact_area)
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
        voltage = physics.voltage(parameters.supply_voltage, parameters.load_resistor, resistance)
        code = physics.adc(voltage, parameters.supply_voltage, parameters.adc_bits)
        return FsrReading(resistance, voltage, code)

    def _with_hysteresis(
        self, parameters: PressureParameters, force: float, touching: float
    ) -> float:
        """Return the resistance in ohms, with a play operator on the logarithm of the conductance.

        For a growing load, the conductance follows the typical curve. When the load begins to fall,
        the conductance first stays constant. After that it is 1/(1 − hysteresis) times the
        conductance of the curve.
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

    def _drift_decades(self, pressed: bool, load: float, time: float) -> float:
        """Return the drift in decades: log10(1 + t/DRIFT_START) after a constant load of t seconds.

        When the load grows, the decades shrink by the ratio of old to new load: the added load has
        not drifted yet, and conductance is about proportional to force.
        """
        if not pressed:
            return 0.0
        if not self.touched:
            self._load, self._load_time, self._decades = load, time, 0.0
        elapsed = (time - self._load_time) / DRIFT_START
        decades = math.log10(10.0**self._decades + elapsed) * min(self._load / load, 1.0)
        if abs(load - self._load) > SAME_LOAD * self._load:
            self._load, self._load_time, self._decades = load, time, decades
        return decades


# The model.

# A partner is listed if its share of the force is larger than this.
LEAST_SHARE = 1e-3
# N. Evidence leaves out objects that press with less.
LEAST_FORCE = 5e-3
# In N. A smaller force on the back of a pad raises no warning.
LEAST_BACKING = 0.1


class PressurePad(Model):
    """Model of one pad. Its state is the last valid reading, and the state of its resistor."""

    def __init__(self) -> None:
        self._resistor: ForceResistor | None = None
        self._last_reading = UNKNOWN
        # The arguments of `pad_reading` that gave `_last_reading`, compared by identity: the
        # reading of a pad at rest is not computed again.
        self._arguments: tuple[Any, ...] = (None, None, None)

    def update(self, parameters: PressureParameters, update: Update) -> Reading:
        """Return the force along the pad's −Z in N, what presses it, and the resistor's output.

        If the scene has no usable forces, repeat the last valid reading, with the field `valid`
        false.
        """
        contact: PadContact = update.ask(FORCES)
        problem = contact.forces.problem
        if contact.forces.usable:
            arguments = parameters, update.pose, contact
            if not all(one is two for one, two in zip(arguments, self._arguments, strict=True)):
                self._arguments, self._last_reading = arguments, pad_reading(*arguments)
            if not problem and self._last_reading.on_its_back:
                problem = (
                    "objects touch only the back of the pad, and its +Z side senses: turn "
                    "the pad over"
                )
        if self._resistor is None:
            self._resistor = ForceResistor(float(update.device_noise().standard_normal()))
        on_force = on_press = 0.0
        # Draw only if one of the numbers is used.
        if parameters.noise_sigma or (
            self._last_reading.force > 0.0 and not self._resistor.touched
        ):
            on_force, on_press = update.noise().standard_normal(2)
        force = self._last_reading.force + parameters.noise_sigma * float(on_force)
        area = self._last_reading.area
        resistor = self._resistor.update(
            parameters, max(force, 0.0), update.time, float(on_press), area
        )
        pressed = force > parameters.threshold
        fields = {
            "force_n": force,
            "pressed": pressed,
            "valid": not problem,
            "residual": contact.forces.residual,
            "resistance_ohm": resistor.resistance_ohm,
            "voltage_v": resistor.voltage_v,
            "adc": resistor.adc,
            "partners": self._last_reading.partners,
            "cop_x_m": self._last_reading.centre[0],
            "cop_y_m": self._last_reading.centre[1],
            "problem": problem,
        }
        last = self._last_reading if contact.forces.usable else UNKNOWN
        evidence = {"shares": last.shares, "own_weight_n": last.own_weight}
        return Reading(pressed, force, fields, evidence)


@dataclass(frozen=True)
class PadReading:
    """The total of the forces on a pad.

    Attributes
    ----------
    force
        The force in N.
    partners
        The names of the objects that press the pad, as one text.
    centre
        The centre of pressure (x, y) in m along the pad's axes from its origin; NaN without
        pressure.
    area
        The contact area in m² of what presses; 0 if it is unknown.
    on_its_back
        Whether only the −Z side of the pad is pressed, by more than the pad's own weight.
    shares
        A row for each object that presses the pad, with its name and its force in N, the greatest
        first, as a text (`rows_of`). Objects with less than `LEAST_FORCE` are left out.
    own_weight
        The part of the force in N that is the pad's own weight.
    """

    force: float
    partners: str
    centre: tuple[float, float]
    area: float = 0.0
    on_its_back: bool = False
    shares: str = ""
    own_weight: float = 0.0


# The reading before the first usable forces.
UNKNOWN = PadReading(0.0, "", (math.nan, math.nan))


def pad_reading(parameters: PressureParameters, pose: Pose, contact: PadContact) -> PadReading:
    """Return the reading of a pad from its contact forces.

    The force includes the pad's own weight unless the parameter `subtract_own_weight` is set.
    """
    inward = -pose.axes[:, 2]
    pressing = area = 0.0
    holding = backing = 0.0
    names: dict[str, float] = {}
    forces: dict[str, float] = {}
    moment = np.zeros(3)
    for partner in contact.forces.partners:
        if contact.chosen is not None and not partner.objects & contact.chosen:
            continue
        along = partner.forces @ inward
        from_above = np.maximum(along, 0.0)
        share = float(from_above.sum())
        pressing += share
        area += partner.area if share > 0.0 else 0.0
        moment += from_above @ (partner.places - pose.origin)
        held = float(np.maximum(-along, 0.0).sum())
        backing += held
        alone = share if share > 0.0 or contact.chosen is None else held
        if alone > LEAST_FORCE:
            forces[partner.name] = forces.get(partner.name, 0.0) + alone
        if contact.chosen is not None:
            holding += held
            share += held
        names[partner.name] = names.get(partner.name, 0.0) + share
    own_weight = float(contact.weight @ inward)
    force = pressing
    if pressing == 0.0 and holding > 0.0:
        # A partner that holds the pad up also carries the pad's own weight.
        force = holding - own_weight if parameters.subtract_own_weight else holding
    elif not parameters.subtract_own_weight:
        force = pressing + own_weight
    least = LEAST_SHARE * max(pressing, holding)
    partners = joined(name for name, share in names.items() if share > least)
    centre = (math.nan, math.nan)
    if pressing > 0.0:
        local = pose.axes.T @ (moment / pressing)
        centre = (float(local[0]), float(local[1]))
    weight = float(np.linalg.norm(contact.weight))
    on_its_back = force <= 0.0 and backing > LEAST_BACKING + 1.05 * weight
    shares = rows_text(sorted(forces.items(), key=lambda item: (-item[1], item[0])))
    own = 0.0 if parameters.subtract_own_weight else own_weight
    return PadReading(force, partners, centre, area, on_its_back, shares, own)


# Presets of commercial force-sensing resistors, each with its load resistor.

# The sheet covers the whole series with one curve and one table: "one standard deviation/mean,
# at 1000 g", hysteresis on average, drift as an upper bound, of which half is taken.
SHEET = "Interlink FSR 400 series data sheet, PDS-10004"
PDS_10004 = f"{SHEET}. Assumed: drift, half of its upper bound"
# The other parts of the series have a rim too; what it carries was measured with an FSR 402 only.
NO_RIM = "Assumed: nothing presses on the rim"
RIM = "Measured: the share of the rim (ekaeoq/uartfsr, one part in a mount that presses already)"
FSR_400_SERIES = {
    "resistor": "FSR_402",
    "force_min": 0.2,
    "force_max": 20.0,
    "unloaded_resistance": 10e6,
    "hysteresis": 0.10,
    "drift": 0.025,
    "part_spread": 0.06,
    "repeatability": 0.02,
    "overall_area": 0.0,
    "rim_force": 1.75,
}
IDEAL = {
    "hysteresis": 0.0,
    "drift": 0.0,
    "part_spread": 0.0,
    "repeatability": 0.0,
    "overall_area": 0.0,
}
FSR_402 = {**FSR_400_SERIES, "area": 1.267e-4, "overall_area": 2.625e-4}


def _with_load(part: Mapping[str, Any], ohms: float) -> dict[str, Any]:
    """Return a part's parameters in a 5 V divider with a load resistor of `ohms`."""
    return {"threshold": 1.0, **part, "load_resistor": ohms, "supply_voltage": 5.0}


# Pads whose switch closes at a force, and which measure none: resistance, voltage and ADC of their
# samples belong to an ideal FSR 402, and mean nothing.
POUND_FORCE = 4.4482
INCH = 0.0254
SMART_CAREGIVER = (
    "All Sensors, Pressure Sensing Floor Mats (allsensors.com/blog), on pads of Smart Caregiver: "
    "{} × {} inch, at least 35 lbs. A switch: resistance and voltage mean nothing. Assumed: it "
    "closes wherever the force acts, and opens at the same force"
)


def _switch_pad(identifier: str, label: str, inches: tuple[int, int]) -> Preset:
    wide, long = inches
    values = _with_load({**FSR_402, **IDEAL}, 10_000.0)
    values |= {"area": wide * long * INCH**2, "threshold": round(35.0 * POUND_FORCE, 1)}
    return Preset(identifier, label, values, SMART_CAREGIVER.format(wide, long))


PRESETS: tuple[Preset, ...] = (
    Preset(
        "PAD",
        "Any pad (no part)",
        {
            **_with_load({**FSR_402, **IDEAL}, 10_000.0),
            "subtract_own_weight": True,
            "noise_sigma": 0.0,
        },
        "no product: a pad of any size that measures every force, from the thesis behind this "
        "extension; the resistor is an ideal FSR 402",
    ),
    _switch_pad("SMART_CAREGIVER_CHAIR", "Smart Caregiver chair pad (25 × 38 cm)", (10, 15)),
    _switch_pad("SMART_CAREGIVER_MAT", "Smart Caregiver floor mat (61 × 122 cm)", (24, 48)),
    Preset(
        "FSR_402_IDEAL",
        "FSR 402, ideal part, 10 kΩ",
        _with_load({**FSR_402, **IDEAL}, 10_000.0),
        f"typical curve alone, without drift and spread: {SHEET}. {NO_RIM}",
    ),
    Preset(
        "FSR_402",
        "FSR 402, 10 kΩ",
        _with_load(FSR_402, 10_000.0),
        f"{PDS_10004}. {RIM}. Load resistor of Adafruit's FSR guide",
    ),
    Preset(
        "FSR_402_3K3",
        "FSR 402, 3.3 kΩ (heavy loads)",
        _with_load(FSR_402, 3_300.0),
        f"{PDS_10004}. {RIM}. Load resistor of SparkFun's Force Sensitive Resistor Hookup Guide",
    ),
    Preset(
        "FSR_402_47K",
        "FSR 402, 47 kΩ (force switch)",
        _with_load(FSR_402, 47_000.0),
        f"{PDS_10004}. {RIM}. Load resistor of the threshold switch in Interlink's FSR "
        "Integration Guide",
    ),
    Preset(
        "FSR_402_100K",
        "FSR 402, 100 kΩ (light touch)",
        _with_load(FSR_402, 100_000.0),
        f"{PDS_10004}. {RIM}. Load resistor for less than 100 g of Sensitronics' note AN-1",
    ),
    Preset(
        "FSR_400",
        "FSR 400, 10 kΩ",
        _with_load({**FSR_400_SERIES, "area": 2.043e-5}, 10_000.0),
        f"5.1 mm diameter, {PDS_10004}. {NO_RIM}. Load resistor of Adafruit's FSR guide",
    ),
    Preset(
        "FSR_406",
        "FSR 406, 10 kΩ",
        _with_load({**FSR_400_SERIES, "area": 1.452e-3}, 10_000.0),
        f"38.1 mm square, {PDS_10004}. {NO_RIM}. Load resistor of Adafruit's FSR guide",
    ),
)


FORCE = Field(
    "force_n",
    float,
    "N",
    2,
    step="report_step",
    quantity="force",
    tip="Force on the pad, along its +Z axis",
)


def cause(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: what presses on the pad, or did before."""
    names = [name for name, _ in rows_of(track.evidence.value("shares", index))]
    if not names and index:
        names = split(track.columns["partners"][index - 1])
    return measured_cause(track, index, names)


KIND = Kind(
    "PRESSURE",
    3,
    "Pressure sensor",
    "Pressure sensor under furniture",
    "TRIA_DOWN_BAR",
    "pressure",
    1.0,
    "Pressed",
    "Free",
    PressureParameters,
    events=(
        Field(
            "pressed", bool, quantity="occupancy", tip="Whether the force is above the threshold"
        ),
        FORCE,
        Field(
            "partners",
            str,
            quantity="names",
            tip="Names of the objects that press the pad, with semicolons",
        ),
        Field(
            "valid",
            bool,
            quantity="validity",
            tip="Whether the contacts explain the loads, so that the force can be relied on",
        ),
    ),
    samples=(
        FORCE,
        Field("pressed", bool),
        Field("valid", bool),
        Field("residual", float, tip="Greatest share of a body's load that no contact explains"),
        Field("resistance_ohm", float, "Ω", tip="Resistance of the force resistor"),
        Field("voltage_v", float, "V", 2, tip="Voltage of the divider"),
        Field("adc", int, tip="Reading of the converter that measures the voltage"),
        Field("partners", str),
        Field("cop_x_m", float, "m", 3, tip="Centre of pressure along the pad's X axis"),
        Field("cop_y_m", float, "m", 3, tip="Centre of pressure along the pad's Y axis"),
        Field("problem", str, tip="Why the reading is not valid; empty if it is"),
    ),
    evidence=(
        Field("shares", str, tip="Objects that press on the pad, with their forces in N"),
        Field("own_weight_n", float, "N", tip="The pad's own weight in the force"),
    ),
    cause=cause,
    model=PressurePad,
    needs={FORCES: ()},
    presets=PRESETS,
    part="SMART_CAREGIVER_CHAIR",
)
