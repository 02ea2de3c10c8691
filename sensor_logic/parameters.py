# SPDX-License-Identifier: GPL-3.0-or-later
"""How a sensor kind declares its parameters: once, as dataclass fields that carry their own facts.

Blender's properties, panels, `list --json` and the tables of the docs are built from these.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

# Blender stores angles in single precision, in which 180° is a little more than π.
SINGLE_PRECISION = 1e-6


@dataclass(frozen=True)
class Choice:
    """One item of an enumeration; `number` is what a file stores, so it is never reused."""

    identifier: str
    label: str
    tip: str
    number: int


@dataclass(frozen=True)
class Spec:
    """What is known of a parameter besides its default. Units are SI, angles radians."""

    label: str
    tip: str
    unit: str = ""
    minimum: float = -math.inf
    maximum: float = math.inf
    above_minimum: bool = False
    choices: tuple[Choice, ...] = ()
    pointer: str = ""
    source: str = ""
    used_when: tuple[str, str] | None = None


def parameter(default: Any, label: str, tip: str, **facts: Any) -> Any:
    """A dataclass field with the default and the `Spec` of a parameter."""
    return dataclasses.field(default=default, metadata={"spec": Spec(label, tip, **facts)})


class Parameters:
    """Base of every kind's parameter dataclass (all frozen, all with defaults)."""

    def contradictions(self) -> list[str]:
        """What is wrong between parameters that are each in range; overridden by kinds."""
        return []

    def problems(self) -> list[str]:
        """Every reason why a sensor with these parameters cannot be simulated, in words."""
        found = []
        for name, spec in specs(type(self)).items():
            problem = _out_of_range(getattr(self, name), spec)
            if problem:
                found.append(f"{name} {problem}")
        return found or self.contradictions()


def specs(kind: type[Parameters]) -> dict[str, Spec]:
    """Name → `Spec` of each parameter, in the order of declaration."""
    return {f.name: f.metadata["spec"] for f in dataclasses.fields(kind)}  # type: ignore[arg-type]


def defaults(kind: type[Parameters]) -> dict[str, Any]:
    """Name → default of each parameter."""
    return {f.name: f.default for f in dataclasses.fields(kind)}  # type: ignore[arg-type]


def used(parameters: Any, name: str, spec: Spec) -> bool:
    """Whether the chosen model or method looks at the parameter `name` at all."""
    return spec.used_when is None or getattr(parameters, spec.used_when[0]) == spec.used_when[1]


def _out_of_range(value: Any, spec: Spec) -> str:
    if spec.choices:
        known = [choice.identifier for choice in spec.choices]
        return "" if value in known else f"is {value!r}: choose one of {', '.join(known)}"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return ""
    if not math.isfinite(value):
        return f"is {value}: it must be a number"
    shown = f"is {format_quantity(value, spec.unit)}"
    if spec.above_minimum and value <= spec.minimum:
        return f"{shown}: it must be above {format_quantity(spec.minimum, spec.unit)}"
    if value < spec.minimum:
        return f"{shown}: it must be at least {format_quantity(spec.minimum, spec.unit)}"
    if value > spec.maximum * (1.0 + SINGLE_PRECISION):
        return f"{shown}: it must be at most {format_quantity(spec.maximum, spec.unit)}"
    return ""


def format_quantity(value: float, unit: str) -> str:
    """A value with its unit as people write it: angles in degrees."""
    if unit == "rad":
        return f"{math.degrees(value):.6g}°"
    return f"{value:.6g} {unit}".rstrip()
