# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of a study file (docs/studies.md), for choices that a user made in the interface.

The package `studies` reads and runs study files.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..sensor_logic.kind import Kind
from ..sensor_logic.kinds import KINDS
from ..sensor_logic.parameters import Spec, specs

# A study moves a sensor along the home's axes (m) and turns it about the sensor's axes (rad).
POSE = ("move_x", "move_y", "move_z", "turn_x", "turn_y", "turn_z")
COMMON = ("enabled", "update_rate")
# The separator between the sensor names in a key.
BETWEEN = "; "
RADIANS = "rad"
# The proposed range of a change of pose, in both directions: m, rad.
MOST_MOVE, MOST_TURN = 0.5, math.radians(30.0)

LABELS = {
    "enabled": ("On", ""),
    "update_rate": ("Rate", "Hz"),
    **{f"move_{axis}": (f"Move {axis.upper()}", "m") for axis in "xyz"},
    **{f"turn_{axis}": (f"Turn {axis.upper()}", RADIANS) for axis in "xyz"},
}


@dataclass(frozen=True)
class Vary:
    """A line of a study's table `[vary]`: a parameter of some sensors, and the values to try.

    Attributes
    ----------
    sensors, parameter
        The names of the sensors, and the name of the parameter.
    first, last, steps
        The values are `steps` numbers from `first` to `last`.
    whole
        Whether the values are whole numbers.
    choices
        The values, if they are not numbers.
    angle
        Whether `first` and `last` are angles in radians.
    """

    sensors: Sequence[str]
    parameter: str
    first: float = 0.0
    last: float = 0.0
    steps: int = 0
    whole: bool = False
    choices: Sequence[Any] = ()
    angle: bool = False

    @property
    def key(self) -> str:
        """The text before "=" in the study file: the names of the sensors and the parameter."""
        return f"{BETWEEN.join(self.sensors)}.{self.parameter}"

    @property
    def line(self) -> str:
        """The line in the study file."""
        key = json.dumps(self.key, ensure_ascii=False)
        if self.choices:
            values = ", ".join(json.dumps(value) for value in self.choices)
            return f"{key} = [{values}]"
        whole = ", whole = true" if self.whole else ""
        first, last = (repr(round(v, 7)) for v in (self.first, self.last))
        line = f"{key} = {{ from = {first}, to = {last}, steps = {self.steps}{whole} }}"
        if not self.angle:
            return line
        return f"{line}  # {math.degrees(self.first):.6g}° to {math.degrees(self.last):.6g}°"


def text(home: str, seeds: int, varied: Sequence[Vary]) -> str:
    """Return the text of a study file.

    `home` is the path of the blend file, absolute or relative to the study's folder. `seeds` is the
    number of seeds.
    """
    lines = [
        f"home = {json.dumps(home, ensure_ascii=False)}",
        f"seeds = {seeds}",
        'measure = ["events", "active"]',
        "",
        "[vary]",
        *(vary.line for vary in varied),
    ]
    return "\n".join(lines) + "\n"


def parameters(kind: Kind) -> list[str]:
    """Return the names of the parameters that a study can vary, including pose and update rate."""
    return [*(n for n, s in specs(kind.parameters).items() if not s.pointer), *COMMON, *POSE]


def label(kind: Kind, parameter: str) -> str:
    """Return the label of a parameter as in panels, with its unit; the unit of angles is °."""
    if parameter in LABELS:
        name, unit = LABELS[parameter]
    else:
        spec = specs(kind.parameters)[parameter]
        name, unit = spec.label, spec.unit
    unit = "°" if unit == RADIANS else unit
    return f"{name} ({unit})" if unit else name


def choice_labels(kind: Kind, parameter: str, choices: Sequence[Any]) -> list[str]:
    """Return the labels of some choices of a parameter, as in panels."""
    spec = specs(kind.parameters).get(parameter)
    known = {choice.identifier: choice.label for choice in spec.choices} if spec else {}
    switch = {True: "On", False: "Off"}
    return [switch[c] if isinstance(c, bool) else known.get(c, str(c)) for c in choices]


def proposed(kind: str, sensors: Sequence[str], parameter: str, now: Any) -> Vary:
    """Return a `Vary` with proposed values for a parameter whose present value is `now`."""
    known = specs(KINDS[kind].parameters)
    if isinstance(now, bool):
        return Vary(sensors, parameter, choices=(True, False))
    if isinstance(now, str):
        choices = [choice.identifier for choice in known[parameter].choices]
        return Vary(sensors, parameter, choices=choices or (now,))
    spec = known.get(parameter)
    first, last = _proposed_range(spec, parameter, float(now))
    angle = (spec.unit if spec else LABELS[parameter][1]) == RADIANS
    if isinstance(now, int):
        return Vary(sensors, parameter, float(int(first)), float(max(int(last), 1)), 3, True)
    return Vary(sensors, parameter, first, last, 3, angle=angle)


def _proposed_range(spec: Spec | None, parameter: str, now: float) -> tuple[float, float]:
    """Return the first and the last proposed value of a parameter.

    They are half and twice the value `now`, within the parameter's limits. For a pose, they are a
    move or a rotation in both directions.
    """
    if parameter in POSE:
        most = MOST_TURN if LABELS[parameter][1] == RADIANS else MOST_MOVE
        return -most, most
    first, last = (now / 2, now * 2) if now else (0.0, 1.0)
    if spec is not None:
        first, last = max(first, spec.minimum), min(last, spec.maximum)
    return first, last
