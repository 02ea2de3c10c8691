# SPDX-License-Identifier: GPL-3.0-or-later
"""The fields that sensors publish, and what logs need to know of the kinds of sensors.

`sensor_logic/kinds/` declares the kinds, and adds each to `LOGGED_KINDS`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from . import wording
from .wording import METRES, Lengths

# A condition: pairs of a parameter's name and a value. It holds if each parameter has its value.
UsedWhen = tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class Field:
    """A published quantity: its name in logs and its Python type (bool, float, int or str).

    Attributes
    ----------
    unit
        SI unit, with angles in radians; empty for a plain number.
    decimals
        The number of decimals shown; None means three significant digits.
    step
        The name of a parameter. A change of the value is an event if it is at least as large as
        this parameter. Empty: every change is an event.
    optional
        Whether files omit the field's column if no row has a value.
    used_when
        Pairs of a parameter and a choice. The field is measured if all these parameters have these
        choices.
    quantity
        The physical quantity, such as "motion" or "force". It determines the type of message in the
        formats of other tools.
    tip
        What the field means, in a phrase for the documentation.
    word
        A word for the value where it stands beside the sensor's state, such as "tilt", if its unit
        does not tell what it is.
    shape
        The names of the parameters with the numbers of columns and of rows, for a text that holds a
        picture: a number for each of its pixels, row by row, with semicolons. Reports show it.
    """

    name: str
    type: type
    unit: str = ""
    decimals: int | None = None
    step: str = ""
    optional: bool = False
    used_when: UsedWhen = ()
    quantity: str = ""
    shape: tuple[str, str] | None = None
    tip: str = ""
    word: str = ""

    def text(self, value: float, lengths: Lengths = METRES) -> str:
        """Return a value with its unit, as shown in the interface and in reports."""
        return wording.measured(value, self.unit, self.decimals, lengths)

    def short(self, value: float, lengths: Lengths = METRES) -> str:
        """Return a value with its unit, in three or four digits."""
        return wording.short(value, self.unit, lengths)


@dataclass(frozen=True)
class LoggedKind:
    """What logs need to know of a kind of sensor.

    Attributes
    ----------
    identifier
        The name of the kind in logs.
    events
        The fields whose changes are in the event log.
    samples
        The fields that are columns of a sensor's sample file.
    casts_rays
        Whether the sensor measures with rays.
    defaults
        The default of each parameter by name.
    presets
        The values of parameters by name, in each preset.
    """

    identifier: str
    events: tuple[Field, ...]
    samples: tuple[Field, ...]
    casts_rays: bool
    defaults: Mapping[str, Any]
    presets: tuple[Mapping[str, Any], ...]


# All kinds by identifier. Empty until `sensor_logic/kinds/` is loaded, as with `sensor_logic`.
LOGGED_KINDS: dict[str, LoggedKind] = {}
