# SPDX-License-Identifier: GPL-3.0-or-later
"""Units of the numbers in a file that does not give them: `--unit FIELD=UNIT`.

A unit is never guessed from a name or from the size of a number.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ..error import InputError
from ..fields import LOGGED_KINDS
from ..log import Event, as_logged
from ..wording import hint, listed

# A standard gravity, in m/s²: a pad that reads kilograms measures their weight.
GRAVITY = 9.80665
# For each unit of a field: the factor and the offset that convert from other units.
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "m": {
        "m": (1.0, 0.0),
        "cm": (0.01, 0.0),
        "mm": (0.001, 0.0),
        "km": (1000.0, 0.0),
        "in": (0.0254, 0.0),
        "ft": (0.3048, 0.0),
        "yd": (0.9144, 0.0),
        "mi": (1609.344, 0.0),
    },
    "N": {
        "N": (1.0, 0.0),
        "kN": (1000.0, 0.0),
        "kg": (GRAVITY, 0.0),
        "g": (GRAVITY / 1000.0, 0.0),
        "lb": (0.45359237 * GRAVITY, 0.0),
    },
    "lx": {"lx": (1.0, 0.0), "klx": (1000.0, 0.0), "fc": (1.0 / 0.09290304, 0.0)},
    "°C": {
        "°C": (1.0, 0.0),
        "C": (1.0, 0.0),
        "°F": (5.0 / 9.0, -160.0 / 9.0),
        "F": (5.0 / 9.0, -160.0 / 9.0),
        "K": (1.0, -273.15),
    },
    "%": {"%": (1.0, 0.0)},
}
MOST = 6


@dataclass(frozen=True)
class UnitOf:
    """Where a field's numbers come from in the file: their name there, and their unit.

    `unit` is empty if the file does not give it. A `name` is such as
    `sensor.radar_detection_distance`. `is_written` says that the file itself gives the unit: then
    only a unit for this name replaces it, not one for the field of all sensors.
    """

    name: str
    unit: str = ""
    is_written: bool = False


@dataclass
class Units:
    """The units that a user gave, by the name of a field or of an entity."""

    given: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def parse(cls, texts: Iterable[str]) -> Units:
        """Return the units in texts such as "distance_m=cm". Raise InputError for other texts."""
        given: dict[str, str] = {}
        for text in texts:
            name, equals, unit = (part.strip() for part in text.rpartition("="))
            if not (name and equals and unit):
                raise InputError(f"--unit: '{text}' is not FIELD=UNIT, such as distance_m=cm")
            if given.get(name, unit) != unit:
                raise InputError(f"--unit: {name} has two units, {given[name]} and {unit}")
            given[name] = unit
        return cls(given)

    def convert(
        self, changes: list[Event[Any]], fields: Mapping[tuple[str, str], UnitOf]
    ) -> tuple[list[Event[Any]], list[str]]:
        """Return the changes in the units of their fields, and a note about those left out.

        Parameters
        ----------
        changes
            Events in the units of the file.
        fields
            The origin of each field whose unit is not the field's own, by sensor and field.

        Raises
        ------
        InputError
            For a unit that the field cannot have, and for a name that the file does not have.
        """
        published = {f.name: f.unit for kind in LOGGED_KINDS.values() for f in kind.events}
        used: set[str] = set()
        ways: dict[tuple[str, str], tuple[float, float] | None] = {}
        for key, origin in fields.items():
            _, name = key
            told = self._key(origin.name, name)
            used |= {other for other in self.given if _means(other, origin.name, name)}
            if told == name and origin.is_written:
                told = ""
            unit = self.given[told] if told else origin.unit
            known = UNITS[published[name]]
            if unit and unit not in known:
                whose = f"--unit: {told}" if told else origin.name
                raise InputError(
                    f"{whose}: '{unit}' is no unit of {name} that can be converted: "
                    f"they are {', '.join(known)}"
                )
            ways[key] = known[unit] if unit else None
        if unused := [name for name in self.given if name not in used]:
            names = [n for (_, f), origin in fields.items() for n in (origin.name, f)]
            raise InputError(
                f"--unit: no number in the file is called '{unused[0]}': "
                f"{hint(unused[0], dict.fromkeys(names))}"
            )
        found = []
        for change in changes:
            way = ways.get((change.sensor, change.field), (1.0, 0.0))
            if way is not None:
                found.append(change if way == (1.0, 0.0) else _converted(change, *way))
        return found, _asked([fields[key].name for key, way in ways.items() if way is None])

    def _key(self, origin: str, name: str) -> str:
        """Return the given name that means this field most exactly; empty if none does."""
        means = [given for given in self.given if _means(given, origin, name)]
        # A name in the file is more exact than a field that many sensors have.
        return max(means, key=lambda given: (given != name, len(given)), default="")


def _means(given: str, origin: str, name: str) -> bool:
    """Return whether a given name is the field `name`, or `origin` or the end of it."""
    return given in {name, origin} or origin.endswith((f".{given}", f"_{given}"))


def _converted(change: Event[Any], factor: float, offset: float) -> Event[Any]:
    return replace(change, value=as_logged(float(change.value) * factor + offset))


def _asked(names: list[str]) -> list[str]:
    if not names:
        return []
    return [
        f"left out, because the file does not give their units: {listed(names, MOST)}; convert and "
        f"replay take a unit with --unit {names[0]}=UNIT"
    ]


UNIT_HELP: dict[str, Any] = {
    "action": "append",
    "default": [],
    "metavar": "FIELD=UNIT",
    "help": "unit of numbers that the file gives without one, as Home Assistant's history does: of "
    "an entity or the end of its name, or of a field: distance_m=cm; may be given again",
}
