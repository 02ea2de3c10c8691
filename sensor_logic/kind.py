# SPDX-License-Identifier: GPL-3.0-or-later
"""A kind of sensor as one declaration; no other code names a kind.

Each kind is a package (or a module) in `kinds/` that has a `KIND`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from . import wording
from .parameters import READING, Parameters, Spec, UsedWhen, is_chosen
from .wording import METRES, Lengths

# The physical quantities that a model can ask the scene for; `model.py` has their shapes and units.
# Ranges of rays; temperature and emissivity where rays hit; solids that crossed rays since the step
# before; contact forces on the sensor; light on it.
RAYS, WARMTH, CROSSINGS, FORCES, LIGHT = "rays", "warmth", "crossings", "contact forces", "light"
# Reflectance where rays hit; poses of the objects that pointer parameters name.
REFLECTANCE, POSES = "reflectance", "poses of objects"


@dataclass(frozen=True)
class Preset:
    """A product or setting: the parameters that it sets, by name; it leaves the others unchanged.

    `identifier` is unique within its kind and never reused, because scripts contain it. `source`
    cites the publication of the values.
    """

    identifier: str
    label: str
    values: Mapping[str, Any]
    source: str


@dataclass(frozen=True)
class Field:
    """A published quantity: its name in logs and its Python type (bool, float, int or str).

    `unit`: SI unit, angles in radians; empty for a plain number. `decimals`: how many are shown.
    `step`: the parameter that holds the least change that is an event; empty: every change is one.
    `optional`: omitted from a file where it has no value in any row. `used_when`: the choices of
    parameters with which it is measured. `quantity`: what it measures ("motion", "force" …); the
    formats of other tools choose their message types by it.
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
        """A value with its unit, as the interface and reports show it."""
        return wording.measured(value, self.unit, self.decimals, lengths)

    def short(self, value: float, lengths: Lengths = METRES) -> str:
        """A value with its unit, in three or four digits."""
        return wording.short(value, self.unit, lengths)


@dataclass(frozen=True)
class Kind:
    """A kind of sensor. Files store `number`; `attribute` names its parameters' PropertyGroup.

    `active_label` and `idle_label` are the words for its binary reading. `events` are the fields
    whose changes the event log lists, `samples` the columns of a sensor's sample file. `model`
    makes the `Model` of one sensor. `needs`: the quantities that the model asks the scene for, each
    with the choices of parameters with which it does. `in_room`: the sensor observes the room it
    is mounted in, unlike one that is part of a door or of furniture. `part`: the preset of the
    real part that the window's menus add; empty: they add one with the defaults.
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
    part: str = ""

    def requires(self, need: str, parameters: Any = None) -> bool:
        """Whether its model asks the scene for this quantity with these parameters; None: with any
        parameters."""
        if need not in self.needs:
            return False
        return parameters is None or is_chosen(parameters, self.needs[need])

    @property
    def requires_forces(self) -> bool:
        """Whether it needs contact forces, which come from three frames in a row."""
        return FORCES in self.needs

    @property
    def requires_light(self) -> bool:
        """Whether it needs rendered light."""
        return LIGHT in self.needs

    def publishes(self, quantity: str) -> bool:
        """Whether its events include this quantity, such as "opening"."""
        return any(f.quantity == quantity for f in self.events)

    @property
    def has_analog_reading(self) -> bool:
        """Whether its events include a number, and not states alone."""
        return any(f.type is float for f in self.events)

    @property
    def fields(self) -> dict[str, Field]:
        """All fields that it publishes, by name."""
        return {f.name: f for f in (*self.samples, *self.events)}

    def reading(self, parameters: Any) -> Field:
        """The field of its main reading, the output `value`: the first number that is measured with
        these parameters."""
        return next(
            f for f in self.samples if f.type is float and is_chosen(parameters, f.used_when)
        )

    def unit_of(self, spec: Spec, parameters: Any) -> str:
        """A parameter's unit; that of a parameter in `READING`, such as a threshold, is the main
        reading's."""
        return self.reading(parameters).unit if spec.unit == READING else spec.unit
