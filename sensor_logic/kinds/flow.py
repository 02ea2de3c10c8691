# SPDX-License-Identifier: GPL-3.0-or-later
"""Water flow sensor: on the pipe of a tap or a shower, or of a cistern that fills after a flush.

- Model: `FlowSensor`, with its parameters and presets in this file.
- Scene: whether the watched object is in use, by angen_addon/scene/uses.py.
- Interface: angen_addon/kinds/flow.py.
- Physics: docs/flow.md.
- Tests: tests/pure/test_flow_and_appliance.py, tests/blender/test_flow_appliance.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..kind import USES, Field, Kind, Preset
from ..logs.wording import METRES, Advice, Lengths, typed
from ..model import Array, Model, Readings, Updates
from ..parameters import Choice, Parameters, parameter
from ..use import Span, UseHistory, device_error, is_within

WHILE_USED, AFTER_USE = "WHILE_USED", "AFTER_USE"
FLOW_UNIT = "L/min"


@dataclass(frozen=True)
class FlowParameters(Parameters):
    """The parameters of a water flow sensor, and of the water in its pipe."""

    watched: str | None = parameter(
        None,
        "Watches",
        "The tap, shower or toilet whose water flows through it. Empty: the sensor's parent",
        pointer="Object",
    )
    flows: str = parameter(
        WHILE_USED,
        "Flows",
        "When water flows",
        choices=(
            Choice(WHILE_USED, "While used", "A tap or a shower: as long as it is in use", 0),
            Choice(AFTER_USE, "After use", "A toilet: its cistern fills once the use ends", 1),
        ),
    )
    flow_rate: float = parameter(
        6.0,
        "Flow rate",
        "Water that flows. Basin taps: 4 to 6 L/min; showers: 6 to 12; valves of cisterns: 6 to 10",
        unit=FLOW_UNIT,
        short="Flow",
        positive=True,
        source="basin taps at most 6 L/min, showers 8 L/min: EU Ecolabel, Decision 2013/250/EU",
    )
    refill_volume: float = parameter(
        6.0,
        "Refill volume",
        "Water of one flush, which flows at the flow rate until the cistern is full",
        unit="L",
        short="Refill",
        positive=True,
        used_when=(("flows", AFTER_USE),),
        source="at most 6 L: EU Ecolabel, Decision 2013/641/EU",
    )
    min_flow: float = parameter(
        1.0,
        "Minimum flow",
        "The output is on at this flow or more. Data sheets: set point, actuation, or start of the "
        "range",
        unit=FLOW_UNIT,
        short="From",
    )
    response_time: float = parameter(
        0.0, "Response time", "The output follows the flow after this time, on and off", unit="s"
    )
    accuracy: float = parameter(
        0.0,
        "Accuracy",
        "Largest error of the measured flow, as a share of it. Each device has its own error, "
        "which stays the same",
        maximum=1.0,
    )
    noise_sigma: float = parameter(
        0.0, "Noise sigma", "Standard deviation of the measured flow", unit=FLOW_UNIT, short="Noise"
    )

    @property
    def refill_time(self) -> float:
        """The time in s for which a cistern fills after a use."""
        return 60.0 * self.refill_volume / self.flow_rate

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if the minimum flow is above the flow, so that the output stays off."""
        if self.flow_rate >= self.min_flow:
            return []
        least, flow = (typed(one, FLOW_UNIT) for one in (self.min_flow, self.flow_rate))
        return [
            Advice(
                f"The flow rate is {flow}, the minimum flow {least}: flowing never goes on",
                "Lower Minimum flow, or choose another part",
            )
        ]


def flow_spans(parameters: FlowParameters, uses: list[Span]) -> list[Span]:
    """Return begin and end of each flow of water in s, from begin and end of each use in s."""
    if parameters.flows == WHILE_USED:
        return uses
    return [(end, end + parameters.refill_time) for _, end in uses if math.isfinite(end)]


class FlowSensor(Model):
    """Model of one water flow sensor."""

    def __init__(self) -> None:
        self._history = UseHistory()

    def sense(self, parameters: FlowParameters, updates: Updates) -> Readings:
        """Return whether water flows, and how much in L/min, at the updates that are due."""
        history = self._history
        history.observe(updates)
        times, spans = updates.times[updates.due], flow_spans(parameters, history.uses)
        rate = parameters.flow_rate * device_error(parameters.accuracy, updates)
        flow: Array = np.where(is_within(spans, times), rate, 0.0)
        is_on = is_within(spans, times - parameters.response_time) & (rate >= parameters.min_flow)
        if parameters.noise_sigma > 0.0:
            numbers = updates.numbers[updates.due].tolist()
            noise = [updates.noise(k).normal(0.0, parameters.noise_sigma) for k in numbers]
            flow = np.maximum(flow + noise, 0.0)
        history.forget_before(
            float(updates.times[-1]) - parameters.refill_time - parameters.response_time
        )
        objects = [history.name if on else "" for on in is_on.tolist()]
        return Readings(
            is_on, flow, {"flowing": is_on, "flow_lpm": flow}, evidence={"object": objects}
        )


# Presets: what flows, and commercial sensors.

GALLON = 3.785411784  # L

KASTEREN = (
    "T. van Kasteren et al., Accurate activity recognition in a home setting, UbiComp 2008: a "
    "float in the cistern measures the flush. Assumed: it is down from the flush until the cistern "
    "is full; 6 L at 6 L/min"
)
GEMS = (
    "Gems Sensors catalogue, flow switches: {} series, set points from {} US gallons a minute. "
    "Assumed: this set point; it answers at once; it measures no flow, so the flow has no error"
)


def _part(
    identifier: str, label: str, source: str, least: float, accuracy: float, seconds: float
) -> Preset:
    """Return a preset of a sensor in a pipe; what flows in it stays as it is.

    `least` is the minimum flow in L/min, and `seconds` the response time.
    """
    values = {"min_flow": least, "accuracy": accuracy, "response_time": seconds, "noise_sigma": 0.0}
    return Preset(identifier, label, values, source)


PRESETS: tuple[Preset, ...] = (
    Preset(
        "CISTERN_FLOAT",
        "Float switch in a cistern",
        {
            "flows": AFTER_USE,
            "flow_rate": 6.0,
            "refill_volume": 6.0,
            "min_flow": 0.0,
            "accuracy": 0.0,
            "response_time": 0.0,
            "noise_sigma": 0.0,
        },
        KASTEREN,
    ),
    _part(
        "YF_S201",
        "YF-S201 (Hall sensor)",
        "YF-S201 data sheet: 1 to 30 L/min, ±10 %, 450 pulses a litre. Assumed: pulses are counted "
        "for 1 s, so the output follows after that",
        1.0,
        0.1,
        1.0,
    ),
    _part("FS_380", "Gems FS-380 (reed)", GEMS.format("FS-380", "0.15"), 0.15 * GALLON, 0.0, 0.0),
    _part("FS_200", "Gems FS-200 (reed)", GEMS.format("FS-200", "0.5"), 0.5 * GALLON, 0.0, 0.0),
)


KIND = Kind(
    "FLOW",
    10,
    "Water flow sensor",
    "Water flow sensor: taps, showers, and cisterns that fill after a flush",
    "MOD_FLUIDSIM",
    "flow",
    1.0,
    "Flowing",
    "No flow",
    FlowParameters,
    events=(
        Field("flowing", bool, quantity="flow", tip="Whether at least the minimum flow flows"),
    ),
    samples=(
        Field("flowing", bool),
        Field("flow_lpm", float, FLOW_UNIT, 2, quantity="flow rate", tip="The measured flow"),
    ),
    evidence=(Field("object", str, tip="The object whose water flows"),),
    model=FlowSensor,
    needs={USES: ()},
    presets=PRESETS,
    part="YF_S201",
)
