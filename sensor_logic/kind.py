# SPDX-License-Identifier: GPL-3.0-or-later
"""What a kind of sensor declares of itself: all that the rest of the product knows of it.

Each kind is a package (or a module) in `kinds/` that has a `KIND`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from . import quantities
from .parameters import READING, Parameters, Spec, UsedWhen, is_chosen
from .quantities import METRES, Lengths

# What a model can ask of the scene: ranges of rays, the heat that rays meet, what went through rays
# since the step before, contact forces on the sensor, light that falls on it.
RAYS, WARMTH, CROSSINGS, FORCES, LIGHT = "rays", "warmth", "crossings", "contact forces", "light"
# How much of what shines on them the things reflect that rays meet; where objects are that
# parameters name.
REFLECTANCE, POSES = "reflectance", "poses of objects"


@dataclass(frozen=True)
class Preset:
    """A known part or setting: the parameters that it sets, by name; it leaves the others alone.

    `identifier` is unique within its kind and never reused, scripts name it. `source` tells where
    the figures were published.
    """

    identifier: str
    label: str
    values: Mapping[str, Any]
    source: str


@dataclass(frozen=True)
class Field:
    """A published quantity: its name in logs and its Python type (bool, float, int or str).

    `unit` is what it is counted in (SI, radians; empty: a plain number), `decimals` how many of
    them are shown. `step` names the parameter that tells by how much it must change to be an
    event; else any change is one. `optional`: left out of a file in which it would be empty
    throughout. `used_when`: with which choices of parameters it is measured. `quantity`: what it
    measures, by which the formats of other tools know it ("motion", "force" …).
    """

    name: str
    type: type
    unit: str = ""
    decimals: int | None = None
    step: str = ""
    optional: bool = False
    used_when: UsedWhen = ()
    quantity: str = ""

    def text(self, value: float, lengths: Lengths = METRES) -> str:
        """A value of it with its unit, as every place shows it."""
        return quantities.measured(value, self.unit, self.decimals, lengths)

    def short(self, value: float, lengths: Lengths = METRES) -> str:
        """The same in three or four digits."""
        return quantities.short(value, self.unit, lengths)


@dataclass(frozen=True)
class Kind:
    """A kind of sensor. `number` is what files store; `attribute` is where its parameters are.

    `active_label` and `idle_label` are the words for its binary reading. `events` are the fields
    whose changes the event log tells, `samples` the columns of its own file. `model` makes what
    senses for one sensor. `needs`: what the model asks of the scene, each with the choices of
    parameters with which it does. `in_room`: it looks into the room that it hangs in, unlike what
    is part of a door or of furniture.
    """

    identifier: str
    number: int
    label: str
    tip: str
    icon: str
    attribute: str
    update_rate: float
    active_label: str
    idle_label: str
    parameters: type[Parameters]
    events: tuple[Field, ...]
    samples: tuple[Field, ...]
    model: Callable[[], Any]
    needs: Mapping[str, UsedWhen] = field(default_factory=dict)
    in_room: bool = False
    presets: tuple[Preset, ...] = ()

    def asks_for(self, need: str, parameters: Any = None) -> bool:
        """Whether its model asks for this of the scene: with some parameters, or with these."""
        if need not in self.needs:
            return False
        return parameters is None or is_chosen(parameters, self.needs[need])

    @property
    def asks_forces(self) -> bool:
        """Whether its reading needs the frames before and after its own."""
        return FORCES in self.needs

    @property
    def asks_light(self) -> bool:
        """Whether it needs a picture of the light."""
        return LIGHT in self.needs

    def tells_of(self, quantity: str) -> bool:
        """Whether it logs this quantity, such as "opening"."""
        return any(f.quantity == quantity for f in self.events)

    @property
    def measures(self) -> bool:
        """Whether its main reading is a number, and not a state."""
        return any(f.type is float for f in self.events)

    @property
    def fields(self) -> dict[str, Field]:
        """Everything that it publishes, by name."""
        return {f.name: f for f in (*self.samples, *self.events)}

    @property
    def active_field(self) -> str:
        """The field that tells its binary reading: the first truth value that it logs."""
        return next(f.name for f in self.events if f.type is bool)

    def reading(self, parameters: Any) -> Field:
        """What its main reading, the output `value`, is with these parameters: the first number
        that is measured."""
        return next(
            f for f in self.samples if f.type is float and is_chosen(parameters, f.used_when)
        )

    def unit_of(self, spec: Spec, parameters: Any) -> str:
        """What a parameter is counted in: of some, such as a threshold, that is the unit of what
        is read."""
        return self.reading(parameters).unit if spec.unit == READING else spec.unit
