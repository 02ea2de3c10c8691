# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of water flow sensors: housing, panel rows and explanations."""

from __future__ import annotations

from ...sensor_logic.kinds.flow import AFTER_USE, FLOW_UNIT
from ...sensor_logic.logs.wording import typed
from ..appearance.appearance import Appearance
from ..appearance.facts import Explanation, Facts
from ..appearance.housing import Housing
from ..appearance.recorded import RecordedSensor
from ..appearance.uses import draw_watched, explain_use


def _turbine() -> Housing:
    """Return a housing of 62 × 36 × 34 mm, a turbine in a half-inch pipe such as a YF-S201.

    The size is from its data sheet. The pipe runs along X.
    """
    body = Housing().box((-0.018, -0.018, 0.0), (0.018, 0.018, 0.034))
    return body.box((-0.031, -0.01, 0.005), (0.031, 0.01, 0.025))


def explain_flow(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a water flow sensor by the use of what it watches."""
    parameters = recorded.parameters_at(index)
    facts: Facts = [("Flow rate", typed(parameters.flow_rate, FLOW_UNIT))]
    if parameters.flows == AFTER_USE:
        volume, seconds = typed(parameters.refill_volume, "L"), typed(parameters.refill_time, "s")
        facts.append(("Cistern", f"{volume}, full {seconds} after the use ends"))
    facts.append(("On", f"from {typed(parameters.min_flow, FLOW_UNIT)}"))
    does = "fills its cistern" if parameters.flows == AFTER_USE else "is in use"
    return explain_use(recorded, index, does, facts)


APPEARANCE = Appearance({"": _turbine}, explain=explain_flow, details=draw_watched)
