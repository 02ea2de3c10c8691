# SPDX-License-Identifier: GPL-3.0-or-later
"""Find mistakes in a home that cause wrong sensor readings, with a remedy for each."""

from __future__ import annotations

import json
from typing import Any

import bpy

from ...sensor_logic.logs.wording import plural
from . import building, sensors
from .examined import Check, Examined, Finding

# In the order of the report. Mistakes that cause findings of later checks come first.
CHECKS: dict[str, Check] = {
    "scale": building.scale,
    "units": sensors.units,
    "coarse": building.coarse,
    "files": building.missing_data,
    "names": building.same_names,
    "hidden": building.hidden_but_rendered,
    "background": building.background_sets,
    "no_faces": building.without_faces,
    "flattened": building.flattened,
    "holes": building.holes,
    "movement": sensors.nothing_moves,
    "idle_keys": sensors.keys_that_do_not_play,
    "doors": building.without_hinges,
    "still_doors": building.standing_still,
    "inside": sensors.inside_walls,
    "too_near": sensors.looks_into_something,
    "facing": sensors.faces_a_wall,
    "slits": sensors.slits,
    "names_none": sensors.names_nothing,
    "magnets": sensors.never_close,
    "watches": sensors.watches_nothing,
    "unplaced": sensors.unplaced,
    "unreachable": sensors.unreachable,
    "warmth": sensors.nothing_warm,
    "watts": sensors.electrical_watts,
    "dark": sensors.none_lit,
    "glass": sensors.opaque_glass,
    "eevee": sensors.eevee_cannot_run,
    "pads": sensors.advised,
    "margins": sensors.margins,
    "pads_in_air": sensors.hanging_in_the_air,
    "pads_not_valid": sensors.not_weighed,
    "physics": sensors.caches,
}


def examine(scene: Any, view_layer: Any, depsgraph: Any) -> list[Finding]:
    """Run all checks on an evaluated scene, and return their findings."""
    home = Examined(scene, view_layer, depsgraph)
    return [Finding(name, *found) for name, check in CHECKS.items() for found in check(home)]


def findings() -> list[Finding]:
    """Run all checks on the current scene, and return their findings."""
    context = bpy.context
    return examine(context.scene, context.view_layer, context.evaluated_depsgraph_get())


def as_text(found: list[Finding], as_json: bool) -> str:
    """Return two lines for each finding: what is wrong, and how to mend it.

    If `as_json` is True, return a JSON list of the findings instead.
    """
    if as_json:
        entries = [finding._asdict() for finding in found]
        return json.dumps(entries, indent=1, ensure_ascii=False) + "\n"
    return "".join(f"{one.check}: {one.text}\n    {one.mend}\n" for one in found)


def count(found: list[Finding]) -> str:
    """Return the number of findings as a text for the user."""
    return f"{plural(len(found), 'problem')} found" if found else "no problem was found"


__all__ = ["CHECKS", "Examined", "Finding", "examine"]
