# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds what makes the sensors of a home read nonsense, each with the way to mend it."""

from __future__ import annotations

from typing import Any

from . import doors, files, lamps, pads, placed, shell
from .examined import Check, Examined, Finding

# In the order in which they are reported: first what makes other checks fail too.
CHECKS: dict[str, Check] = {
    "scale": shell.scale,
    "files": files.lacks,
    "names": files.same_names,
    "hidden": shell.hidden_but_rendered,
    "background": shell.background_sets,
    "no_faces": shell.without_faces,
    "flattened": shell.flattened,
    "holes": shell.holes,
    "movement": placed.nothing_moves,
    "idle_keys": placed.keys_that_do_not_play,
    "doors": doors.without_hinges,
    "still_doors": doors.standing_still,
    "inside": placed.inside_walls,
    "too_near": placed.looks_into_something,
    "slits": placed.slits,
    "names_none": placed.names_nothing,
    "unplaced": placed.unplaced,
    "unreachable": placed.unreachable,
    "warmth": placed.nothing_warm,
    "watts": lamps.electrical_watts,
    "dark": lamps.none_lit,
    "glass": lamps.opaque_glass,
    "eevee": lamps.eevee_cannot_run,
    "pads": pads.advised,
    "margins": pads.margins,
    "pads_in_air": pads.hanging_in_the_air,
    "physics": pads.caches,
}


def examine(scene: Any, view_layer: Any, depsgraph: Any) -> list[Finding]:
    """The findings of all checks of an evaluated scene."""
    home = Examined(scene, view_layer, depsgraph)
    return [Finding(name, *found) for name, check in CHECKS.items() for found in check(home)]


__all__ = ["CHECKS", "Examined", "Finding", "examine"]
