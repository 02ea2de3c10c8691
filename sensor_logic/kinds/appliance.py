# SPDX-License-Identifier: GPL-3.0-or-later
"""Smart plug: the power that an appliance draws, by whether it is used.

- Model: `SmartPlug`, with its parameters, the table of loads and the presets in this file.
- Scene: whether the watched object is in use, by angen_addon/scene/uses.py.
- Interface: angen_addon/kinds/appliance.py.
- Physics: docs/appliance.md.
- Tests: tests/pure/test_flow_and_appliance.py, tests/blender/test_flow_appliance.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kind import USES, Field, Kind, Preset
from ..logs.wording import METRES, Advice, Lengths, typed
from ..model import Array, Model, Readings, Updates
from ..parameters import Choice, Parameters, parameter
from ..use import Span, UseHistory, device_error, is_within

WHILE_USED, SWITCHED, LINGERS, PROGRAMME = "WHILE_USED", "SWITCHED", "LINGERS", "PROGRAMME"
CUSTOM = "CUSTOM"


@dataclass(frozen=True)
class ApplianceLoad:
    """What an appliance draws.

    Attributes
    ----------
    works
        When it works: a choice of the parameter `works`.
    phases
        Duration in s and power in W of each phase of its work, in order. The last phase lasts until
        the work ends; the others are those of a programme.
    standby
        The power in W while it does not work.
    runs
        For how long it goes on after a use, s. Of a programme, the duration of all phases.
    source
        Where the figures are from.
    """

    works: str
    phases: tuple[tuple[float, float], ...]
    standby: float
    runs: float
    source: str

    def power(self, seconds: Array) -> Array:
        """Return the power (n,) in W at times (n,) in s since the work began."""
        ends = np.cumsum([phase[0] for phase in self.phases])[:-1]
        watts = np.array([phase[1] for phase in self.phases])
        found: Array = watts[np.searchsorted(ends, seconds, side="right")]
        return found


DOE = "US Department of Energy, Estimating Appliance and Home Electronic Energy Use: "
STANDBY = ". Assumed: standby as Regulation (EU) 2023/826 allows at most"
LOADS: dict[str, ApplianceLoad] = {
    "MICROWAVE": ApplianceLoad(
        PROGRAMME,
        ((120.0, 1100.0),),
        0.8,
        120.0,
        f"{DOE}750 to 1100 W{STANDBY} with a clock, 2 min",
    ),
    "TOASTER": ApplianceLoad(
        PROGRAMME, ((150.0, 1000.0),), 0.0, 150.0, f"{DOE}800 to 1400 W. Assumed: 150 s, no standby"
    ),
    "KETTLE": ApplianceLoad(
        PROGRAMME,
        ((170.0, 2200.0),),
        0.0,
        170.0,
        "1 L from 20 to 100 °C takes 335 kJ. Assumed: 2200 W, nine tenths of it into the water",
    ),
    "COFFEE_MAKER": ApplianceLoad(
        PROGRAMME, ((360.0, 1000.0),), 0.0, 360.0, f"{DOE}900 to 1200 W. Assumed: 6 min, no standby"
    ),
    "TELEVISION": ApplianceLoad(
        SWITCHED,
        ((0.0, 133.0),),
        0.5,
        0.0,
        f"{DOE}36 inches, 133 W{STANDBY}",
    ),
    "STOVE": ApplianceLoad(
        LINGERS,
        ((0.0, 1500.0),),
        0.0,
        300.0,
        "Assumed: one plate of 1500 W, on until 5 min after somebody was last at it",
    ),
    "WASHING_MACHINE": ApplianceLoad(
        PROGRAMME,
        ((900.0, 2000.0), (3600.0, 150.0), (600.0, 400.0)),
        0.5,
        5100.0,
        f"{DOE}350 to 500 W (motor){STANDBY}; it heats for 15 min with 2000 W, washes for 60 min "
        "with 150 W, and spins for 10 min with 400 W",
    ),
    "DISHWASHER": ApplianceLoad(
        PROGRAMME,
        ((1200.0, 1800.0), (3000.0, 100.0), (900.0, 1800.0)),
        0.5,
        5100.0,
        f"{DOE}1200 to 2400 W while it heats{STANDBY}; it heats for 20 and for 15 min",
    ),
    "COMPUTER": ApplianceLoad(
        WHILE_USED, ((0.0, 60.0),), 0.5, 0.0, f"{DOE}laptop 50 W{STANDBY}; 10 W of a screen"
    ),
    "LAMP": ApplianceLoad(SWITCHED, ((0.0, 9.0),), 0.0, 0.0, "Assumed: an LED lamp of 9 W"),
}
TIPS = {name: f"{load.phases[0][1]:g} W. {load.source}" for name, load in LOADS.items()}
OWN = (("load", CUSTOM),)


@dataclass(frozen=True)
class ApplianceParameters(Parameters):
    """The parameters of a smart plug, and of the appliance in it."""

    watched: str | None = parameter(
        None,
        "Watches",
        "The appliance in the plug. Empty: the sensor's parent",
        pointer="Object",
    )
    load: str = parameter(
        CUSTOM,
        "Load",
        "What the appliance is: when it works, and the power that it draws",
        choices=(
            Choice(CUSTOM, "Custom", "Given below", 0),
            *(
                Choice(name, name.replace("_", " ").capitalize(), TIPS[name], number)
                for number, name in enumerate(LOADS, 1)
            ),
        ),
    )
    works: str = parameter(
        WHILE_USED,
        "Works",
        "When the appliance works",
        choices=(
            Choice(WHILE_USED, "While used", "As long as it is in use", 0),
            Choice(SWITCHED, "Switched", "Each use switches it on, and the next one off", 1),
            Choice(LINGERS, "Lingers", "While it is in use, and for some time after", 2),
            Choice(
                PROGRAMME,
                "Programme",
                "For some time once a use ends, whatever happens meanwhile",
                3,
            ),
        ),
        used_when=OWN,
    )
    power: float = parameter(
        100.0, "Power", "Power that it draws while it works", unit="W", used_when=OWN
    )
    standby_power: float = parameter(
        0.0,
        "Standby power",
        "Power that it draws otherwise",
        unit="W",
        short="Standby",
        used_when=OWN,
    )
    run_time: float = parameter(
        60.0,
        "Run time",
        "For how long it works after a use. Only for Lingers and Programme",
        unit="s",
        used_when=OWN,
    )
    threshold: float = parameter(
        5.0, "Threshold", "The output is on at this power or more", unit="W", positive=True
    )
    report_step: float = parameter(
        1.0,
        "Report step",
        "Least change of the power that the event log records",
        unit="W",
        short="Report by",
    )
    min_power: float = parameter(
        0.0, "Least power", "The plug reads 0 below this power", unit="W", short="Least"
    )
    max_power: float = parameter(
        3680.0,
        "Greatest power",
        "The plug reads at most this power",
        unit="W",
        positive=True,
        short="Greatest",
    )
    resolution: float = parameter(
        0.0, "Resolution", "Step of the measured power. 0: none", unit="W", short="Step"
    )
    accuracy: float = parameter(
        0.0,
        "Accuracy",
        "Largest error of the measured power, as a share of it. Each device has its own error, "
        "which stays the same",
        maximum=1.0,
    )
    noise_sigma: float = parameter(
        0.0, "Noise sigma", "Standard deviation of the measured power", unit="W", short="Noise"
    )

    @property
    def drawn(self) -> ApplianceLoad:
        """What the appliance draws: of the chosen load, or as the parameters say."""
        if self.load != CUSTOM:
            return LOADS[self.load]
        return ApplianceLoad(
            self.works, ((0.0, self.power),), self.standby_power, self.run_time, ""
        )

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return a sentence if the greatest power is not above the least."""
        return self.must_be_smaller("min_power", "max_power", lengths)

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if the output could never switch on, or never off."""
        load = self.drawn
        most = min(max(watts for _, watts in load.phases), self.max_power)
        limit = typed(self.threshold, "W")
        if most < self.threshold:
            text = f"The appliance draws at most {typed(most, 'W')}, and the threshold is {limit}"
            return [Advice(f"{text}: on never goes on", "Lower the threshold")]
        if load.standby >= self.threshold:
            text = f"The standby power is {typed(load.standby, 'W')}, and the threshold is {limit}"
            return [Advice(f"{text}: on never goes off", "Raise the threshold")]
        return []


def work_spans(load: ApplianceLoad, uses: list[Span]) -> list[Span]:
    """Return begin and end of each time of work in s, from begin and end of each use in s."""
    if load.works == WHILE_USED:
        return uses
    if load.works == LINGERS:
        return [(begin, end + load.runs) for begin, end in uses]
    found: list[Span] = []
    for begin, end in uses:
        if load.works == SWITCHED:
            if found and math.isinf(found[-1][1]):
                found[-1] = found[-1][0], begin
            else:
                found.append((begin, math.inf))
        elif math.isfinite(end) and not (found and end < found[-1][1]):
            found.append((end, end + load.runs))
    return found


def power_at(
    load: ApplianceLoad, uses: list[Span], times: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the power (n,) in W at times (n,) in s, and whether the appliance works (n,).

    `uses` has begin and end of each use in s, in order.
    """
    spans = work_spans(load, uses)
    works = is_within(spans, times)
    power: Array = np.full(len(times), load.standby)
    # A use that goes on while the appliance lingers does not begin its work anew.
    for begin, end in spans:
        during = (times >= begin) & (times < end)
        since = times[during] - begin if math.isfinite(begin) else np.full(during.sum(), math.inf)
        power[during] = load.power(since)
    return power, works


class SmartPlug(Model):
    """Model of one smart plug."""

    def __init__(self) -> None:
        self._history = UseHistory()

    def sense(self, parameters: ApplianceParameters, updates: Updates) -> Readings:
        """Return whether the appliance is on, and its power in W, at the updates that are due."""
        history, load = self._history, parameters.drawn
        history.observe(updates)
        times = updates.times[updates.due]
        power, works = power_at(load, history.uses, times)
        power *= device_error(parameters.accuracy, updates)
        if parameters.noise_sigma > 0.0:
            numbers = updates.numbers[updates.due].tolist()
            power += [updates.noise(k).normal(0.0, parameters.noise_sigma) for k in numbers]
        if parameters.resolution > 0.0:
            power = np.round(power / parameters.resolution) * parameters.resolution
        power = np.clip(power, 0.0, parameters.max_power)
        power[power < parameters.min_power] = 0.0
        is_on = power >= parameters.threshold
        if load.works == LINGERS or load.works == WHILE_USED:
            history.forget_before(float(updates.times[-1]) - load.runs)
        objects = [history.name if one else "" for one in works.tolist()]
        return Readings(is_on, power, {"on": is_on, "power_w": power}, evidence={"object": objects})


# Presets of commercial plugs; what is plugged in stays as it is.


def _plug(
    identifier: str, label: str, source: str, rate: float, most: float, accuracy: float, step: float
) -> Preset:
    """Return a preset of a plug that reads powers up to `most` W, in steps of `step` W."""
    values = {
        "threshold": 5.0,
        "min_power": 0.0,
        "max_power": most,
        "resolution": step,
        "accuracy": accuracy,
        "noise_sigma": 0.0,
    }
    return Preset(identifier, label, values, source, rate)


PRESETS: tuple[Preset, ...] = (
    _plug(
        "SHELLY_PLUG_S",
        "Shelly Plug S",
        "Shelly Plug S manual: 2500 W; its meter is a HLW8012 (labparvum.com), given as good to 2 "
        "to 3 %. Assumed: 3 %, 0.01 W as in its MQTT topic, a reading a second",
        1.0,
        2500.0,
        0.03,
        0.01,
    ),
    _plug(
        "HS110",
        "TP-Link HS110 (EU)",
        "TP-Link HS110 manual: 16 A, 3680 W; softscheck.com: its command get_realtime gives "
        "millionths of a watt; Sense asks every 2 s. Assumed: 1 %",
        0.5,
        3680.0,
        0.01,
        0.0,
    ),
    _plug(
        "KP115",
        "TP-Link KP115 (EU)",
        "TP-Link KP115 manual: 16 A, 3680 W; its command get_realtime gives milliwatts; Sense asks "
        "every 2 s. Assumed: 1 %",
        0.5,
        3680.0,
        0.01,
        0.001,
    ),
)


KIND = Kind(
    "APPLIANCE",
    9,
    "Smart plug",
    "Smart plug: the power that an appliance draws",
    "PLUGIN",
    "appliance",
    1.0,
    "On",
    "Off",
    ApplianceParameters,
    events=(
        Field("on", bool, quantity="operation", tip="Whether it draws at least the threshold"),
        Field(
            "power_w", float, "W", 1, step="report_step", quantity="power", tip="The measured power"
        ),
    ),
    samples=(
        Field("on", bool),
        Field("power_w", float, "W", 1, step="report_step", quantity="power"),
    ),
    evidence=(Field("object", str, tip="The appliance, while it works"),),
    model=SmartPlug,
    needs={USES: ()},
    presets=PRESETS,
    part="SHELLY_PLUG_S",
)
