# SPDX-License-Identifier: GPL-3.0-or-later
"""What each kind of sensor looks like in Blender: the `APPEARANCE` of the package or module in this
folder that is called as its kind is. A kind without one looks as Appearance's defaults say."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ...sensor_logic.kind import Kind

if TYPE_CHECKING:
    from ..view.appearance import Appearance


def appearance_of(kind: Kind) -> Appearance:
    return _appearance(kind.attribute)


@cache
def _appearance(name: str) -> Appearance:
    # Imported here: what kinds look like is built on what asks for it.
    if find_spec(f".{name}", __package__) is None:
        default: Appearance = import_module("..view.appearance", __package__).Appearance()
        return default
    found: Appearance = import_module(f".{name}", __package__).APPEARANCE
    return found
