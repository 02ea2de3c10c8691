# SPDX-License-Identifier: GPL-3.0-or-later
"""The declaration of a kind of sensor; no code outside `kinds/` names a particular kind.

Each kind is a package (or a module) in `kinds/` that has a `KIND`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from . import wording
from .parameters import READING, Parameters, Spec, UsedWhen, is_chosen
from .wording import METRES, Lengths

# The physical quantities that a model can query from the scene; `model.py` has shapes and units.
# Ranges of rays; temperature and emissivity at the hits; solids that crossed rays since the last
# step; contact forces on the sensor; light at the sensor.
RAYS, WARMTH, CROSSINGS, FORCES, LIGHT = "rays", "warmth", "crossings", "contact forces", "light"
# Reflectance at the hits of rays; poses of the objects that pointer parameters name.
REFLECTANCE, POSES = "reflectance", "poses of objects"


@dataclass(frozen=True)
class Preset:
    """Parameters of a product or a setting, by name; a parameter not named keeps its value.

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

    Attributes
    ----------
    unit
        SI unit, with angles in radians; empty for a plain number.
    decimals
        The number of decimals shown.
    step
        The parameter that holds the least change that counts as an event; empty: every change does.
    optional
        Leave the field out of a file where no row has a value for it.
    used_when
        The choices of parameters with which the field is measured.
    quantity
        What the field measures, such as "motion" or "force"; formats of other tools choose their
        message types by it.
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
        """Return a value with its unit, as the interface and reports show it."""
        return wording.measured(value, self.unit, self.decimals, lengths)

    def short(self, value: float, lengths: Lengths = METRES) -> str:
        """Return a value with its unit, in three or four digits."""
        return wording.short(value, self.unit, lengths)


@dataclass(frozen=True)
class Kind:
    """A kind of sensor.

    Attributes
    ----------
    number
        The number that files store for the kind.
    attribute
        The name of the PropertyGroup that holds the parameters.
    active_label, idle_label
        The words for the binary reading.
    events
        The fields whose changes the event log lists.
    samples
        The columns of a sensor's sample file.
    model
        A function that makes the `Model` of one sensor.
    needs
        The quantities that the model queries from the scene, each with the choices of parameters
        with which it does so.
    in_room
        The sensor observes the room that it is mounted in, and is not part of a door or of
        furniture.
    part
    The preset of the real part that the window's menus add. Empty: they add the defaults.
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
        """Return whether the model queries the quantity `need` with these parameters.

        With `parameters` None, return whether it does so with any parameters.
        """
        if need not in self.needs:
            return False
        return parameters is None or is_chosen(parameters, self.needs[need])

    @property
    def requires_forces(self) -> bool:
        """Whether the kind needs contact forces, which take three consecutive frames to compute."""
        return FORCES in self.needs

    @property
    def requires_light(self) -> bool:
        """Whether the kind needs rendered light."""
        return LIGHT in self.needs

    def publishes(self, quantity: str) -> bool:
        """Return whether the events of the kind include this quantity, such as "opening"."""
        return any(f.quantity == quantity for f in self.events)

    @property
    def has_analog_reading(self) -> bool:
        """Whether the events of the kind include a number, and not only on/off states and texts."""
        return any(f.type is float for f in self.events)

    @property
    def fields(self) -> dict[str, Field]:
        """All published fields by name."""
        return {f.name: f for f in (*self.samples, *self.events)}

    def reading(self, parameters: Any) -> Field:
        """Return the field of the main reading, which is the output `value`.

        The main reading is the first number that is measured with these parameters.
        """
        return next(
            f for f in self.samples if f.type is float and is_chosen(parameters, f.used_when)
        )

    def unit_of(self, spec: Spec, parameters: Any) -> str:
        """Return the unit of a parameter.

        A parameter declared with the unit `READING`, such as a threshold, has the unit of the main
        reading.
        """
        return self.reading(parameters).unit if spec.unit == READING else spec.unit
