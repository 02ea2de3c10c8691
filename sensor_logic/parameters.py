# SPDX-License-Identifier: GPL-3.0-or-later
"""The declaration of a kind's parameters, as dataclass fields with labels, units and limits.

Blender's properties, the panels, `list --json` and the tables of the docs are made from these
fields.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from .logs.fields import UsedWhen
from .logs.wording import METRES, Advice, Lengths, named, typed

# The unit of a parameter that has the unit of its sensor's main reading.
READING = "reading"
# Blender stores angles in single precision, in which 180° is a little more than π.
SINGLE_PRECISION = 1e-6


@dataclass(frozen=True)
class Choice:
    """One item of an enumeration; files store its `number`, which is never reused."""

    identifier: str
    label: str
    tip: str
    number: int


@dataclass(frozen=True)
class FormerChoice:
    """An item that was removed from an enumeration, but that older files can still contain.

    `now` is the identifier of the item that replaces it.
    """

    identifier: str
    number: int
    now: str


@dataclass(frozen=True)
class Spec:
    """The metadata of a parameter, apart from its default.

    Attributes
    ----------
    short
        The label where space is narrow.
    other_labels
        Labels for some conditions: the condition, the label, the short label.
    unit
        SI unit, with angles in radians; READING for the unit of the sensor's reading.
    minimum, maximum
        The limits of a number.
    positive
        Whether the number must be above 0.
    choices
        The items of an enumeration.
    former
        Items that only older files contain.
    pointer
        The type of Blender object that the parameter refers to; empty for any other parameter.
    source
        The publication of the default.
    used_when
        Pairs of another parameter and a choice. The model uses this parameter if all the others
        have these choices.
    """

    label: str
    tip: str
    short: str = ""
    other_labels: tuple[tuple[UsedWhen, str, str], ...] = ()
    unit: str = ""
    minimum: float = 0.0
    maximum: float = math.inf
    positive: bool = False
    choices: tuple[Choice, ...] = ()
    former: tuple[FormerChoice, ...] = ()
    pointer: str = ""
    source: str = ""
    used_when: UsedWhen = ()


def parameter(default: Any, label: str, tip: str, **facts: Any) -> Any:
    """Return a dataclass field for a parameter, with its default, and with a `Spec` as metadata.

    `facts` are the other attributes of the `Spec`, such as `unit`.
    """
    return dataclasses.field(default=default, metadata={"spec": Spec(label, tip, **facts)})


class Parameters:
    """Base class of the parameters of all kinds: frozen dataclasses whose fields have defaults."""

    def contradictions(self, lengths: Lengths = METRES) -> list[str]:
        """Return sentences about parameters that are within limits but contradict each other.

        Subclasses override this method.
        """
        return []

    def unreachable(self, lengths: Lengths = METRES) -> list[Advice]:
        """Return advice if the output could never switch on, or never off, with these parameters.

        Subclasses override this method.
        """
        return []

    def must_be_smaller(self, low: str, high: str, lengths: Lengths) -> list[str]:
        """Return a list with a sentence if the parameter `low` is not below `high`, else []."""
        if getattr(self, low) < getattr(self, high):
            return []
        unit = specs(type(self))[low].unit
        one, two = (typed(getattr(self, name), unit, lengths) for name in (low, high))
        return [f"{low} ({one}) must be smaller than {high} ({two})"]

    def problems(self, lengths: Lengths = METRES) -> list[str]:
        """Return the reasons why a sensor with these parameters cannot be simulated."""
        found = []
        for name, spec in specs(type(self)).items():
            problem = _out_of_range(getattr(self, name), spec, lengths)
            if problem:
                found.append(f"{name} {problem}")
        return found or self.contradictions(lengths)


def specs(kind: type[Parameters]) -> dict[str, Spec]:
    """Return the `Spec` of each parameter by name, in the order of declaration."""
    return {f.name: f.metadata["spec"] for f in dataclasses.fields(kind)}  # type: ignore[arg-type]


def defaults(kind: type[Parameters]) -> dict[str, Any]:
    """Return the default of each parameter by name."""
    return {f.name: f.default for f in dataclasses.fields(kind)}  # type: ignore[arg-type]


def former_choice(spec: Spec, value: Any) -> FormerChoice | None:
    """Return the removed choice of an enumeration with the identifier `value`, or None."""
    return next((former for former in spec.former if former.identifier == value), None)


def former_text(found: Iterable[tuple[str, str, FormerChoice]]) -> str:
    """Return a sentence about removed choices that were replaced; empty if there are none.

    `found` has the sensor's name, the parameter's name, and the removed choice of each.
    """
    sensors: dict[tuple[str, FormerChoice], list[str]] = {}
    for sensor, parameter, former in found:
        sensors.setdefault((parameter, former), []).append(sensor)
    return "; ".join(
        f"{named(names)}: {parameter} {former.identifier} no longer exists and was replaced by "
        f"{former.now}"
        for (parameter, former), names in sensors.items()
    )


def is_chosen(parameters: Any, used_when: UsedWhen) -> bool:
    """Return whether a condition holds: each parameter in `used_when` has the paired value."""
    return all(getattr(parameters, name) == choice for name, choice in used_when)


def label_of(spec: Spec, parameters: Any, short: bool = False) -> str:
    """Return the label of a parameter, which can depend on the values in `parameters`.

    If `short`, return the label for narrow spaces.
    """
    for used_when, label, short_label in spec.other_labels:
        if is_chosen(parameters, used_when):
            return short_label if short else label
    return spec.short if short and spec.short else spec.label


def _out_of_range(value: Any, spec: Spec, lengths: Lengths) -> str:
    if spec.choices:
        known = [choice.identifier for choice in spec.choices]
        # Blender reads an enumeration as an empty text if no item has the stored number.
        shown = (
            repr(value)
            if value
            else ("not one of its choices (set by an old file, a keyframe or a driver)")
        )
        return "" if value in known else f"is {shown}: choose one of {', '.join(known)}"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return ""
    if not math.isfinite(value):
        return f"is {value}: it must be a number"
    shown = f"is {format_quantity(value, spec.unit, lengths)}"
    least, most = (format_quantity(v, spec.unit, lengths) for v in (spec.minimum, spec.maximum))
    if spec.positive and value <= 0:
        return f"{shown}: it must be above {least}"
    if value < spec.minimum:
        return f"{shown}: it must be at least {least}"
    if value > spec.maximum * (1.0 + SINGLE_PRECISION):
        return f"{shown}: it must be at most {most}"
    return ""


def format_quantity(value: float, unit: str, lengths: Lengths = METRES) -> str:
    """Return a parameter's value with its unit; an angle is shown in degrees."""
    return typed(value, "" if unit == READING else unit, lengths)


def value_text(value: Any, spec: Spec, unit: str, lengths: Lengths = METRES) -> str:
    """Return a parameter's value as text: on or off, a number with its unit, or a choice."""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, (int, float)):
        return format_quantity(value, unit, lengths)
    label = next((choice.label for choice in spec.choices if choice.identifier == value), value)
    return str(label)
