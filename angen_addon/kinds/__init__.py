# SPDX-License-Identifier: GPL-3.0-or-later
"""How each kind of sensor looks in Blender: `APPEARANCE` in the package or module of this folder
that has the kind's name. A kind without one has the defaults of `Appearance`."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ...sensor_logic.kind import Kind

if TYPE_CHECKING:
    from ..view.appearance import Appearance


def appearance_of(kind: Kind) -> Appearance:
    """The appearance of a kind."""
    return _appearance(kind.attribute)


# One a kind, until Blender ends; without it 2.5 µs more each of the many times a redraw asks.
@cache
def _appearance(name: str) -> Appearance:
    # Imported here, since these packages import the modules that call this function.
    if find_spec(f".{name}", __package__) is None:
        default: Appearance = import_module("..view.appearance", __package__).Appearance()
        return default
    found: Appearance = import_module(f".{name}", __package__).APPEARANCE
    return found
