# SPDX-License-Identifier: GPL-3.0-or-later
"""The declaration of a kind of sensor.

Each kind is a module or a package in `kinds/` with a `KIND`. No code outside `kinds/` names a
particular kind.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from .evidence import Cause

# Declarations of kinds import `Field` from here, beside `Kind` and `Preset`.
from .logs.fields import Field as Field
from .logs.fields import LoggedKind, UsedWhen
from .parameters import READING, Parameters, Spec, defaults, is_chosen

# The physical quantities that a model can query from the scene; `model.py` has shapes and units.
# Ranges of rays; temperature and emissivity at the hits; solids that crossed rays since the last
# step; contact forces on the sensor; light at the sensor.
RAYS, WARMTH, CROSSINGS, FORCES, LIGHT = "rays", "warmth", "crossings", "contact forces", "light"
# Reflectance at the hits of rays; poses of the objects that pointer parameters name; whether the
# object that the sensor watches is in use.
REFLECTANCE, POSES, USES = "reflectance", "poses of objects", "uses of objects"


@dataclass(frozen=True)
class Preset:
    """Values of parameters by name, for a product or for a setting.

    A parameter that is not in `values` stays as it is. `identifier` is unique within its kind and
    is never reused, because scripts contain it. `source` cites the publication of the values.
    `rate` is the update rate in Hz for which the values hold; 0 leaves the sensor's rate as it is.
    """

    identifier: str
    label: str
    values: Mapping[str, Any]
    source: str
    rate: float = 0.0


def parts_with(**common: Any) -> Callable[..., Preset]:
    """Return a function of an identifier, a label, a source and values that makes a preset.

    It also takes the `rate` of the preset. The preset also has the `common` values that it does not
    replace. So all presets of a kind set the same parameters, and none keeps values of a preset
    chosen before.
    """

    def part(identifier: str, label: str, source: str, rate: float = 0.0, **values: Any) -> Preset:
        return Preset(identifier, label, {**common, **values}, source, rate)

    return part


@dataclass(frozen=True)
class OwnerProperties:
    """Properties that a kind of sensor needs of objects or materials, such as breathing.

    Attributes
    ----------
    attribute
        The name of the property group in Blender.
    owners
        The types of its owners: "Object", "Material" or both.
    label, tip
        The title of its panel, and a sentence on it.
    parameters
        The class of the properties.
    """

    attribute: str
    owners: tuple[str, ...]
    label: str
    tip: str
    parameters: type[Parameters]


@dataclass(frozen=True)
class Kind:
    """A kind of sensor.

    Attributes
    ----------
    number
        The number that blend files store for the kind.
    attribute
        The name of the PropertyGroup that holds the parameters.
    update_rate
        The default update rate in Hz.
    active_label, idle_label
        The words for the output `active`, when it is on and when it is off.
    parameters
        The class of the parameters.
    events
        The fields whose changes are in the event log.
    samples
        The fields that are columns of a sensor's sample file.
    evidence
        The fields that tell why the sensor read what it did: a recording has them for explanations,
        and no file of other tools has.
    cause
        A function of a `Track` and the index of an update, which returns the `Cause` of the reading
        there. None: the object in the field `object` of `evidence`, if the kind has that.
    model
        A function that makes the `Model` of one sensor.
    needs
        The queries that the model makes to the scene. Each has pairs of a parameter and a choice:
        the model makes the query if all these parameters have these choices.
    signal_rate
        The update rate in Hz that suffices for the signal of a moving body, for models whose signal
        builds up between updates; a lower rate is warned of. 0: any rate suffices.
    integrates
        The name of the parameter with the time in s before each update over which the sensor
        integrates. A run also evaluates the scene at the steps in that time. Empty: only at
        updates.
    in_room
        Whether the sensor observes the room that it is mounted in. A sensor that is part of a door
        or of furniture does not.
    presets
        The presets of the kind.
    part
        The identifier of a preset. Sensors that are added from menus have its parameters. Empty:
        they have the defaults.
    view
        For coverage maps: a function of the parameters, an `Update` in the scene at rest, and the
        update rate in Hz. It returns a `DetectorView` (coverage/detect.py). None: the kind has no
        coverage maps.
    owner_properties
        The properties that the kind needs of other objects and of materials.
    value_when_idle
        Whether the main value means anything while the output is off. If not, it is not shown then.
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
    signal_rate: float = 0.0
    integrates: str = ""
    in_room: bool = False
    presets: tuple[Preset, ...] = ()
    part: str = ""
    view: Callable[[Any, Any, float], Any] | None = None
    owner_properties: tuple[OwnerProperties, ...] = ()
    value_when_idle: bool = True
    evidence: tuple[Field, ...] = ()
    cause: Callable[[Any, int], Cause] | None = None

    @property
    def logged(self) -> LoggedKind:
        """What logs need to know of the kind."""
        return LoggedKind(
            self.identifier,
            self.events,
            self.samples,
            self.requires(RAYS),
            defaults(self.parameters),
            tuple(preset.values for preset in self.presets),
        )

    def requires(self, need: str, parameters: Any = None) -> bool:
        """Return whether the model makes the query `need` with these parameters.

        If `parameters` is None, return whether it makes the query with any parameters.
        """
        if need not in self.needs:
            return False
        return parameters is None or is_chosen(parameters, self.needs[need])

    @property
    def requires_forces(self) -> bool:
        """Whether the model queries contact forces, which need three consecutive frames."""
        return FORCES in self.needs

    @property
    def requires_light(self) -> bool:
        """Whether the model queries rendered light."""
        return LIGHT in self.needs

    @property
    def short_label(self) -> str:
        """The abbreviation in the brackets of the label; without brackets the whole label."""
        return self.label.partition("(")[2].rstrip(")") or self.label

    def publishes(self, quantity: str) -> bool:
        """Return whether a field in `events` has this quantity, such as "opening"."""
        return any(f.quantity == quantity for f in self.events)

    @property
    def has_analog_reading(self) -> bool:
        """Whether a field in `events` is a measured number, not a state or a text."""
        return any(f.type is float for f in self.events)

    @property
    def fields(self) -> dict[str, Field]:
        """All fields in `samples` and `events`, by name."""
        return {f.name: f for f in (*self.samples, *self.events)}

    def reading(self, parameters: Any) -> Field:
        """Return the main field, whose value is also the output `value`.

        It is the first field of `samples` that is a number and is measured with these parameters.
        """
        return next(
            f for f in self.samples if f.type is float and is_chosen(parameters, f.used_when)
        )

    def unit_of(self, spec: Spec, parameters: Any) -> str:
        """Return the unit of the parameter that `spec` describes.

        A parameter declared with the unit `READING`, such as a threshold, has the unit of the main
        field.
        """
        return self.reading(parameters).unit if spec.unit == READING else spec.unit
