# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of sensor: every package and module in this folder defines a `KIND`.

In Blender, `obj.angen_sensor` has a property group for each kind, under the name of the kind's
module. It holds the parameters.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module

from ..heat import HEAT
from ..kind import Kind, OwnerProperties
from ..logs.fields import LOGGED_KINDS
from ..use import IN_USE

NO_KIND = "NONE"


def _load_kinds() -> list[Kind]:
    """Return the kinds in this folder, ordered by number.

    Raise ValueError if two kinds have the same number or identifier, or if a kind's `attribute` is
    not the name of its module.
    """
    kinds: list[Kind] = []
    for module in pkgutil.iter_modules(__path__):
        kind: Kind = import_module(f"{__name__}.{module.name}").KIND
        if kind.attribute != module.name:
            raise ValueError(f"the attribute of {kind.identifier} must be '{module.name}'")
        kinds.append(kind)
    for name in ("number", "identifier"):
        if len({getattr(kind, name) for kind in kinds}) < len(kinds):
            raise ValueError(f"two kinds of sensor have the same {name}")
    return sorted(kinds, key=lambda kind: kind.number)


KINDS: dict[str, Kind] = {kind.identifier: kind for kind in _load_kinds()}
LOGGED_KINDS.update({identifier: kind.logged for identifier, kind in KINDS.items()})


# The properties that kinds need of other objects and of materials, by the type of the owner.
_EVERY = (IN_USE, HEAT, *(made for kind in KINDS.values() for made in kind.owner_properties))
_OWNED = {
    owner: tuple(made for made in _EVERY if owner in made.owners)
    for owner in ("Object", "Material")
}


def owner_properties(owner: str) -> tuple[OwnerProperties, ...]:
    """Return the properties that kinds need of a type of owner, such as "Object"."""
    return _OWNED.get(owner, ())
