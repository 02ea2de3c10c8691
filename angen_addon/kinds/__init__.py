# SPDX-License-Identifier: GPL-3.0-or-later
"""The appearance of each kind of sensor in Blender.

Each module or package of this folder is named after a kind, and defines its `APPEARANCE`. A kind
without a module has the defaults of `Appearance`.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

from ...sensor_logic.kind import Kind

if TYPE_CHECKING:
    from ..view.appearance import Appearance


def appearance_of(kind: Kind) -> Appearance:
    """Return the appearance of a kind of sensor."""
    return _appearance(kind.attribute)


# Each of the many calls in a redraw takes 2.5 µs longer without the cache.
@cache
def _appearance(name: str) -> Appearance:
    # Imported here, because the modules of the kinds import modules that import this one.
    if find_spec(f".{name}", __package__) is None:
        default: Appearance = import_module("..view.appearance", __package__).Appearance()
        return default
    found: Appearance = import_module(f".{name}", __package__).APPEARANCE
    return found
