# SPDX-License-Identifier: GPL-3.0-or-later
"""Light sensor: luminance of four views in percent, or illuminance in lux, and what is behind it.

The scene gives the light (`LightSample`); the model adds noise and what the part itself does: the
slowness of a photoresistor, its divider, or the counts of a digital part; a comparator with
hysteresis then says whether it is lit.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Any

from ...kind import LIGHT
from ...model import LightSample, Model, Reading, Update
from ...parameters import READING, Choice, Parameters, parameter
from ...quantities import METRES, Lengths
from .photoresistor import conductance, divided, equivalent_lux, follow

THESIS = "camera sensor of the thesis's Gazebo plugin"
GL5528 = "GL5528 data sheet"
BH1750 = "BH1750FVI data sheet"
LUX = ("method", "ILLUMINANCE")
FOUR_WALL: dict[str, Any] = {"used_when": (("method", "FOUR_WALL"),)}
ILLUMINANCE: dict[str, Any] = {"used_when": (LUX,)}
RESISTOR: dict[str, Any] = {"used_when": (LUX, ("output", "RESISTOR"))}
DIGITAL: dict[str, Any] = {"used_when": (LUX, ("output", "DIGITAL"))}


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
        0.5, "Clip start", "Nearer than this is not seen", unit="m", source=THESIS, **FOUR_WALL
    )
    clip_end: float = parameter(
        5.0,
        "Clip end",
        "How far the views see",
        unit="m",
        positive=True,
        source=THESIS,
        **FOUR_WALL,
    )
    field_of_view: float = parameter(
        0.02,
        "Field of view",
        "Angle of each of the four views",
        unit="rad",
        positive=True,
        maximum=math.pi,
        source=THESIS,
        **FOUR_WALL,
    )
    exposure: float = parameter(
        1.0, "Exposure", "Radiance that reads 100 % is one over this", **FOUR_WALL
    )
    threshold: float = parameter(
        50.0,
        "Threshold",
        "Lit above this reading: percent, or lux, as the method reads",
        unit=READING,
    )
    report_step: float = parameter(
        1.0,
        "Report step",
        "The event log tells of the reading when it changed by this much",
        unit=READING,
        short="Report by",
    )
    hysteresis: float = parameter(
        0.0,
        "Hysteresis",
        "Difference of the readings at which it turns lit and dark, about the threshold",
        unit=READING,
    )
    output: str = parameter(
        "RESISTOR",
        "Output",
        "What stands behind the light-sensitive face",
        choices=(
            Choice("RESISTOR", "Photoresistor", "A light-dependent resistor in a divider", 0),
            Choice("DIGITAL", "Digital", "A light-to-digital part that counts lux", 1),
        ),
        **ILLUMINANCE,
    )
    gamma: float = parameter(
        0.7,
        "Gamma",
        "Slope of the resistance over the light, both logarithmic",
        positive=True,
        source="0.6 ± 0.1, GL55 series manual",
        **RESISTOR,
    )
    resistance_10lux: float = parameter(
        14_000.0,
        "Resistance at 10 lux",
        "Resistance of the photoresistor at 10 lux",
        unit="Ω",
        positive=True,
        source="8–20 or 10–20 kΩ, GL5528 data sheets",
        short="At 10 lux",
        **RESISTOR,
    )
    dark_resistance: float = parameter(
        1_000_000.0,
        "Dark resistance",
        "Resistance of the photoresistor in the dark",
        unit="Ω",
        positive=True,
        source=GL5528,
        short="Dark",
        **RESISTOR,
    )
    rise_time: float = parameter(
        0.02,
        "Rise time",
        "Time constant with which it follows a light that grows",
        unit="s",
        source="20 ms, " + GL5528,
        **RESISTOR,
    )
    fall_time: float = parameter(
        0.03,
        "Fall time",
        "Time constant with which it follows a light that fades",
        unit="s",
        source="30 ms, " + GL5528,
        **RESISTOR,
    )
    load_resistor: float = parameter(
        10_000.0,
        "Load resistor",
        "Fixed resistor of the divider",
        unit="Ω",
        positive=True,
        short="Load",
        **RESISTOR,
    )
    supply_voltage: float = parameter(
        5.0,
        "Supply voltage",
        "Voltage of the divider",
        unit="V",
        positive=True,
        short="Supply",
        **RESISTOR,
    )
    lux_max: float = parameter(
        65535.0 / 1.2,
        "Full scale",
        "Most light that the digital part can tell",
        unit="lx",
        positive=True,
        source=BH1750,
        **DIGITAL,
    )
    lux_step: float = parameter(
        1.0 / 1.2,
        "Step",
        "Light of one count of the digital part; 0: no steps",
        unit="lx",
        source=BH1750,
        **DIGITAL,
    )
    integration_time: float = parameter(
        0.12,
        "Integration time",
        "The digital part tells the mean light of this long",
        unit="s",
        source=BH1750,
        short="Integration",
        **DIGITAL,
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on the reading", unit=READING
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        four = self.method == "FOUR_WALL"
        return self.must_be_smaller("clip_start", "clip_end", lengths) if four else []


class LightSensor(Model):
    """The state of one sensor: its photoresistor or its integration, and its comparator."""

    def __init__(self) -> None:
        self._time: float | None = None
        self._siemens = 0.0
        self._window: deque[tuple[float, float]] = deque()
        self._lit: bool | None = None

    def update(self, parameters: LightParameters, update: Update) -> Reading:
        sample: LightSample = update.ask(LIGHT)
        dt = 0.0 if self._time is None else max(update.time - self._time, 0.0)
        fields: dict[str, Any] = {
            "luminance_percent": None,
            "illuminance_lux": None,
            "resistance_ohm": None,
            "voltage_v": None,
            "note": sample.note,
        }
        if parameters.method == "FOUR_WALL":
            percent = self._noisy(sample.luminance_percent, parameters, update)
            value = fields["luminance_percent"] = min(percent, 100.0)
            decides = value
        else:
            lux = self._noisy(sample.illuminance_lux, parameters, update)
            if parameters.output == "RESISTOR":
                value = fields["illuminance_lux"] = lux
                decides = self._resistor(parameters, lux, dt, fields)
            else:
                value = fields["illuminance_lux"] = self._digital(parameters, lux, dt)
                decides = value
        self._time = update.time
        fields["lit"] = self._compare(parameters, decides)
        return Reading(fields["lit"], value, fields)

    @staticmethod
    def _noisy(light: float | None, parameters: LightParameters, update: Update) -> float:
        if light is None or math.isnan(light):
            raise ValueError(f"no light was measured by the method {parameters.method}")
        if parameters.noise_sigma > 0.0:
            light += float(update.noise().normal(0.0, parameters.noise_sigma))
        return max(light, 0.0)

    def _resistor(
        self, parameters: LightParameters, lux: float, dt: float, fields: dict[str, Any]
    ) -> float:
        """The light that the photoresistor shows, in lux; it starts at rest."""
        curve = parameters.resistance_10lux, parameters.gamma, parameters.dark_resistance
        target = conductance(lux, *curve)
        if self._time is None:
            self._siemens = target
        self._siemens = follow(
            self._siemens, target, dt, parameters.rise_time, parameters.fall_time
        )
        fields["resistance_ohm"] = 1.0 / self._siemens
        fields["voltage_v"] = divided(
            parameters.supply_voltage, parameters.load_resistor, 1.0 / self._siemens
        )
        # At rest it is the light itself, without the rounding of the way there and back.
        return lux if self._siemens == target else equivalent_lux(self._siemens, *curve)

    def _digital(self, parameters: LightParameters, lux: float, dt: float) -> float:
        """The lux that the part tells: mean over its integration time, in whole counts.

        Each light is taken to have held since the update before; the first one, for ever.
        """
        span = parameters.integration_time
        self._window.append((dt if self._time is not None else math.inf, lux))
        left, total = span, 0.0
        keep = 0
        for held, light in reversed(self._window):
            keep += 1
            part = min(held, left)
            total += part * light
            left -= part
            if left <= 0.0:
                break
        while len(self._window) > max(keep, 1):
            self._window.popleft()
        mean = total / span if span > 0.0 else lux
        mean = min(mean, parameters.lux_max)
        if parameters.lux_step > 0.0:
            # A hair, so that a whole count is not lost to rounding.
            mean = math.floor(mean / parameters.lux_step * (1.0 + 1e-12)) * parameters.lux_step
        return mean

    def _compare(self, parameters: LightParameters, light: float) -> bool:
        half = parameters.hysteresis / 2
        if self._lit is None:
            self._lit = light > parameters.threshold
        elif light > parameters.threshold + half:
            self._lit = True
        elif light <= parameters.threshold - half:
            self._lit = False
        return self._lit
