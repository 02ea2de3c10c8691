# SPDX-License-Identifier: GPL-3.0-or-later
"""Light sensor: luminance of four walls, or illuminance, and the circuit behind the sensing part.

- Model: `LightSensor`, with its photoresistor, parameters and presets in this file.
- Scene: angen_addon/scene/light/, beginning with probe.py; `LightChanges` in
  angen_addon/scene/changes.py tells when light must be measured again.
- Interface: angen_addon/kinds/light.py.
- Physics: docs/light.md; how light is measured: docs/light_how.md.
- Tests: tests/pure/test_light.py, tests/blender/test_light_*.py.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from .. import physics
from ..evidence import Cause, measured_cause, rows_of, rows_text
from ..kind import LIGHT, Field, Kind, Preset
from ..logs.wording import METRES, Advice, Lengths
from ..model import LightSample, LightShare, Model, Reading, Update
from ..parameters import READING, Choice, FormerChoice, Parameters, parameter

# Photoresistor (LDR): its resistance as a function of light, and its response to changes.

REFERENCE_LUX = 10.0


def conductance(lux: float, resistance_10lux: float, gamma: float, dark_resistance: float) -> float:
    """Return the conductance in S at a constant illuminance E: 1/R_dark + (E / 10 lx)^γ / R10.

    Parameters
    ----------
    lux
        The illuminance E in lux.
    resistance_10lux
        The resistance R10 at 10 lux in ohms.
    gamma
        γ = log10(R at 10 lx / R at 100 lx), as in data sheets; it does not hold near darkness.
    dark_resistance
        The resistance R_dark in ohms.
    """
    return 1.0 / dark_resistance + math.pow(max(lux, 0.0) / REFERENCE_LUX, gamma) / resistance_10lux


def equivalent_lux(
    siemens: float, resistance_10lux: float, gamma: float, dark_resistance: float
) -> float:
    """Return the constant illuminance in lux at which `conductance` is `siemens`."""
    of_light = (siemens - 1.0 / dark_resistance) * resistance_10lux
    return REFERENCE_LUX * math.pow(max(of_light, 0.0), 1.0 / gamma)


def follow(before: float, target: float, dt: float, rise: float, fall: float) -> float:
    """Return the conductance after `dt` s of exponential approach from `before` to `target`.

    The time constant in s is `rise` if the conductance grows, else `fall`. The result is exact for
    light that is constant during `dt`.
    """
    constant = rise if target > before else fall
    return target + (before - target) * math.exp(-dt / constant) if constant > 0.0 else target


# The parameters and the model.
#
# The scene gives the light (`LightSample`). The model adds noise and the circuit: the time
# constants of a photoresistor and its voltage divider, or the counts of a digital part. A
# comparator with hysteresis then decides whether the sensor is lit.

THESIS = "camera sensor of the Gazebo plugin from the thesis behind this extension"
GL5528 = "GL5528 data sheet"
BH1750 = "BH1750FVI data sheet"
LUX = ("method", "ILLUMINANCE")
FOUR_WALL: dict[str, Any] = {"used_when": (("method", "FOUR_WALL"),)}
ILLUMINANCE: dict[str, Any] = {"used_when": (LUX,)}
RESISTOR: dict[str, Any] = {"used_when": (LUX, ("output", "RESISTOR"))}
DIGITAL: dict[str, Any] = {"used_when": (LUX, ("output", "DIGITAL"))}


@dataclass(frozen=True)
class LightParameters(Parameters):
    """The parameters of a light sensor."""

    method: str = parameter(
        "FOUR_WALL",
        "Method",
        "Which quantity the sensor measures",
        choices=(
            Choice("FOUR_WALL", "Four walls", "Luminance of four views, in percent", 0),
            Choice("ILLUMINANCE", "Illuminance", "Light on the sensor's face, in lux", 1),
        ),
    )
    engine: str = parameter(
        "CYCLES",
        "Engine",
        "How the light is computed",
        choices=(
            Choice("CYCLES", "Cycles", "Path tracing", 0),
            Choice("EEVEE", "EEVEE", "Rasterising; needs a GPU", 1),
        ),
        former=(FormerChoice("DIRECT", 2, "CYCLES"),),
    )
    samples: int = parameter(
        1024, "Samples", "Light paths per reading", minimum=1, maximum=1_000_000
    )
    clip_start: float = parameter(
        0.5,
        "Clip start",
        "Views do not show surfaces nearer than this",
        unit="m",
        source=THESIS,
        **FOUR_WALL,
    )
    clip_end: float = parameter(
        5.0,
        "Clip end",
        "Views do not show surfaces farther than this",
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
        1.0, "Exposure", "A radiance of 1/exposure reads 100 %", **FOUR_WALL
    )
    threshold: float = parameter(
        50.0,
        "Threshold",
        "The output lit goes on above this reading, in percent or lux, depending on the method",
        unit=READING,
    )
    report_step: float = parameter(
        1.0,
        "Report step",
        "Least change of the reading that the event log records",
        unit=READING,
        short="Report by",
    )
    hysteresis: float = parameter(
        0.0,
        "Hysteresis",
        "Difference between the readings at which the output goes on and off, half of it above "
        "and half below the threshold",
        unit=READING,
    )
    output: str = parameter(
        "RESISTOR",
        "Output",
        "Circuit that measures the light",
        choices=(
            Choice(
                "RESISTOR", "Photoresistor", "A light-dependent resistor in a voltage divider", 0
            ),
            Choice("DIGITAL", "Digital", "A digital light sensor that counts lux", 1),
        ),
        **ILLUMINANCE,
    )
    gamma: float = parameter(
        0.7,
        "Gamma",
        "Slope of the resistance over the illuminance, both on logarithmic scales",
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
        "Time constant of the photoresistor for rising light",
        unit="s",
        source="20 ms, " + GL5528,
        **RESISTOR,
    )
    fall_time: float = parameter(
        0.03,
        "Fall time",
        "Time constant of the photoresistor for falling light",
        unit="s",
        source="30 ms, " + GL5528,
        **RESISTOR,
    )
    load_resistor: float = parameter(
        10_000.0,
        "Load resistor",
        "Fixed resistor of the voltage divider",
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
        "Highest illuminance that the digital part can report",
        unit="lx",
        positive=True,
        source=BH1750,
        **DIGITAL,
    )
    lux_step: float = parameter(
        1.0 / 1.2,
        "Step",
        "Illuminance of one count of the digital part; 0: no steps",
        unit="lx",
        source=BH1750,
        **DIGITAL,
    )
    integration_time: float = parameter(
        0.12,
        "Integration time",
        "The digital part reports the mean illuminance over this time",
        unit="s",
        source=BH1750,
        short="Integration",
        **DIGITAL,
    )
    noise_sigma: float = parameter(
        0.0, "Noise", "Standard deviation of the noise on the reading", unit=READING
    )
    noise_share: float = parameter(
        0.0,
        "Noise share",
        "Standard deviation of the noise as a share of the reading, besides Noise: that of lamps "
        "on the mains, and of the part",
        maximum=0.5,
        source="measured: with steps of 1 lx, 0.5 to 1.0 % of readings of 50 to 250 lx, five "
        "sensors in two lamp-lit offices",
    )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return a sentence if the clip distances of the four views contradict each other."""
        four = self.method == "FOUR_WALL"
        return self.must_be_smaller("clip_start", "clip_end", lengths) if four else []

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if the output never switches on, or if it never switches off."""
        half, unit, most = self.hysteresis / 2, "lx", math.inf
        if self.method == "FOUR_WALL":
            unit, most = "%", 100.0
        elif self.output == "DIGITAL":
            most = self.lux_max
        on, off = self.threshold + half, self.threshold - half
        if on >= most:
            return [
                Advice(
                    f"The output lit goes on above {on:g} {unit}, but the sensor reads at most "
                    f"{most:g} {unit}: once off, lit stays off",
                    "Lower the threshold or the hysteresis",
                )
            ]
        if off < 0.0:
            return [
                Advice(
                    f"Half the hysteresis ({half:g} {unit}) is more than the threshold "
                    f"({self.threshold:g} {unit}): once on, lit stays on in the dark",
                    "Raise the threshold or lower the hysteresis",
                )
            ]
        return []


class LightSensor(Model):
    """Model of one light sensor.

    Its state is the state of its photoresistor or integrator, and of its comparator.
    """

    def __init__(self) -> None:
        self._time: float | None = None
        self._siemens = 0.0
        self._window: deque[tuple[float, float]] = deque()
        self._lit: bool | None = None

    def update(self, parameters: LightParameters, update: Update) -> Reading:
        """Return the luminance or illuminance, the circuit's outputs, and the state `lit`."""
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
            compared = value
        else:
            lux = self._noisy(sample.illuminance_lux, parameters, update)
            if parameters.output == "RESISTOR":
                value = fields["illuminance_lux"] = lux
                compared = self._resistor(parameters, lux, dt, fields)
            else:
                value = fields["illuminance_lux"] = self._digital(parameters, lux, dt)
                compared = value
        self._time = update.time
        fields["lit"] = self._compare(parameters, compared)
        shares = ((share.names, share.source, share.light) for share in sample.shares or ())
        evidence = {"shares": rows_text(shares), "note": sample.note}
        return Reading(fields["lit"], value, fields, evidence)

    @staticmethod
    def _noisy(light: float | None, parameters: LightParameters, update: Update) -> float:
        if light is None or math.isnan(light):
            raise ValueError(f"no light was measured by the method {parameters.method}")
        sigma = math.hypot(parameters.noise_sigma, parameters.noise_share * light)
        if sigma > 0.0:
            light += float(update.noise().normal(0.0, sigma))
        return max(light, 0.0)

    def _resistor(
        self, parameters: LightParameters, lux: float, dt: float, fields: dict[str, Any]
    ) -> float:
        """Store resistance and voltage in `fields`, and return the apparent illuminance in lux.

        The apparent illuminance is the constant illuminance that would give the photoresistor its
        present conductance. At the first update, the light counts as constant.
        """
        curve = parameters.resistance_10lux, parameters.gamma, parameters.dark_resistance
        target = conductance(lux, *curve)
        if self._time is None:
            self._siemens = target
        self._siemens = follow(
            self._siemens, target, dt, parameters.rise_time, parameters.fall_time
        )
        fields["resistance_ohm"] = 1.0 / self._siemens
        fields["voltage_v"] = physics.voltage(
            parameters.supply_voltage, parameters.load_resistor, 1.0 / self._siemens
        )
        # In the steady state, return `lux` itself, without rounding errors of the inverse.
        return lux if self._siemens == target else equivalent_lux(self._siemens, *curve)

    def _digital(self, parameters: LightParameters, lux: float, dt: float) -> float:
        """Return the illuminance in lux that the digital part reports.

        It is the mean over the integration time, in whole counts. Each sample is weighted by the
        time since the previous update. Light before the first update counts as equal to the first
        sample.
        """
        span = parameters.integration_time
        self._window.append((dt if self._time is not None else math.inf, lux))
        left, total = span, 0.0
        used = 0
        for duration, light in reversed(self._window):
            used += 1
            part = min(duration, left)
            total += part * light
            left -= part
            if left <= 0.0:
                break
        while len(self._window) > used:
            self._window.popleft()
        mean = total / span if span > 0.0 else lux
        mean = min(mean, parameters.lux_max)
        if parameters.lux_step > 0.0:
            # The factor prevents rounding errors from losing a whole count.
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


# Presets of commercial light sensors, and of the thesis.
#
# A preset sets only parameters of the part that its source gives; for a range, the middle.

MANUAL = (
    "GL55 Series CdS Photoresistor Manual, p. 2 (10 lx of 2856 K after 2 h at 400 to 600 lx; dark "
    "10 s after 10 lx; gamma = lg(R10/R100)); the table does not name its rows, so they are taken "
    "in order"
)
CURVE = (
    "resistances as traded (10 lx; dark); gamma from the curve lux = a / ohm^b of the "
    "Arduino-Light-Dependent-Resistor-Library by Quentin Comte-Gaz, 1/b; no response times known"
)
NO_NOISE = "Assumed: no noise"
# With the steps of a BH1750, readings of 50 to 150 lx then vary by 0.5 to 0.7 %, and 30 to 70 % of
# them equal the one before. Measured: 0.7 ± 0.35 %, and 45 to 70 %.
NOISE_SHARE = 0.005
NOISE = (
    "Measured: the noise, of five lux sensors of unknown type in lamp-lit offices "
    "(Room-Occupancy-Estimation, UCI 864; LuisM78/Occupancy-detection-data). Assumed: that this "
    "part's is the same"
)


def _part(name: str, values: dict[str, Any], source: str) -> Preset:
    return Preset(name.upper().replace("-", "_"), name, values, source)


def _resistor(
    name: str, kilo: tuple[float, float], dark_mega: float, gamma: float, rise_fall_ms: Any = ()
) -> Preset:
    low, high = kilo
    values = {
        "method": "ILLUMINANCE",
        "output": "RESISTOR",
        "resistance_10lux": 500.0 * (low + high),
        "dark_resistance": dark_mega * 1e6,
        "gamma": gamma,
        "noise_share": 0.0,
    }
    for key, ms in zip(("rise_time", "fall_time"), rise_fall_ms, strict=False):
        values[key] = ms / 1000.0
    source = MANUAL if rise_fall_ms else CURVE
    return _part(name, values, f"{low:g}–{high:g} kΩ: {source}. {NO_NOISE}")


def _digital(name: str, step: float, full: float, seconds: float, source: str) -> Preset:
    values = {
        "method": "ILLUMINANCE",
        "output": "DIGITAL",
        "lux_step": step,
        "lux_max": full,
        "integration_time": seconds,
        "noise_share": NOISE_SHARE,
    }
    return _part(name, values, f"{source}. {NOISE}")


PRESETS: tuple[Preset, ...] = (
    Preset(
        "THESIS",
        "Thesis (Gazebo cameras that look at four walls)",
        {
            "method": "FOUR_WALL",
            "clip_start": 0.5,
            "clip_end": 5.0,
            "field_of_view": 0.02,
            "noise_sigma": 0.0,
            "noise_share": 0.0,
        },
        "camera sensor of the Gazebo plugin from the thesis behind this extension",
    ),
    _resistor("GL5516", (5.0, 10.0), 0.5, 0.5, (30.0, 30.0)),
    _resistor("GL5528", (10.0, 20.0), 1.0, 0.6, (20.0, 30.0)),
    _resistor("GL5537-1", (20.0, 30.0), 2.0, 0.6, (20.0, 30.0)),
    _resistor("GL5537-2", (30.0, 50.0), 3.0, 0.85),
    _resistor("GL5539", (50.0, 100.0), 5.0, 0.8, (20.0, 30.0)),
    _resistor("GL5549", (100.0, 200.0), 10.0, 0.78),
    _digital(
        "BH1750FVI",
        1.0 / 1.2,
        65535.0 / 1.2,
        0.12,
        "ROHM BH1750FVI technical note, 2009.04 Rev. B: H-resolution mode, 1.2 counts a lux "
        "typical, 16 bit, 120 ms typical",
    ),
    _digital(
        "TSL2561",
        0.1,
        40_000.0,
        0.402,
        "0.1 to 40 000 lx and 402 ms as in Raspberry Connect's description of the breakout board; "
        "the step is its resolution at high gain",
    ),
    _digital(
        "TSL2591",
        408.0 / (100.0 * 25.0),
        408.0 / (100.0 * 25.0) * 36863,
        0.1,
        "driver of Adafruit (Adafruit_TSL2591): 408 / (100 ms × gain 25) lx a count without "
        "infrared light, at most 36863 counts in 100 ms",
    ),
    _digital(
        "VEML7700",
        0.0576,
        0.0576 * 65535,
        0.1,
        "drivers of Adafruit (Adafruit_VEML7700) and ESPHome: 0.0036 lx a count at gain 2 and "
        "800 ms, so 0.0576 lx at gain 1 and 100 ms, 16 bit; others say 0.0042 instead of 0.0036",
    ),
)


PERCENT = Field(
    "luminance_percent",
    float,
    "%",
    1,
    step="report_step",
    quantity="luminance",
    tip="Mean brightness of the four views",
    **FOUR_WALL,
)
LUX_FIELD = Field(
    "illuminance_lux",
    float,
    "lx",
    step="report_step",
    quantity="illuminance",
    tip="Illuminance of the sensor's face, as the sensor reports it",
    **ILLUMINANCE,
)
# A lamp counts as changed if its light changed by more than this fraction of all light.
NOTABLE = 0.01


def shares_at(track: Any, index: int) -> tuple[LightShare, ...]:
    """Return the light of each source at an update; empty if they cannot be told apart."""
    rows = rows_of(track.evidence.value("shares", index)) if index >= 0 else ()
    return tuple(LightShare(tuple(names), source, light) for names, source, light in rows)


def given(shares: Iterable[LightShare]) -> float:
    """Return the total light of all sources except negative lamps, which take light away."""
    return sum(max(share.light, 0.0) for share in shares)


def most_changed(track: Any, index: int) -> tuple[LightShare, LightShare] | None:
    """Return the source whose light changed most: its light at the update before and at this one.

    Return None if no light changed notably.
    """
    now, before = shares_at(track, index), shares_at(track, index - 1)
    if not before or not now:
        return None
    then, since = ({(s.names, s.source): s for s in found} for found in (before, now))
    pairs = [
        (then.get(key, LightShare(*key, 0.0)), since.get(key, LightShare(*key, 0.0)))
        for key in dict.fromkeys([*since, *then])
    ]
    best = max(pairs, key=lambda pair: abs(pair[1].light - pair[0].light))
    whole = max(given(now), given(before), 1e-9)
    return best if abs(best[1].light - best[0].light) > NOTABLE * whole else None


def cause(track: Any, index: int) -> Cause:
    """Return the cause of update `index` of a `Track`: the source whose light changed most."""
    found = most_changed(track, index)
    if found is None:
        return measured_cause(track, index, ())
    before, after = found
    measure = track.reading_at(index).name
    return Cause(after.names, after.source, measure, before.light, after.light)


KIND = Kind(
    "LIGHT",
    4,
    "Light sensor",
    "Light sensor: luminance or illuminance",
    "LIGHT_SUN",
    "light",
    1.0,
    "Lit",
    "Dark",
    LightParameters,
    events=(
        PERCENT,
        LUX_FIELD,
        Field("lit", bool, quantity="light", tip="Whether the reading is above the threshold"),
    ),
    samples=(
        PERCENT,
        LUX_FIELD,
        Field("resistance_ohm", float, "Ω", tip="Resistance of the photoresistor"),
        Field("voltage_v", float, "V", 2, tip="Voltage of the divider"),
        Field("lit", bool),
    ),
    evidence=(
        Field(
            "shares",
            str,
            tip="Sources with the names of their lamps, and their light in the unit of the reading",
        ),
        Field("note", str, tip="A remark on the measured light"),
    ),
    cause=cause,
    model=LightSensor,
    needs={LIGHT: ()},
    in_room=True,
    presets=PRESETS,
    part="BH1750FVI",
)
