# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of smart plugs: housing, panel rows and explanations."""

from __future__ import annotations

from functools import reduce

from ...sensor_logic.kinds.appliance import LINGERS, PROGRAMME, SWITCHED, WHILE_USED
from ...sensor_logic.logs.wording import typed
from ..appearance.appearance import Appearance
from ..appearance.facts import Explanation, Facts
from ..appearance.housing import Housing
from ..appearance.recorded import RecordedSensor
from ..appearance.uses import draw_watched, explain_use

# What the appliance does while it works.
DOES = {
    WHILE_USED: "is in use",
    SWITCHED: "was switched on",
    LINGERS: "is in use, or was a short time ago",
    PROGRAMME: "runs its programme",
}


def _plug() -> Housing:
    """Return a housing of 44 × 44 × 70 mm, as a Shelly Plug S has it, out of the wall along Z."""
    return Housing().box((-0.022, -0.022, 0.0), (0.022, 0.022, 0.07))


def explain_appliance(recorded: RecordedSensor, index: int) -> Explanation:
    """Explain update `index` of a smart plug by the use of the appliance."""
    parameters = recorded.parameters_at(index)
    load = parameters.drawn
    # Joined one by one, as a text with values that dictionaries can have.
    phases = (typed(watts, "W") for _, watts in load.phases)
    draws = reduce(lambda before, watts: f"{before}, then {watts}", phases)
    facts: Facts = [
        ("Draws", f"{draws} while it works, else {typed(load.standby, 'W')}"),
        ("On", f"from {typed(parameters.threshold, 'W')}"),
    ]
    if load.works in (LINGERS, PROGRAMME):
        facts.insert(1, ("Works", f"for {typed(load.runs, 's')} after a use"))
    return explain_use(recorded, index, DOES[load.works], facts)


SECTIONS = (
    ("Appliance", ("watched", "load", "works", "power", "standby_power", "run_time")),
    (
        "Plug",
        (
            "threshold",
            "report_step",
            "min_power",
            "max_power",
            "resolution",
            "accuracy",
            "noise_sigma",
        ),
    ),
)
APPEARANCE = Appearance(
    {"": _plug}, explain=explain_appliance, sections=SECTIONS, details=draw_watched
)
