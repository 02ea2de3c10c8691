# SPDX-License-Identifier: GPL-3.0-or-later
"""Pressure sensor under furniture: the force on its pad, and its force-sensing resistor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...kind import FORCES
from ...log.partner_names import joined
from ...model import Model, PadContact, Pose, Reading, Update
from .force_resistor import ForceResistor
from .parameters import PressureParameters

# A partner is listed if its share of the force is larger than this.
LEAST_SHARE = 1e-3
# N: a smaller force on the back of a pad raises no warning.
LEAST_BACKING = 0.1


class PressurePad(Model):
    """One pad. Its state is the last valid reading, and that of its resistor."""

    def __init__(self) -> None:
        self._resistor: ForceResistor | None = None
        self._known = PadReading(0.0, "", (math.nan, math.nan))
        # The arguments of `pad_reading` for the reading in `_known`, compared by identity: a pad at
        # rest is not computed again.
        self._arguments: tuple[Any, ...] = (None, None, None)

    def update(self, parameters: PressureParameters, update: Update) -> Reading:
        """The force along the pad's −Z in N, its partners, and the resistor's reading.

        Where the scene has no usable forces, the last valid ones stand, and `valid` is false.
        """
        contact: PadContact = update.ask(FORCES)
        problem = contact.forces.problem
        if contact.forces.usable:
            arguments = parameters, update.pose, contact
            if not all(one is two for one, two in zip(arguments, self._arguments, strict=True)):
                self._arguments, self._known = arguments, pad_reading(*arguments)
            if not problem and self._known.on_its_back:
                problem = "what touches the pad does so on its back: its +Z side senses; turn it"
        if self._resistor is None:
            self._resistor = ForceResistor(float(update.device_noise().standard_normal()))
        on_force = on_press = 0.0
        # The draw is skipped where neither number is used.
        if parameters.noise_sigma or (self._known.force > 0.0 and not self._resistor.touched):
            on_force, on_press = update.noise().standard_normal(2)
        force = self._known.force + parameters.noise_sigma * float(on_force)
        resistor = self._resistor.update(parameters, max(force, 0.0), update.time, float(on_press))
        pressed = force > parameters.threshold
        fields = {
            "force_n": force,
            "pressed": pressed,
            "valid": not problem,
            "residual": contact.forces.residual,
            "resistance_ohm": resistor.resistance_ohm,
            "voltage_v": resistor.voltage_v,
            "adc": resistor.adc,
            "partners": self._known.partners,
            "cop_x_m": self._known.centre[0],
            "cop_y_m": self._known.centre[1],
            "problem": problem,
        }
        return Reading(pressed, force, fields)


@dataclass(frozen=True)
class PadReading:
    """Force in N, names of the partners joined by `partner_names.joined`, and the centre of
    pressure (x, y) in m along the pad's axes from its origin; NaN without pressure. `on_its_back`:
    only its −Z side is pressed, by more than its own weight."""

    force: float
    partners: str
    centre: tuple[float, float]
    on_its_back: bool = False


def pad_reading(parameters: PressureParameters, pose: Pose, contact: PadContact) -> PadReading:
    """The pad's reading from its contacts, with its own weight unless that is subtracted."""
    inward = -pose.axes[:, 2]
    pressing = 0.0
    holding = backing = 0.0
    names: dict[str, float] = {}
    moment = np.zeros(3)
    for partner in contact.forces.partners:
        if contact.chosen is not None and not partner.objects & contact.chosen:
            continue
        along = partner.forces @ inward
        from_above = np.maximum(along, 0.0)
        share = float(from_above.sum())
        pressing += share
        moment += from_above @ (partner.places - pose.origin)
        held = float(np.maximum(-along, 0.0).sum())
        backing += held
        if contact.chosen is not None:
            holding += held
            share += held
        names[partner.name] = names.get(partner.name, 0.0) + share
    own = float(contact.weight @ inward)
    force = pressing
    if pressing == 0.0 and holding > 0.0:
        # The partner holds the pad up: its force includes the pad's own weight.
        force = holding - own if parameters.subtract_own_weight else holding
    elif not parameters.subtract_own_weight:
        force = pressing + own
    least = LEAST_SHARE * max(pressing, holding)
    partners = joined(name for name, share in names.items() if share > least)
    centre = (math.nan, math.nan)
    if pressing > 0.0:
        local = pose.axes.T @ (moment / pressing)
        centre = (float(local[0]), float(local[1]))
    weight = float(np.linalg.norm(contact.weight))
    on_its_back = force <= 0.0 and backing > LEAST_BACKING + 1.05 * weight
    return PadReading(force, partners, centre, on_its_back)
